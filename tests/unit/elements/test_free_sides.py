"""Sides of quadrilateral shells that no other shell has, also across blocks and next to triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.elements.free_sides import free_sides, with_free_sides
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
    assert triangle.own.free_sides is None
    assert mass.own.free_sides is None
    assert other.own.take(slice(0, 1)).free_sides.shape == (1, 4)


def test_no_shells_are_no_sides():
    assert with_free_sides([]) == []
