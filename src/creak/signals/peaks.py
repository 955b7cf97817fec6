"""Largest values of motion that is known at even instants alone."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray

NUMBERS = 2**22
"""Of series that are gone through at a time."""


def largest(samples: FloatArray) -> FloatArray:
    """(...) largest value of even series (n, ...), between the instants, too.

    It is a sample, or the highest top of the parabolas through three samples l, m, r that lies between them,
    m + (r - l)^2 / (8 (2 m - l - r)). Of a sine with k instants in a period the largest sample may be off by
    (pi / k)^2 / 2 of its amplitude, this by some .38 (pi / k)^4: 5 and .4 % for k = 10.
    """
    series = samples.reshape(len(samples), -1)
    found = np.empty(series.shape[1])
    step = max(1, NUMBERS // len(series))
    for first in range(0, found.size, step):
        some = slice(first, first + step)
        high = np.array(series[:, some], dtype=np.float64)
        if len(high) > 2:
            rise, bend = high[2:] - high[:-2], -np.diff(high, 2, axis=0)
            turns = (bend > 0.0) & (np.abs(rise) <= 2.0 * bend)
            high[1:-1] += np.divide(rise**2, 8.0 * bend, out=np.zeros_like(bend), where=turns)
        found[some] = high.max(axis=0)
    return found.reshape(samples.shape[1:])
