"""Spectra and largest values of motion that is known at even instants; of records with uneven steps means over other
cells of time that keep every integral, and their low-pass."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from creak.arrays import ComplexArray, FloatArray

NUMBERS = 2**22
"""Of series that are gone through at a time."""


def spectrum(x: FloatArray, step: float, f_max: float) -> tuple[FloatArray, ComplexArray]:
    """One-sided complex amplitudes of x (n_time, ...) over exactly its span, up to `f_max` Hz.

    A line of A cos(2 pi f t + phi) with whole periods gives A exp(i phi).

    Returns
    -------
    freq : (n_freq,) Hz, without 0. amplitude : (n_freq, ...).
    """
    n = x.shape[0]
    freq = np.fft.rfftfreq(n, step)
    amplitude = np.fft.rfft(x, axis=0) * (2.0 / n)
    keep = (freq > 0.0) & (freq <= f_max * (1.0 + 1e-9))
    return np.asarray(freq[keep], dtype=np.float64), np.asarray(amplitude[keep])


def low_pass(x: FloatArray, step: float, f_max: float) -> FloatArray:
    """x (n_time, ...) without content above `f_max`: Butterworth of order 4, forward and backward (no delay).

    Returns x itself where the sampling cannot hold more than `f_max`.
    """
    if f_max >= 0.45 / step or x.shape[0] < 16:
        return x
    from scipy.signal import sosfiltfilt  # half a second, which runs and commands without filters do not pay

    sections = _butterworth(2.0 * f_max * step)
    return np.asarray(sosfiltfilt(sections, x, axis=0, padtype="constant", padlen=min(x.shape[0] - 1, 100)))


@lru_cache(maxsize=64)
def _butterworth(edge: float) -> FloatArray:
    """Second-order sections of order 4, edge as a share of the Nyquist frequency: events of a run share them."""
    from scipy.signal import butter

    return np.asarray(butter(4, edge, output="sos"))


def largest(samples: FloatArray, time: FloatArray | None = None) -> FloatArray:
    """(...) largest value of series (n, ...) at times (n,), or even ones (None), between the instants, too.

    It is a sample, or the highest top of the parabolas through three samples l, m, r that lies between them, of even
    ones m + (r - l)^2 / (8 (2 m - l - r)). Of a sine with k instants in a period the largest sample may be off by
    (pi / k)^2 / 2 of its amplitude, this by some .38 (pi / k)^4: 5 and .4 % for k = 10.
    """
    series = samples.reshape(len(samples), -1)
    before, after = (h[:, None] for h in (np.diff(time)[:-1], np.diff(time)[1:])) if time is not None else (1.0, 1.0)
    found = np.empty(series.shape[1])
    step = max(1, NUMBERS // len(series))
    for first in range(0, found.size, step):
        some = slice(first, first + step)
        high = np.array(series[:, some], dtype=np.float64)
        if len(high) > 2:
            up, on = np.diff(high, axis=0)[:-1] / before, np.diff(high, axis=0)[1:] / after
            slope, bend = (up * after + on * before) / (before + after), 2.0 * (up - on) / (before + after)
            turns = (bend > 0.0) & (slope <= bend * after) & (-slope <= bend * before)
            high[1:-1] += np.divide(slope**2, 2.0 * bend, out=np.zeros_like(bend), where=turns)
        found[some] = high.max(axis=0)
    return found.reshape(samples.shape[1:])


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
