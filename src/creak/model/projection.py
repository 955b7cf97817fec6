"""Points and shell facets: shape functions, projection along a direction, nearest point.

A facet is four corners. A triangle repeats its third corner, an edge (of two ends) its second corner twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray

OVERHANG = 1e-3
"""How far outside a facet (in parametric coordinates, -1..1) a projection still counts."""
NEWTON_STEPS = 8
STILL = 1e-13
"""Least movement in a step, in parametric coordinates and as a share of the length, with which another follows."""
POINTS_AT_ONCE = 4096
"""Points whose nearest facets are sought at a time; bounds the memory."""
SAME = 1e-9
"""Share of a facet's size below which two points are the same."""


@dataclass(frozen=True)
class Nearest:
    """The nearest points of a surface; rows with `found` False have none within reach."""

    found: BoolArray
    facet: IntArray
    shape: FloatArray
    """(n, 4) shape functions of the facet's corners there; they sum to one and none is negative."""
    distance: FloatArray
    """(n,) from the point to the facet."""


def facet_shape(xi: FloatArray, triangle: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (n, 4) and derivatives (n, 4, 2): bilinear on -1..1, triangles linear on the first three."""
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


def meet_facets(
    points: FloatArray, X: FloatArray, triangle: BoolArray, directions: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Solve x + lambda d = sum N_j(xi) X_j by Newton; d is given, or the facet's normal at xi.

    Parameters
    ----------
    points : (n, 3); X : (n, 4, 3) corners of the facet of each point; triangle : (n,).

    Returns
    -------
    N (n, 4), lambda (n,), d (n, 3), and whether the meeting point lies on the facet (n,), up to `OVERHANG`.
    """
    n = points.shape[0]
    xi, lam = np.zeros((n, 2)), np.zeros(n)
    xi[triangle] = 1.0 / 3.0
    d = np.zeros((n, 3)) if directions is None else directions
    regular = np.ones(n, dtype=bool)
    size = np.linalg.norm(X[:, 2] - X[:, 0], axis=1)
    left = np.arange(n)  # flat facets are met in one step: only what still moves goes on
    for _ in range(NEWTON_STEPS):
        N, dN = facet_shape(xi[left], triangle[left])
        tangents = np.einsum("nja,njx->nax", dN, X[left])
        if directions is None:
            normal = np.cross(tangents[:, 0], tangents[:, 1])
            d[left] = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        gap = np.einsum("nj,njx->nx", N, X[left]) - points[left] - lam[left, None] * d[left]
        J = np.stack([-tangents[:, 0], -tangents[:, 1], d[left]], axis=2)
        good = np.abs(np.linalg.det(J)) > 1e-12 * np.linalg.norm(tangents, axis=2).prod(axis=1)
        J[~good] = np.eye(3)
        update = np.linalg.solve(J, gap[:, :, None])[:, :, 0]
        moved = np.clip(xi[left] + update[:, :2], -4.0, 4.0)
        still = (np.abs(moved - xi[left]) <= STILL).all(axis=1)
        still &= np.abs(update[:, 2]) <= STILL * (np.abs(lam[left]) + size[left])
        xi[left], regular[left] = moved, good
        lam[left] += update[:, 2]
        left = left[~still]
        if not left.size:
            break
    N, _ = facet_shape(xi, triangle)
    low = np.where(triangle, 0.0, -1.0) - OVERHANG
    inside = (xi >= low[:, None]).all(axis=1) & regular
    inside &= np.where(triangle, xi.sum(axis=1), xi.max(axis=1)) <= 1.0 + OVERHANG
    return N, lam, d, inside


def nearest_points(points: FloatArray, X: FloatArray, triangle: BoolArray, limit: float) -> Nearest:
    """The nearest point of a surface to each point: inside a facet, on an edge or at a corner.

    Parameters
    ----------
    points : (n, 3); X : (m, 4, 3) corners of the facets; triangle : (m,) true for triangles and edges.
    limit : reach; points farther from the surface than this are not found.
    """
    from scipy.spatial import cKDTree  # a tenth of a second, which runs without it do not pay

    n, centre = points.shape[0], X.mean(axis=1)
    radius = np.linalg.norm(X - centre[:, None], axis=2).max(axis=1)
    corners, centres = cKDTree(X.reshape(-1, 3)), cKDTree(centre)
    best = Nearest(np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64), np.zeros((n, 4)), np.full(n, np.inf))
    for start in range(0, n, POINTS_AT_ONCE):
        mine = np.arange(start, min(start + POINTS_AT_ONCE, n))
        # The nearest facet is no farther than the nearest corner.
        reach = np.minimum(corners.query(points[mine])[0], limit) * (1.0 + SAME) + SAME * radius.max()
        near = centres.query_ball_point(points[mine], reach + radius.max())
        row = np.repeat(mine, [len(f) for f in near])
        facet = np.concatenate([np.array(f, dtype=np.int64) for f in near])
        shape, distance = _nearest_on_facet(points[row], X[facet], triangle[facet])
        order = np.lexsort((facet, distance, row))
        first = order[np.unique(row[order], return_index=True)[1]]
        first = first[distance[first] <= limit + SAME * radius[facet[first]]]
        best.found[row[first]] = True
        best.facet[row[first]] = facet[first]
        best.shape[row[first]] = shape[first]
        best.distance[row[first]] = distance[first]
    return best


def _nearest_on_facet(points: FloatArray, X: FloatArray, triangle: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (n, 4) and distance (n,) of the point of one facet nearest to each point."""
    shape, distance = _nearest_on_border(points, X)
    N, _, _, inside = meet_facets(points, X, triangle, None)
    away = np.linalg.norm(np.einsum("nj,njx->nx", N, X) - points, axis=1)
    size = np.linalg.norm(X - X.mean(axis=1)[:, None], axis=2).max(axis=1)
    better = inside & (N >= 0.0).all(axis=1) & (away < distance - SAME * size)
    return np.where(better[:, None], N, shape), np.where(better, away, distance)


def _nearest_on_border(points: FloatArray, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same among the edges of the facet."""
    along = np.roll(X, -1, axis=1) - X
    square = (along**2).sum(axis=2)
    t = ((points[:, None] - X) * along).sum(axis=2) / np.where(square > 0.0, square, 1.0)
    t = np.clip(t, 0.0, 1.0)
    t = np.where(t < SAME, 0.0, np.where(t > 1.0 - SAME, 1.0, t))
    away = np.linalg.norm(X + t[:, :, None] * along - points[:, None], axis=2)
    edge = np.argmin(away, axis=1)
    every = np.arange(points.shape[0])
    shape = np.zeros((points.shape[0], 4))
    shape[every, edge] = 1.0 - t[every, edge]
    shape[every, (edge + 1) % 4] += t[every, edge]
    return shape, away[every, edge]
