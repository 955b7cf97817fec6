"""The surface of a model for the 3-D view: few enough nodes to send, every one of them a node of the mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.plain_mesh import Mesh
from creak.report.figures.view import EDGES_UP_TO, facets_of, lines_of

MOST_NODES = 40_000
CREASE = 40.0
"""Degrees between facets from which the edge between them is drawn where not all are."""


@dataclass(frozen=True)
class Surface:
    """Triangles and edges by part, on rows into `nodes_idx`."""

    nodes_idx: IntArray
    """(n,) rows of the model's nodes."""
    triangles: IntArray
    """(n_triangle, 3), those of a part behind each other."""
    edges: IntArray
    """(n_edge, 2), those of a part behind each other."""
    parts: IntArray
    """(n_part, 5): row into `Model.parts` (-1: beams, springs and what belongs to no part), first and number of
    triangles, first and number of edges."""
    outline: IntArray
    """(n_line, 2), borders, creases and lines only."""
    coarsened: bool
    """Nodes of the mesh were left out."""

    def rows(self, nodes_idx: IntArray) -> IntArray:
        """Rows of nodes that the surface is known to have."""
        order = np.argsort(self.nodes_idx)
        return order[np.searchsorted(self.nodes_idx, nodes_idx, sorter=order)]


def surface_of(model: Mesh, needed: IntArray, most: int = MOST_NODES) -> Surface | None:
    """Shells, free faces of solids and line elements; None where the model has none of them.

    Where there are more than `most` nodes, those of a part that fall into one cell of a grid become one of them, the
    cell as small as that allows, and facets that lose their area go. Of many facets only creases and borders are drawn
    as edges.

    Parameters
    ----------
    needed : nodes that the surface has whether or not a facet uses them (marks).
    """
    facets, lines = facets_of(model), lines_of(model)
    if not facets.count and not lines.size:
        return None
    keep = _represented(model, facets.nodes_idx, facets.part, lines, most)
    coarsened = bool((keep != np.arange(model.nodes.count)).any())
    creases, crease_owner = _creases(model.nodes.coords, *_triangles(facets.nodes_idx, facets.part))
    creases, crease_owner = _distinct(keep[creases], crease_owner)
    triangles, owner = _triangles(keep[facets.nodes_idx], facets.part)
    all_sides = facets.count <= EDGES_UP_TO and not coarsened
    edges, edge_owner = _sides(facets.nodes_idx, facets.part) if all_sides else (creases, crease_owner)
    lines = keep[lines]
    lines = np.unique(np.sort(lines[lines[:, 0] != lines[:, 1]], axis=1), axis=0)
    outline = np.concatenate([creases, lines])
    edges = np.concatenate([edges, lines])
    edge_owner = np.concatenate([edge_owner, np.full(len(lines), -1)])
    nodes = np.unique(np.concatenate([triangles.ravel(), edges.ravel(), needed])).astype(np.int64)
    t, e = np.argsort(owner, kind="stable"), np.argsort(edge_owner, kind="stable")
    parts = _ranges(owner[t], edge_owner[e])
    corners, ends = np.searchsorted(nodes, triangles[t]), np.searchsorted(nodes, edges[e])
    return Surface(nodes, corners, ends, parts, np.searchsorted(nodes, outline), coarsened)


def _triangles(quads: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Triangles with three corners and their parts, each once."""
    both = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    owner = np.concatenate([part, part])
    real = (both[:, 0] != both[:, 1]) & (both[:, 1] != both[:, 2]) & (both[:, 0] != both[:, 2])
    both, owner = both[real], owner[real]
    _, first = np.unique(np.column_stack([np.sort(both, axis=1), owner]), axis=0, return_index=True)
    first = np.sort(first)
    return both[first], owner[first]


def _sides(quads: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Sides of the facets and their parts, each once."""
    sides = np.concatenate([quads[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))])
    return _distinct(sides, np.tile(part, 4))


def _distinct(sides: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Sides with two ends, each once in its part."""
    owned = np.column_stack([np.sort(sides, axis=1), part])[sides[:, 0] != sides[:, 1]]
    owned = np.unique(owned, axis=0)
    return owned[:, :2], owned[:, 2]


def _creases(xyz: FloatArray, triangles: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Sides of triangles at a border or a crease, and their parts."""
    normal = np.cross(xyz[triangles[:, 1]] - xyz[triangles[:, 0]], xyz[triangles[:, 2]] - xyz[triangles[:, 0]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    sides = np.concatenate([np.sort(triangles[:, [a, b]], axis=1) for a, b in ((0, 1), (1, 2), (2, 0))])
    owned = np.column_stack([sides, np.tile(part, 3)])
    of = np.tile(np.arange(len(triangles)), 3)
    found, first, which, count = np.unique(owned, axis=0, return_index=True, return_inverse=True, return_counts=True)
    which = which.ravel()
    flat = np.abs(np.einsum("nx,nx->n", normal[of], normal[of[first]][which])) > np.cos(np.radians(CREASE))
    bent = np.bincount(which[~flat], minlength=len(found)) > 0
    drawn = found[(count != 2) | bent]
    return drawn[:, :2], drawn[:, 2]


def _ranges(owner: IntArray, edge_owner: IntArray) -> IntArray:
    names = np.unique(np.concatenate([owner, edge_owner]))
    columns = [names]
    for x in (owner, edge_owner):
        first = np.searchsorted(x, names)
        columns += [first, np.searchsorted(x, names, side="right") - first]
    return np.column_stack(columns).astype(np.int64)


def _represented(model: Mesh, quads: IntArray, part: IntArray, lines: IntArray, most: int) -> IntArray:
    """(n_node,) the node that stands for each one."""
    used = np.unique(np.concatenate([quads.ravel(), lines.ravel()]))
    if used.size <= most:
        return np.arange(model.nodes.count)
    owner = np.full(model.nodes.count, -1, dtype=np.int64)
    owner[quads] = part[:, None]
    xyz = model.nodes.coords[used]
    size = float(np.ptp(xyz, axis=0).max())
    small, large = size / 2000.0, size
    for _ in range(24):
        cell = np.sqrt(small * large)
        count = _cells(xyz, owner[used], cell)[1].size
        small, large = (cell, large) if count > most else (small, cell)
    which, first = _cells(xyz, owner[used], large)
    keep = np.arange(model.nodes.count)
    # The point of each cell that is closest to the mean of its points.
    number = np.bincount(which, minlength=first.size)
    mean = np.column_stack([np.bincount(which, xyz[:, k], first.size) for k in range(3)]) / number[:, None]
    away = np.linalg.norm(xyz - mean[which], axis=1)
    order = np.lexsort((away, which))
    keep[used] = used[order[np.searchsorted(which[order], np.arange(first.size))]][which]
    return keep


def _cells(xyz: FloatArray, owner: IntArray, cell: float) -> tuple[IntArray, IntArray]:
    """Number of the cell of each point, and the first point of each."""
    key = np.column_stack([np.floor((xyz - xyz.min(axis=0)) / cell).astype(np.int64), owner])
    _, first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return which.ravel(), first
