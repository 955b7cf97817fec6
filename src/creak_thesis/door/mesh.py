"""Structured grids of shells and the part they are glued into; a coarser mesh along a band of it.

Columns of quads are merged, the mesh beside the band stays. Merging n quads of every row along the band leaves nodes
of its two border lines without a partner inside the band. The elements beside a merged border edge are therefore
joined to one polygon, which is cut again without those nodes: a quad and a triangle for n = 2, a quad and two triangles
for n = 3.
"""

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


CLEARLY_BETTER = 0.5
"""Degrees by which the worst corner must improve before a polygon is cut otherwise than in the middle."""


def kept_columns(segments: Sequence[int], merge: int) -> IntArray:
    """Columns of nodes that stay when `merge` neighbouring elements become one.

    Parameters
    ----------
    segments : number of elements of each piece of the band; the nodes between two pieces always stay.
    merge : number of elements merged; the rest of a piece, fewer than `merge`, becomes its last element.
    """
    starts = np.cumsum([0, *segments[:-1]])
    pieces = [start + np.arange(0, count, merge) for start, count in zip(starts, segments, strict=True)]
    return np.concatenate(pieces).astype(np.int64)


def coarsen_band(mesh: PartMesh, tag: str, lines: IntArray, kept: IntArray) -> PartMesh:
    """Merge the columns of a closed band of quads.

    Parameters
    ----------
    mesh : the part.
    tag : name of the quads of the band; all of them are replaced.
    lines : (n_row, n_column) nodes of the band, border to border; the last column is followed by the first.
    kept : sorted columns that stay, at most two left out in a row; the first column is one of them.
    """
    removed = np.zeros(mesh.coords.shape[0], dtype=bool)
    removed[np.delete(lines, kept, axis=1)] = True
    touched_quads, touched_tris = removed[mesh.quads].any(axis=1), removed[mesh.tris].any(axis=1)
    beside = [*mesh.quads[touched_quads & ~mesh.tags[tag]].tolist(), *mesh.tris[touched_tris].tolist()]
    new_quads, new_tris = _transition(mesh.coords, beside, lines, kept, removed)
    band = _merged_band(mesh, tag, lines[:, kept])
    stay = ~touched_quads & ~mesh.tags[tag]
    quads = np.concatenate([band, mesh.quads[stay], np.array(new_quads, dtype=np.int64).reshape(-1, 4)])
    tris = np.concatenate([mesh.tris[~touched_tris], np.array(new_tris, dtype=np.int64).reshape(-1, 3)])
    tags = {t: _padded(mesh.tags[t][stay], len(band), len(new_quads), t == tag) for t in mesh.tags}
    row = np.cumsum(~removed) - 1
    nodes = {name: row[rows[~removed[rows]]] for name, rows in mesh.nodes.items()}
    return PartMesh(mesh.name, mesh.coords[~removed], row[quads], row[tris], tags, nodes)


def _merged_band(mesh: PartMesh, tag: str, lines: IntArray) -> IntArray:
    """Quads between the lines, facing as the quads that they replace."""
    flat = lines.ravel()
    plain = flat[structured_quads(*lines.shape, closed=True, flip=False)]
    old = mesh.coords[mesh.quads[mesh.tags[tag]][0]]
    new = mesh.coords[plain[0]]
    same = np.dot(np.cross(old[2] - old[0], old[3] - old[1]), np.cross(new[2] - new[0], new[3] - new[1])) > 0
    return plain if same else plain[:, ::-1]


def _padded(stay: BoolArray, before: int, after: int, is_band: bool) -> BoolArray:
    """Membership of the quads that stay, between that of the band's quads and that of the transition's."""
    return np.concatenate([np.full(before, is_band), stay, np.zeros(after, dtype=bool)])


def _transition(
    coords: FloatArray, beside: list[list[int]], lines: IntArray, kept: IntArray, removed: BoolArray
) -> tuple[list[list[int]], list[list[int]]]:
    """Quads and triangles in place of the elements `beside` that touch a removed node of a border line."""
    group = np.searchsorted(kept, np.arange(lines.shape[1]), side="right") - 1
    owner: dict[int, tuple[int, int]] = {}
    for border in (0, lines.shape[0] - 1):
        nodes = lines[border]
        owner.update({n: (border, g) for n, g in zip(nodes.tolist(), group.tolist(), strict=True) if removed[n]})
    elements: dict[tuple[int, int], list[list[int]]] = {}
    for corners in beside:
        elements.setdefault(next(owner[n] for n in corners if n in owner), []).append(corners)
    quads: list[list[int]] = []
    tris: list[list[int]] = []
    for (border, g), joined in sorted(elements.items()):
        ends = {int(lines[border, kept[g]]), int(lines[border, kept[(g + 1) % kept.size]])}
        polygon = _from_long_side([n for n in _boundary(joined) if not removed[n]], ends)
        for piece in _cut(coords, polygon, mirrored=g % 2 == 1):
            (quads if len(piece) == 4 else tris).append(piece)
    return quads, tris


def _boundary(elements: list[list[int]]) -> list[int]:
    """Nodes around a patch of elements, in the sense in which the elements walk their edges."""
    edges = {(a, b) for corners in elements for a, b in zip(corners, corners[1:] + corners[:1], strict=True)}
    follower = {a: b for a, b in edges if (b, a) not in edges}
    walk = [min(follower)]
    while follower[walk[-1]] != walk[0]:
        walk.append(follower[walk[-1]])
    return walk


def _from_long_side(polygon: list[int], ends: set[int]) -> list[int]:
    """The polygon begun with the two ends of its merged side."""
    k = next(k for k in range(len(polygon)) if {polygon[k - 1], polygon[k]} == ends)
    return polygon[k - 1 :] + polygon[: k - 1] if k else [polygon[-1], *polygon[:-1]]


def _cut(coords: FloatArray, polygon: list[int], *, mirrored: bool) -> list[list[int]]:
    """Cut a polygon, its merged side first, into one quad and triangles at both ends of the merged side.

    The quad takes the piece of the opposite side for which the worst corner is best: straight opposite, or
    further along where the rows of elements are sheared.
    """
    a, b, *far = polygon
    far = far[::-1]
    n = len(far) - 1
    order = sorted(range(n), key=lambda k: (abs(2 * k + 1 - n), -k if mirrored else k))
    best = _pieces(a, b, far, order[0])
    for k in order[1:]:
        other = _pieces(a, b, far, k)
        if _worst_corner(coords, other) > _worst_corner(coords, best) + CLEARLY_BETTER:
            best = other
    return best


def _pieces(a: int, b: int, far: list[int], k: int) -> list[list[int]]:
    """The quad between side a-b and edge k of the far side, triangles on its left at a and on its right at b."""
    left = [[a, far[i + 1], far[i]] for i in range(k)]
    right = [[b, far[i + 1], far[i]] for i in range(k + 1, len(far) - 1)]
    return [[a, b, far[k + 1], far[k]], *left, *right]


def _worst_corner(coords: FloatArray, pieces: list[list[int]]) -> float:
    """Smallest distance of any corner's angle from 0 and 180 degrees."""
    return min(_sharpest(coords[corners]) for corners in pieces)


def _sharpest(x: FloatArray) -> float:
    forth, back = np.roll(x, -1, axis=0) - x, np.roll(x, 1, axis=0) - x
    cosine = (forth * back).sum(axis=1) / np.linalg.norm(forth, axis=1) / np.linalg.norm(back, axis=1)
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return float(np.minimum(angle, 180.0 - angle).min())
