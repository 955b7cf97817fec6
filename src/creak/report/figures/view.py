"""Where the reader stands, and what can be drawn of a model; its surface for the 3-D view: few enough nodes to send,
every one of them a node of the mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.faces import FACES, SHELL_FACETS, faces_of, facets_of_shells, free_faces
from creak.model.plain_mesh import Mesh

LINES = ("beam2", "beam3", "truss2", "spring2")
FLAT = 0.25
"""Extent along z over the lesser of the others, up to which a model is looked at from above."""
EDGES_UP_TO = 8000
"""Facets up to which element edges are drawn."""


class Sides(Protocol):
    """Nodes on both sides of gap channels; `GapOperator` has them."""

    @property
    def m(self) -> int: ...
    @property
    def nodes_idx(self) -> IntArray: ...
    @property
    def retained_nodes(self) -> IntArray: ...


@dataclass(frozen=True)
class View:
    """Parallel projection; columns of `matrix` are right, up and toward the reader."""

    matrix: FloatArray

    def rotate(self, xyz: FloatArray) -> FloatArray:
        """(n, 3) right, up, toward."""
        return xyz @ self.matrix

    def flat(self, xyz: FloatArray) -> FloatArray:
        """(n, 2) position on paper."""
        return xyz @ self.matrix[:, :2]


@dataclass(frozen=True)
class Facets:
    """Surfaces to paint; a triangle repeats its last corner."""

    nodes_idx: IntArray
    """(n, 4)"""
    part: IntArray
    """(n,) row into `Model.parts`, -1 for none."""

    @property
    def count(self) -> int:
        return int(self.part.size)


def facets_of(model: Mesh) -> Facets:
    """Shell elements and free faces of solids."""
    nodes, part = [np.zeros((0, 4), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for faces, owner in _solid_faces(model):
        nodes.append(faces)
        part.append(owner)
    for block in model.blocks:
        if block.kind in SHELL_FACETS:
            nodes.append(facets_of_shells(block.kind, block.nodes_idx).reshape(-1, 4))
            part.append(np.full(nodes[-1].shape[0], block.part, dtype=np.int64))
    return Facets(np.concatenate(nodes), np.concatenate(part))


def _solid_faces(model: Mesh) -> list[tuple[IntArray, IntArray]]:
    """Free faces (k, 4) of the solids and their parts (k,); none where there are no solids."""
    solids = [b for b in model.blocks if b.kind in FACES]
    if not solids:
        return []
    faces = [faces_of(b.kind, b.nodes_idx) for b in solids]
    every = np.concatenate([f.reshape(-1, 4) for f in faces])
    owner = np.concatenate([np.full(f.shape[0] * f.shape[1], b.part) for f, b in zip(faces, solids, strict=True)])
    free = free_faces(every, [every])
    return [(every[free], owner[free].astype(np.int64))]


def lines_of(model: Mesh) -> IntArray:
    """(n, 2) ends of beams, trusses and springs."""
    ends = [b.nodes_idx[:, :2] for b in model.blocks if b.kind in LINES]
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *ends])


def front(coords: FloatArray, outward: FloatArray) -> View:
    """Look along the shorter of x and y, z up; on a model that is flat along z from above, y up.

    Parameters
    ----------
    outward : (3,) roughly the way from the hidden to the facing side; zero where there is no such way.
    """
    extent = np.ptp(coords, axis=0)
    toward = 2 if extent[2] <= FLAT * extent[:2].min() else int(np.argmin(extent[:2]))
    up = 2 if toward != 2 else 1
    axes = np.eye(3)
    sign = float(np.sign(outward[toward])) or (-1.0 if toward == 1 else 1.0)
    t, u = sign * axes[toward], axes[up]
    return View(np.column_stack([np.cross(u, t), u, t]))


def three_quarter(straight: View) -> View:
    """The front view turned by 32 degrees about the vertical and tilted by 18."""
    a, e = np.radians([-32.0, 18.0])
    right, up, toward = straight.matrix.T
    t = np.cos(e) * (np.cos(a) * toward + np.sin(a) * right) + np.sin(e) * up
    r = np.cos(a) * right - np.sin(a) * toward
    return View(np.column_stack([r, np.cross(t, r), t]))


def outward(gaps: Sides, coords: FloatArray) -> FloatArray:
    """From the main to the secondary side of the contact, (3,); zero without contact."""
    other = np.setdiff1d(gaps.retained_nodes, gaps.nodes_idx)
    if gaps.m == 0 or other.size == 0:
        return np.zeros(3)
    return np.asarray(coords[gaps.nodes_idx].mean(axis=0) - coords[other].mean(axis=0))


def cut_up(corners: FloatArray, cuts: int) -> tuple[FloatArray, FloatArray]:
    """Quadrilaterals (n, 4, 3) divided into cuts x cuts each, and their edges as patches without width.

    Returns
    -------
    inner : (n cuts^2, 4, 3), edges : (4 n cuts, 4, 3); the pieces of one quadrilateral follow each other.
    """
    s = np.linspace(0.0, 1.0, cuts + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    weight = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    grid = np.einsum("uvk,nkx->nuvx", weight, corners)
    inner = np.stack([grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]], axis=3)
    sides = np.stack([grid[:, :, 0], grid[:, :, -1], grid[:, 0, :], grid[:, -1, :]], axis=1)
    ends = sides[:, :, :-1], sides[:, :, 1:]
    edges = np.stack([ends[0], ends[1], ends[1], ends[0]], axis=3)
    return inner.reshape(-1, 4, 3), edges.reshape(-1, 4, 3)


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
