"""A deck beside a modal test: its modes, its frequency response functions, or both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from creak.errors import InputError
from creak.formats.measured.mode_files import read_test
from creak.formats.measured.modes import Measured
from creak.progress import Progress, silent
from creak.studies.models.correlation import Correlation, correlate
from creak.studies.models.deck_modes import DeckModes, deck_modes
from creak.studies.models.frfs import FrfComparison, compare_frfs
from creak.studies.prepare.measured_damping import ABOVE
from creak.studies.prepare.sensors import Sensors, locate, read_sensor_map


@dataclass(frozen=True)
class BesideTest:
    """What a test holds, at least one of the two, beside the modes of a deck."""

    found: DeckModes
    modes: Correlation | None
    frfs: FrfComparison | None

    @property
    def notes(self) -> tuple[str, ...]:
        """Those of both, each once."""
        return tuple(dict.fromkeys(note for side in (self.modes, self.frfs) if side is not None for note in side.notes))


def deck_beside_test(
    deck: Path,
    test: Path,
    *,
    f_max: float | None = None,
    count: int | None = None,
    about: Sequence[float] = (0.0, 0.0, 0.0),
    units: str = "mm-t-s",
    test_units: str | None = None,
    sensors: Path | None = None,
    ignore: Sequence[str] = (),
    functions: bool = True,
    progress: Progress = silent,
) -> BesideTest:
    """The modes and the frequency response functions of a deck beside those of a test.

    Parameters
    ----------
    f_max, count, about, ignore : as `deck_modes`; without f_max and count up to `ABOVE` times the highest measured
        frequency. Functions are compared up to f_max, or the last of `count` modes.
    sensors : CSV file with the header sensor,node. units, test_units : as `sensors.locate`.
    functions : of the test count too; else its modes alone, without which it is refused.

    Raises
    ------
    InputError : a file is wrong, or as `locate`, `correlate` and `compare_frfs`. NumericalError : the modes
        could not be found.
    """
    measured = read_test(test)
    if not functions:
        if measured.modes is None:
            raise InputError("no modes in it", where=test, expected="mode shapes", fix="Call creak.compare_frfs.")
        measured = replace(measured, frfs=None)
    tops = [] if measured.modes is None else [float(measured.modes.frequencies.max())]
    if measured.frfs is not None:
        tops.append(max(float(f.freq[-1]) for f in measured.frfs.functions))
    highest = ABOVE * max(tops) if f_max is None and count is None else f_max
    found = deck_modes(deck, f_max=highest, count=count, about=about, ignore=ignore, progress=progress)
    modes = frfs = None

    def at(one: Measured) -> Sensors:
        return locate(found.model, one, units, test_units, read_sensor_map(sensors, found.model, one))

    if measured.modes is not None:
        modes = correlate(found, measured.modes, at(measured.modes))
    if measured.frfs is not None:
        top = tops[-1] if f_max is None else min(tops[-1], f_max)
        top = top if count is None else min(top, found.frequencies[-1])
        frfs = compare_frfs(found, measured.frfs, at(measured.frfs), top, modes=modes, progress=progress)
    return BesideTest(found, modes, frfs)
