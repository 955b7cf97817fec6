"""Recorded sounds beside computed ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from creak.given import items_of, path_of

if TYPE_CHECKING:
    from creak.formats.measured.recordings import Recording
    from creak.studies.sound.beside import SoundComparison


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
