"""Spectra and largest values of motion that is known at even instants."""

from __future__ import annotations

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
