"""Parts that are drawn through each other: an edge of one's elements pierces a facet of the other.

Channels lie between surfaces that face each other. A shell that stands through a plate faces it nowhere, so no channel
would part the two, whatever they do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import FEATURE, middles
from creak.model.constraints import tied_nodes
from creak.model.faces import SHELL_FACETS, unit, vector_areas
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import Model
from creak.model.skin import Skin, skin_of

SLIVER = 0.05
"""Of a facet's size: what pierces a solid by no more is that of their meshes."""
PAIRS_AT_ONCE = 2_000_000
"""Edges and facets tried at a time; bounds the memory."""
PIERCING = 4
"""Nodes that a warning names."""


@dataclass(frozen=True)
class Crossing:
    """A part that reaches through another."""

    part: str
    other: str
    edges: int
    """Edges of elements that pass through."""
    nodes: tuple[str, ...]
    """Labels of their nodes on the far side, the deepest first."""
    depth: float
    """How far the deepest lies beyond the far face of the other, length."""


@dataclass(frozen=True)
class _Side:
    """One part's skin."""

    edge: IntArray
    """(n_edge, 2) node rows, without those at links and ties."""
    facets: IntArray
    """(n, 4) node rows."""
    border: BoolArray
    """(2 n, 6) see `_edges`."""
    half: FloatArray
    """(n,) thickness."""


def crossings(model: Model) -> list[Crossing]:
    """Of each pair of parts that pierce each other the one that reaches less deep, the deepest pair first.

    An edge p0 p1 pierces a triangle where its ends lie on both sides, farther from the middle than the far face, and it
    meets the plane inside. So do two edges from a node within the thickness. Edges at links and ties are left out: what
    is welded there is meant.
    """
    tied = tied_nodes(model.constraints, model.nodes.count)
    shallower: dict[frozenset[int], Crossing] = {}
    skin = skin_of(model)
    half = _half(model, skin)
    parts = [np.flatnonzero(skin.part == i) for i in range(len(model.parts))]
    boxes = {i: _box(skin.corners[rows].reshape(-1, 3)) for i, rows in enumerate(parts) if rows.size}

    @cache
    def side(i: int) -> _Side:
        f = skin.nodes_idx[parts[i]]
        edge, border = _edges(f, model.nodes.coords, skin.solid[parts[i]])
        return _Side(edge[~tied[edge].any(axis=1)], f, border, half[parts[i]])

    for i, j in permutations(boxes, 2):
        box = np.maximum(boxes[i][0], boxes[j][0]), np.minimum(boxes[i][1], boxes[j][1])
        if (box[0] > box[1]).any():
            continue
        nodes, depth = _pierced(model.nodes.coords, side(i).edge, side(j), box)
        if nodes.size:
            order = np.argsort(-depth, kind="stable")
            labels = tuple(dict.fromkeys(model.nodes.label(int(row)) for row in nodes[order]))
            names = model.parts[i].name, model.parts[j].name
            found = Crossing(*names, nodes.size, labels, float(depth.max()))
            key = frozenset((i, j))
            if key not in shallower or found.depth < shallower[key].depth:
                shallower[key] = found
    return sorted(shallower.values(), key=lambda c: -c.depth)


def crossing_warnings(model: Model, unit: str) -> list[str]:
    """Parts that are drawn through each other, in this unit of length: no channel parts them."""
    return [
        f"{c.part} is drawn through {c.other}: {c.edges} edge(s) of its elements pierce it, by {c.depth:.3g} {unit} or "
        f"more beyond the far face at node {', '.join(c.nodes[:PIERCING])}{' and more' * (len(c.nodes) > PIERCING)}; "
        "no contact acts there; move one of them, cut a slot, or tie them where they are joined"
        for c in crossings(model)
    ]


def _box(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    return x.min(axis=0), x.max(axis=0)


def _edges(f: IntArray, coords: FloatArray, solid: BoolArray) -> tuple[IntArray, BoolArray]:
    """(n_edge, 2) node rows of the edges of facets f (n, 4); (2 n, 6) whether edges 01, 12, 20 of their triangles 012,
    then 023, are of one facet alone, and whether their corners lie on such an edge.

    So are the edges of solids, where faces turn by more than 45 degrees: what lies in one face meets the other there.
    """
    n_node = len(coords)
    a, b = f, np.roll(f, -1, axis=1)
    key, which, count = np.unique(np.minimum(a, b) * n_node + np.maximum(a, b), return_inverse=True, return_counts=True)
    which = which.reshape(f.shape)
    x = coords[f]
    normal = unit(vector_areas(x))
    total = np.zeros((key.size, 3))
    np.add.at(total, which, normal[:, None])
    # Two normals at an angle t add up to 2 cos(t / 2).
    turns = (count == 2) & ((total**2).sum(axis=1) < 2.0 + 2.0 * FEATURE)
    free = ((count[which] == 1) | (turns[which] & solid[:, None])) & (a != b)
    on = np.zeros(n_node, dtype=bool)
    on[a[free]], on[b[free]] = True, True
    at, flat, none = on[f], f[:, 2] == f[:, 3], np.zeros(len(f), dtype=bool)
    border = np.concatenate(
        [
            np.column_stack([free[:, 0], free[:, 1], flat & free[:, 3], at[:, [0, 1, 2]]]),
            np.column_stack([none, free[:, 2], free[:, 3], at[:, [0, 2, 3]]]),
        ]
    )
    edge = np.column_stack(np.divmod(key, n_node))
    return edge[edge[:, 0] != edge[:, 1]], border


def _half(model: Model, skin: Skin) -> FloatArray:
    """(n,) half the thickness of each facet; 0 for faces of solids, which come first."""
    half = [np.zeros(int(skin.solid.sum()))]
    for block in model.blocks:
        if block.kind in SHELL_FACETS:
            n, thickness = block.ids.size, np.zeros(block.ids.size)
            if isinstance(block.section, ShellSection | GeneralShell):
                thickness, _ = middles(model, block, np.arange(n))
            half.append(np.repeat(0.5 * thickness, len(SHELL_FACETS[block.kind])))
    return np.concatenate(half)


def _pierced(
    coords: FloatArray, edge: IntArray, other: _Side, box: tuple[FloatArray, FloatArray]
) -> tuple[IntArray, FloatArray]:
    """Nodes (k,) at the shorter ends of the edges that pass through the facets of a part, and their depths beyond it.

    Parameters
    ----------
    box : that both parts share.
    """
    from scipy.spatial import cKDTree  # see `model.projection.nearest_points`

    edge = edge[_meets(coords[edge], box)]
    corners = np.concatenate([other.facets[:, [0, 1, 2]], other.facets[:, [0, 2, 3]]])
    border, half = other.border, np.tile(other.half, 2)
    keep = _meets(coords[corners], box)
    keep = keep[corners[keep, 1] != corners[keep, 2]]
    corners, border, half = corners[keep], border[keep], half[keep]
    if not edge.size or not corners.size:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    x, triangle = coords[edge], coords[corners]
    centre = triangle.mean(axis=1)
    size = np.linalg.norm(triangle - centre[:, None], axis=2).max(axis=1)
    reach = 0.5 * np.linalg.norm(x[:, 1] - x[:, 0], axis=1) + size.max()
    near = cKDTree(centre).query_ball_point(x.mean(axis=1), reach)
    count = np.array([len(n) for n in near])
    rows, depths = [], []
    for piece in np.array_split(np.arange(len(edge)), 1 + int(count.sum()) // PAIRS_AT_ONCE):
        e = np.repeat(piece, count[piece])
        t = np.concatenate([np.array(near[k], dtype=np.int64) for k in piece])
        short, depth = _through(x[e], triangle[t], border[t], half[t], size[t])
        hit = depth > 0.0
        # An edge that meets the border of two triangles is one edge.
        one, first = np.unique(e[hit], return_index=True)
        node, deep = _from_within(edge[e], t, x[e], triangle[t], border[t], half[t])
        rows += [edge[one, short[hit][first]], node]
        depths += [depth[hit][first], deep]
    return np.concatenate(rows), np.concatenate(depths)


def _meets(points: FloatArray, box: tuple[FloatArray, FloatArray]) -> IntArray:
    """Rows of the (n, k, 3) points of which the box meets the box."""
    return np.flatnonzero(((points.max(axis=1) >= box[0]) & (points.min(axis=1) <= box[1])).all(axis=1))


def _through(
    x: FloatArray, triangle: FloatArray, border: BoolArray, half: FloatArray, size: FloatArray
) -> tuple[IntArray, FloatArray]:
    """The shorter end (n,) of edges x (n, 2, 3), and its depth (n,) beyond the far face; 0: not pierced."""
    height, flat = _heights(x, triangle)
    span = height[:, 0] - height[:, 1]
    opposite = height[:, 0] * height[:, 1] < 0.0
    t = np.where(opposite, height[:, 0] / np.where(opposite, span, 1.0), 0.0)
    inside = _over(x[:, 0] + t[:, None] * (x[:, 1] - x[:, 0]), triangle, border) & flat
    short = np.abs(height).argmin(axis=1)
    beyond = np.abs(height).min(axis=1) - half - np.where(half > 0.0, 0.0, SLIVER * size)
    return short, np.where(opposite & inside, np.maximum(beyond, 0.0), 0.0)


def _from_within(
    edge: IntArray, number: IntArray, x: FloatArray, triangle: FloatArray, border: BoolArray, half: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Outer ends (k,) of edges that leave a shell to both sides from one node within its thickness, and their depths.

    Parameters
    ----------
    edge : (n, 2) node rows; number : (n,) of the triangle.
    """
    height, flat = _heights(x, triangle)
    within = np.abs(height) < half[:, None]
    inner = within.argmax(axis=1)
    every = np.arange(len(edge))
    leaves = flat & (within.sum(axis=1) == 1)
    leaves[leaves] &= _over(x[every, inner][leaves], triangle[leaves], border[leaves])
    k, inner = np.flatnonzero(leaves), inner[leaves]
    up, deep = height[k, 1 - inner], np.abs(height[k, 1 - inner]) - half[k]
    place, at = np.unique(np.column_stack([edge[k, inner], number[k]]), axis=0, return_inverse=True)
    deepest = np.zeros((2, len(place)))
    side = (up > 0.0).astype(np.int64)
    np.maximum.at(deepest, (side, at.ravel()), deep)
    # The shorter side: where it is short on both, one of them.
    lower = np.where(deepest[0] <= deepest[1], 0, 1)
    least = deepest.min(axis=0)[at.ravel()]
    mine = (least > 0.0) & (side == lower[at.ravel()]) & (deep == least)
    nodes, first = np.unique(edge[k, 1 - inner][mine], return_index=True)
    return nodes, deep[mine][first]


def _heights(x: FloatArray, triangle: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Of both ends of edges (n, 2, 3) over the triangles' planes (n, 2), and whether these have any area (n,)."""
    normal = unit(vector_areas(triangle))
    return np.einsum("nex,nx->ne", x - triangle[:, None, 0], normal), (normal != 0.0).any(axis=1)


def _over(points: FloatArray, triangle: FloatArray, border: BoolArray) -> BoolArray:
    """(n,) whether points lie over triangles, seen along their normals, and not at a border of the surface.

    What meets a border stands on it or ends at it, as the two legs of a T do.
    """
    u, v, at = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0], points - triangle[:, 0]
    normal = np.cross(u, v)
    square = np.maximum(np.einsum("nx,nx->n", normal, normal), 1e-300)
    a = np.einsum("nx,nx->n", np.cross(at, v), normal) / square
    b = np.einsum("nx,nx->n", np.cross(u, at), normal) / square
    weight = np.column_stack([1.0 - a - b, a, b])
    edges = weight[:, [2, 0, 1]] >= np.where(border[:, :3], SLIVER, -1e-9)
    return np.asarray((edges & ~(border[:, 3:] & (weight > 1.0 - SLIVER))).all(axis=1))
