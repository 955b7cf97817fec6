"""Which main facet lies opposite a point: tree search and projection onto bilinear facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets

CANDIDATES = 16
"""Facets tried per point: those with the nearest centroids."""
OVERHANG = 1e-3
"""How far outside a facet (in parametric coordinates, -1..1) a projection still counts."""
NEWTON_STEPS = 8


@dataclass(frozen=True)
class Projection:
    """Where points meet the main surface; rows with `found` False have no partner."""

    found: BoolArray
    facet: IntArray
    shape: FloatArray
    """(n, 4) shape functions of the facet's nodes at the meeting point."""
    distance: FloatArray
    """(n,) signed, along `direction` from the point to the facet."""
    direction: FloatArray
    """(n, 3) unit vectors."""


def project_along(points: FloatArray, directions: FloatArray, main: Facets, limit: float) -> Projection:
    """Meet the main facets along given directions (both ways), nearest first."""
    return _best(points, main, limit, directions)


def project_closest(points: FloatArray, main: Facets, limit: float) -> Projection:
    """Meet the main facets along their own normals."""
    return _best(points, main, limit, None)


def _best(points: FloatArray, main: Facets, limit: float, directions: FloatArray | None) -> Projection:
    n, k = points.shape[0], min(CANDIDATES, main.count)
    _, near = cKDTree(main.coords.mean(axis=1)).query(points, k=k)
    near = near.reshape(n, k)
    best = Projection(
        np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64), np.zeros((n, 4)), np.full(n, np.inf), np.zeros((n, 3))
    )
    for column in range(k):
        facet = near[:, column]
        shape, distance, normal, inside = _meet(points, main, facet, directions)
        better = inside & (np.abs(distance) < np.abs(best.distance)) & (np.abs(distance) <= limit)
        best.found[better] = True
        best.facet[better] = facet[better]
        best.shape[better] = shape[better]
        best.distance[better] = distance[better]
        best.direction[better] = normal[better]
    return best


def _meet(
    points: FloatArray, main: Facets, facet: IntArray, directions: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Solve x + lambda d = sum N_j(xi) X_j by Newton; d is given, or the facet's normal at xi."""
    X, triangle = main.coords[facet], main.is_triangle[facet]
    n = points.shape[0]
    xi, lam = np.zeros((n, 2)), np.zeros(n)
    xi[triangle] = 1.0 / 3.0
    d = np.zeros((n, 3))
    for _ in range(NEWTON_STEPS):
        N, dN = _shape(xi, triangle)
        tangents = np.einsum("nja,njx->nax", dN, X)
        if directions is None:
            d = np.cross(tangents[:, 0], tangents[:, 1])
            d /= np.maximum(np.linalg.norm(d, axis=1), 1e-300)[:, None]
        else:
            d = directions
        gap = np.einsum("nj,njx->nx", N, X) - points - lam[:, None] * d
        J = np.stack([-tangents[:, 0], -tangents[:, 1], d], axis=2)
        regular = np.abs(np.linalg.det(J)) > 1e-12 * np.linalg.norm(tangents, axis=2).prod(axis=1)
        J[~regular] = np.eye(3)
        update = np.linalg.solve(J, gap[:, :, None])[:, :, 0]
        xi = np.clip(xi + update[:, :2], -4.0, 4.0)
        lam = lam + update[:, 2]
    N, _ = _shape(xi, triangle)
    low = np.where(triangle, 0.0, -1.0) - OVERHANG
    inside = (xi >= low[:, None]).all(axis=1) & regular
    inside &= np.where(triangle, xi.sum(axis=1), xi.max(axis=1)) <= 1.0 + OVERHANG
    return N, lam, d, inside


def _shape(xi: FloatArray, triangle: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (n, 4) and derivatives (n, 4, 2); triangles use the first three columns."""
    r, s = xi[:, 0], xi[:, 1]
    N = 0.25 * np.stack([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)], axis=1)
    dr = 0.25 * np.stack([-(1 - s), 1 - s, 1 + s, -(1 + s)], axis=1)
    ds = 0.25 * np.stack([-(1 - r), -(1 + r), 1 + r, 1 - r], axis=1)
    dN = np.stack([dr, ds], axis=2)
    if triangle.any():
        t = triangle
        N[t] = np.stack([1 - r[t] - s[t], r[t], s[t], np.zeros(t.sum())], axis=1)
        dN[t] = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    return N, dN
