"""Faces of elements: facets of shells (one of the corners, or several that reach the middle nodes); faces of solids,
which nodes, which way they look, which of them are free; volumes."""

from __future__ import annotations

from collections.abc import Iterable

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
    normal = unit(np.cross(x[:, :, 2] - x[:, :, 0], x[:, :, 3] - x[:, :, 1]))
    out = np.zeros((*nodes.shape, 3))
    for facet, place in enumerate(places):
        out[:, np.unique(place)] += normal[:, facet, None]
    return unit(out)


def unit(v: FloatArray) -> FloatArray:
    """Vectors (..., 3) of length one; zero where they are."""
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1), np.finfo(float).tiny)[..., None])


def facet_areas(corners: FloatArray) -> FloatArray:
    """(...,) areas of facets with corners (..., 4, 3); a triangle repeats its third."""
    diagonals = corners[..., 2, :] - corners[..., 0, :], corners[..., 3, :] - corners[..., 1, :]
    return np.asarray(0.5 * np.linalg.norm(np.cross(*diagonals), axis=-1))


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
