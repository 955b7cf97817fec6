"""Five-node pyramid.

Nodes: the base 1-2-3-4, turning right-handed towards the apex, then the apex. The rotations have no stiffness.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_square
from creak.elements.solids.common import Reference

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """h_i = [(1 + r_i r)(1 + s_i s) - t + r_i s_i r s t / (1 - t)] / 4 at the base (r, s = -1, 1; t = 0), h_5 = t."""
    r, s, t = points.T[:, :, None]
    ri, si = CORNERS.T
    up = 1.0 / (1.0 - t)
    base = 0.25 * ((1.0 + ri * r) * (1.0 + si * s) - t + ri * si * r * s * t * up)
    by_r = 0.25 * (ri * (1.0 + si * s) + ri * si * s * t * up)
    by_s = 0.25 * (si * (1.0 + ri * r) + ri * si * r * t * up)
    by_t = 0.25 * (-1.0 + ri * si * r * s * up**2)
    zero, one = np.zeros_like(t), np.ones_like(t)
    top = np.stack([np.concatenate(pair, axis=1) for pair in ((by_r, zero), (by_s, zero), (by_t, one))], axis=1)
    return Reference(points, weights, np.concatenate([base, t], axis=1), top)


GAUSS_JACOBI = {
    2: ((-0.754970354689117, 0.08830368802245062), (1.860379610028064, 0.8062870566386026)),
    3: (
        (-0.8540119518537006, -0.30599246792329643, 0.41000441977699675),
        (1.2570908885190917, 1.169970154078929, 0.23960562406864572),
    ),
}
"""Points -> places and weights of the integral of (1 - x)^2 f(x) over -1 to 1, as `roots_jacobi(n, 2, 0)`."""


def _rule(n: int) -> Reference:
    """n Gauss points along each side of the base, shrunk with it towards the apex, times n along the axis with the
    weight (1 - t)^2 (Gauss-Jacobi)."""
    plane, share = gauss_square(n)
    x, w = (np.array(row) for row in GAUSS_JACOBI[n])
    t, weight = 0.5 * (x + 1.0), w / 8.0
    points = [np.column_stack([plane * (1.0 - a), np.full(len(plane), a)]) for a in t]
    return reference(np.concatenate(points), np.concatenate([share * b for b in weight]))


PYRAMID5 = _rule(2), _rule(3)
"""Rules of stiffness and mass.

A fill-in element between hexahedra and tetrahedra, whose faces it fits: like the tetrahedron it is too stiff in bending
and in nearly incompressible material. Source: Bedrosian, Int. J. Numer. Meth. Eng. 35 (1992) 95.
"""
