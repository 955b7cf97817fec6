"""The curve through the points of a table: as smooth as they are, without overshoot where they have corners."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from creak.arrays import BoolArray, FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

APART = 0.03
"""Distance of both splines over the largest change of the table near it, from which on there is a corner."""
NEAR = 2
"""Intervals to both sides that count as near."""
ROUNDS = 20


def smooth_table(time: FloatArray, value: FloatArray) -> CubicHermiteSpline:
    """The cubic spline where it and the modified Akima spline are alike, and that one at corners and plateaus.

    A cubic spline has continuous second derivatives, off by h^2 / 12 of their own second derivative: an acceleration
    that can be used. At a corner it swings to both sides. A modified Akima spline does not swing, but its second
    derivative is off by as much as it is, however close the points lie. Where both differ in the middle of an interval
    by more than `APART` of what the table changes by near it, the slopes at its ends are those of the latter, and the
    cubic spline is found anew between them.

    Parameters
    ----------
    time : (k,) strictly increasing, k >= 2. value : (k,)
    """
    from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline, CubicSpline  # see `signals.spectra`

    akima = np.asarray(Akima1DInterpolator(time, value, method="makima")(time, 1))
    slope, fixed = akima.copy(), np.zeros(time.size, dtype=bool)
    slope[[0, -1]] = CubicSpline(time, value)(time[[0, -1]], 1)
    fixed[[0, -1]] = True
    h, allowed = np.diff(time), APART * _largest_near(np.abs(np.diff(value))) + 1e-12 * np.ptp(value)
    for _ in range(ROUNDS):
        found = _with_continuous_bends(h, np.diff(value) / h, slope, fixed)
        off = found - akima
        corner = np.abs(h / 8.0 * (off[:-1] - off[1:])) > allowed
        ends = np.concatenate([[False], corner]) | np.concatenate([corner, [False]])
        if not (ends & ((found != akima) | ~fixed)).any():
            break
        fixed |= ends
        slope[ends] = akima[ends]
    return CubicHermiteSpline(time, value, found)


def _with_continuous_bends(h: FloatArray, rise: FloatArray, slope: FloatArray, fixed: BoolArray) -> FloatArray:
    """Slopes at the points: those that are fixed, and between them those of continuous second derivatives.

    h_i d_(i-1) + 2 (h_(i-1) + h_i) d_i + h_(i-1) d_(i+1) = 3 (h_i rise_(i-1) + h_(i-1) rise_i)
    """
    from scipy.linalg import solve_banded

    i = np.flatnonzero(~fixed)
    bands, right = np.zeros((3, slope.size)), slope.copy()
    bands[1] = 1.0
    bands[0, i + 1], bands[1, i], bands[2, i - 1] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
    right[i] = 3.0 * (h[i] * rise[i - 1] + h[i - 1] * rise[i])
    return np.asarray(solve_banded((1, 1), bands, right))


def _largest_near(size: FloatArray) -> FloatArray:
    found = size.copy()
    for k in range(1, min(NEAR, size.size - 1) + 1):
        found[k:] = np.maximum(found[k:], size[:-k])
        found[:-k] = np.maximum(found[:-k], size[k:])
    return found
