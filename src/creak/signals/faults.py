"""What the samples of a measured course alone show to be wrong with it: its sensor fell out or was at its limit, single
samples are none, or it was sampled too slowly."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray

STILL, CUT = 8, 3
"""Equal samples in a row from which on a sensor may have fallen out, and at its limit."""
JUMP = 0.5
"""Share of the usual change from sample to sample by which a course jumps to where it stands, or away."""
COARSE = 4.0
"""Smallest steps between samples up to which a jump or a peak is one of their rounding."""
OVER = 0.01
"""Share of all that is spanned by which a peak that was cut off went on."""
APART, FEW = 5.0, 5
"""How far spikes stand out over the next ones, and how many of them there are at most."""
TOP, ANY = 0.1, 0.03
"""Of the frequencies that samples hold, the uppermost, and the share of the power there that is too much."""


def dropouts(x: FloatArray) -> IntArray:
    """(n, 2) first and last sample of stretches within x (n_sample,) that stand still and begin or end by a jump.

    None where x stands still for most of the time: pulses with pauses are no road.
    """
    runs = _runs(x, STILL)
    runs = runs[(runs[:, 0] > 0) & (runs[:, 1] < x.size - 1)]
    runs = runs[(x[runs[:, 0]] > x.min()) & (x[runs[:, 0]] < x.max())]
    if not runs.size or 2 * np.diff(runs).sum() > x.size:
        return runs[:0]
    change, least = np.abs(np.diff(x)), _least(x)
    jump = np.maximum(change[runs[:, 0] - 1], change[runs[:, 1]])
    return runs[jump > max(JUMP * np.sqrt(np.mean(change[change > 0.0] ** 2)), COARSE * least)]


def cut_off(x: FloatArray) -> IntArray:
    """(n, 2) first and last sample of the peaks of x (n_sample,) that stand at its highest or its lowest value, where
    the slopes beside them would have gone on."""
    runs = _runs(x, CUT)
    runs = runs[(runs[:, 0] > 1) & (runs[:, 1] < x.size - 2)]
    runs = runs[(x[runs[:, 0]] == x.max()) | (x[runs[:, 0]] == x.min())]
    before, after = runs[:, 0], runs[:, 1]
    slope = np.minimum(np.abs(x[before - 1] - x[before - 2]), np.abs(x[after + 1] - x[after + 2]))
    beyond = 0.25 * (after - before + 1) * slope  # of a parabola with these slopes
    cut = beyond > max(OVER * np.ptp(x), COARSE * _least(x))
    return runs if cut.sum() > 1 and 2 * np.diff(runs).sum() < x.size else runs[:0]


def spikes(x: FloatArray) -> IntArray:
    """Single samples of x (n_sample,) that stand out from both neighbours, by more than all others span."""
    left, right = x[1:-1] - x[:-2], x[1:-1] - x[2:]
    alone = np.where(left * right > 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
    order = np.argsort(alone)[::-1][: FEW + 1]
    high = alone[order]
    far = np.flatnonzero(high[:-1] > APART * high[1:]) if alone.size > 2 * FEW and high[-1] > 0.0 else order[:0]
    found = np.sort(order[: int(far.max(initial=-1)) + 1] + 1)
    return found if found.size and alone[found - 1].min() > np.ptp(np.delete(x, found)) else found[:0]


def reaches_top(x: FloatArray) -> bool:
    """Whether x (n_sample,) has power up to the highest frequency that its samples hold: what was above is folded."""
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(x.size))) ** 2
    return bool(power[int((1.0 - TOP) * power.size) :].sum() > ANY * power.sum())


def _runs(x: FloatArray, least: int) -> IntArray:
    """(n, 2) first and last of so many equal samples or more."""
    ends = np.flatnonzero(np.diff(x, append=np.nan) != 0.0)
    runs = np.stack([np.concatenate([[0], ends[:-1] + 1]), ends], axis=1)
    return runs[np.diff(runs)[:, 0] + 1 >= least]


def _least(x: FloatArray) -> float:
    """The smallest step between two of its samples."""
    change = np.abs(np.diff(x))
    return float(change[change > 0.0].min(initial=np.inf))
