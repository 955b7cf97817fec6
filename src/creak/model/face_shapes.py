"""How facets move: those of a face or shell with middle nodes by the shape functions of the whole face.

A face with middle nodes counts as several facets (`solid_faces.FACES`, `shell_facets.SHELL_FACETS`), each of which
covers a part of its natural coordinates. Motion that is linear within each facet would make a uniform pressure other
forces than those with which the element carries it: on a square face 1/12 of it at a corner for -1/12.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.shell_facets import N_CORNER, SHELL_FACETS
from creak.model.solid_faces import FACES, HEX20, MIDDLES, face_numbers

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
FEW, MOST = 4, 8
"""Nodes of faces without and with middle nodes."""


@dataclass(frozen=True)
class FaceShapes:
    """The faces that facets are parts of."""

    nodes: IntArray
    """(n, 4) node rows of the face, (n, 8) where some have middle nodes: corners first; the first one again beyond its
    last."""
    natural: FloatArray
    """(n, 4, 2) natural coordinates of the facet's corners in its face."""
    sides: IntArray
    """(n,) of a face with middle nodes, 3 or 4; 0: the facet is the face."""

    def at(self, facet: IntArray, shape: FloatArray) -> tuple[IntArray, FloatArray]:
        """(k, w) nodes, and their shape functions at points of facets (k,) that the facet's own (k, 4) tell.

        Triangles: h = L_i (2 L_i - 1) and 4 L_i L_j with areas L; squares: (1 + x x_i)(1 + y y_i)(x x_i + y y_i - 1)
        / 4 at corners, (1 - x^2)(1 + y y_i) / 2 and (1 + x x_i)(1 - y^2) / 2 between them.
        """
        nodes, weights = self.nodes[facet], np.zeros((facet.size, self.nodes.shape[1]))
        weights[:, :FEW] = shape
        sides, place = self.sides[facet], np.einsum("kc,kcx->kx", shape, self.natural[facet])
        for count, shapes in ((3, _of_triangle), (4, _of_square)):
            mine = sides == count
            if mine.any():
                weights[mine] = shapes(place[mine])
        return nodes, weights


def face_shapes(kind: str, nodes_idx: IntArray, number: IntArray) -> FaceShapes:
    """Of facets `number` (n,), from 0, of elements of a kind with nodes (n, n_node)."""
    places, natural, sides = _table(kind)
    nodes = np.take_along_axis(nodes_idx, places[number], axis=1)
    return FaceShapes(nodes, natural[number], sides[number])


def faces_of_facets(kind: str, nodes_idx: IntArray, corners: IntArray) -> FaceShapes:
    """The same of the facets with node rows `corners` (n, 4)."""
    facets = nodes_idx[:, np.array(FACES.get(kind) or SHELL_FACETS[kind])]
    number = (facets == corners[:, None]).all(axis=2)
    assert number.any(axis=1).all(), "facets of other elements"
    return face_shapes(kind, nodes_idx, number.argmax(axis=1))


def facets_alone(corners: IntArray) -> FaceShapes:
    """Facets (n, 4) that are faces themselves."""
    return FaceShapes(corners, np.zeros((len(corners), 4, 2)), np.zeros(len(corners), dtype=np.int64))


def joined(pieces: list[tuple[IntArray, FaceShapes]], n: int) -> FaceShapes:
    """Of n facets, from those of the rows (k,) that each piece has."""
    width = max((piece.nodes.shape[1] for _, piece in pieces), default=FEW)
    nodes, natural, sides = np.zeros((n, width), dtype=np.int64), np.zeros((n, 4, 2)), np.zeros(n, dtype=np.int64)
    for rows, piece in pieces:
        nodes[rows, : piece.nodes.shape[1]], nodes[rows, piece.nodes.shape[1] :] = piece.nodes, piece.nodes[:, :1]
        natural[rows], sides[rows] = piece.natural, piece.sides
    return FaceShapes(nodes, natural, sides)


@cache
def _table(kind: str) -> tuple[IntArray, FloatArray, IntArray]:
    """Of each facet of an element: places (w,) of its face's nodes, its corners' natural coordinates, sides."""
    facets = np.array(FACES.get(kind) or SHELL_FACETS[kind])
    pairs = MIDDLES.get("hex20" if kind in HEX20 else kind)
    corners = 1 + int(np.max(pairs)) if pairs else N_CORNER.get(kind, facets.max() + 1)
    if facets.max() < corners:
        return facets, np.zeros((len(facets), 4, 2)), np.zeros(len(facets), dtype=np.int64)
    number = face_numbers(kind) if kind in FACES else np.ones(len(facets), dtype=np.int64)
    places, natural = np.zeros((len(facets), MOST), dtype=np.int64), np.zeros((len(facets), 4, 2))
    sides = np.zeros(len(facets), dtype=np.int64)
    for face in np.unique(number):
        mine = number == face
        around = [_from_corner(facet, corners) for facet in facets[mine].tolist() if min(facet) < corners]
        nodes = [corner for corner, _ in around] + [middle for _, middle in around]
        ends = SQUARE if len(around) == 4 else TRIANGLE
        at = dict(zip(nodes, np.concatenate([ends, 0.5 * (ends + np.roll(ends, -1, axis=0))]), strict=True))
        places[mine] = (nodes + nodes[:1] * MOST)[:MOST]
        natural[mine] = [[at[node] for node in facet] for facet in facets[mine].tolist()]
        sides[mine] = len(around)
    return places, natural, sides


def _from_corner(facet: list[int], corners: int) -> tuple[int, int]:
    """The corner of the face in a facet, and the middle node after it."""
    three = facet[:3]
    k = next(i for i, node in enumerate(three) if node < corners)
    return three[k], three[(k + 1) % 3]


def _of_triangle(place: FloatArray) -> FloatArray:
    """(k, 8); the last two are nothing."""
    x, y = place.T
    areas = np.stack([1.0 - x - y, x, y], axis=1)
    after = np.roll(areas, -1, axis=1)
    return np.concatenate([areas * (2.0 * areas - 1.0), 4.0 * areas * after, np.zeros((len(place), 2))], axis=1)


def _of_square(place: FloatArray) -> FloatArray:
    """(k, 8)"""
    ends = place[:, None, :] * SQUARE
    corner = 0.25 * (1.0 + ends).prod(axis=2) * (ends.sum(axis=2) - 1.0)
    middle = 0.5 * (SQUARE + np.roll(SQUARE, -1, axis=0))
    across = np.where(middle == 0.0, 1.0 - place[:, None, :] ** 2, 1.0 + place[:, None, :] * middle)
    return np.concatenate([corner, 0.5 * across.prod(axis=2)], axis=1)
