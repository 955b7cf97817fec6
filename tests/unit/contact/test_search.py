"""The facet tree: nothing is missed on long, thin, unequal, curved or stacked facets."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.facets import Facets
from creak.contact.search import facet_tree, project_along, project_closest
from creak.model.faces import shapes_of
from creak.model.projection import meet_facets
from helpers_fem import random_rotation


def facets(x: np.ndarray) -> Facets:
    """Facets with nodes of their own."""
    n = len(x)
    one = np.ones(n)
    triangle = (x[:, 2] == x[:, 3]).all(axis=1)
    nodes = np.arange(4 * n).reshape(n, 4)
    nodes[triangle, 3] = nodes[triangle, 2]
    return Facets(nodes, x, np.zeros(n, dtype=np.int64), one, one, one, one, shapes_of(nodes, []))


def strips(width: np.ndarray, length: float, *, triangles: bool = False) -> np.ndarray:
    """Rectangles side by side in the plane z = 0, (n, 4, 3)."""
    y = np.concatenate([[0.0], np.cumsum(width)])
    x = np.zeros((width.size, 4, 3))
    x[:, 1:3, 0] = length
    x[:, :2, 1], x[:, 2:, 1] = y[:-1, None], y[1:, None]
    if triangles:
        x = x[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(-1, 4, 3)
    return x


def brute_force(points: np.ndarray, main: Facets, limit: float, directions: np.ndarray | None):
    """Nearest meeting among all facets, inf where there is none."""
    best = np.full(len(points), np.inf)
    for f in range(main.count):
        rows = np.full(len(points), f)
        N, distance, d, inside = meet_facets(points, main.coords[rows], main.is_triangle[rows], directions)
        miss = np.linalg.norm(N @ main.coords[f] - points - distance[:, None] * d, axis=1)
        good = inside & (np.abs(distance) <= limit) & (miss < 1e-6 * np.maximum(1e-2, np.abs(distance)))
        best = np.where(good, np.minimum(best, np.abs(distance)), best)
    return best


def wavy(n: int) -> np.ndarray:
    s = np.linspace(0.0, 1.0, n + 1)
    x, y = np.meshgrid(s, s, indexing="ij")
    grid = np.stack([x, y, 0.1 * np.sin(7 * x) * np.cos(5 * y)], axis=-1)
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2).reshape(-1, 4, 3)


SURFACES = {
    "long thin strips": strips(np.full(60, 0.01), 1.0),
    "long thin triangles": strips(np.full(40, 0.015), 1.0, triangles=True),
    "widths from 1e-4 to 1": strips(np.geomspace(1e-4, 1.0, 40), 1.0),
    "wavy": wavy(9),
    "a plate under fine strips": np.concatenate([strips(np.full(50, 0.01), 0.5), strips(np.ones(1), 3.0) - 0.3]),
    "one facet": strips(np.ones(1), 1.0),
}


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("seed", [1, 2])
def test_tree_finds_what_a_look_at_every_facet_finds(name, seed):
    rng = np.random.default_rng(seed)
    R = random_rotation(seed)
    x = SURFACES[name]
    low, high = x.min(axis=(0, 1)), x.max(axis=(0, 1))
    points = rng.uniform(low - 0.1, high + [0.1, 0.1, 0.3], (150, 3))
    main = facets(x @ R.T)
    points = points @ R.T
    direction = rng.standard_normal((150, 3)) * 0.3 + R @ [0.0, 0.0, 1.0]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    for met, given in (
        (project_along(points, direction, main, 0.5), direction),
        (project_closest(points, main, 0.5), None),
    ):
        expected = brute_force(points, main, 0.5, given)
        np.testing.assert_array_equal(met.found, np.isfinite(expected))
        assert met.found.sum() > 20
        np.testing.assert_allclose(np.abs(met.distance), expected, atol=1e-12)


@pytest.mark.slow
def test_few_candidates_are_tried_on_a_large_mesh(monkeypatch):
    """10,000 points over 100,000 facets: a few projections a point, whatever lies over the border."""
    from creak.contact import search

    main = facets(wavy(316))
    points = np.random.default_rng(0).uniform([-0.5, -0.5, 0.12], [1.5, 1.5, 0.3], (10_000, 3))
    tried = []

    def counting(p, *args):
        tried.append(len(p))
        return meet_facets(p, *args)

    monkeypatch.setattr(search, "meet_facets", counting)
    met = project_along(points, np.tile([0.0, 0.0, -1.0], (10_000, 1)), main, 0.5)
    inside = ((points[:, :2] > 0.0) & (points[:, :2] < 1.0)).all(axis=1)
    np.testing.assert_array_equal(met.found, inside)
    assert sum(tried) < 3 * inside.sum()
    tried.clear()
    project_closest(points, main, 0.5)
    assert sum(tried) < 10 * inside.sum()


def test_lines_along_a_flat_surface_try_none_of_its_facets(monkeypatch):
    """The sides of a solid that stands on a plate: each point of them would meet each facet in its line."""
    from creak.contact import search

    x = np.concatenate([strips(np.full(40, 0.025), 0.025) + [0.025 * j, 0.0, 0.0] for j in range(40)])
    points = np.random.default_rng(0).uniform([0.0, 0.0, 0.0], [1.0, 1.0, 0.1], (200, 3))
    tried = []

    def counting(p, *args):
        tried.append(len(p))
        return meet_facets(p, *args)

    monkeypatch.setattr(search, "meet_facets", counting)
    met = project_along(points, np.tile([1.0, 0.0, 0.0], (200, 1)), facets(x), 2.0)
    assert not met.found.any()
    assert sum(tried) == 0
    met = project_along(points, np.tile([0.0, 0.0, -1.0], (200, 1)), facets(x), 2.0)
    assert met.found.all()


def test_a_flat_facet_is_met_in_one_step_and_looked_at_once_more(monkeypatch):
    """Newton's steps on a parallelogram are exact, so eight of them are six too many."""
    from creak.model import projection

    solved = []
    solve = np.linalg.solve

    def counting(a, b):
        solved.append(len(a))
        return solve(a, b)

    monkeypatch.setattr(projection.np.linalg, "solve", counting)
    x = strips(np.ones(1), 1.0)[[0] * 50]
    points = np.random.default_rng(0).uniform([0.0, 0.0, 0.1], [1.0, 1.0, 0.2], (50, 3))
    down = np.tile([0.0, 0.0, -1.0], (50, 1))
    _, distance, _, inside = meet_facets(points, x, np.zeros(50, dtype=bool), down)
    assert inside.all()
    np.testing.assert_allclose(distance, points[:, 2], atol=1e-14)
    assert solved == [50, 50]


def test_tree_halves_its_groups():
    tree = facet_tree(facets(wavy(9)))
    assert sorted(tree.order.tolist()) == list(range(81))
    size = np.diff(tree.bounds)
    assert size.max() <= 4
    assert size.min() >= 2
    for level in tree.levels:
        assert (level.sine <= 1.0).all()
    assert tree.levels[-1].radius.max() < 0.5 * tree.levels[0].radius[0]


def test_a_meeting_that_is_not_accepted_gives_way_to_the_next():
    main = facets(np.concatenate([strips(np.ones(1), 1.0), strips(np.ones(1), 1.0) - [0.0, 0.0, 0.2]]))
    point, down = np.array([[0.5, 0.5, 0.1]]), np.array([[0.0, 0.0, -1.0]])
    met = project_along(point, down, main, 1.0, lambda row, facet, distance, direction: facet == 1)
    assert met.facet[0] == 1
    assert met.distance[0] == pytest.approx(0.3)
    none = project_closest(point, main, 1.0, lambda row, facet, distance, direction: facet > 5)
    assert not none.found[0]
