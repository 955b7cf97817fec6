"""Gauss points of squares and triangles."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def gauss_square(n_side: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre product rule on [-1, 1]^2: points (n_side^2, 2) and weights (n_side^2,)."""
    at, weight = np.polynomial.legendre.leggauss(n_side)
    r, s = np.meshgrid(at, at, indexing="ij")
    return np.column_stack([r.ravel(), s.ravel()]), np.outer(weight, weight).ravel()


def gauss_triangle() -> tuple[FloatArray, FloatArray]:
    """Six-point rule on the unit triangle, exact to degree four.

    Points (6, 2) in (r, s) and weights (6,) that sum to one (multiply by the area).
    Source: Strang and Fix (1973); Dunavant, Int. J. Numer. Meth. Eng. 21 (1985) 1129, degree 4.
    """
    a, b = 0.445948490915965, 0.091576213509771
    points = [(a, a), (1 - 2 * a, a), (a, 1 - 2 * a), (b, b), (1 - 2 * b, b), (b, 1 - 2 * b)]
    weights = [0.223381589678011] * 3 + [0.109951743655322] * 3
    return np.array(points), np.array(weights) / sum(weights)
