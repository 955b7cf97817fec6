"""A contact pair of the study turned into gap channels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets, facets_of
from creak.contact.gap_operator import ChannelRows, GapOperator, join
from creak.contact.laws.parameters import laid_over
from creak.contact.search import Projection
from creak.errors import InputError
from creak.model.constraints import Constraint, Equation, Tie
from creak.model.contact_law import BY_THE_ELEMENTS, ContactLaw
from creak.model.dofs import TRANSLATIONS, nodes_of
from creak.model.mesh import Model

T = TypeVar("T")

AUTO_FACTOR = 10.0
"""Penalty = 10 x the stiffness of the softer parent element, as Abaqus does."""
REACH = 0.25
"""A partner is looked for within this fraction of the secondary surface's diagonal."""
EDGE_ON = 0.05
"""A one-sided facet takes part along a given normal when their cosine is above this."""
ROUND_OFF = 1e-9
"""Share of an element's width by which surfaces that touch may seem to overlap."""
WHOLE = ("channel", "label", "nodes_idx")
"""Fields of channels that are whole numbers."""
Arrays = dict[str, FloatArray]
Keep = Callable[[Sequence[FloatArray | IntArray], Callable[[], Arrays]], Arrays]
"""All that a search depends on, and the search -> what it finds, or what an earlier one has found."""


@dataclass(frozen=True)
class ContactPair:
    """What the study says of one contact."""

    name: str
    secondary: str
    main: str
    method: str = "surface-to-surface"
    clearance: float | Mapping[int, float] | None = None
    """Replaces the geometric gap, length: of all channels, or by node row."""
    normal: tuple[float, float, float] | None = None
    """Direction from the main to the secondary surface, instead of the surfaces' own."""
    per_area: bool = False
    """node-to-surface: the law is per area of the secondary surface."""
    law: ContactLaw = BY_THE_ELEMENTS
    """Per area (surface-to-surface, `per_area`) or per node (node-to-surface)."""
    table: str = "contact"
    """Table of the study that it comes from."""
    press_fit: bool = False
    """Gaps below zero stay: what overlaps presses."""
    unit: str = ""
    """Of length, where it is known."""

    @property
    def where(self) -> str:
        return f"[{self.table}.{self.name}]"

    def told(self, length: float, digits: int = 4) -> str:
        """A length with its unit."""
        return f"{length:.{digits}g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Channels:
    """The m channels of a pair as geometry: what the laws are laid over."""

    nodes_idx: IntArray
    """(m,) secondary nodes."""
    gap: FloatArray
    """(m,) geometric gap, length."""
    depth: FloatArray
    """(m,) how deep they may start inside, length."""
    stiffness: FloatArray
    """(m,) force / length (surface-to-surface: over area), from the parent elements."""
    area: FloatArray
    """(m,) tributary area; 0 for node-to-surface."""
    size: FloatArray
    """(m,) width of the facets there."""
    scale: FloatArray
    """(m,) what turns the study's numbers into those of a channel: the area, or 1 for node-to-surface."""


Wall = tuple[ChannelRows, Channels]
"""Channels to one wall of the main surface, before the study's numbers are laid over them."""


def searched(
    keep: Keep | None, inputs: Sequence[FloatArray | IntArray], search: Callable[[], list[Wall]]
) -> list[Wall]:
    """What a search finds, kept or not."""
    if keep is None:
        return search()
    kept = keep(inputs, lambda: _flat(search()))
    count = 1 + max((int(name.partition(".")[0]) for name in kept), default=-1)
    return [(_unflat(ChannelRows, kept, k), _unflat(Channels, kept, k)) for k in range(count)]


def _flat(walls: list[Wall]) -> Arrays:
    return {f"{k}.{f.name}": getattr(of, f.name) for k, wall in enumerate(walls) for of in wall for f in fields(of)}


def _unflat(kind: type[T], kept: Arrays, k: int) -> T:
    """Rows, labels and nodes are whole numbers, which were kept as others are."""
    values = {f.name: kept[f"{k}.{f.name}"] for f in fields(kind)}  # type: ignore[arg-type]
    return kind(**{name: v.astype(np.int64) if name in WHOLE else v for name, v in values.items()})


def reach(coords: FloatArray) -> float:
    """How far from the secondary surface a main facet may lie."""
    return REACH * float(np.linalg.norm(np.ptp(coords.reshape(-1, 3), axis=0)))


def main_facets(model: Model, pair: ContactPair) -> Facets:
    """Facets of the main surface."""
    return facets_of(model, pair.main, where=f"{pair.where} main")


def given_normal(pair: ContactPair) -> FloatArray | None:
    """The study's direction from main to secondary, of unit length; None: the surfaces' own normals.

    Raises
    ------
    InputError : a direction of length zero.
    """
    if pair.normal is None:
        return None
    normal = np.array(pair.normal, dtype=np.float64)
    length = float(np.linalg.norm(normal))
    if not 0.0 < length < np.inf:
        raise InputError(
            f"normal = {list(pair.normal)} has no direction",
            where=f"{pair.where} normal",
            expected="a vector from the main to the secondary surface",
            fix="Give one, or leave it out.",
        )
    return normal / length


def deepest(facets: Facets) -> FloatArray:
    """(n,) how far behind a one-sided facet a point still belongs to it: the height of a solid, 0 for shells."""
    return np.where(facets.is_solid, 2.0 * facets.depth, 0.0)


def overlap(thickness: tuple[FloatArray, FloatArray], depth: tuple[FloatArray, FloatArray]) -> FloatArray:
    """How deep two sides may start in each other: the thickness of both shells, and half a solid's height."""
    return thickness[0] + thickness[1] + np.maximum(*depth)


def looks_along(facets: Facets, rows: IntArray, direction: FloatArray, cosine: float = 0.0) -> BoolArray:
    """Which of the facets `rows` touch with a side that looks along `direction` (n, 3); two-sided ones always do."""
    normal = facets.area_normals[rows] * facets.side[rows, None]
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    return np.asarray((facets.side[rows] == 0) | (np.einsum("nx,nx->n", normal, direction) > cosine))


def never_face(pair: ContactPair, limit: float) -> InputError:
    """The error for surfaces that have no point opposite each other."""
    if pair.secondary.upper() == pair.main.upper():
        return InputError(
            f"surface {pair.secondary!r} touches itself",
            where=pair.where,
            expected="two surfaces",
            fix="creak has no self-contact: name the surface of the other part.",
        )
    along = "" if pair.normal is None else f" along the normal {list(pair.normal)}"
    sides = "the sides (SPOS, SNEG) of the surfaces" if pair.normal is None else "the sense of the normal"
    return InputError(
        f"surfaces {pair.secondary!r} and {pair.main!r} never face each other: no point of the first has a facet "
        f"of the second opposite it within {pair.told(limit)}{along}",
        where=pair.where,
        expected="two surfaces that lie opposite each other",
        fix=f"Check the names, the positions of the parts and {sides}.",
    )


def channels_of_walls(
    model: Model, pair: ContactPair, walls: Sequence[Wall], limit: float
) -> tuple[GapOperator, list[str]]:
    """The channels of each wall, those of further ones named after their order (NAME:2).

    Raises
    ------
    InputError : there is none up to `limit`; deep initial overclosure.
    """
    if not walls:
        raise never_face(pair, limit)
    operators: list[GapOperator] = []
    notes: list[str] = []
    for k, wall in enumerate(walls, start=1):
        operator, more = _channels_of(model, pair if k == 1 else replace(pair, clearance=None), *wall)
        operators.append(operator if k == 1 else replace(operator, names=tuple(f"{n}:{k}" for n in operator.names)))
        notes += more
    return join(operators), notes


def _channels_of(
    model: Model, pair: ContactPair, rows: ChannelRows, channels: Channels
) -> tuple[GapOperator, list[str]]:
    """Finish the channels of a pair: clearance, initial overclosure, laws, names."""
    given, notes = _given_gaps(model, pair, channels)
    gap0, more = _without_overclosure(model, pair, channels, given)
    rows = rows if pair.law.friction.static > 0.0 else rows.without_rotations()
    operator = GapOperator(
        **rows.motion(gap0.size),
        gap0=gap0,
        area=channels.area,
        names=tuple(f"{pair.name}:{model.nodes.label(int(i))}" for i in channels.nodes_idx),
        nodes_idx=channels.nodes_idx,
        group=(pair.name,) * gap0.size,
        size=channels.size,
        **laid_over(pair.law, channels.scale, channels.stiffness),
    )
    if pair.law.hard and pair.law.damping:
        notes.append(f"{pair.where} a hard contact takes no damping; the number given is not used")
    return operator, [*notes, *more]


def _given_gaps(model: Model, pair: ContactPair, channels: Channels) -> tuple[FloatArray, list[str]]:
    """(m,) gaps that the study gives, nan where the geometric one holds."""
    given = np.full_like(channels.gap, np.nan)
    if pair.clearance is None:
        return given, []
    if not isinstance(pair.clearance, Mapping):
        return np.full_like(given, pair.clearance), []
    table = pair.clearance
    given = np.array([table.get(int(i), np.nan) for i in channels.nodes_idx])
    notes = []
    without = channels.nodes_idx[np.isnan(given)]
    if without.size:
        notes.append(
            f"{pair.where} {without.size} node(s) have no row in the table of clearances and keep their geometric "
            f"gap: {model.nodes.first_few(without)}"
        )
    unused = np.array(sorted(set(table) - set(channels.nodes_idx.tolist())), dtype=np.int64)
    if unused.size:
        notes.append(
            f"{pair.where} {unused.size} row(s) of the table of clearances are for nodes that face nothing: "
            f"{model.nodes.first_few(unused)}"
        )
    return given, notes


def _without_overclosure(
    model: Model, pair: ContactPair, channels: Channels, given: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Gaps (m,) with channels that start closed set to zero, and a note about these; a press fit keeps them. Another
    where most nodes are deep inside and a clearance is given.

    Raises
    ------
    InputError : the geometric gap of a node is deeper inside than `Channels.depth`.
    """
    free = np.isnan(given)
    gap0 = np.where(free, channels.gap, given)
    inside = channels.gap + np.maximum(channels.depth, ROUND_OFF * channels.size)
    deep = np.where(free, inside, np.inf)
    turned = 2 * np.count_nonzero(inside < 0.0) > inside.size
    if deep.size and deep.min() < 0.0:
        worst = int(np.argmin(deep))
        raise InputError(
            f"node {model.nodes.label(int(channels.nodes_idx[worst]))} starts {pair.told(-gap0[worst])} inside the "
            "main surface, more than the shells' thickness (of solids: half an element's height)",
            where=pair.where,
            fix="Move the parts apart, or give a clearance."
            + (f" {_side_asked(pair)}" if turned or pair.normal else ""),
        )
    notes = []
    if turned:
        count, most = np.count_nonzero(inside < 0.0), -channels.gap.min()
        notes.append(
            f"{pair.where} {count} of {inside.size} nodes lie up to {pair.told(most, 3)} behind the main surface, "
            "which the clearance hides: where it looks the other way, the contact holds "
            f"parts together instead of apart. {_side_asked(pair)}"
        )
    if pair.press_fit:
        return gap0, notes
    closed = np.flatnonzero(gap0 < -ROUND_OFF * channels.size)
    if not closed.size:
        return np.maximum(gap0, 0.0), notes
    node = model.nodes.label(int(channels.nodes_idx[np.argmin(gap0)]))
    note = (
        f"{pair.where} {closed.size} channel(s) start closed, by up to {pair.told(-gap0.min(), 3)} at node {node}; "
        "their gap is set to 0 without strain"
    )
    return np.maximum(gap0, 0.0), [*notes, note]


def _side_asked(pair: ContactPair) -> str:
    if pair.normal is None:
        return "Does the main surface name the side (SPOS or SNEG) that looks at the secondary one?"
    return "Does the normal point from the main to the secondary surface?"


def gap_normals(projection: Projection, sides: IntArray) -> tuple[FloatArray, FloatArray]:
    """Signed distance between mid-surfaces and the unit normal from main to secondary.

    `distance` runs from the secondary point to the facet along `direction`; a double-sided main surface
    (side 0) faces whichever side the point is on.
    """
    d, direction = projection.distance, projection.direction
    flip = np.where(sides == 0, np.where(d > 0.0, -1.0, 1.0), np.where(sides >= 0, 1.0, -1.0))
    normal = direction * flip[:, None]
    return -d * flip, normal


def turns_of(t1: FloatArray, t2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What a rotation theta moves along two tangents at the tip of a unit arm along their normal n = t1 x t2:
    t . (theta x n) = theta . (n x t)."""
    return t2, -t1


def tangents_of(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit tangents for each normal."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    t1 = np.cross(normals, helper)
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    return t1, np.cross(normals, t1)


def tied_channels(model: Model, pair: ContactPair, operator: GapOperator) -> BoolArray:
    """(m,) channels whose node is tied to the main surface opposite it, or whose main nodes are all tied to the
    secondary surface.

    A gap there is sum_k w_k (u_s - u_k) . n with u_s = sum_k w_k u_k: it stays as it is, and what is seen of it is
    round-off.

    Parameters
    ----------
    operator : the channels of the pair.
    """
    leaders = dict(_ties(model.constraints, set(nodes_of(operator.labels).tolist())))
    tied = np.zeros(operator.m, dtype=bool)
    if not leaders:
        return tied
    surface, G = set(main_facets(model, pair).nodes.ravel().tolist()), operator.G.tocsr()
    for k, node in enumerate(operator.nodes_idx.tolist()):
        row = set(nodes_of(operator.labels[G.indices[G.indptr[k] : G.indptr[k + 1]]]).tolist())
        opposite, own = row & surface, row - surface
        if node in leaders:
            tied[k] = leaders[node] <= surface and not leaders[node].isdisjoint(opposite)
        else:
            tied[k] = bool(opposite) and all(not leaders.get(n, set()).isdisjoint(own) for n in opposite)
    return tied


def _ties(constraints: Sequence[Constraint], of: set[int]) -> Iterator[tuple[int, set[int]]]:
    """Nodes among `of` that ties join to several others in all three directions, and those others."""
    dofs: dict[int, set[int]] = {}
    nodes: dict[int, set[int]] = {}
    for c in constraints:
        if isinstance(c, Tie) and c.node_idx in of:
            yield c.node_idx, set(c.nodes_idx.tolist())
        elif isinstance(c, Equation) and int(c.nodes_idx[0]) in of:
            node = int(c.nodes_idx[0])
            dofs.setdefault(node, set()).add(int(c.dofs[0]))
            nodes.setdefault(node, set()).update(c.nodes_idx[1:].tolist())
    yield from ((n, nodes[n]) for n in dofs if set(TRANSLATIONS) <= dofs[n] and len(nodes[n]) > 1)
