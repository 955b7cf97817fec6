"""Do modes lie where the excitation is: its spectrum around each of them."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.loads import Loads

LINES = 1.5
"""Lines of the spectrum to both sides of a mode that count as at it, where its half bandwidth is less."""
ACCELERATION = 2


def driven_level(loads: Loads, frequencies: FloatArray, damping: FloatArray) -> FloatArray:
    """(n,) dB: the excitation's spectrum at each mode, within its half bandwidth, under its highest line.

    Accelerations of supports and forces, the whole record under a Hann window, the largest of all excitations; -inf
    where there is none.
    """
    columns = np.hstack([loads.support[ACCELERATION], loads.force])
    n = loads.time.size
    spectrum = np.abs(np.fft.rfft(columns * np.hanning(n)[:, None], axis=0)) ** 2
    highest = spectrum.max(axis=0, initial=0.0)
    share = (spectrum[:, highest > 0.0] / highest[highest > 0.0]).max(axis=1, initial=0.0)
    line = 1.0 / (n * loads.step)
    half = np.maximum(np.nan_to_num(damping) * frequencies, LINES * line)
    freq, found = np.arange(share.size) * line, np.zeros(frequencies.size)
    for i, (low, high) in enumerate(zip(frequencies - half, frequencies + half, strict=True)):
        found[i] = share[np.searchsorted(freq, low) : np.searchsorted(freq, high) + 1].max(initial=0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(found))
