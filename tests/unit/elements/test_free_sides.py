"""Sides that no other shell has, where a surface ends, and where its edge bears a twisting moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.elements.free_sides import ending_sides, free_sides, twisting_sides, with_free_sides
from creak.model.materials import PointMass
from creak.model.mesh import ElementBlock
from helpers_fem import shell_section

QUADS = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
"""Side by side, joined at 1-4."""
TRIANGLE = np.array([[3, 4, 6]])
SECTION = shell_section(1.0, 1.0, 0.3)


def block(kind: str, nodes: np.ndarray) -> ElementBlock:
    return ElementBlock(kind, np.arange(len(nodes)), nodes, SECTION, 0)


def test_shared_sides_are_not_free():
    (found,) = free_sides([QUADS])
    np.testing.assert_array_equal(found, [[True, False, True, True], [True, True, True, False]])


def test_neighbours_count_across_blocks_and_kinds():
    """The same quads in two blocks, a triangle on side 4-3 of the first; a point mass on a node is no neighbour."""
    points = replace(block("mass", np.array([[0]])), section=PointMass("P", 1.0))
    one, other, triangle, mass = with_free_sides(
        [block("quad4", QUADS[:1]), block("quad4", QUADS[1:]), block("tri3", TRIANGLE), points]
    )
    np.testing.assert_array_equal(one.own.free_sides, [[True, False, False, True]])
    np.testing.assert_array_equal(other.own.free_sides, [[True, True, True, False]])
    assert triangle.own.free_sides is None  # `twisting_sides` looks for those
    assert mass.own.free_sides is None
    assert other.own.take(slice(0, 1)).free_sides.shape == (1, 4)


def test_no_shells_are_no_sides():
    assert with_free_sides([]) == []
    assert free_sides([]) == ending_sides(np.zeros((0, 3)), []) == []


def corner(angle: float) -> np.ndarray:
    """Two triangles on 0-1-2-3 in the plane, a third that leaves it along 1-2 at an angle, degrees."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1 + c, 0, s]])


FACES = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]])


@pytest.mark.parametrize(("angle", "ends"), [(10.0, False), (30.0, True), (90.0, True)])
def test_a_surface_ends_at_folds_of_more_than_20_degrees(angle, ends):
    (found,) = ending_sides(corner(angle), [FACES])
    np.testing.assert_array_equal(found, [[True, ends, False], [False, True, True], [True, True, ends]])


def test_a_plane_goes_on_below_a_plate_that_stands_on_it():
    """T: 0-1-2-3 goes on in a triangle beyond 1-2, and one that stands on 1-2 ends there, across blocks."""
    coords = np.vstack([corner(0.0), [[1.0, 0.0, 1.0]]])
    flat, upright = ending_sides(coords, [FACES, np.array([[1, 5, 2]])])
    assert not flat[0, 1]
    assert not flat[2, 2]
    assert upright[0, 2]


def test_an_edge_bears_twist_where_the_rotation_across_it_is_held_at_both_ends():
    coords, ends = corner(90.0), np.array([[True, True, False]])
    nodes, x = np.array([0, 1]), np.diag([1.0, 0.0, 0.0])
    of = FACES[:1]
    about_the_side = twisting_sides(coords, of, ends, nodes, np.stack([x, x]))
    np.testing.assert_array_equal(about_the_side, ends)
    across = twisting_sides(coords, of, ends, nodes, np.eye(3) - np.stack([x, x]))
    np.testing.assert_array_equal(across, [[False, True, False]])
    one_end = twisting_sides(coords, of, ends, nodes[:1], np.eye(3)[None])
    np.testing.assert_array_equal(one_end, ends)
