"""The steady sound that contacts are heard beside, as the study gives it."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.sound.zwicker_tables import BANDS
from creak.studies.file.reader import Study
from creak.studies.file.tables import read_table

NOTHING = -100.0
"""dB of bands that are not given."""
NEAR = 0.02
"""Share by which a frequency may be off the middle of its band: nominal ones are by up to 1 %."""
LOUDEST = 120.0
"""dB, of any band."""


def background_of(study: Study) -> FloatArray | None:
    """(28,) dB re 20 uPa of the third octaves from 25 Hz to 12.5 kHz; None: the study gives no background.

    Raises
    ------
    InputError : no such file, a wrong header, a frequency that is no third octave, one twice, a level above 120 dB.
    """
    table = study.config.background
    if table is None:
        return None
    path = study.sibling(table.file)
    freq, level = read_table(path, study.where("background", "file"), ("frequency", "level"))
    band = np.abs(freq[:, None] / BANDS - 1.0).argmin(axis=1)
    off = np.abs(freq / BANDS[band] - 1.0) > NEAR
    if off.any():
        raise InputError(
            f"{freq[off][0]:g} Hz is no third octave from 25 Hz to 12.5 kHz",
            where=path,
            expected="nominal frequencies: 25, 31.5, 40, 50, 63, 80, 100, ...",
            fix="Give third-octave levels.",
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
    found = np.full(BANDS.size, NOTHING)
    found[band] = np.maximum(level, NOTHING)
    return found
