"""What a study says, by question: what may touch, what drives the model, how long the run is and what of it is kept."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from creak.errors import InputError
from creak.model.units import METRES, UnitsName
from creak.studies.file.config import OutputTable, TimeTable
from creak.studies.file.contact_tables import ClipTable, ConnectorTable, ContactTable
from creak.studies.file.eline_tables import ElineTable, MaterialPairTable
from creak.studies.file.excitation_tables import ExcitationTable, StaticTable
from creak.studies.file.places import Places
from creak.studies.file.scatter_tables import ToleranceFile
from creak.studies.file.sound_tables import BackgroundTable, ListenerTable, RoomTable

MOST_PERIODS = 1000
"""Of the longest period after which all excitations still count as repeating together."""
IN_STEP = 1e-6
"""Share of its own period by which an excitation may be off when all begin again."""


@dataclass(frozen=True)
class Touching:
    """What may touch."""

    contacts: Mapping[str, ContactTable]
    connectors: Sequence[ConnectorTable]
    clips: Sequence[ClipTable]
    library: str | None
    """File of clips beside those of creak."""
    press_fit: bool
    """Whether surfaces that overlap press from the start."""
    units: UnitsName
    places: Places


@dataclass(frozen=True)
class Driving:
    """What drives the model, and what it stands under before."""

    excitations: Mapping[str, ExcitationTable]
    statics: Sequence[StaticTable]
    units: UnitsName
    places: Places

    @property
    def moving(self) -> dict[str, ExcitationTable]:
        """Excitations that prescribe motion."""
        return {name: t for name, t in self.excitations.items() if t.kind != "force"}

    @property
    def forcing(self) -> dict[str, ExcitationTable]:
        """Excitations that are forces."""
        return {name: t for name, t in self.excitations.items() if t.kind == "force"}

    @property
    def period(self) -> float | None:
        """Longest period of the excitations that have one, s; None when nothing is periodic."""
        return max((p for p in self._periods if p is not None), default=None)

    @property
    def repeats(self) -> float | None:
        """s after which all excitations begin again together; None where they hardly ever do, or one never does."""
        periods, longest = self._periods, self.period
        if longest is None or None in periods:
            return None
        whole = longest * np.arange(1.0, MOST_PERIODS + 1.0)
        counts = whole[:, None] / np.array(periods, dtype=float)
        together = np.flatnonzero(np.all(np.abs(counts - np.round(counts)) <= IN_STEP, axis=1))
        return float(whole[together[0]]) if together.size else None

    @property
    def fade(self) -> float:
        """s until all prescribed motion has its level."""
        return max((t.signal.fade for t in self.moving.values()), default=0.0)

    @property
    def _periods(self) -> list[float | None]:
        return [table.signal.repeats for table in self.excitations.values()]


@dataclass(frozen=True)
class Course:
    """How long a run is, when it is written, and what of it is compared."""

    time: TimeTable
    output: OutputTable
    f_max: float
    """Hz, up to which motion is compared."""
    period: float | None
    """s, longest of the excitation."""
    repeats: float | None
    """s after which all of the excitation begins again."""
    fade: float
    """s until prescribed motion has its level."""
    until: float | None
    """s, where the unreduced model is run no longer than that beside the reduced one."""
    places: Places

    @property
    def end(self) -> float:
        """Length of the run, s.

        Raises
        ------
        InputError : neither end nor a periodic excitation.
        """
        if self.time.end is not None:
            return self.time.end
        if self.period is None and self.time.periods is not None:
            raise InputError(
                "periods without a periodic excitation",
                where=self.places.where("time", "periods"),
                fix="Give end instead.",
            )
        if self.period is None:
            raise InputError(
                "the end of the run is not given", where=self.places.where("time"), fix="Add end = ... (s)."
            )
        return self.period * (self.time.periods if self.time.periods is not None else 5.0)


@dataclass(frozen=True)
class Listening:
    """Who hears the contacts, in which room and beside what."""

    listeners: Mapping[str, ListenerTable]
    background: BackgroundTable | None
    room: RoomTable | None
    sharp: str
    """Acum above which time counts as sharp, with its unit."""
    units: UnitsName
    places: Places

    @property
    def metre(self) -> float:
        """m of the deck's length."""
        return METRES[self.units]


@dataclass(frozen=True)
class Lines:
    """Between which parts relative motion is looked at, and what was measured of their materials."""

    elines: Mapping[str, ElineTable]
    contacts: Collection[str]
    """Names of the contacts, which are lines by themselves."""
    materials: Mapping[str, MaterialPairTable]
    library: str | None
    """File of material pairs beside those of the study."""
    tolerance: str | ToleranceFile | None
    """What scatter may take of each gap: with its unit, or a table."""
    percentile: float
    """Of the peaks of motion that is told beside the largest."""
    units: UnitsName
    places: Places
