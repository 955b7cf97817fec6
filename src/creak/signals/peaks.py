"""Largest values of motion that is known at even instants alone."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def largest(samples: FloatArray) -> FloatArray:
    """(m,) largest value of each column of an even series (n, m), between the instants, too.

    It is the top of the parabola through the largest sample and its neighbours, m + (r - l)^2 / (8 (2 m - l - r)). Of a
    sine with k instants in a period the largest sample may be off by (pi / k)^2 / 2 of its amplitude, this by some
    .38 (pi / k)^4: 5 and .4 % for k = 10. At either end of the series it is the sample.
    """
    n, m = samples.shape
    columns, row = np.arange(m), samples.argmax(axis=0)
    top = samples[row, columns]
    inside = np.flatnonzero((row > 0) & (row < n - 1))
    left, right = samples[row[inside] - 1, inside], samples[row[inside] + 1, inside]
    bend = 2.0 * top[inside] - left - right
    rise = np.divide((right - left) ** 2, 8.0 * bend, out=np.zeros(inside.size), where=bend > 0.0)
    found = np.array(top, dtype=np.float64)
    found[inside] += rise
    return found
