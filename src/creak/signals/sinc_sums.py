"""Sums of samples weighted by a windowed sinc, at many places."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.jit import njit

NARROW = 9.0
"""Of the window exp(NARROW (sqrt(1 - (x / side)^2) - 1)) (Barnett, Magland and af Klinteberg 2019)."""
TABLE = 256
"""Values of the window for each sample; between them it is straight, to 2e-8."""


def window_table(side: int) -> FloatArray:
    """The window at every `TABLE`th of a sample from the middle, and once more beyond its end."""
    share = np.minimum(np.arange(side * TABLE + 2) / (side * TABLE), 1.0)
    return np.asarray(np.exp(NARROW * (np.sqrt(1.0 - share**2) - 1.0)))


@njit(nogil=True)
def windowed_sums(known: FloatArray, at: FloatArray, window: FloatArray, side: int, out: FloatArray) -> None:
    """`out` (k, n_at) = sums of samples `known` (k, n + 2 side) by sinc(x) window(|x|), x the distance from each.

    sinc(f - j) is (-1)^j sin(pi f) / (pi (f - j)): one sine for all samples around a place.
    """
    for i in range(at.size):
        before = int(at[i])
        f = at[i] - before
        if f == 0.0:
            for c in range(known.shape[0]):
                out[c, i] = known[c, before + side]
            continue
        for c in range(known.shape[0]):
            out[c, i] = 0.0
        sine = np.sin(np.pi * min(f, 1.0 - f)) / np.pi  # exact where a place is nearly a sample
        sign = sine if side % 2 else -sine  # of j = 1 - side
        for j in range(1 - side, side + 1):
            x = f - j
            place = abs(x) * TABLE
            below = int(place)
            weight = sign / x * (window[below] + (place - below) * (window[below + 1] - window[below]))
            for c in range(known.shape[0]):
                out[c, i] += weight * known[c, before + j + side]
            sign = -sign
