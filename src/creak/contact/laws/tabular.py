"""Tabular pressure-overclosure: p = scale f(-g) while closed, f piecewise linear through the points of a curve.

f starts at f(0) = 0 and rises; beyond the last point the last slope goes on. A damper adds c g' as in `linear`, with
the same closure at zero gap. Source: softened contact by table, Abaqus *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR;
measured force-displacement curves of seals and bumpers. Valid for loading and unloading on one curve (no hysteresis
beside the damper's). A plateau of the table gets LEAST_SLOPE times the mean slope, so that forces stay unique.
"""

from __future__ import annotations

from creak.contact.laws.pieces import add_piece
from creak.linalg.compiled import either

LEAST_SLOPE = 1e-9
"""Least slope of a segment as a fraction of the mean slope of its curve."""


@either
def segment_slope(x, y, j, start, end):  # type: ignore[no-untyped-def]
    """Slope of the segment after point j of the curve that owns points start to end."""
    mean = (y[end - 1] - y[start]) / (x[end - 1] - x[start])
    j = min(j, end - 2)
    return max((y[j + 1] - y[j]) / (x[j + 1] - x[j]), LEAST_SLOPE * mean)


@either
def segment_at(x, start, end, overclosure):  # type: ignore[no-untyped-def]
    """The point after which the segment of an overclosure begins."""
    j = start
    while j + 2 < end and x[j + 1] < overclosure:
        j += 1
    return j


@either
def curve_force(x, y, start, end, overclosure):  # type: ignore[no-untyped-def]
    """f(overclosure), 0 while open."""
    if overclosure <= 0.0:
        return 0.0
    j = segment_at(x, start, end, overclosure)
    return y[j] + segment_slope(x, y, j, start, end) * (overclosure - x[j])


@either
def curve_energy(x, y, start, end, overclosure):  # type: ignore[no-untyped-def]
    """Integral of f from 0 to the overclosure."""
    energy, j = 0.0, start
    while j < end - 1 and x[j] < overclosure:
        length = overclosure - x[j] if j == end - 2 else min(overclosure, x[j + 1]) - x[j]
        energy += length * (y[j] + 0.5 * segment_slope(x, y, j, start, end) * length)
        j += 1
    return energy


@either
def tabular_pieces(law, at, x, y, start, end, scale, slope, c_hat):  # type: ignore[no-untyped-def]
    """Pieces of scale f(y) + slope y - c_hat, clipped at 0: the jump, then the segments. Returns the next place.

    slope = a c >= 0 and c_hat come from the damper (see `linear`). Room for end - start + 1 pieces is needed.
    """
    if c_hat < 0.0:
        at = add_piece(law, at, 0.0, 0.0, 0.0)
    force = -c_hat
    for j in range(start, end - 1):
        steepness = scale * segment_slope(x, y, j, start, end) + slope
        length = x[j + 1] - x[j]
        if force >= 0.0:
            at = add_piece(law, at, force, x[j], 1.0 / steepness)
        elif j == end - 2 or force + steepness * length > 0.0:
            at = add_piece(law, at, 0.0, x[j] - force / steepness, 1.0 / steepness)
        force += steepness * length
    return at
