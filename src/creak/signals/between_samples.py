"""What evenly sampled values stand for between their samples: sums of them weighted by a windowed sinc."""

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


SIDE = 32
"""Samples on either side that count: a sine up to .45 of the sampling rate is met within 1e-4. A cubic spline keeps .85
of one at .39 of it, and adds one of .14 at .61."""
EVEN = 0.01
"""Share of a step by which even samples may stand off the straight line."""


JITTER = 0.5
"""Share of the usual step by which steps may differ from it for the samples to be put on even times."""
FEWEST = 16
"""Samples from which on that is done."""


def even_step(time: FloatArray) -> float | None:
    """s of the even step that n >= 2 rising times stand for, along the line from the first to the last; None: some
    stand off it.

    They may do so by `EVEN` of the step, or by one in the last decimal place they are rounded to, which is at most a
    tenth of the step: a time that is missing moves the line by half a step.
    """
    step = float(time[-1] - time[0]) / (time.size - 1)
    place = 10.0 ** np.floor(np.log10(0.1 * step))
    whole = time / place
    rounded = bool((np.abs(whole - np.rint(whole)) < 1e-3).all())
    off = np.abs(time - (time[0] + step * np.arange(time.size))).max()
    return step if off <= (1.001 * place if rounded else EVEN * step) else None


def evened(time: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray, float] | None:
    """An uneven course (n,) at n even times from its first to its last, and how far off that may be; None: steps
    differ by more than `JITTER` of the usual one, as where a sample is missing.

    Values are those of the cubic spline through the samples, whose error falls with the fourth power of the step. So
    it is 1/16 of what the spline through every other sample misses the others by, here as a share of the rms about
    the mean. De Boor, A Practical Guide to Splines, chapter V.
    """
    from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

    between = np.diff(time)
    usual = float(np.median(between))
    if time.size < FEWEST or np.abs(between - usual).max() > JITTER * usual:
        return None
    even = np.linspace(time[0], time[-1], time.size)
    known, asked = slice(0, None, 2), slice(1, time.size - 1, 2)
    missed = CubicSpline(time[known], value[known])(time[asked]) - value[asked]
    spread = float(np.std(value))
    off = float(np.sqrt(np.mean(missed**2))) / (16.0 * spread) if spread else 0.0
    return even, CubicSpline(time, value)(even), off


def between_samples(x: FloatArray, at: FloatArray) -> FloatArray:
    """Values (k, n_at) of the band-limited courses through samples x (k, n); the first and last hold outside.

    Each is the sum of the samples around it, weighted by a windowed sinc (Shannon). What comes before the first and
    after the last sample is not known: towards them, over `SIDE` samples, a cubic spline takes over.

    Parameters
    ----------
    at : (n_at,) counted in samples from the first.
    """

    n = x.shape[1]
    at = np.clip(at, 0.0, n - 1.0)
    known = np.pad(x, ((0, 0), (SIDE, SIDE)), mode="reflect", reflect_type="odd")
    out = np.empty((x.shape[0], at.size))
    windowed_sums(np.ascontiguousarray(known, dtype=np.float64), at, window_table(SIDE), SIDE, out)
    return _ends_by_splines(x, at, out)


def _ends_by_splines(x: FloatArray, at: FloatArray, found: FloatArray) -> FloatArray:
    from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

    n = x.shape[1]
    for first, last in ((0, min(n, 4 * SIDE)), (max(0, n - 4 * SIDE), n)):
        edge = at if first == 0 else n - 1.0 - at
        near = np.flatnonzero(edge < SIDE)
        s = edge[near] / SIDE
        share = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        spline = CubicSpline(np.arange(first, last), x[:, first:last], axis=1)(at[near])
        found[:, near] = share * found[:, near] + (1.0 - share) * spline
    return found
