"""Which parts come near each other, and the names of the deck that cover what is near."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import facets_of
from creak.errors import InputError
from creak.model.constraints import tied_nodes
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import BeamSection
from creak.model.mesh import Model
from creak.model.projection import nearest_points
from creak.studies.propose.opposite import Kind, Met, Skin, element_numbers, joined, opposite, reach_along, skin_of

LEAST = 0.05
"""A set that covers less than this share of what is near is not taken."""
ASIDE, ENDS = 0.3, 0.02
"""How far a third part may lie beside the way between two others, and how near to its ends, as shares of it."""
NUMBER = re.compile(r"(PID|PART|B?SURFS?|BCPROPS?|SET(_[A-Z]+)?)_\d+(\.S(POS|NEG))?")
"""Names that decks without names give."""
FITS = 0.8
"""A node set that fits less well than this does not stand for near nodes."""


@dataclass(frozen=True)
class Near:
    """Two parts whose surfaces, or the free edges of whose shells, come near each other."""

    kind: Kind
    parts: tuple[str, str]
    """Of an edge on a face the edge's part first."""
    elements: tuple[IntArray, IntArray]
    """Numbers of the near elements of either part."""
    touching: IntArray
    """(m, 2) numbers of elements of the first and the second part that are opposite each other."""
    met: Met
    """The near nodes, of both parts; of edges those of the edges alone."""

    @property
    def gap(self) -> float:
        """Smallest distance between the surfaces, thickness taken off; negative: they overlap."""
        return float(self.met.gap.min())

    @property
    def node(self) -> int:
        """Row of the node where it is smallest."""
        return int(self.met.nodes[self.met.gap.argmin()])


def skins_of(model: Model) -> dict[int, Skin]:
    """Of each part that has shells or solids, by its number."""
    return {i: s for i in range(len(model.parts)) if (s := skin_of(model, i)).facets.size}


def near_parts(model: Model, skins: Mapping[int, Skin], distance: float, far: float) -> list[Near]:
    """Pairs of parts that come nearer than `distance`, or else than `far`, the nearest first.

    Nodes that links or ties hold are left out: nothing rattles there. So are those that another part lies before.
    Parts without shells and solids have no skin. Two edges are told only of parts that are near each other nowhere
    else.

    Parameters
    ----------
    distance, far : between the surfaces, in the deck's unit of length.
    """
    tied = tied_nodes(model.constraints, model.nodes.count)
    boxes = {k: _box(model.nodes.coords[skin.facets].reshape(-1, 3)) for k, skin in skins.items()}
    found: list[Near] = []
    for i, j in combinations(skins, 2):
        limit = far + skins[i].reach + skins[j].reach
        if (boxes[i][0] > boxes[j][1] + limit).any() or (boxes[j][0] > boxes[i][1] + limit).any():
            continue
        between = [(skin, boxes[k]) for k, skin in skins.items() if k not in (i, j)]
        there = _in_sight(model, opposite(model, skins[i], skins[j], far, tied, 0), between)
        back = _in_sight(model, opposite(model, skins[j], skins[i], far, tied, 1), between)
        names = (model.parts[i].name, model.parts[j].name)
        of_kind = partial(_near, skins=(skins[i], skins[j]), distance=distance)
        pairs = [
            of_kind("face", names, [there.of("face"), back.of("face")]),
            of_kind("edge", names, [there.of("edge")]),
            of_kind("edge", names, [back.of("edge")]),
        ]
        if not any(pairs):
            pairs = [of_kind("ends", names, [there.of("ends"), back.of("ends")])]
        found += [pair for pair in pairs if pair is not None]
    return sorted(found, key=lambda n: n.gap)


def _box(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest coordinates of points (n, 3)."""
    return points.min(axis=0), points.max(axis=0)


def _in_sight(model: Model, met: Met, others: Sequence[tuple[Skin, tuple[FloatArray, FloatArray]]]) -> Met:
    """Without nodes between which and the nearest point of the other skin a third part, in its box, lies.

    It does where its nearest point, from either end, is on the way: within `ASIDE` of it as seen from that end.
    """
    X, clear = model.nodes.coords, np.ones(met.nodes.size, dtype=bool)
    for skin, (low, high) in others:
        rows = np.flatnonzero(clear & (met.gap > 0.0))
        if not rows.size:
            break
        start, end = X[met.nodes[rows]], met.point[rows]
        beside = (np.maximum(start, end) < low).any(axis=1) | (np.minimum(start, end) > high).any(axis=1)
        rows, start, end = rows[~beside], start[~beside], end[~beside]
        if rows.size:
            corners = X[skin.facets]
            hidden = _lies_on(skin, corners, start, end)
            hidden[~hidden] = _lies_on(skin, corners, end[~hidden], start[~hidden])
            clear[rows[hidden]] = False
    return met.where(clear)


def _lies_on(skin: Skin, corners: FloatArray, start: FloatArray, end: FloatArray) -> BoolArray:
    """(n,) whether the skin's point nearest to each start lies on the way to its end."""
    way = end - start
    length = np.linalg.norm(way, axis=1)
    near = nearest_points(start, corners, skin.facets[:, 2] == skin.facets[:, 3], float(length.max(initial=0.0)))
    foot = np.einsum("nc,ncx->nx", near.shape, corners[np.where(near.found, near.facet, 0)]) - start
    along = np.einsum("nx,nx->n", foot, way) / np.maximum(length, 1e-300)
    aside = np.sqrt(np.maximum(np.einsum("nx,nx->n", foot, foot) - along**2, 0.0))
    on_it = (along > ENDS * length) & (along < (1.0 - ENDS) * length) & (aside <= ASIDE * along)
    return np.asarray(near.found & on_it)


def near_beams(model: Model, skins: Mapping[int, Skin], distance: float, unit: str) -> list[str]:
    """Parts of beams alone, which have no skin, whose nodes come within `distance` of a skin: a sentence each.

    unit : of length.
    """
    tied, said = tied_nodes(model.constraints, model.nodes.count), list[str]()
    for i, part in enumerate(model.parts):
        blocks = [b for b in model.blocks if b.part == i and isinstance(b.section, BeamSection)]
        if i in skins or not blocks:
            continue
        radius = np.full(model.nodes.count, -1.0)
        for block in blocks:
            np.maximum.at(radius, block.nodes_idx, block.section.radius)  # type: ignore[union-attr]
        rows = np.flatnonzero((radius >= 0.0) & ~tied)
        for j, skin in skins.items():
            gap = _beside(model, rows, radius[rows], skin, distance)
            if gap.min(initial=np.inf) <= distance:
                k = int(gap.argmin())
                how = f"{gap[k]:.3g} {unit} from" if gap[k] > 0.0 else f"{-gap[k]:.3g} {unit} inside"
                said.append(
                    f"{part.name} is of beams, which have no surface that is looked for: its node "
                    f"{model.nodes.label(int(rows[k]))} is {how} {model.parts[j].name}. If they may touch, add a "
                    f'[contact.NAME] with method = "node-to-surface" and its nodes as secondary'
                )
    return said


def _beside(model: Model, rows: IntArray, radius: FloatArray, skin: Skin, distance: float) -> FloatArray:
    """(n,) distance of round nodes from a skin, its thickness taken off; inf where it is far."""
    coords, gap = model.nodes.coords, np.full(rows.size, np.inf)
    corners, reach = coords[skin.facets], skin.reach
    limit = distance + reach + float(radius.max(initial=0.0))
    near = nearest_points(coords[rows], corners, skin.facets[:, 2] == skin.facets[:, 3], limit)
    facet = near.facet[near.found]
    way = coords[rows[near.found]] - np.einsum("nc,ncx->nx", near.shape[near.found], corners[facet])
    away = np.linalg.norm(way, axis=1)
    along = np.einsum("nx,nx->n", skin.normals(coords)[facet], way) / np.maximum(away, 1e-300)
    behind = skin.solid[facet] & (along < 0.0)
    gap[near.found] = np.where(behind, -away, away) - reach_along(skin, facet, along) - radius[near.found]
    return gap


def _near(
    kind: Kind, names: tuple[str, str], sides: list[Met], skins: tuple[Skin, Skin], distance: float
) -> Near | None:
    met = joined(sides)
    if not met.nodes.size:
        return None
    close = met.gap <= distance
    met = met.where(close if close.any() else ~close)
    pairs = []
    for side in (0, 1):
        mine, other = met.where(met.side == side), skins[1 - side]
        facet_at = np.full(1 + int(max(skins[side].facets.max(), mine.nodes.max(initial=0))), -1, dtype=np.int64)
        facet_at[mine.nodes] = mine.facet
        opposite = facet_at[skins[side].facets]
        facet, corner = np.nonzero(opposite >= 0)
        pair = np.column_stack([skins[side].element[facet], other.element[opposite[facet, corner]]])
        pairs.append(pair if side == 0 else pair[:, ::-1])
    touching = np.unique(np.concatenate(pairs), axis=0)
    if kind == "edge" and met.side[0] == 1:
        names, touching, met = (names[1], names[0]), touching[:, ::-1], replace(met, side=0 * met.side)
    return Near(kind, names, (np.unique(touching[:, 0]), np.unique(touching[:, 1])), touching, met)


def closest_parts(model: Model) -> tuple[str, str, float] | None:
    """The two parts whose nodes are nearest and that distance; None for a model with fewer than two."""
    trees = {p.name: cKDTree(model.nodes.coords[p.nodes_idx]) for p in model.parts if p.nodes_idx.size}
    pairs = [(a, b, float(trees[b].query(trees[a].data)[0].min())) for a, b in combinations(trees, 2)]
    return min(pairs, key=lambda p: p[2], default=None)


def covering_sets(model: Model, n: Near, side: int) -> list[str]:
    """Names of surfaces and element sets of a part that fit its near elements best, none overlapping another.

    A set fits by 2 |set and near| / (|set| + |near|): all of what is near, and little else. Surfaces that look away
    from the other part are taken only where there are no others.

    Parameters
    ----------
    side : 0: of the first part, 1: of the second.
    """
    near, index = n.elements[side], next(i for i, p in enumerate(model.parts) if p.name == n.parts[side])
    every = dict(_sets_of_part(model, index))
    looking = _covering(model, every, near, lambda name: looks_at(model, name, n.met, side))
    return looking or _covering(model, every, near, lambda _: True)


def _covering(model: Model, every: Mapping[str, IntArray], near: IntArray, usable: Callable[[str], bool]) -> list[str]:
    """Those of some sets of elements that fit best and are usable."""
    candidates = dict(every)
    left, taken = np.zeros((2, element_numbers(model)[-1]), dtype=bool)
    left[near] = True
    chosen: list[str] = []
    while left.any():
        free = {name: int(np.count_nonzero(left[s])) for name, s in candidates.items() if not taken[s].any()}
        size = int(np.count_nonzero(left))
        fits = [(2.0 * shared / (size + candidates[name].size), name) for name, shared in free.items()]
        score, name = max(fits, key=lambda f: (f[0], not is_number(f[1])), default=(0.0, ""))
        if not score or free[name] < LEAST * near.size:
            break
        if not usable(name):
            del candidates[name]
            continue
        chosen.append(name)
        left[candidates[name]] = False
        taken[candidates[name]] = True
    return chosen


def looks_at(model: Model, name: str, met: Met, side: int) -> bool:
    """Whether a surface of a part has facets near the other part that look at it; an element set looks every way."""
    if name.upper() not in model.surfaces:
        return True
    try:
        facets = facets_of(model, name, where=name)
    except InputError:  # the contact that is tried says it
        return True
    toward = np.where((met.side == side)[:, None], -met.toward, met.toward)
    away, at = cKDTree(model.nodes.coords[met.nodes]).query(facets.coords.mean(axis=1))
    normals = facets.area_normals
    reach = away.min() + np.linalg.norm(np.ptp(facets.coords, axis=1), axis=1)
    areas, cosine = np.linalg.norm(normals, axis=1), np.einsum("nx,nx->n", normals, toward[at])
    looking = (facets.side == 0) | (facets.side * cosine > 0.0)
    close = away <= reach
    return bool(areas[close & looking].sum() >= LEAST * areas[close].sum())


def fitting_node_set(model: Model, near: IntArray, part: str) -> str | None:
    """The node set of a part alone that fits its near nodes (k,) best, by the same measure; None: none fits well."""
    rows = next(p.nodes_idx for p in model.parts if p.name == part)
    fits = [
        (2.0 * np.isin(members, near).sum() / (members.size + near.size), name)
        for name, members in model.node_sets.items()
        if members.size and not name.startswith("_") and np.isin(members, rows).all()
    ]
    score, name = max(fits, default=(0.0, ""))
    return name if score >= FITS else None


def is_number(name: str) -> bool:
    """Whether a name is the number of a part, property or set in a deck, as PID_7 and PART_7.SPOS are."""
    return NUMBER.fullmatch(name) is not None


def titles_of(model: Model, names: Container[str] | None = None) -> dict[str, str]:
    """Name of a part -> that of the first set of all its shells and solids that is no number.

    names : parts that are looked at; None: those whose name is a number.
    """
    first, whole = element_numbers(model), dict[bytes, str]()
    for name, members in model.element_sets.items():
        if not is_number(name) and not name.startswith("_"):
            whole.setdefault(np.unique(first[members[:, 0]] + members[:, 1]).tobytes(), name)
    found = dict[str, str]()
    for i, part in enumerate(model.parts):
        own = [row for row, b in enumerate(model.blocks) if b.part == i and (b.kind in SHELL_FACETS or b.kind in FACES)]
        if own and (is_number(part.name) if names is None else part.name in names):
            key = np.concatenate([first[row] + np.arange(model.blocks[row].ids.size) for row in own]).tobytes()
            found |= {part.name: whole[key]} if key in whole else {}
    return found


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
