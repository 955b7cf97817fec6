"""Tetrahedra of four and of ten nodes: shape functions, and the rules by which stiffness and mass are integrated.

The fourth corner lies on the side to which 1-2-3 turn right-handed; middle nodes are those of 1-2, 2-3, 3-1, 1-4, 2-4,
3-4. The rotations have no stiffness.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.solids.common import Reference
from creak.model.faces import MIDDLES

EDGES = MIDDLES["tet10"]
CORNER_SLOPES = np.array([[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 1.0]])


def linear(points: FloatArray, weights: FloatArray) -> Reference:
    """h = L = (1 - r - s - t, r, s, t) at the points (n_point, 3)."""
    L = np.column_stack([1.0 - points.sum(axis=1), points])
    return Reference(points, weights, L, np.tile(CORNER_SLOPES, (len(points), 1, 1)))


def quadratic(points: FloatArray, weights: FloatArray) -> Reference:
    """h_i = L_i (2 L_i - 1) at the corners and 4 L_i L_j between them, L = (1 - r - s - t, r, s, t)."""
    L = np.column_stack([1.0 - points.sum(axis=1), points])
    shapes = [L[:, i] * (2.0 * L[:, i] - 1.0) for i in range(4)] + [4.0 * L[:, i] * L[:, j] for i, j in EDGES]
    slopes = [(4.0 * L[:, i, None] - 1.0) * CORNER_SLOPES[:, i] for i in range(4)]
    slopes += [4.0 * (L[:, i, None] * CORNER_SLOPES[:, j] + L[:, j, None] * CORNER_SLOPES[:, i]) for i, j in EDGES]
    return Reference(points, weights, np.stack(shapes, axis=1), np.stack(slopes, axis=2))


def _four_points() -> tuple[FloatArray, FloatArray]:
    """Rule of degree two: Hammer and Stroud (1956)."""
    a, b = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
    return (np.full((4, 4), a) + (b - a) * np.eye(4))[:, 1:], np.full(4, 1.0 / 24.0)


def _fourteen_points() -> tuple[FloatArray, FloatArray]:
    """Rule of degree five with positive weights: Walkington (2000)."""
    orbits = ((0.31088591926330060980, 0.018781320953002641800), (0.092735250310891226402, 0.012248840519393658257))
    edge, edge_weight = 0.045503704125649649492, 0.0070910034628469110730
    points, weights = [], []
    for a, w in orbits:
        barycentric = np.full((4, 4), a) + (1.0 - 4.0 * a) * np.eye(4)
        points.append(barycentric[:, 1:])
        weights += [w] * 4
    pairs = [(i, j) for i in range(4) for j in range(i)]
    barycentric = np.full((6, 4), edge)
    for row, pair in enumerate(pairs):
        barycentric[row, list(pair)] = 0.5 - edge
    points.append(barycentric[:, 1:])
    return np.concatenate(points), np.array([*weights, *[edge_weight] * 6])


TET4 = linear(np.full((1, 3), 0.25), np.array([1.0 / 6.0])), linear(*_four_points())
"""Constant strain, and mass rho V/20 (1 + delta_ij) on each translation.

Much too stiff in bending (some ten elements through the thickness are needed) and locked in nearly incompressible
material; use hexahedra where the answer depends on it. Source: Zienkiewicz and Taylor, The Finite Element Method, vol.
1 (2000), chapter 6.
"""
TET10 = quadratic(*_four_points()), quadratic(*_fourteen_points())
"""Four points, exact where the edges are straight and the middle nodes centred; fourteen for the mass, exact where the
edges are straight.

Good in bending with one element through the thickness; stiff near incompressibility. Source: as above, chapter 8.
"""
