"""Six-node shell: MITC7 bending and shear, membrane strains tied along its sides."""

from __future__ import annotations

from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_triangle
from creak.elements.shells import quadratic
from creak.elements.shells.quadratic import Shape, shear_tying
from creak.elements.solids.common import Reference

NODES = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])
"""(r, s) of the six nodes."""
_SIDES = np.array([[1.0, 0.0], [-1.0, 1.0], [0.0, -1.0]])
"""Directions of sides 1-2, 2-3, 3-1."""


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """Corners: L (2 L - 1); between them 4 L_i L_j."""
    r, s = points.T
    L = np.column_stack([1.0 - r - s, r, s])
    after = np.roll(L, -1, axis=1)
    slope = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    slopes = [np.concatenate([(4.0 * L - 1.0) * d, 4.0 * (L * np.roll(d, -1) + after * d)], axis=1) for d in slope]
    return Reference(
        points, weights, np.concatenate([L * (2.0 * L - 1.0), 4.0 * L * after], axis=1), np.stack(slopes, 1)
    )


def _shear_space(points: FloatArray) -> FloatArray:
    """(n, 2, 8): linear, and s (a r + b s), -r (a r + b s)."""
    r, s = points.T
    out = np.zeros((len(points), 2, 8))
    out[:, 0, :3] = out[:, 1, 3:6] = np.stack([np.ones_like(r), r, s], axis=1)
    out[:, 0, 6:] = np.stack([s * r, s * s], axis=1)
    out[:, 1, 6:] = np.stack([-r * r, -r * s], axis=1)
    return out


def _along_sides(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(9, 2) points where strains along the sides are taken, and (n, 3, 9, 3) the covariant strains from them.

    Each is linear, from two points on its side and one in the middle of the parallel through the third.
    """
    a, b = 0.5 - 0.5 / np.sqrt(3.0), 1.0 / np.sqrt(3.0)
    areas = np.array([[1.0 - a, a, 0.0], [a, 1.0 - a, 0.0], [a, a, b]])
    at, spread = [], np.zeros((len(points), 3, 9, 3))
    monomials = np.column_stack([np.ones(len(points)), points])
    for side, (d_r, d_s) in enumerate(_SIDES):
        mine = np.roll(areas, side, axis=1) @ NODES[:3]
        at.append(mine)
        linear = monomials @ np.linalg.inv(np.column_stack([np.ones(3), mine]))
        taken = np.multiply.outer(linear, [d_r * d_r, d_s * d_s, d_r * d_s])
        to = np.array([[1.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 1.0]])[side]
        spread[:, :, 3 * side : 3 * side + 3] += to[:, None, None] * taken[:, None]
    return np.concatenate(at), spread


def _bubble(points: FloatArray) -> FloatArray:
    """(n, 3): 27 r s (1 - r - s) and its slopes."""
    r, s = points.T
    q = 1.0 - r - s
    return 27.0 * np.stack([r * s * q, s * (q - r), r * (q - s)], axis=1)


def _shape() -> Shape:
    points, weights = gauss_triangle()
    full = reference(points, 0.5 * weights)
    at, spread = _along_sides(points)
    ends, offset = NODES[:3], 0.5 / np.sqrt(3.0)
    sides = np.concatenate([ends + (0.5 + sign * offset) * _SIDES for sign in (-1.0, 1.0)])
    sampled = np.concatenate([sides, points])
    conditions = np.zeros((8, 12, 2))
    conditions[range(6), range(6)] = np.concatenate([_SIDES, _SIDES])
    conditions[6, 6:, 0] = conditions[7, 6:, 1] = weights
    tying = shear_tying(_shear_space, points, sampled, conditions)
    few, tied = reference(at, np.zeros(9)), reference(sampled, np.zeros(12))
    return Shape(
        n_corner=3,
        nodes=reference(NODES, np.zeros(6)),
        full=full,
        few=few,
        spread=spread,
        bubble=_bubble(points),
        tied=tied,
        tied_bubble=_bubble(sampled)[:, 0],
        tying=tying,
    )


SHAPE = _shape()


stiffness = partial(quadratic.stiffness, SHAPE)
"""Stiffness of six-node shells, flat or curved, see `shells.quadratic.stiffness`.

Bending and shear are those of MITC7; membrane strains are linear, from three points for each side (Lee and Bathe,
Comput. Struct. 82 (2004) 945). Exact in constant strain and curvature where sides are straight, their middle nodes
in the middle. Sources: Bathe, Brezzi and Cho, Comput. Struct. 32 (1989) 797.

Nodes: corners counter-clockwise about the positive normal, then the middles of sides 1-2, 2-3, 3-1.
"""
mass = partial(quadratic.mass, SHAPE)
"""Consistent mass, six points, exact where sides are straight."""
geometric_stiffness = partial(quadratic.geometric_stiffness, SHAPE)
heat_load = partial(quadratic.heat_load, SHAPE)
