"""How facets move: those of a face or shell with middle nodes by the shape functions of the whole face.

A face with middle nodes counts as several facets (`solid_faces.FACES`, `shell_facets.SHELL_FACETS`), each of which
covers a part of its natural coordinates. Motion that is linear within each facet would make a uniform pressure other
forces than those with which the element carries it: on a square face 1/12 of it at a corner for -1/12.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.faces import FACES, N_CORNER, SHELL_FACETS, face_numbers, solid_corners

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

    def slopes(self, shape: FloatArray, slope: FloatArray) -> FloatArray:
        """(n, w, 2) derivatives of the shape functions at one point of each facet by the facet's own two coordinates.

        Parameters
        ----------
        shape, slope : (4,) and (4, 2) the facet's own shape functions and their derivatives.
        """
        out = np.zeros((*self.nodes.shape, 2))
        out[:, :FEW] = slope
        for count, shapes in ((3, _of_triangle), (4, _of_square)):
            mine = self.sides == count
            place = np.einsum("c,kcx->kx", shape, self.natural[mine])
            turn = np.einsum("cr,kcx->kxr", slope, self.natural[mine])
            out[mine] = np.einsum("kwx,kxr->kwr", _derivatives(shapes, place), turn)[:, : out.shape[1]]
        return out


def face_shapes(kind: str, nodes_idx: IntArray, number: IntArray) -> FaceShapes:
    """Of facets `number` (n,), from 0, of elements of a kind with nodes (n, n_node)."""
    places, natural, sides = _table(kind)
    nodes = np.take_along_axis(nodes_idx, places[number], axis=1)
    return FaceShapes(nodes, natural[number], sides[number])


def joined(pieces: list[tuple[IntArray, FaceShapes]], n: int) -> FaceShapes:
    """Of n facets, from those of the rows (k,) that each piece has."""
    width = max((piece.nodes.shape[1] for _, piece in pieces), default=FEW)
    nodes, natural, sides = np.zeros((n, width), dtype=np.int64), np.zeros((n, 4, 2)), np.zeros(n, dtype=np.int64)
    for rows, piece in pieces:
        nodes[rows, : piece.nodes.shape[1]], nodes[rows, piece.nodes.shape[1] :] = piece.nodes, piece.nodes[:, :1]
        natural[rows], sides[rows] = piece.natural, piece.sides
    return FaceShapes(nodes, natural, sides)


def shapes_of(corners: IntArray, elements: Iterable[tuple[str, IntArray]]) -> FaceShapes:
    """Of facets with corners (n, 4), each of the face of one of the elements (kind, nodes) that has it; a facet that
    none with middle nodes has is the face itself."""
    n, wanted = len(corners), np.zeros(int(corners.max(initial=0)) + 2, dtype=np.bool_)
    wanted[corners] = True
    pieces = [(np.arange(n), FaceShapes(corners, np.zeros((n, 4, 2)), np.zeros(n, dtype=np.int64)))]
    key, order = _sorted(corners)
    for kind, nodes_idx in elements:
        if kind not in (*FACES, *SHELL_FACETS) or not _table(kind)[2].any():
            continue
        near = nodes_idx[wanted[np.minimum(nodes_idx, wanted.size - 1)].any(axis=1)]
        facets = near[:, np.array(FACES.get(kind) or SHELL_FACETS[kind])]
        element, number = np.nonzero(wanted[np.minimum(facets, wanted.size - 1)].all(axis=2))
        its_key, its_order = _sorted(facets[element, number])
        _, at = np.unique(np.concatenate([its_key, key]), axis=0, return_inverse=True)
        at = at.reshape(-1)
        first = np.full(at.max(initial=0) + 1, -1)
        first[at[: len(its_key)]] = np.arange(len(its_key))
        row = first[at[len(its_key) :]]
        mine = np.flatnonzero(row >= 0)
        row = row[mine]
        piece = face_shapes(kind, near[element[row]], number[row])
        natural = np.zeros_like(piece.natural)
        its = np.take_along_axis(piece.natural, its_order[row][:, :, None], axis=1)
        np.put_along_axis(natural, order[mine][:, :, None], its, axis=1)
        triangle = corners[mine, 2] == corners[mine, 3]
        natural[triangle, 3] = natural[triangle, 2]
        pieces.append((mine, FaceShapes(piece.nodes, natural, piece.sides)))
    return joined(pieces, n)


def _sorted(corners: IntArray) -> tuple[IntArray, IntArray]:
    """(n, 4) corners in rising order, -1 for the repeated one of a triangle, and their places."""
    once = np.where((np.arange(4) == 3) & (corners[:, 3:] == corners[:, 2:3]), -1, corners)
    order = np.argsort(once, axis=1)
    return np.take_along_axis(once, order, axis=1), order


@cache
def _table(kind: str) -> tuple[IntArray, FloatArray, IntArray]:
    """Of each facet of an element: places (w,) of its face's nodes, its corners' natural coordinates, sides."""
    facets = np.array(FACES.get(kind) or SHELL_FACETS[kind])
    corners = N_CORNER[kind] if kind in N_CORNER else 1 + max(map(max, solid_corners(kind)))
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


def _derivatives(shapes: Callable[[FloatArray], FloatArray], place: FloatArray) -> FloatArray:
    """(k, 8, 2) by central differences: exact, as shape functions are of second degree along each coordinate."""
    return np.stack([0.5 * (shapes(place + step) - shapes(place - step)) for step in np.eye(2)], axis=2)
