"""Wedges of six and of fifteen nodes: shape functions, and the rules by which stiffness and mass are integrated.

Nodes are the triangle 1-2-3, the nodes 4-5-6 opposite them, then the middles of 1-2, 2-3, 3-1, of 4-5, 5-6, 6-4, and of
1-4, 2-5, 3-6. The rotations have no stiffness. Source: Zienkiewicz and Taylor, The Finite Element Method, vol. 1
(2000), chapter 8.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_triangle
from creak.elements.solids.common import Reference
from creak.model.faces import MIDDLES

_SIDES = MIDDLES["wedge15"][:3]
_IN_PLANE = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
"""Slopes of the area coordinates by r and s."""


def linear(points: FloatArray, weights: FloatArray) -> Reference:
    """h = L_i (1 -+ t)/2 with the area coordinates L = (1 - r - s, r, s) at the points (n_point, 3)."""
    r, s, t = points.T
    area = np.stack([1.0 - r - s, r, s], axis=1)
    low, high = 0.5 * (1.0 - t)[:, None], 0.5 * (1.0 + t)[:, None]
    in_plane = [np.concatenate([low * row, high * row], axis=1) for row in _IN_PLANE]
    slopes = np.stack([*in_plane, np.concatenate([-0.5 * area, 0.5 * area], axis=1)], axis=1)
    return Reference(points, weights, np.concatenate([low * area, high * area], axis=1), slopes)


def quadratic(points: FloatArray, weights: FloatArray) -> Reference:
    """Serendipity, with the area coordinates L = (1 - r - s, r, s).

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


def _rule(n: int, plane: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of the triangle (their weights sum to one) times n along the axis."""
    at, along = np.polynomial.legendre.leggauss(n)
    points = np.column_stack([np.tile(plane, (n, 1)), np.repeat(at, len(plane))])
    return points, 0.5 * np.outer(along, weight).ravel()


WEDGE6 = (linear(*_rule(2, *gauss_triangle())),) * 2
"""Six points in the triangle times two along the axis.

A fill-in element: like the tetrahedron it is too stiff in bending and in nearly incompressible material.
"""
NINE = _rule(3, np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0, np.full(3, 1.0 / 3.0))
WEDGE15 = quadratic(*NINE), quadratic(*_rule(3, *gauss_triangle()))
"""Nine points, three in the triangle times three along the axis (as C3D15); 6 x 3 for the mass, exact for straight
prisms.

No hourglass modes; good in bending, stiff near incompressibility.
"""
