"""Eight-node shell: MITC9 bending and shear, membrane strains sampled at 2 x 2 points."""

from __future__ import annotations

from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_square
from creak.elements.shells import quadratic
from creak.elements.shells.quad4_geometry import CORNERS
from creak.elements.shells.quad4_geometry import shape as bilinear
from creak.elements.shells.quadratic import Shape, shear_tying
from creak.elements.solids.common import Reference, serendipity

NODES = np.concatenate([CORNERS, 0.5 * (CORNERS + np.roll(CORNERS, -1, axis=0))])
"""(r, s) of the eight nodes."""


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """Shape functions at the points (n_point, 2)."""
    return serendipity(NODES, points, weights)


def _shear_space(points: FloatArray) -> FloatArray:
    """(n, 2, 10): g_r of 1, r, s, r s, s^2, g_s of 1, r, s, r s, r^2."""
    r, s = points.T
    common = np.stack([np.ones_like(r), r, s, r * s])
    out = np.zeros((len(points), 2, 10))
    out[:, 0, :5] = np.stack([*common, s * s], axis=1)
    out[:, 1, 5:] = np.stack([*common, r * r], axis=1)
    return out


def _bubble(points: FloatArray) -> FloatArray:
    """(n, 3): (1 - r^2)(1 - s^2) and its slopes."""
    r, s = points.T
    return np.stack([(1 - r * r) * (1 - s * s), -2 * r * (1 - s * s), -2 * s * (1 - r * r)], axis=1)


def _shape() -> Shape:
    few, full = reference(*gauss_square(2)), reference(*gauss_square(3))
    at = float(np.abs(few.points).max())
    corner = [int(np.argmin(np.abs(few.points - at * c).sum(axis=1))) for c in CORNERS]
    spread = np.zeros((9, 4))
    spread[:, corner] = bilinear(full.points / at)
    sides = np.array([[at, -1.0], [-at, -1.0], [at, 1.0], [-at, 1.0], [1.0, at], [1.0, -at], [-1.0, at], [-1.0, -at]])
    sampled = np.concatenate([sides, full.points])
    conditions = np.zeros((10, 17, 2))
    conditions[range(8), range(8), [0, 0, 0, 0, 1, 1, 1, 1]] = 1.0
    conditions[8, 8:, 0] = conditions[9, 8:, 1] = full.weights
    tying = shear_tying(_shear_space, full.points, sampled, conditions)
    tied = reference(sampled, np.zeros(17))
    return Shape(
        n_corner=4,
        nodes=reference(NODES, np.zeros(8)),
        full=full,
        few=few,
        spread=spread,
        bubble=_bubble(full.points),
        tied=tied,
        tied_bubble=_bubble(sampled)[:, 0],
        tying=tying,
    )


SHAPE = _shape()


stiffness = partial(quadratic.stiffness, SHAPE)
"""Stiffness of eight-node shells, flat or curved, see `shells.quadratic.stiffness`.

Membrane strains are sampled at 2 x 2 points; shear and bending are those of MITC9, whose deflection has the eight
nodes and whose rotations have a ninth. Exact in constant strain and curvature
where sides are straight, their middle nodes in the middle. Sides whose middle nodes lie off the middle, and
angles far from 90 degrees, cost accuracy, as with all serendipity elements. Sources: Ahmad, Irons and Zienkiewicz,
Int. J. Numer. Meth. Eng. 2 (1970) 419; Bathe, Brezzi and Cho, Comput. Struct. 32 (1989) 797.

Nodes: corners counter-clockwise about the positive normal, then the middles of sides 1-2, 2-3, 3-4, 4-1.
"""
mass = partial(quadratic.mass, SHAPE)
"""Consistent mass, 3 x 3 points."""
geometric_stiffness = partial(quadratic.geometric_stiffness, SHAPE)
heat_load = partial(quadratic.heat_load, SHAPE)
