"""The contacts of a first study: which names or nodes stand for what is near, tried; which are doubtful."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.contact.pair import ContactPair, Keep, tied_channels
from creak.errors import InputError
from creak.model.faces import FACES
from creak.model.mesh import Model
from creak.progress import Progress
from creak.studies.prepare.pairs import METHODS
from creak.studies.propose.joints import linked_parts
from creak.studies.propose.opposite import STRAIGHT, Met
from creak.studies.propose.proximity import Near, covering_sets, fitting_node_set, is_number, numbers_of, titles_of
from creak.words import listed

EVEN = 0.05
"""Share of the thickness by which gaps may differ for one clearance to stand for all."""
TELLS = 0.05
"""Of half of the plate's thickness: a node nearer to its middle does not tell the side on which the edge stands."""
ROUND_OFF = 1e-12
"""Of the model's size: a gap that is no larger is none."""
TOUCHING = 1e-3
"""Of the largest near gap: what is no more apart touches at rest."""
MANY = 20
"""Channels that start closed from which on linked parts are taken to lie on each other."""
FAR = "far"
OVERLAP = "overlap"
SIDE = "side"
EDGES = "edges"
UNEVEN = "uneven"
PRESSED = "pressed"
"""Why a contact is asked about."""
TIED = "a tie holds both sides together"
"""Why there is none."""


@dataclass(frozen=True)
class Contact:
    """A contact table; or a question, or why the deck's names make none: then it is commented out."""

    name: str
    secondary: str
    main: str
    gap: float
    """Smallest distance between the surfaces of the two parts, length."""
    place: str
    """Label of the node where it is."""
    near: int
    """Elements of the secondary part that are near; nodes of an edge or a node set."""
    elements: int
    """Elements of the secondary surface or set; nodes of an edge or a node set."""
    channels: int
    start: float | None
    """Smallest gap of a channel at the start, length."""
    problem: str = ""
    """Why the pair cannot be used as it is; empty: it can."""
    parts: tuple[str, str] = ("", "")
    """Of the secondary and of the main side."""
    edge: bool = False
    """The secondary side is the free edge of shells."""
    method: str = "surface-to-surface"
    labels: tuple[str, ...] = ()
    """Nodes of the secondary side, where the study itself has to name them."""
    clearance: float | Mapping[int, float] | None = None
    """Of all channels, or by row of a node: then it becomes a table of its own (`table`)."""
    normal: tuple[float, float, float] | None = None
    closed: int = 0
    """Channels that are closed at the start."""
    question: str = ""
    """Why it is doubtful: far, overlap, side, edges, uneven, pressed; empty: it is not."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The place, length."""
    toward: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Direction of the other side there."""
    nodes: tuple[int, ...] = ()
    """Rows of the near nodes."""
    ends: tuple[str, ...] = ()
    """Labels of the nearest nodes of two edges."""
    picture: str = ""
    """File beside the study that shows it; empty: none is drawn."""
    table: str = ""
    """File beside the study with clearances by node; empty: none."""
    deck: str = ""
    """file:line of the deck's own contact pair; empty: it was found by what is near."""
    law: Mapping[str, Any] = field(default_factory=dict)
    """Keys of its table that the deck gives: stiffness or overclosure, friction, damping."""

    @property
    def live(self) -> bool:
        return self.channels > 0 and not self.problem and not self.question

    def how_far(self, unit: str) -> str:
        """The distance of its two sides in words."""
        if self.gap > -1e-9:
            return f"{max(self.gap, 0.0):.3g} {unit} apart"
        return f"{-self.gap:.3g} {unit} inside each other"


@dataclass(frozen=True)
class Tools:
    """What contacts are tried with."""

    keep: Keep | None = None
    """Takes what is searched, for who searches the same contacts later."""
    unit: str = ""
    """Of length, for messages."""


NOTHING = Tools()


def find_contacts(
    model: Model,
    near: Sequence[Near],
    distance: float,
    progress: Progress,
    tools: Tools = NOTHING,
    of_deck: Sequence[Contact] = (),
) -> tuple[Contact, ...]:
    """The contacts of what is near, those that are sure first; none where a tie holds both sides together.

    tools : what contacts are tried with.
    of_deck : pairs of the deck, which stand in place of what is near between their parts.
    """
    done = {frozenset(c.parts) for c in of_deck if not c.problem}
    near = [n for n in near if frozenset(n.parts) not in done]
    found: list[Contact] = []
    for k, n in enumerate(near):
        progress("try the contacts", k, len(near))
        of_kind = {"face": _of_faces, "edge": _of_edge, "ends": _ends}[n.kind]
        found += [c for c in of_kind(model, n, tools) if c.problem != TIED]
    progress("try the contacts", len(near), len(near))
    found = [replace(c, question=FAR) if c.gap > distance and not c.question else c for c in found]
    names, titles = dict[str, int](), titles_of(model)
    out = []
    for c in sorted([*of_deck, *found], key=lambda c: not c.live):
        own = c.deck and not is_number(c.secondary) and not is_number(c.main)
        ends = (c.secondary, c.main) if own else [titles.get(part, part) for part in c.parts]
        c = replace(c, name=_pair_name(ends))
        k = names[c.name] = names.get(c.name, 0) + 1
        if k > 1:
            c = replace(c, name=f"{c.name}-{k}", secondary=f"{c.secondary}_{k}" if c.labels else c.secondary)
        out.append(c)
    return tuple(out)


def _of_faces(model: Model, n: Near, tools: Tools) -> list[Contact]:
    sides, found = [covering_sets(model, n, side) for side in (0, 1)], []
    for first, second in product(*sides):
        members = [numbers_of(model, first), numbers_of(model, second)]
        facing = np.isin(n.touching[:, 0], members[0]) & np.isin(n.touching[:, 1], members[1])
        if facing.any():
            near = n.met.where(_meets(n.met, members))
            if near.nodes.size:
                found.append(_surfaces(model, n, near, (first, second), members, tools))
    if found:
        return [part for c in found for part in _without_pressed(model, n, c, tools)]
    for side in (0, 1):
        if sides[side] and not sides[1 - side]:
            return _by_nodes(model, n, n.met.where(n.met.side == 1 - side), 1 - side, sides[side], tools)
    bare = [part for part, names in zip(n.parts, sides, strict=True) if not names]
    problem = f"the deck has no surface or element set of {listed(bare or n.parts)} alone that is near"
    count = len(n.elements[0])
    return [replace(_drawn(model, n.met, _pair_name(n.parts), n.parts, count, count), problem=problem)]


def _without_pressed(model: Model, n: Near, c: Contact, tools: Tools) -> list[Contact]:
    """Of linked parts the nodes that are open, and as a question the surfaces that lie on each other beside them.

    What is bolted down presses all the time: hundreds of its channels cost hours and tell nothing of a rattle.
    """
    side = n.parts.index(c.parts[0])
    mine = n.met.where(n.met.side == side)
    away = mine.where(mine.gap > TOUCHING * mine.gap.max(initial=0.0))
    if not c.live or c.closed < MANY or frozenset(n.parts) not in linked_parts(model):
        return [c]
    if not away.nodes.size:
        return [replace(c, question=PRESSED)]
    if all(b.kind in FACES for b in model.blocks if model.parts[b.part].name == c.parts[0]):
        apart = [tried(model, _nodes(model, away, c.parts, c.main, "near"), tools)]
    else:
        apart = _by_nodes(model, n, away, side, [c.main], tools)
    return [*apart, replace(c, question=PRESSED)] if any(a.live for a in apart) else [c]


def _meets(met: Met, members: Sequence[IntArray]) -> BoolArray:
    return np.where(met.side == 0, np.isin(met.element, members[1]), np.isin(met.element, members[0]))


def _drawn(model: Model, met: Met, name: str, parts: tuple[str, str], near: int, elements: int) -> Contact:
    """A contact of the near nodes, of which no more is known than where it is."""
    k = int(met.gap.argmin())
    x, y, z = model.nodes.coords[met.nodes[k]].tolist()
    place, nodes = model.nodes.label(int(met.nodes[k])), tuple(np.unique(met.nodes).tolist())
    c = Contact(name, *parts, float(met.gap[k]), place, near, elements, 0, None, parts=parts)
    u, v, w = met.toward[k].tolist()
    return replace(c, at=(x, y, z), toward=(u, v, w), nodes=nodes)


def _surfaces(
    model: Model, n: Near, met: Met, names: tuple[str, str], members: list[IntArray], tools: Tools
) -> Contact:
    """The pair with the finer side as secondary; the other way round where that does not work."""
    fine = len(n.elements[0]) >= len(n.elements[1])
    orders = ((0, 1), (1, 0)) if fine else ((1, 0), (0, 1))
    each = []
    for a, b in orders:
        parts = (n.parts[a], n.parts[b])
        drawn = _drawn(model, met, _pair_name(parts), parts, len(n.elements[a]), len(members[a]))
        plain = replace(drawn, secondary=names[a], main=names[b], question=_overlaps(met))
        each.append(tried(model, plain, tools))
        if not each[-1].problem:
            return each[-1]
        by_side = _by_side(model, names[a], names[b])
        sided = [tried(model, replace(plain, secondary=s, main=m), tools) for s, m in by_side]
        if good := [c for c in sided if not c.problem]:
            return min(good, key=lambda c: abs((c.start or 0.0) - c.gap))
    return _closed(met, each[0]) if each[0].question else each[0]


def _by_side(model: Model, secondary: str, main: str) -> list[tuple[str, str]]:
    """Both names with the sides of shells whose nodes lie off their middle, where the deck has surfaces of a side."""
    one, other = (
        [n, *(s for s in (f"{n}.SPOS", f"{n}.SNEG") if s.upper() in model.surfaces)] for n in (secondary, main)
    )
    return [(a, b) for a in one for b in other][1:]


def _by_nodes(model: Model, n: Near, met: Met, side: int, mains: Sequence[str], tools: Tools) -> list[Contact]:
    """Nodes of the side that has no surface or element set, each against the names of the other."""
    found, parts = [], (n.parts[side], n.parts[1 - side])
    for main in mains:
        near = met.where(np.isin(met.element, numbers_of(model, main)))
        if not near.nodes.size:
            continue
        drawn = _nodes(model, near, parts, main, "near")
        # Nodes of a set have no thickness of their own, so the study says the gap.
        thick = float(near.apart.max() - near.gap.min())
        even = float(np.ptp(near.gap)) <= EVEN * max(thick, float(near.gap.max()))
        clearance = max(float(f"{near.gap.mean():.4g}"), 0.0)
        question = _overlaps(near) or ("" if even or thick <= 0.0 else UNEVEN)
        c = replace(drawn, clearance=clearance if thick > 0.0 else None, question=question)
        found.append(tried(model, c, tools))
    return found


def _of_edge(model: Model, n: Near, tools: Tools) -> list[Contact]:
    """The free edge of shells on a face: node by node, for the edge has no area."""
    found = []
    for main in covering_sets(model, n, 1):
        over = n.met.where(np.isin(n.met.element, numbers_of(model, main)))
        for met in _by_direction(over):
            drawn = replace(_nodes(model, met, n.parts, main, "edge"), edge=True)
            found.append(tried(model, _sided(met, drawn), tools))
    if found:
        return found
    problem = f"the deck has no surface or element set of {n.parts[1]} alone that is near"
    count = n.met.nodes.size
    return [replace(_drawn(model, n.met, _pair_name(n.parts), n.parts, count, count), edge=True, problem=problem)]


def _by_direction(met: Met) -> list[Met]:
    """Edge nodes that need to be told on which side they stand, by that side; else all of them together."""
    if not met.nodes.size:
        return []
    if not _sideless(met).any():
        return [met]
    groups, left = [], np.ones(met.nodes.size, dtype=bool)
    while left.any():
        like = left & (met.toward @ met.toward[left.argmax()] > STRAIGHT)
        groups.append(met.where(like))
        left &= ~like
    return groups


def _sideless(met: Met) -> BoolArray:
    return met.apart <= TELLS * (met.apart - met.gap)


def _sided(met: Met, c: Contact) -> Contact:
    """With the direction of the side where the nodes do not tell it, and closed where thickness explains an overlap."""
    question = SIDE if met.unsure.any() else _overlaps(met)
    if _sideless(met).any() or question:
        mean = met.toward.mean(axis=0)
        x, y, z = (np.round(mean / np.linalg.norm(mean), 4) + 0.0).tolist()
        c = replace(c, normal=(x, y, z))
    return _closed(met, replace(c, question=question))


def _closed(met: Met, c: Contact) -> Contact:
    """A clearance of nothing where all of it overlaps: nothing is left to be set to zero at the start."""
    return replace(c, clearance=0.0) if (met.gap <= 0.0).all() else c


def _overlaps(met: Met) -> str:
    return OVERLAP if (met.gap < -met.excused).any() else ""


def _nodes(model: Model, met: Met, parts: tuple[str, str], main: str, suffix: str) -> Contact:
    """The node set that fits the near nodes, or else their labels."""
    rows = np.unique(met.nodes)
    name = fitting_node_set(model, rows, parts[0])
    size = rows.size if name is None else model.node_sets[name].size
    c = replace(_drawn(model, met, _pair_name(parts), parts, rows.size, size), main=main, method="node-to-surface")
    if name is not None:
        return replace(c, secondary=name)
    labels = tuple(model.nodes.label(int(row)) for row in rows)
    taken = {n.upper() for n in (*model.node_sets, *model.element_sets, *model.surfaces)}
    own = re.sub(r"[^A-Z0-9_]+", "_", f"{parts[0]}_{suffix}_on_{parts[1]}".upper())
    while own in taken:
        own += "_"
    return replace(c, secondary=own, labels=labels)


def _ends(model: Model, n: Near, _: Tools) -> list[Contact]:
    """Two edges: no contact of shells can be made of them."""
    count = n.met.nodes.size
    drawn, k = _drawn(model, n.met, _pair_name(n.parts), n.parts, count, count), int(n.met.gap.argmin())
    side = int(n.met.side[k])
    if side == 1:
        drawn = replace(drawn, parts=(n.parts[1], n.parts[0]), secondary=n.parts[1], main=n.parts[0])
    other = next(p.nodes_idx for p in model.parts if p.name == drawn.parts[1])
    nearest = other[np.linalg.norm(model.nodes.coords[other] - n.met.point[k], axis=1).argmin()]
    return [replace(drawn, edge=True, question=EDGES, ends=(drawn.place, model.nodes.label(int(nearest))))]


def tried(model: Model, c: Contact, tools: Tools) -> Contact:
    """With its channels, or what keeps it from having any."""
    pair = ContactPair(c.name, c.secondary, c.main, c.method, c.clearance, c.normal, unit=tools.unit)
    if c.labels:
        model = replace(model, node_sets={**model.node_sets, c.secondary: np.array(c.nodes)})
    try:
        operator, _ = METHODS[c.method](model, pair, tools.keep)
    except InputError as error:
        return replace(c, problem=error.what)
    stuck = tied_channels(model, pair, operator)
    if stuck.all():
        return replace(c, problem=TIED)
    operator = operator.select(np.flatnonzero(~stuck))
    gap0 = np.where(np.abs(operator.gap0) > ROUND_OFF * np.ptp(model.nodes.coords), operator.gap0, 0.0)
    closed, k = int((gap0 <= TOUCHING * gap0.max(initial=0.0)).sum()), int(gap0.argmin())
    place = c.place or model.nodes.label(int(operator.nodes_idx[k]))
    gap = c.gap if c.place else float(gap0[k])
    return replace(c, channels=operator.m, start=float(gap0[k]), closed=closed, place=place, gap=gap)


def _pair_name(parts: Sequence[str]) -> str:
    return "-".join(re.sub(r"[^a-z0-9_]+", "_", name.lower()) for name in parts)
