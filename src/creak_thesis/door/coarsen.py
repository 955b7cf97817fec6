"""Coarser mesh along a band of a part: columns of quads merged, the mesh beside the band unchanged.

Merging n quads of every row along the band leaves nodes of its two border lines without a partner inside the
band. The elements beside a merged border edge are therefore joined to one polygon, which is cut again without
those nodes: a quad and a triangle for n = 2, a quad and two triangles for n = 3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak_thesis.arrays import BoolArray, FloatArray, IntArray
from creak_thesis.door.mesh import PartMesh, structured_quads

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
