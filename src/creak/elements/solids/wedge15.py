"""Fifteen-node wedge (serendipity)."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_triangle
from creak.elements.solids.common import Reference, consistent_mass, isoparametric_stiffness
from creak.model.faces import MIDDLES
from creak.model.materials import SolidSection
from creak.model.mesh import COMMON, Own

_SIDES = MIDDLES["wedge15"][:3]
_IN_PLANE = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
"""Slopes of the area coordinates by r and s."""


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """Shape functions at the points (n_point, 3), with the area coordinates L = (1 - r - s, r, s).

    Corners: h = L_i ((2 L_i - 1)(1 -+ t) - (1 - t^2))/2; between corners of a triangle: 2 L_i L_j (1 -+ t); between the
    triangles: L_i (1 - t^2).
    """
    L = np.column_stack([1.0 - points[:, 0] - points[:, 1], points[:, :2]])
    low, high, bow = (f[:, None] for f in (1.0 - points[:, 2], 1.0 + points[:, 2], 1.0 - points[:, 2] ** 2))
    t = points[:, 2:]
    side = np.stack([L[:, i] * L[:, j] for i, j in _SIDES], axis=1)
    ends = [0.5 * L * ((2.0 * L - 1.0) * f - bow) for f in (low, high)]
    shapes = np.concatenate([*ends, 2.0 * side * low, 2.0 * side * high, L * bow], axis=1)
    slopes = []
    for d in _IN_PLANE:
        d_side = np.stack([d[i] * L[:, j] + L[:, i] * d[j] for i, j in _SIDES], axis=1)
        ends = [0.5 * d * ((4.0 * L - 1.0) * f - bow) for f in (low, high)]
        slopes.append(np.concatenate([*ends, 2.0 * d_side * low, 2.0 * d_side * high, d * bow], axis=1))
    ends = [0.5 * L * (sign * (2.0 * L - 1.0) + 2.0 * t) for sign in (-1.0, 1.0)]
    slopes.append(np.concatenate([*ends, -2.0 * side, 2.0 * side, -2.0 * t * L], axis=1))
    return Reference(points, weights, shapes, np.stack(slopes, axis=1))


def _rule(plane: FloatArray, weight: FloatArray) -> Reference:
    """Points of the triangle (their weights sum to one) times three along the axis."""
    at, along = np.polynomial.legendre.leggauss(3)
    points = np.column_stack([np.tile(plane, (3, 1)), np.repeat(at, len(plane))])
    return reference(points, 0.5 * np.outer(along, weight).ravel())


NINE = _rule(np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0, np.full(3, 1.0 / 3.0))
EIGHTEEN = _rule(*gauss_triangle())


def stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = integral of B' D B with nine points, three in the triangle times three along the axis (as C3D15).

    No hourglass modes; good in bending, stiff near incompressibility. Source: Zienkiewicz and Taylor, The Finite
    Element Method, vol. 1 (2000), chapter 8.

    Nodes: the triangle 1-2-3, the nodes 4-5-6 opposite them, then the middles of 1-2, 2-3, 3-1, of 4-5, 5-6, 6-4, and
    of 1-4, 2-5, 3-6. The rotations have no stiffness.
    """
    return isoparametric_stiffness(coords, section, NINE, own)


def mass(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass with 6 x 3 points, exact for straight prisms, see `consistent_mass`."""
    return consistent_mass(coords, section, EIGHTEEN, own)
