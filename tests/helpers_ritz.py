"""Rayleigh-Ritz of Mindlin plates with any D and S: products of Legendre polynomials on a parallelogram."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre

from creak.model.materials import GeneralShell

HELD = {"F": (False, False, False), "S": (True, False, True), "C": (True, True, True)}
"""Of an edge: deflection, rotation across it, rotation along it (hard support)."""


def plate_frequencies(
    section: GeneralShell, a: float, b: float, edges: str, count: int, *, skew: float = 0.0, n: int = 11
) -> np.ndarray:
    """Hz, rigid modes left out. Sides a along x and b at `skew` (radian) from y; edges x = 0, y = 0, x = a, y = b.

    Held edges of a skew plate may be clamped only. `n` functions in each direction for each of w, beta_x, beta_y.
    """
    at, weight = legendre.leggauss(n + 4)
    jacobian = 0.5 * np.array([[a, 0.0], [b * np.sin(skew), b * np.cos(skew)]])
    inverse, dA = np.linalg.inv(jacobian), np.linalg.det(jacobian)
    held = np.array([HELD[e] for e in edges])
    fields = []
    for x_column, y_column in ((0, 0), (1, 2), (2, 1)):
        X, dX = _functions(n, *held[[0, 2], x_column], at)
        Y, dY = _functions(n, *held[[1, 3], y_column], at)
        value, by_xi, by_eta = (np.kron(p, q) for p, q in ((X, Y), (dX, Y), (X, dY)))
        fields.append((value, *(row[0] * by_xi + row[1] * by_eta for row in inverse)))
    w, p, q = fields
    zero = np.zeros_like(w[0])
    bent = [np.vstack(rows) for rows in ((zero, p[1], zero), (zero, zero, q[2]), (zero, p[2], q[1]))]
    sheared = [np.vstack(rows) for rows in ((w[1], p[0], zero), (w[2], zero, q[0]))]
    area = np.outer(weight, weight).ravel() * dA
    K = sum(
        C[i, j] * (left * area) @ right.T
        for C, strains in ((section.D, bent), (section.S, sheared))
        for i, left in enumerate(strains)
        for j, right in enumerate(strains)
    )
    density = (section.mass, section.rotary_inertia, section.rotary_inertia)
    M = scipy.linalg.block_diag(*(m * (f[0] * area) @ f[0].T for m, f in zip(density, fields, strict=True)))
    scale = 1.0 / np.sqrt(M.diagonal())
    rigid = 3 if edges == "FFFF" else 0
    S = np.outer(scale, scale)
    values = scipy.linalg.eigh(K * S, M * S, eigvals_only=True, subset_by_index=[rigid, rigid + count - 1])
    return np.sqrt(values) / (2.0 * np.pi)


def _functions(n: int, left: bool, right: bool, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (n, n_point), zero at the held ends of [-1, 1]."""
    edge = legendre.poly2leg([1.0])
    for end, factor in ((left, [1.0, 1.0]), (right, [1.0, -1.0])):
        edge = legendre.legmul(edge, factor) if end else edge
    made = [legendre.legmul(edge, row) for row in np.eye(n)]
    return tuple(np.array([legendre.legval(at, f) for f in fs]) for fs in (made, [legendre.legder(f) for f in made]))
