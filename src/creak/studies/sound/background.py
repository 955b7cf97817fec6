"""The steady sound that contacts are heard beside, as the study gives it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.sound.zwicker_tables import BANDS
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import BackgroundTable
from creak.studies.file.tables import read_table

NOTHING = -100.0
"""dB of bands that are not given."""
NEAR = 0.02
"""Share by which a frequency may be off the middle of its band: nominal ones and those to base 2 are by up to 1.3 %."""
LOUDEST = 120.0
"""dB, of any band."""
NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
"""Of the third octaves of a decade."""
OCTAVE = 3
"""Third octaves."""
LOWEST, HIGHEST, FIRST = -20, 13, -16
"""Third octaves from 1 kHz, of 10 Hz, of 20 kHz and of the first of `BANDS`."""


def background_of(table: BackgroundTable | None, places: Places) -> FloatArray | None:
    """(28,) dB re 20 uPa of the third octaves from 25 Hz to 12.5 kHz; None: the study gives no levels.

    The file has third octaves, or octaves, whose energy is shared equally by their third octaves. Bands that loudness
    does not know are read and left out.

    Raises
    ------
    InputError : no such file, a wrong header, a frequency that is no third octave, one twice, a band left out between
        others, a level above 120 dB.
    """
    if table is None or table.file is None:
        return None
    path = places.sibling(table.file)
    freq, level = read_table(path, places.where("background", "file"), ("frequency", "level"))
    band = np.rint(10.0 * np.log10(np.maximum(freq, 1e-3) / 1000.0)).astype(np.int64)
    off = (np.abs(freq / (1000.0 * 10.0 ** (0.1 * band)) - 1.0) > NEAR) | (band < LOWEST) | (band > HIGHEST)
    if off.any():
        raise InputError(
            f"{freq[off][0]:g} Hz is no third octave from {_name(LOWEST)} to {_name(HIGHEST)} Hz",
            where=path,
            expected="nominal frequencies: 25, 31.5, 40, 50, 63, 80, 100, ...; of octaves 31.5, 63, 125, ...",
            fix="Give third-octave or octave levels.",
        )
    if np.unique(band).size < band.size:
        raise InputError("two levels of one third octave", where=path, expected="one of each")
    if level.max() > LOUDEST:
        raise InputError(
            f"a level of {level.max():g} dB",
            where=path,
            expected=f"dB re 20 uPa, {LOUDEST:g} at most",
            fix="Check its unit.",
        )
    band, level = _thirds(band, level, path)
    known = (band >= FIRST) & (band < FIRST + BANDS.size)
    found = np.full(BANDS.size, NOTHING)
    found[band[known] - FIRST] = np.maximum(level[known], NOTHING)
    return found


def _thirds(band: IntArray, level: FloatArray, path: Path) -> tuple[IntArray, FloatArray]:
    """Third octaves, of bands in order that are third octaves or octaves without a hole.

    Raises
    ------
    InputError : they are neither.
    """
    apart = np.diff(band)
    if (apart == 1).all():
        return band, level
    if (apart == OCTAVE).all() and band[0] % OCTAVE == 0:
        each = band[:, None] + np.arange(-1, OCTAVE - 1)
        return each.ravel(), np.repeat(level - 10.0 * np.log10(OCTAVE), OCTAVE)
    hole = int(np.flatnonzero(apart != (OCTAVE if (band % OCTAVE == 0).all() else 1))[0])
    raise InputError(
        f"no level between {_name(int(band[hole]))} and {_name(int(band[hole + 1]))} Hz",
        where=path,
        expected="every third octave, or every octave, from the first to the last",
        fix=f"Give the others too; {NOTHING:g} dB is silence.",
    )


def _name(band: int) -> str:
    """Nominal frequency of a third octave, Hz."""
    digits = NOMINAL[band % len(NOMINAL)]
    return f"{digits * 10.0 ** (3 + band // len(NOMINAL)):g}"
