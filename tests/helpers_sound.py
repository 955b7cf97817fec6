"""Filters of whole modes and several listeners."""

from __future__ import annotations

import numpy as np

from creak.sound.forced import LOWEST, high_end, smooth
from creak.sound.rayleigh import HIGHEST, PressureRows, pressure_weights


def pressure_rows(points, volumes, listeners, rate: float, **options) -> PressureRows:
    """`pressure_weights` of each listener (n_listener, 3) times the volumes (n, n_mode) that the points move."""
    band = HIGHEST * rate
    weights, start = zip(
        *(pressure_weights(points, np.array(at), rate, band, **options) for at in listeners), strict=True
    )
    rows = np.zeros((len(weights), max(w.shape[0] for w in weights), volumes.shape[1]))
    for row, w in zip(rows, weights, strict=True):
        row[: w.shape[0]] = w @ volumes
    return PressureRows(rows, np.array(start), rate, band)


def faded(freq, band: float):
    """Gain of each frequency, Hz: 1 from 20 Hz to .85 of the band, falling to 0 at 10 Hz and at its end."""
    return smooth(2.0 * freq / LOWEST - 1.0) * high_end(freq, band)
