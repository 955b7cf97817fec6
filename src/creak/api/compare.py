"""Two results side by side, and recorded sounds beside computed ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from creak.api.result import Result
from creak.api.saved import SavedResult, open_result
from creak.errors import InputError
from creak.given import items_of, of_kind, path_of

if TYPE_CHECKING:
    from creak.formats.measured.recordings import Recording
    from creak.report.tables.comparison import Comparison, Side
    from creak.studies.findings.beside_records import RecordComparison
    from creak.studies.sound.beside import SoundComparison


def compare(a: str | Path | Result | SavedResult, b: str | Path | Result | SavedResult) -> Comparison:
    """Settings, figures of the whole run, places, events and relative motion of two results side by side.

    Places of a contact that share nodes are one place; events that start within the verification's `event_tolerance`
    of `a` are one event.

    Parameters
    ----------
    a, b : results, or folders that `creak run` wrote.

    Raises
    ------
    InputError : what is no result, a folder without one, the same folder twice, results in different units or without
        a run.
    """
    from creak.report.tables.comparison import compare_results

    for which, x in (("first", a), ("second", b)):
        expected = "a result of creak.run or creak.open_result, or a folder that `creak run` wrote"
        of_kind(x, (str, Path, Result, SavedResult), f"the {which} of the two", expected)
    names = [Path(x).resolve().name if isinstance(x, str | Path) else x.summary["title"] or "result" for x in (a, b)]
    if isinstance(a, str | Path) and isinstance(b, str | Path) and Path(a).resolve() == Path(b).resolve():
        raise InputError(f"{a} and {b} are the same folder", expected="two results")
    if names[0] == names[1] and isinstance(a, str | Path) and isinstance(b, str | Path):
        names = [str(a), str(b)]
    elif names[0] == names[1]:
        names = [f"{name} ({which})" for name, which in zip(names, ("first", "second"), strict=True)]
    return compare_results(_side(names[0], a), _side(names[1], b))


def compare_records(results: str | Path, test: str | Path, run: str | None = None) -> RecordComparison:
    """Time histories of a test over those of a run, aligned by one shift in time.

    Parameters
    ----------
    results : folder that `creak run` wrote.
    test : CSV with a column for each channel, universal file (58) or RPC III. Channels are named as what they measure:
        `1017 Z`, `flange gap`, `flange force`, `flange:3 normal force`.
    run : reduced or reference; None: the reduced one where there are both.

    Returns
    -------
    RecordComparison: shift, pairs (name, unit, fit), notes; `as_dict()` for JSON.

    Raises
    ------
    InputError : a file is wrong, or no channel is one that the run computed.
    """
    from creak.studies.findings import beside_records
    from creak.studies.findings.stored import read_findings

    results, test = path_of(results, "results"), path_of(test, "test")
    found, _ = read_findings(results, lambda _: None)
    f_max = found.setup.study.config.verification.f_max
    return beside_records.compare_records(results, test, f_max, run)


def _side(name: str, result: str | Path | Result | SavedResult) -> Side:
    from creak.report.tables.comparison import Side

    at_hand = result if isinstance(result, Result | SavedResult) else open_result(result)
    return Side(name, at_hand.findings)


def read_recordings(
    path: str | Path,
    *,
    calibration: float | None = None,
    calibrator: str | Path | None = None,
    level: float | None = None,
) -> tuple[Recording, ...]:
    """The channels of a WAV file as pressure.

    Parameters
    ----------
    calibration : Pa of full scale; or `calibrator`, a WAV file recorded with the same gain, of a tone of `level` dB re
        20 uPa. Files of creak tell their own.

    Raises
    ------
    InputError : no WAV file, none or two calibrations, a calibrator that is no steady tone, silence, less than .2 s, a
        sampling rate outside 8 kHz to 10 MHz.
    """
    from creak.formats.measured.recordings import read_recordings as read

    return read(path_of(path, "path"), calibration, calibrator, level)


def compare_sounds(
    folder: str | Path, recordings: Sequence[Recording], *, listener: str | None = None
) -> SoundComparison:
    """What a run computed at a listener and what was recorded: the same figures, third octaves and N(t), ranked.

    Recordings are heard whole, and up to the end of the run's band.

    Parameters
    ----------
    folder : that `creak run` wrote. recordings : of `read_recordings`. listener : NAME; the first unless given.

    Raises
    ------
    InputError : no result with a sound, no such listener, no recording.
    """
    from creak.formats.measured.recordings import Recording
    from creak.studies.sound.beside import beside

    heard = items_of(recordings, Recording, "recordings", "a list of what creak.read_recordings makes")
    return beside(path_of(folder, "folder"), heard, listener)
