"""Nearest points of facets, against a dense sample of each facet."""

from __future__ import annotations

import numpy as np
import pytest

from creak.model.projection import facet_shape, nearest_points


def surface(kind: str, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 4, 3) of facets on a wavy sheet of unequal rows, and which are triangles."""
    x, y = np.array([0.0, 0.3, 0.7, 2.5, 6.0]), np.array([0.0, 1.0, 1.2, 3.0])
    X, Y = np.meshgrid(x, y, indexing="ij")
    jitter = 0.05 * np.random.default_rng(seed).standard_normal(X.shape)
    P = np.stack([X, Y, 0.3 * np.sin(X) * np.cos(Y) + jitter], axis=2)
    quads = np.stack([P[:-1, :-1], P[1:, :-1], P[1:, 1:], P[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    if kind == "quad":
        return quads, np.zeros(len(quads), dtype=bool)
    halves = quads[:, [0, 1, 2, 2]] if kind == "tri" else quads[:, [0, 1, 1, 1]]
    return halves, np.ones(len(halves), dtype=bool)


def sampled_distance(points: np.ndarray, X: np.ndarray, triangle: np.ndarray, n: int) -> np.ndarray:
    """Smallest distance of each point from n x n points of every facet."""
    r, s = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n)))
    best = np.full(len(points), np.inf)
    for corners, is_tri in zip(X, triangle, strict=True):
        xi = np.column_stack([r, s * (1 - r)] if is_tri else [2 * r - 1, 2 * s - 1])
        N, _ = facet_shape(xi, np.full(xi.shape[0], is_tri))
        best = np.minimum(best, np.linalg.norm(points[:, None] - (N @ corners)[None], axis=2).min(axis=1))
    return best


@pytest.mark.parametrize("kind", ["quad", "tri", "edge"])
def test_nearest_point_is_the_nearest_of_a_dense_sample(kind):
    X, triangle = surface(kind)
    rng = np.random.default_rng(1)
    points = rng.uniform([-1.0, -1.0, -1.0], [7.0, 4.0, 1.0], (60, 3))
    found = nearest_points(points, X, triangle, np.inf)
    assert found.found.all()
    np.testing.assert_allclose(found.shape.sum(axis=1), 1.0, atol=1e-12)
    assert found.shape.min() >= 0.0
    at = np.einsum("nj,njx->nx", found.shape, X[found.facet])
    np.testing.assert_allclose(np.linalg.norm(at - points, axis=1), found.distance, atol=1e-12)
    sample = sampled_distance(points, X, triangle, 81)
    assert (found.distance <= sample + 1e-12).all()
    # Samples are at most 3.5 / 80 apart along a side, so the nearest lies within 0.7 of that in the facet.
    assert (sample - found.distance).max() < 0.7 * 3.5 / 80 * 1.2


def test_points_out_of_reach_are_not_found():
    X, triangle = surface("quad")
    points = np.array([[0.5, 0.5, 0.3], [0.5, 0.5, 9.0], [40.0, 0.0, 0.0]])
    everywhere = nearest_points(points, X, triangle, np.inf)
    near = nearest_points(points, X, triangle, 1.0)
    np.testing.assert_array_equal(everywhere.found, True)
    np.testing.assert_array_equal(near.found, [True, False, False])
    np.testing.assert_allclose(near.shape[0], everywhere.shape[0])


def test_point_above_the_end_of_a_long_facet_finds_it():
    """Its centre is farther away than those of a hundred small facets on the other side."""
    long = np.array([[[0.0, 0, 0], [100.0, 0, 0], [100.0, 1, 0], [0.0, 1, 0]]])
    small = np.array([[[0.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0], [0.0, 1, 0]]]) + np.array([0.0, 0.0, 3.0])
    many = np.concatenate([small + [0.05 * k, 0.0, 0.0] for k in range(100)])
    X = np.concatenate([many, long])
    found = nearest_points(np.array([[2.0, 0.5, 1.0]]), X, np.zeros(len(X), dtype=bool), np.inf)
    assert found.facet[0] == 100
    assert found.distance[0] == pytest.approx(1.0)


def test_node_on_a_corner_takes_all_of_its_weight():
    X, triangle = surface("quad")
    found = nearest_points(X[5, 2][None], X, triangle, np.inf)
    assert sorted(found.shape[0]) == [0.0, 0.0, 0.0, 1.0]
    assert found.distance[0] == 0.0
