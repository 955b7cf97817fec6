"""Records with uneven steps: means over other cells of time that keep every integral, and their low-pass."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray
from creak.signals.spectra import low_pass

BLOCK = 4_000_000
"""Numbers worked on at a time."""
SAMPLES = 128
"""Even samples per period of the low-pass: a blow that is far shorter than a sample is a hundredth of a per cent off
then, a fourth of as many leave it off by one. Means over their cells keep .9999 of f_max."""


def cells(at: FloatArray, start: float, end: float) -> FloatArray:
    """(n + 1,) edges of the time that each instant stands for: halfway to its neighbours, within `start` to `end`."""
    if at.size == 1:
        return np.array([start, end])
    middle = 0.5 * (at[1:] + at[:-1])
    first, last = max(start, 2.0 * at[0] - middle[0]), min(end, 2.0 * at[-1] - middle[-1])
    return np.concatenate([[first], middle, [last]])


def cell_means(time: FloatArray, x: FloatArray, at: FloatArray) -> FloatArray:
    """Means (n_at, k) of x (n_time, k) over the cells of the instants `at`.

    x is taken as constant over the cells of its own instants (see `cells`), so its trapezoidal sum is its integral and
    the sum of the means, each times its cell, is the same integral. Both time axes rise and may be uneven; `at` lies
    within `time`.
    """
    if np.array_equal(at, time):
        return x
    own, wanted = cells(time, time[0], time[-1]), cells(at, time[0], time[-1])
    row = np.clip(np.searchsorted(own, wanted, side="right") - 1, 0, time.size - 1)
    into, own_width, width = (wanted - own[row])[:, None], np.diff(own)[:, None], np.diff(wanted)[:, None]
    out = np.empty((at.size, x.shape[1]))
    for here in blocks(x.shape[1], time.size):
        values = x[:, here]
        total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(own_width * values, axis=0)])
        out[:, here] = np.diff(total[row] + into * values[row], axis=0) / width
    return out


def cell_peaks(time: FloatArray, x: FloatArray, at: FloatArray) -> FloatArray:
    """Largest values (n_at, k) of x (n_time, k) within the cells of the instants `at`, some of those of `time`."""
    edges = cells(at, time[0], time[-1])[:-1]
    return x if np.array_equal(at, time) else np.maximum.reduceat(x, np.searchsorted(time, edges), axis=0)


def low_pass_uneven(time: FloatArray, x: FloatArray, f_max: float) -> tuple[FloatArray, FloatArray]:
    """x (n_time, k) without content above `f_max` Hz on an even axis: times (n,) and values (n, k).

    The even step is the shortest of the record, or a period of f_max over 128 where that is longer; means over its
    cells keep the integral (`cell_means`). Where all steps are equal and not shorter than that, x itself is filtered.
    """
    step = max(float(np.diff(time).min()), 1.0 / (SAMPLES * f_max))
    even = time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-6) + 1)
    even[-1] = min(even[-1], time[-1])
    return even, low_pass(cell_means(time, x, even), step, f_max)


def blocks(count: int, width: int) -> Iterator[slice]:
    """`count` columns or rows of `width` numbers each, a bounded number of them at a time."""
    few = max(1, BLOCK // max(width, 1))
    return (slice(k, min(k + few, count)) for k in range(0, count, few))
