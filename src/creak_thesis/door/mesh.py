"""Structured grids of shells and the part they are glued into."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from creak_thesis.arrays import BoolArray, FloatArray, IntArray

MERGE_DISTANCE = 1e-4
"""Nodes of neighbouring grids closer than this (mm) are the same node."""


@dataclass(frozen=True)
class Grid:
    """One mapped piece of a part before gluing."""

    coords: FloatArray
    """(n, 3) mm."""
    quads: IntArray
    """(m, 4) rows into `coords`."""
    tris: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    """(k, 3) rows into `coords`."""
    tags: Mapping[str, BoolArray] = field(default_factory=dict)
    """Named subsets of the quads, (m,) each."""
    nodes: Mapping[str, IntArray] = field(default_factory=dict)
    """Named rows of nodes."""


@dataclass(frozen=True)
class PartMesh:
    """The shells of one part, every node used, every element facing the same side."""

    name: str
    coords: FloatArray
    """(n, 3) mm."""
    quads: IntArray
    """(m, 4) rows into `coords`."""
    tris: IntArray
    """(k, 3) rows into `coords`."""
    tags: Mapping[str, BoolArray]
    """Named subsets of the quads, (m,) each."""
    nodes: Mapping[str, IntArray]
    """Named rows of nodes."""

    @cached_property
    def centres(self) -> FloatArray:
        """(m, 3) of the quads."""
        return np.asarray(self.coords[self.quads].mean(axis=1))

    def nodes_of(self, tag: str) -> IntArray:
        """Rows of the nodes that the tagged quads use, sorted."""
        return np.unique(self.quads[self.tags[tag]])

    def area(self) -> float:
        """Area of the shells, mm^2 (a warped quad counts as its two pairs of triangles, averaged)."""
        q, t = self.coords[self.quads], self.coords[self.tris]
        halves = [q[:, [0, 1, 2]], q[:, [0, 2, 3]], q[:, [0, 1, 3]], q[:, [1, 2, 3]]]
        return sum(0.5 * _triangle_area(h) for h in halves) + _triangle_area(t)


def _triangle_area(corners: FloatArray) -> float:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(0.5 * np.linalg.norm(normal, axis=1).sum())


def divisions(length: float, mesh_size: float, least: int = 1) -> int:
    """Number of elements of about `mesh_size` over a length."""
    return max(least, round(length / mesh_size))


def spread(stops: Sequence[float], counts: Sequence[int]) -> FloatArray:
    """Values from the first stop to the last, `counts` equal steps between neighbouring stops."""
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(stops[:-1], stops[1:], counts, strict=True)]
    return np.concatenate([*pieces, [stops[-1]]])


def structured_quads(n_rows: int, n_cols: int, *, closed: bool, flip: bool) -> IntArray:
    """Quads of a grid of n_rows x n_cols nodes, row by row.

    closed : the last column is followed by the first.
    flip : turn the normal round.
    """
    row = np.arange(n_rows - 1)[:, None] * n_cols
    left = np.arange(n_cols if closed else n_cols - 1)[None, :]
    right = (left + 1) % n_cols
    corners = [row + left, row + right, row + n_cols + right, row + n_cols + left]
    quads = np.stack(np.broadcast_arrays(*corners), axis=-1).reshape(-1, 4).astype(np.int64)
    return quads[:, ::-1] if flip else quads


def glue(name: str, grids: Sequence[Grid]) -> PartMesh:
    """Join grids into one part: coincident nodes become one, in order of first appearance."""
    start = np.cumsum([0, *(g.coords.shape[0] for g in grids)])
    coords = np.concatenate([g.coords for g in grids])
    row = _merged_rows(coords)
    first = np.unique(row, return_index=True)[1]
    quads = row[np.concatenate([g.quads + s for g, s in zip(grids, start, strict=False)])]
    tris = row[np.concatenate([g.tris + s for g, s in zip(grids, start, strict=False)])]
    tags = {t: _gather(grids, t) for t in {t: 0 for g in grids for t in g.tags}}
    nodes = {n: row[g.nodes[n] + s] for g, s in zip(grids, start, strict=False) for n in g.nodes}
    return PartMesh(name, coords[first], quads, tris, tags, nodes)


def _gather(grids: Sequence[Grid], tag: str) -> BoolArray:
    return np.concatenate([g.tags.get(tag, np.zeros(g.quads.shape[0], dtype=bool)) for g in grids])


def _merged_rows(coords: FloatArray) -> IntArray:
    """For every node the number of the node it becomes, counted by first appearance."""
    pairs = cKDTree(coords).query_pairs(MERGE_DISTANCE, output_type="ndarray")
    n = coords.shape[0]
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))
    return order[inverse].astype(np.int64)
