"""Facets of shells: one of the corners, or several that reach the middle nodes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray

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
