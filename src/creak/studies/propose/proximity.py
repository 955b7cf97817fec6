"""Where parts come near each other: stretches of their skins, and the names of the deck that cover them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import ElementBlock, Model
from creak.model.projection import nearest_points
from creak.model.shell_facets import SHELL_FACETS, facets_of_shells
from creak.model.solid_faces import FACES, faces_of, free_faces

LEAST = 0.05
"""A set that covers less than this share of what is near is not taken."""


@dataclass(frozen=True)
class Skin:
    """Shells and free faces of solids of a part."""

    facets: IntArray
    """(n, 4) node rows; triangles repeat their third."""
    element: IntArray
    """(n,) number of the element that each facet belongs to, see `element_numbers`."""
    half: FloatArray
    """(n,) half thickness; 0 for faces of solids."""


@dataclass(frozen=True)
class Near:
    """Two parts whose surfaces come within the distance."""

    parts: tuple[str, str]
    elements: tuple[IntArray, IntArray]
    """Numbers of the near elements of either part."""
    touching: IntArray
    """(k, 2) numbers of elements of the first and the second part that are opposite each other."""
    gap: float
    """Smallest distance between the surfaces, thickness taken off; negative: they overlap."""
    node: int
    """Row of the node of the first part where it is smallest."""


def near_parts(model: Model, distance: float) -> list[Near]:
    """Pairs of parts whose surfaces are nearer than `distance`, the nearest first.

    Nodes that links or ties hold are left out: nothing rattles there. Parts without shells and solids have no skin.

    Parameters
    ----------
    distance : between the surfaces, in the deck's unit of length.
    """
    skins = {i: s for i in range(len(model.parts)) if (s := skin_of(model, i)).facets.size}
    tied = tied_nodes(model)
    found = []
    for i, j in combinations(skins, 2):
        pair = _near(model, (i, j), (skins[i], skins[j]), distance, tied)
        if pair is not None:
            found.append(pair)
    return sorted(found, key=lambda n: n.gap)


def closest_parts(model: Model) -> tuple[str, str, float] | None:
    """The two parts whose nodes are nearest and that distance; None for a model with fewer than two."""
    trees = {p.name: cKDTree(model.nodes.coords[p.nodes_idx]) for p in model.parts if p.nodes_idx.size}
    pairs = [(a, b, float(trees[b].query(trees[a].data)[0].min())) for a, b in combinations(trees, 2)]
    return min(pairs, key=lambda p: p[2], default=None)


def element_numbers(model: Model) -> IntArray:
    """First number of each block's elements: element k of block b has number first[b] + k."""
    return np.cumsum([0, *(b.ids.size for b in model.blocks)]).astype(np.int64)


def skin_of(model: Model, part: int) -> Skin:
    """Shells and free solid faces of a part."""
    first, pieces = element_numbers(model), []
    for row, block in enumerate(model.blocks):
        if block.part == part and (block.kind in SHELL_FACETS or block.kind in FACES):
            pieces.append(_skin_of_block(block, int(first[row])))
    if not pieces:
        none = np.zeros(0, dtype=np.int64)
        return Skin(none.reshape(0, 4), none, np.zeros(0))
    facets, element, half, solid = (np.concatenate(x) for x in zip(*pieces, strict=True))
    keep = np.ones(len(facets), dtype=bool)
    rows = np.flatnonzero(solid)
    keep[rows] = False
    keep[rows[free_faces(facets[rows], [facets[rows]])]] = True
    return Skin(facets[keep], element[keep], half[keep])


def _skin_of_block(block: ElementBlock, first: int) -> tuple[IntArray, IntArray, FloatArray, BoolArray]:
    n = block.ids.size
    if block.kind in SHELL_FACETS:
        section = block.section
        thickness = section.thickness if isinstance(section, ShellSection | GeneralShell) else 0.0
        faces, half, solid = facets_of_shells(block.kind, block.nodes_idx), 0.5 * thickness, False
    else:
        faces, half, solid = faces_of(block.kind, block.nodes_idx), 0.0, True
    m = n * faces.shape[1]
    number = first + np.repeat(np.arange(n), faces.shape[1])
    return faces.reshape(-1, 4), number, np.full(m, half), np.full(m, solid)


def tied_nodes(model: Model) -> BoolArray:
    """(n_node,) nodes that any link, coupling, tie or equation names."""
    tied = np.zeros(model.nodes.count, dtype=bool)
    for c in model.constraints:
        tied[c.nodes] = True
    return tied


def _near(model: Model, at: tuple[int, int], skins: tuple[Skin, Skin], distance: float, tied: BoolArray) -> Near | None:
    there = _opposite(model, skins[0], skins[1], distance, tied)
    back = _opposite(model, skins[1], skins[0], distance, tied)
    if there is None and back is None:
        return None
    sides = [x for x in (there, back) if x is not None]
    node, gap = min(((int(x.nodes[x.gap.argmin()]), float(x.gap.min())) for x in sides), key=lambda p: p[1])
    pairs = [np.column_stack([x.own, x.other] if x is there else [x.other, x.own]) for x in sides]
    touching = np.unique(np.concatenate(pairs), axis=0)
    names = (model.parts[at[0]].name, model.parts[at[1]].name)
    return Near(names, (np.unique(touching[:, 0]), np.unique(touching[:, 1])), touching, gap, node)


@dataclass(frozen=True)
class _Opposite:
    """Near nodes of one skin with the gap there, and elements opposite each other."""

    nodes: IntArray
    gap: FloatArray
    own: IntArray
    other: IntArray


def _opposite(model: Model, skin: Skin, other: Skin, distance: float, tied: BoolArray) -> _Opposite | None:
    """Nodes of a skin that lie within the distance of the other's facets."""
    coords = model.nodes.coords
    half = np.zeros(model.nodes.count)
    np.maximum.at(half, skin.facets, skin.half[:, None])
    limit = distance + float(half.max()) + float(other.half.max())
    corners = coords[other.facets]
    low, high = corners.min(axis=(0, 1)) - limit, corners.max(axis=(0, 1)) + limit
    rows = np.unique(skin.facets)
    rows = rows[((coords[rows] >= low) & (coords[rows] <= high)).all(axis=1) & ~tied[rows]]
    if not rows.size:
        return None
    met = nearest_points(coords[rows], corners, other.facets[:, 2] == other.facets[:, 3], limit)
    gap = met.distance - half[rows] - other.half[met.facet]
    good = met.found & (gap <= distance)
    if not good.any():
        return None
    facet_at = np.full(model.nodes.count, -1, dtype=np.int64)
    facet_at[rows[good]] = met.facet[good]
    opposite = facet_at[skin.facets]
    facet, corner = np.nonzero(opposite >= 0)
    return _Opposite(rows[good], gap[good], skin.element[facet], other.element[opposite[facet, corner]])


def covering_sets(model: Model, near: IntArray, part: str) -> list[str]:
    """Names of surfaces and element sets of a part that fit its near elements best, none overlapping another.

    A set fits by 2 |set and near| / (|set| + |near|): all of what is near, and little else.

    Parameters
    ----------
    near : numbers of elements of the part.
    """
    index = next(i for i, p in enumerate(model.parts) if p.name == part)
    candidates = dict(_sets_of_part(model, index))
    left, taken = np.zeros((2, element_numbers(model)[-1]), dtype=bool)
    left[near] = True
    chosen: list[str] = []
    while left.any():
        free = {name: int(np.count_nonzero(left[s])) for name, s in candidates.items() if not taken[s].any()}
        size = int(np.count_nonzero(left))
        fits = [(2.0 * shared / (size + candidates[name].size), name) for name, shared in free.items()]
        score, name = max(fits, key=lambda f: f[0], default=(0.0, ""))
        if not score or free[name] < LEAST * near.size:
            break
        chosen.append(name)
        left[candidates[name]] = False
        taken[candidates[name]] = True
    return chosen


def numbers_of(model: Model, name: str) -> IntArray:
    """Numbers of the elements of a surface or element set, rising."""
    first, surface = element_numbers(model), model.surfaces.get(name.upper())
    members = surface.facets if surface is not None else model.element_sets[name.upper()]
    return np.unique(first[members[:, 0]] + members[:, 1])


def _sets_of_part(model: Model, part: int) -> Iterator[tuple[str, IntArray]]:
    """Surfaces first: of two equal ones the first is taken."""
    usable = [b.part == part and (b.kind in SHELL_FACETS or b.kind in FACES) for b in model.blocks]
    groups: Sequence[tuple[str, IntArray]] = [
        *((name, s.facets) for name, s in model.surfaces.items() if not s.is_node_based),
        *model.element_sets.items(),
    ]
    for name, members in groups:
        if len(members) and not name.startswith("_") and all(usable[row] for row in np.unique(members[:, 0])):
            yield name, numbers_of(model, name)
