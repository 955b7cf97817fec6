"""Measures of the relative motion at points between two parts: across the gap and in its plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.signals.spectra import largest

RIPPLE = 0.05
"""Share of the peak-to-peak by which a motion leaves its mean before that counts as a stretch on one side of it."""
DEFINITION = (
    "A peak of the closing displacement is its largest value in a stretch above its mean; a peak of "
    "the in-plane motion is the swing from one extreme to the next, stretches above and below the mean in turn, along "
    "the direction of its largest peak-to-peak. A stretch leaves the mean by more than 5 % of the peak-to-peak. The "
    "percentile is that of the peaks of a point, interpolated linearly."
)
"""What the percentiles are of."""


@dataclass(frozen=True)
class PointMeasures:
    """Of p points over a window of a run, length; z opens the gap."""

    closing: FloatArray
    """(p,) largest closing displacement, -z, from the unloaded state."""
    closing_percentile: FloatArray
    """(p,) percentile of its peaks (`DEFINITION`)."""
    across: FloatArray
    """(p,) peak-to-peak along z."""
    along: FloatArray
    """(p, 2) peak-to-peak along x and y."""
    in_plane: FloatArray
    """(p,) largest principal peak-to-peak: over all directions in the plane that of the motion along them."""
    in_plane_percentile: FloatArray
    """(p,) percentile of the swings along that direction."""


def measure(motion: FloatArray, percentile: float) -> PointMeasures:
    """Measures of the relative motion.

    Parameters
    ----------
    motion : (n, p, 3) displacement of the secondary side relative to the main one along x, y, z of each point.
    percentile : of the peaks, %.
    """
    closing = 0.0 - motion[:, :, 2]
    span = largest(motion) + largest(-motion)
    planes = [largest_swing(np.ascontiguousarray(motion[:, j, :2])) for j in range(motion.shape[1])]
    swings = [_percentile(_swings(s), percentile) for _, s in planes]
    return PointMeasures(
        largest(closing),
        np.array([_percentile(_peaks(closing[:, j]), percentile) for j in range(motion.shape[1])]),
        span[:, 2],
        span[:, :2],
        np.array([width for width, _ in planes]),
        np.array(swings),
    )


def joined(pieces: list[PointMeasures]) -> PointMeasures:
    """Measures of points in turn."""
    names = PointMeasures.__dataclass_fields__
    return PointMeasures(**{n: np.concatenate([getattr(p, n) for p in pieces]) for n in names})


def largest_swing(path: FloatArray) -> tuple[float, FloatArray]:
    """Largest peak-to-peak of a plane motion over all directions, and the motion along the direction that has it.

    The widest projection of points in a plane is as wide as the farthest two of them are apart, so both are corners of
    their convex hull.

    Parameters
    ----------
    path : (n, 2)
    """
    from scipy.spatial import ConvexHull, QhullError  # see `signals.spectra.low_pass`
    from scipy.spatial.distance import pdist, squareform

    about = path - path.mean(axis=0)
    try:
        corners = about[ConvexHull(about).vertices]
    except (QhullError, ValueError):  # on a line, or at rest
        along = about @ np.linalg.svd(about.T @ about)[0][:, 0]
        return float(np.ptp(along)), along
    apart = squareform(pdist(corners))
    i, j = np.unravel_index(int(apart.argmax()), apart.shape)
    direction = (corners[j] - corners[i]) / apart[i, j]
    return float(apart[i, j]), about @ direction


def _stretches(values: FloatArray) -> tuple[IntArray, BoolArray]:
    """First rows of the stretches above and below the mean in turn, and which of them are above.

    A stretch begins where the values leave the mean by more than `RIPPLE` of their peak-to-peak, on the other side.
    """
    about, beside = values - values.mean(), RIPPLE * float(np.ptp(values))
    far = np.flatnonzero(np.abs(about) > beside)
    if not far.size:
        return np.zeros(1, dtype=np.int64), np.ones(1, dtype=bool)
    above = about[far] > 0.0
    turns = np.flatnonzero(above[1:] != above[:-1]) + 1
    return np.concatenate([[0], far[turns]]).astype(np.int64), above[np.concatenate([[0], turns])]


def _peaks(values: FloatArray) -> FloatArray:
    """Largest value of each stretch above the mean; where there is none the largest value."""
    first, above = _stretches(values)
    return np.asarray(np.maximum.reduceat(values, first)[above]) if above.any() else values.max(keepdims=True)


def _swings(values: FloatArray) -> FloatArray:
    """From the extreme of each stretch on one side of the mean to that of the next."""
    first, above = _stretches(values)
    high, low = np.maximum.reduceat(values, first), np.minimum.reduceat(values, first)
    extremes = np.where(above, high, low)
    return np.asarray(np.abs(np.diff(extremes))) if extremes.size > 1 else np.zeros(1)


def _percentile(values: FloatArray, percentile: float) -> float:
    return float(np.percentile(values, percentile))
