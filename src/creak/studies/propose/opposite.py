"""Where the skin of a part lies opposite that of another: face on face, the free edge of a shell on a face, two edges.

The distance of surfaces is that of the nodes' surfaces, less what the thickness of either shell reaches into the
direction between them: half of it along its normal, with what its middle lies off its nodes, nothing past its edge. So
the gap under the edge of a rib that stands on a plate is the distance less half of the plate's thickness alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Literal

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import middles
from creak.model.faces import FACES, SHELL_FACETS, faces_of, facets_of_shells, free_faces, unit, vector_areas
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import ElementBlock, Model
from creak.model.projection import nearest_points

Kind = Literal["face", "edge", "ends"]
"""Faces look at each other; the free edge of a shell looks at a face; two edges look at each other."""
FLAT = 0.5
"""A skin looks at what lies within 60 degrees of its normal."""
STRAIGHT = 0.99
"""An edge on a face lies straight above it: beyond the rim of a face it meets nothing."""
LEANS = 0.1
"""Cosine, to the normal of a face, of the way from an edge into its shell, from which on it lies on one side."""
ACROSS = 0.7
"""Cosine up to which a free edge lies across the direction to the other part."""
SAME = 1e-6
"""Share of the other skin's facets below which a node lies on it."""
SLIVER = 0.01
"""Of a facet's size: an overlap of solids up to this is that of their meshes."""


@dataclass(frozen=True)
class Skin:
    """Shells and free faces of solids of a part."""

    facets: IntArray
    """(n, 4) node rows; triangles repeat their third."""
    element: IntArray
    """(n,) number of the element that each facet belongs to, see `element_numbers`."""
    half: FloatArray
    """(n,) half thickness; 0 for faces of solids."""
    offset: FloatArray
    """(n,) of the middle from the surface of the nodes, along the normal."""
    solid: BoolArray
    """(n,) whether it is the face of a solid, whose normal looks outward."""

    @cached_property
    def reach(self) -> float:
        """How far it reaches from the surface of its nodes at most, length."""
        return float((self.half + np.abs(self.offset)).max())

    @cached_property
    def free_edges(self) -> IntArray:
        """(n, 2) node rows of the edges that belong to one facet alone."""
        edge = np.stack([self.facets, np.roll(self.facets, -1, axis=1)], axis=2).reshape(-1, 2)
        edge = np.sort(edge[edge[:, 0] != edge[:, 1]], axis=1)
        found, count = np.unique(edge, axis=0, return_counts=True)
        return found[count == 1]

    def normals(self, coords: FloatArray) -> FloatArray:
        """(n, 3) of unit length; zero where there is no area."""
        return unit(vector_areas(coords[self.facets]))


@dataclass(frozen=True)
class Met:
    """Near nodes (k) of skins, and what they meet of the other's."""

    nodes: IntArray
    side: IntArray
    """(k,) 0: of the first part, 1: of the second."""
    kind: IntArray
    """(k,) 0: face, 1: edge, 2: ends."""
    facet: IntArray
    """(k,) of the other skin."""
    element: IntArray
    """(k,) number of that facet's element."""
    point: FloatArray
    """(k, 3) nearest point of the other skin."""
    toward: FloatArray
    """(k, 3) from there to the node; of an edge along the normal to the side on which its shell lies; unit length."""
    gap: FloatArray
    """(k,) between the surfaces."""
    apart: FloatArray
    """(k,) along `toward`, between the surfaces of the nodes."""
    excused: FloatArray
    """(k,) length of an overlap that thickness explains: of what is drawn on the middle of a shell."""
    unsure: BoolArray
    """(k,) the side of an edge cannot be told from its shell, which lies along the face or reaches through it."""

    def where(self, good: BoolArray) -> Met:
        return Met(*(getattr(self, f.name)[good] for f in fields(self)))

    def of(self, kind: Kind) -> Met:
        return self.where(self.kind == ("face", "edge", "ends").index(kind))


def joined(pieces: Sequence[Met]) -> Met:
    """All of them in one."""
    return Met(*(np.concatenate([getattr(p, f.name) for p in pieces]) for f in fields(Met)))


def element_numbers(model: Model) -> IntArray:
    """First number of each block's elements: element k of block b has number first[b] + k."""
    return np.cumsum([0, *(b.ids.size for b in model.blocks)]).astype(np.int64)


def skin_of(model: Model, part: int) -> Skin:
    """Shells and free solid faces of a part."""
    first, pieces = element_numbers(model), []
    for row, block in enumerate(model.blocks):
        if block.part == part and (block.kind in SHELL_FACETS or block.kind in FACES):
            pieces.append(_skin_of_block(model, block, int(first[row])))
    if not pieces:
        none = np.zeros(0, dtype=np.int64)
        return Skin(none.reshape(0, 4), none, np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))
    facets, element, half, offset, solid = (np.concatenate(x) for x in zip(*pieces, strict=True))
    keep = np.ones(len(facets), dtype=bool)
    rows = np.flatnonzero(solid)
    keep[rows] = False
    keep[rows[free_faces(facets[rows], [facets[rows]])]] = True
    return Skin(facets[keep], element[keep], half[keep], offset[keep], solid[keep])


def _skin_of_block(
    model: Model, block: ElementBlock, first: int
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, BoolArray]:
    n = block.ids.size
    thickness, offset, solid = np.zeros(n), np.zeros(n), block.kind in FACES
    if isinstance(block.section, ShellSection | GeneralShell):
        thickness, offset = middles(model, block, np.arange(n))
    faces = (faces_of if solid else facets_of_shells)(block.kind, block.nodes_idx)
    of = np.repeat(np.arange(n), faces.shape[1])
    return faces.reshape(-1, 4), first + of, 0.5 * thickness[of], offset[of], np.full(of.size, solid)


def opposite(model: Model, skin: Skin, other: Skin, distance: float, tied: BoolArray, side: int) -> Met:
    """Nodes of a skin whose surface lies within the distance of the other's, each with the nearest point of that."""
    coords = model.nodes.coords
    limit = distance + skin.reach + other.reach
    corners = coords[other.facets]
    low, high = corners.min(axis=(0, 1)) - limit, corners.max(axis=(0, 1)) + limit
    rows = np.unique(skin.facets)
    rows = rows[((coords[rows] >= low) & (coords[rows] <= high)).all(axis=1) & ~tied[rows]]
    if rows.size:
        near = nearest_points(coords[rows], corners, other.facets[:, 2] == other.facets[:, 3], limit)
        rows, facet, shape = rows[near.found], near.facet[near.found], near.shape[near.found]
    else:
        facet, shape = rows, np.zeros((0, 4))
    x, normal = coords[rows], other.normals(coords)[facet]
    point = np.einsum("nc,ncx->nx", shape, corners[facet])
    away = np.linalg.norm(x - point, axis=1)
    size = np.linalg.norm(np.ptp(corners[facet], axis=1), axis=1)
    direction = np.where((away > SAME * size)[:, None], (x - point) / np.maximum(away, 1e-300)[:, None], normal)
    along = np.einsum("nx,nx->n", normal, direction)
    own = _around(model, skin, rows, direction)
    beside = _on_rim(model, other, facet, shape)
    faces_other = (np.abs(along) >= np.where(beside, STRAIGHT, FLAT)) | other.solid[facet]
    kind = np.where(own.faces & faces_other, 0, np.where(np.abs(along) >= STRAIGHT, 1, np.where(faces_other, 3, 2)))
    kind[(kind > 0) & ~own.rim] = 3
    apart = np.where(other.solid[facet] & (along < -FLAT), -away, away)
    lean = np.einsum("nx,nx->n", own.body, normal)
    edge = kind == 1
    outward = np.where(other.solid[facet], 1.0, np.where(lean < 0.0, -1.0, 1.0))
    toward = np.where(edge[:, None], outward[:, None] * normal, direction)
    apart = np.where(edge, np.einsum("nx,nx->n", x - point, toward), apart)
    half = reach_along(other, facet, np.where(edge, outward, along))
    through = edge & (apart < -half)
    toward[through & ~other.solid[facet]] *= -1.0
    apart = np.where(through & ~other.solid[facet], -apart, apart)
    gap = apart - half - np.where(edge, 0.0, own.half)
    thin = np.minimum(np.where(own.half > 0.0, own.half, np.inf), np.where(half > 0.0, half, np.inf))
    excused = np.where(edge, half, np.where(np.isfinite(thin), thin, 0.0)) + SLIVER * size
    unsure = edge & ~other.solid[facet] & ((np.abs(lean) < LEANS) | through)
    met = Met(
        nodes=rows,
        side=np.full(rows.size, side),
        kind=kind,
        facet=facet,
        element=other.element[facet],
        point=point,
        toward=toward,
        gap=gap,
        apart=apart,
        excused=excused,
        unsure=unsure,
    )
    return met.where((kind < 3) & (gap <= distance))


@dataclass(frozen=True)
class _Around:
    """Of a skin at some of its nodes (n)."""

    faces: BoolArray
    """Any facet there looks along the direction, or is that of a solid."""
    half: FloatArray
    """How far the thickness there reaches into the direction."""
    rim: BoolArray
    """A free edge runs through the node across the direction."""
    body: FloatArray
    """(n, 3) of unit length, from the node to the middle of the facets there."""


def _around(model: Model, skin: Skin, rows: IntArray, direction: FloatArray) -> _Around:
    coords, n = model.nodes.coords, rows.size
    at = np.full(model.nodes.count, -1, dtype=np.int64)
    at[rows] = np.arange(n)
    facet, corner = np.nonzero(at[skin.facets] >= 0)
    node = at[skin.facets[facet, corner]]
    toward = np.einsum("nx,nx->n", skin.normals(coords)[facet], direction[node])
    cosine = np.abs(toward)
    most, half, body = np.zeros(n), np.zeros(n), np.zeros((n, 3))
    np.maximum.at(most, node, np.where(skin.solid[facet], 1.0, cosine))
    np.maximum.at(half, node, reach_along(skin, facet, -toward))
    np.add.at(body, node, coords[skin.facets[facet]].mean(axis=1) - coords[rows[node]])
    body /= np.maximum(np.linalg.norm(body, axis=1), 1e-300)[:, None]
    edge = skin.free_edges
    ends = np.concatenate([edge, edge[:, ::-1]])
    ends = ends[at[ends[:, 0]] >= 0]
    line = coords[ends[:, 1]] - coords[ends[:, 0]]
    line /= np.maximum(np.linalg.norm(line, axis=1), 1e-300)[:, None]
    rim = np.zeros(n, dtype=bool)
    crosses = np.abs(np.einsum("nx,nx->n", line, direction[at[ends[:, 0]]])) < ACROSS
    rim[at[ends[crosses, 0]]] = True
    return _Around(most >= FLAT, half, rim, body)


def reach_along(skin: Skin, facet: IntArray, cosine: FloatArray) -> FloatArray:
    """(n,) how far facets reach from the surface of their nodes into directions, by the cosine to the normal."""
    return np.asarray(skin.half[facet] * np.abs(cosine) + skin.offset[facet] * cosine)


def _on_rim(model: Model, skin: Skin, facet: IntArray, shape: FloatArray) -> BoolArray:
    """(n,) whether points of the facets, shape functions (n, 4), lie on a free edge."""
    free = np.zeros(model.nodes.count, dtype=bool)
    free[skin.free_edges] = True
    inner = (shape > SAME) & ~free[skin.facets[facet]]
    return np.asarray(~inner.any(axis=1) & ((shape > SAME).sum(axis=1) <= 2))
