"""Faces of solid elements: which nodes, which way they look, which of them are free."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from creak.arrays import FloatArray, IntArray

FACES = {
    "hex8": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "tet4": ((0, 2, 1, 1), (0, 1, 3, 3), (1, 2, 3, 3), (2, 0, 3, 3)),
    "wedge6": ((0, 2, 1, 1), (3, 4, 5, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "tet10": tuple(
        (i, j, k, k)
        for a, b, c, ab, bc, ca in ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9))
        for i, j, k in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    ),
}
"""Corners of faces S1, S2, ... of Abaqus, turned so that their normals look outward; a triangle repeats its third.

A face of a ten-node tetrahedron counts as four triangles, so that contact and ties reach its middle nodes."""
PER_FACE = {"tet10": 4}
"""How many facets a face of the element makes, where that is not one."""


def faces_of(kind: str, nodes_idx: IntArray) -> IntArray:
    """(n, n_face, 4) node rows of the faces of elements with nodes (n, n_node)."""
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
