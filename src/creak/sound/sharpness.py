"""Sharpness, DIN 45692:2009: how far up the critical bands the loudness lies."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.sound.zwicker_tables import ACUM, BARK, SHARPNESS

FAINT = 0.1
"""sone: softer sounds are given no sharpness."""


def sharpness(specific: FloatArray) -> FloatArray:
    """.11 int N' g z dz / int N' dz of specific loudness (n, 240), (n,) acum.

    g = 1 up to 15.8 Bark and .15 exp(.42 (z - 15.8)) + .85 above. 0 where the loudness is below .1 sone.
    """
    width = float(BARK[0])
    total = width * specific.sum(axis=1)
    heard = total >= FAINT
    return np.asarray(np.where(heard, ACUM * width * (specific @ SHARPNESS) / np.where(heard, total, 1.0), 0.0))
