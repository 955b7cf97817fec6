"""Faces of elements: facets of shells (one of the corners, or several that reach the middle nodes); faces of solids,
which nodes, which way they look, which of them are free; volumes; how facets move.

A face with middle nodes counts as several facets (`FACES`, `SHELL_FACETS`), each of which covers a part of its natural
coordinates. Motion that is linear within each facet would make a uniform pressure other forces than those with which
the element carries it: on a square face 1/12 of it at a corner for -1/12. So they move by the shape functions of the
whole face."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.materials import BeamSection, GeneralShell, Section, ShellSection, TrussSection

SHELL_FACETS: dict[str, tuple[tuple[int, int, int, int], ...]] = {
    "quad4": ((0, 1, 2, 3),),
    "tri3": ((0, 1, 2, 2),),
    "quad8": ((0, 4, 7, 7), (1, 5, 4, 4), (2, 6, 5, 5), (3, 7, 6, 6), (4, 5, 6, 7)),
    "tri6": ((0, 3, 5, 5), (1, 4, 3, 3), (2, 5, 4, 4), (3, 4, 5, 5)),
}
"""Nodes of the facets, turned as the shell is; a triangle repeats its third.

A shell with middle nodes counts as several facets, so that contact and ties reach them: a triangle at each corner, then
what lies between the middle nodes, as faces of solids do."""
N_CORNER = {"quad4": 4, "tri3": 3, "quad8": 4, "tri6": 3}

SMOOTH = float(np.cos(np.deg2rad(20.0)))
"""Cosine of the angle up to which shells at a node count as one smooth surface: 20 degrees, as Nastran (SNORM) and
Abaqus (*NORMAL) have it."""
EXACT = 1.7e-3
"""Sine of the angle (0.1 degree) up to which a direction is the normal, as of material directions."""
EXACTLY = float(np.sqrt(1.0 - EXACT**2))


def facets_of_shells(kind: str, nodes_idx: IntArray) -> IntArray:
    """(n, n_facet, 4) node rows of the facets of elements with nodes (n, n_node)."""
    return np.asarray(nodes_idx[:, np.array(SHELL_FACETS[kind])], dtype=np.int64)


def sides_of_shells(kind: str, nodes_idx: IntArray, side: int) -> IntArray:
    """(n, n_piece, 2) ends of the pieces of side 0, 1, ...: its corners, with the middle node in between."""
    k = N_CORNER[kind]
    ends = [side, (side + 1) % k] if nodes_idx.shape[1] == k else [side, k + side, (side + 1) % k]
    along = nodes_idx[:, ends]
    return np.stack([along[:, :-1], along[:, 1:]], axis=2)


def normals_at_nodes(kind: str, nodes: IntArray, coords: FloatArray) -> FloatArray:
    """(n, k, 3) unit normals of shells at their nodes, the mean of the facets there; zero where there is no area."""
    places = np.array(SHELL_FACETS[kind])
    x = coords[facets_of_shells(kind, nodes)]
    normal = unit(vector_areas(x))
    out = np.zeros((*nodes.shape, 3))
    for facet, place in enumerate(places):
        out[:, np.unique(place)] += normal[:, facet, None]
    return unit(out)


def unit(v: FloatArray) -> FloatArray:
    """Vectors (..., 3) of length one; zero where they are."""
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1), np.finfo(float).tiny)[..., None])


def facet_areas(corners: FloatArray) -> FloatArray:
    """(...,) areas of facets with corners as `vector_areas` takes them."""
    return np.asarray(np.linalg.norm(vector_areas(corners), axis=-1))


def vector_areas(corners: FloatArray) -> FloatArray:
    """(..., 3) normals as long as the area of facets with corners (..., 3 or 4, 3); triangles may repeat their third.

    Half the cross product of the diagonals; of a warped facet what any surface between its edges has.
    """
    return 0.5 * np.cross(corners[..., 2, :] - corners[..., 0, :], corners[..., -1, :] - corners[..., 1, :])


HEX20 = ("hex20", "hex20r", "hex20s")
"""Hexahedra of twenty nodes: integrated fully, reduced, with reduced shear."""
CORNERS_AS = {"tet10": "tet4", **dict.fromkeys(HEX20, "hex8"), "wedge15": "wedge6"}
"""Solids with middle nodes -> the one without, whose nodes are their corners."""
_FOUR_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0)), ((4, 5), (5, 6), (6, 7), (7, 4)), ((0, 4), (1, 5), (2, 6), (3, 7))
MIDDLES = {
    **dict.fromkeys(HEX20, tuple(pair for four in _FOUR_EDGES for pair in four)),
    "tet10": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "wedge15": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
}
"""Corners between which the nodes after the corners lie, in Abaqus's order."""
_PLAIN = {
    "hex8": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "tet4": ((0, 2, 1, 1), (0, 1, 3, 3), (1, 2, 3, 3), (2, 0, 3, 3)),
    "wedge6": ((0, 2, 1, 1), (3, 4, 5, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "pyramid5": ((0, 3, 2, 1), (0, 1, 4, 4), (1, 2, 4, 4), (2, 3, 4, 4), (3, 0, 4, 4)),
}
"""Solids without middle nodes, whose faces are facets."""


def solid_corners(kind: str) -> tuple[tuple[int, ...], ...]:
    """Corners of each face, each once."""
    return tuple(tuple(dict.fromkeys(face)) for face in _PLAIN[CORNERS_AS.get(kind, kind)])


def _divided(kind: str) -> tuple[tuple[int, int, int, int], ...]:
    """Facets of faces with middle nodes: a triangle at each corner, then what lies between the middle nodes."""
    faces = solid_corners(kind)
    first = 1 + max(map(max, faces))
    middle = {frozenset(pair): k for k, pair in enumerate(MIDDLES[kind], first)}
    found = []
    for corners in faces:
        m = [middle[frozenset(p)] for p in zip(corners, (*corners[1:], corners[0]), strict=True)]
        found += [(c, m[k], m[k - 1], m[k - 1]) for k, c in enumerate(corners)]
        found.append((m[0], m[1], m[2], m[-1]))
    return tuple(found)


FACES = _PLAIN | {kind: _divided(kind) for kind in CORNERS_AS}
"""Corners of faces S1, S2, ... of Abaqus, turned so that their normals look outward; a triangle repeats its third.

A face with middle nodes counts as several facets, so that contact and ties reach them: four triangles where it is a
triangle, four triangles at the corners and a quadrilateral between them where it has four sides."""


def face_numbers(kind: str) -> IntArray:
    """(n_facet,) number of the face, 1 for S1, to which each entry of `FACES` belongs."""
    faces = solid_corners(kind)
    per_face = [len(corners) + 1 for corners in faces] if kind in CORNERS_AS else [1] * len(faces)
    return np.repeat(np.arange(1, len(per_face) + 1, dtype=np.int64), per_face)


def faces_of(kind: str, nodes_idx: IntArray) -> IntArray:
    """(n, n_facet, 4) node rows of the facets, see `FACES`, of elements with nodes (n, n_node)."""
    table = np.array(FACES[kind])
    if not nodes_idx.shape[0]:
        return np.zeros((0, *table.shape), dtype=np.int64)
    return np.asarray(nodes_idx[:, table], dtype=np.int64)


def free_faces(wanted: IntArray, every: Iterable[IntArray]) -> IntArray:
    """Which of the faces `wanted` (n, 4) belong to one element only.

    Parameters
    ----------
    wanted : (n, 4) node rows.
    every : the faces (k, 4) of all elements that may lie against them, `wanted` included.

    Returns
    -------
    Rows of `wanted`, in order.
    """
    if not wanted.size:
        return np.zeros(0, dtype=np.int64)
    own = np.zeros(int(wanted.max()) + 2, dtype=bool)
    own[wanted] = True
    near = [faces[own[np.minimum(faces, own.size - 1)].all(axis=1)] for faces in every]
    table = np.concatenate([wanted, *near])
    table[table[:, 2] == table[:, 3], 3] = -1
    table.sort(axis=1)
    order = np.lexsort(table.T)
    new = np.concatenate([[True], (table[order[1:]] != table[order[:-1]]).any(axis=1)])
    group = np.empty(order.size, dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    return np.flatnonzero(np.bincount(group)[group[: wanted.shape[0]]] <= 2)


def volumes(faces: FloatArray) -> FloatArray:
    """Volumes (n,) of elements from the coordinates (n, n_face, 4, 3) of their faces: a third of int x . n dA.

    Exact for plane faces.
    """
    faces = faces - faces.mean(axis=(1, 2))[:, None, None]
    normal = 0.5 * np.cross(faces[:, :, 2] - faces[:, :, 0], faces[:, :, 3] - faces[:, :, 1])
    return np.asarray(np.einsum("nfx,nfx->n", faces.mean(axis=2), normal) / 3.0, dtype=np.float64)


LINES = {"beam2": 2, "truss2": 2, "beam3": 3}
"""Nodes along the element."""


def element_volumes(
    kind: str, nodes_idx: IntArray, coords: FloatArray, section: Section, thickness: FloatArray | None = None
) -> FloatArray:
    """(n,) volumes of structural elements, length^3: of shells area times thickness, of beams length times area.

    Elements without a volume of their own, as springs and layers of glue, have 0.

    Parameters
    ----------
    nodes_idx : (n, n_node) rows into coords. coords : (n_node, 3), length.
    section : of all of them.
    thickness : (n, n_node) of shells over that of the section, whose mean at the corners counts; None: as the section.
    """
    if kind in FACES:
        return np.abs(volumes(coords[faces_of(kind, nodes_idx)]))
    if kind in SHELL_FACETS and isinstance(section, ShellSection | GeneralShell):
        areas = facet_areas(coords[facets_of_shells(kind, nodes_idx)]).sum(axis=1)
        return section.thickness * areas * (1.0 if thickness is None else thickness[:, : N_CORNER[kind]].mean(axis=1))
    if kind in LINES and isinstance(section, BeamSection | TrussSection):
        pieces = np.diff(coords[nodes_idx[:, : LINES[kind]]], axis=1)
        return np.asarray(section.area * np.linalg.norm(pieces, axis=2).sum(axis=1), dtype=np.float64)
    return np.zeros(nodes_idx.shape[0])


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
