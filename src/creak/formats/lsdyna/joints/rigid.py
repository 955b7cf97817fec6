"""Rigid bodies: nodal ones, rigid parts, spotwelds, extra nodes, and what joins them -> kinematic couplings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.lsdyna.mesh.nodes import directions
from creak.formats.lsdyna.mesh.sets import Sets
from creak.formats.lsdyna.sections.parts import PartCard, Properties
from creak.formats.lsdyna.text.deck import Card, Deck, Named
from creak.model.constraints import Constraint, Fixed, KinematicCoupling
from creak.model.dofs import ALL, ROTATIONS, TRANSLATIONS


@dataclass(frozen=True)
class Body:
    """Nodes that move as one."""

    name: str
    rows: list[int]
    where: str
    held: tuple[int, ...] = ()
    """Dofs of the whole body that are held."""


def read_rigid(
    deck: Deck, properties: Properties, sets: Sets, fixed: tuple[Fixed, ...]
) -> tuple[list[Constraint], tuple[Fixed, ...]]:
    """One coupling for each rigid body; bodies that share nodes, or that *CONSTRAINED_RIGID_BODIES merges, are one.

    Its first node that is supported, else its first one, leads the others.

    Parameters
    ----------
    fixed : supports of the deck.

    Returns
    -------
    The couplings, and supports of bodies that are held as a whole.

    Raises
    ------
    InputError : an unknown node, set or part, or a body that is not rigid in all directions.
    """
    bodies = [
        *_nodal_bodies(deck, sets),
        *_rigid_parts(deck, properties, sets),
        *_spotwelds(deck),
        *_weld_groups(deck, sets),
    ]
    for body in bodies:
        if not body.rows:
            raise InputError(
                f"rigid body {body.name} has no nodes",
                where=body.where,
                expected="a set with nodes",
                fix="Put nodes into its set, or take it out.",
            )
    ids = {body.name: i for i, body in enumerate(bodies)}
    leader = list(range(len(bodies)))

    def find(i: int) -> int:
        while leader[i] != i:
            leader[i] = i = leader[leader[i]]
        return i

    for first, second in _merged(deck, ids):
        leader[find(second)] = find(first)
    owner: dict[int, int] = {}
    for i, body in enumerate(bodies):
        for row in body.rows:
            leader[find(i)] = find(owner.setdefault(row, i))
    together: dict[int, list[Body]] = {}
    for i, body in enumerate(bodies):
        together.setdefault(find(i), []).append(body)
    supported = {row for f in fixed for row in f.nodes_idx.tolist()}
    return _couplings(list(together.values()), supported)


def _couplings(together: list[list[Body]], supported: set[int]) -> tuple[list[Constraint], tuple[Fixed, ...]]:
    couplings: list[Constraint] = []
    held: list[Fixed] = []
    for group in together:
        rows = list(dict.fromkeys(row for body in group for row in body.rows))
        lead = next((row for row in rows if row in supported), rows[0])
        others = np.array([row for row in rows if row != lead], dtype=np.int64)
        if others.size:
            couplings.append(KinematicCoupling(group[0].name, lead, others, ALL, group[0].where))
        dofs = tuple(sorted({d for body in group for d in body.held}))
        if dofs:
            held.append(Fixed(np.array([lead], dtype=np.int64), dofs, group[0].where))
    return couplings, tuple(held)


def _nodal_bodies(deck: Deck, sets: Sets) -> Iterator[Body]:
    """PID, CID, NSID, PNODE, IPRT, DRFLAG, RRFLAG; with _SPC a line of CMO, CON1, CON2."""
    for named in deck.named("CONSTRAINED_NODAL_RIGID_BODY"):
        size = 2 if "SPC" in named.options else 1
        for lines in named.block.records(size, f"{size} line(s) for each body", skip=int(named.titled)):
            card, *more = (named.block.card(line) for line in lines)
            pid = card.defined(0, "p")
            for i, what in ((5, "DRFLAG"), (6, "RRFLAG")):
                if card.integer(i):
                    raise card.wrong(i, f"{what} 0: creak's nodal rigid bodies hold all six motions", "Use springs.")
            set_id = card.label(2, "s") or card.label(0, "s")
            rows = list(referred(sets.nodes, set_id, card, "node set", "*SET_NODE"))
            if card.integer(3):
                rows.append(deck.nodes.row(card, 3))
            yield Body(f"NRB_{pid}", rows, card.where, _held(more[0]) if more else ())


def _rigid_parts(deck: Deck, properties: Properties, sets: Sets) -> Iterator[Body]:
    """All nodes of a part of *MAT_RIGID, and its extra nodes; its elements keep their mass."""
    rows: dict[int, list[int]] = {pid: [] for pid, part in properties.parts.items() if properties.is_rigid(part)}
    for (_, pid, *_), group in deck.groups.items():
        if isinstance(pid, int) and pid in rows:
            rows[pid] += [row for nodes in group.nodes for row in nodes]
    for card, pid, extra in _extra_nodes(deck, sets):
        if pid not in rows:
            raise card.wrong(0, "the id of a part of *MAT_RIGID")
        rows[pid] += extra
    for pid, members in rows.items():
        part = properties.parts[pid]
        if members:
            yield Body(part.name, list(dict.fromkeys(members)), part.card.where, _of_law(part, properties))


def _of_law(part: PartCard, properties: Properties) -> tuple[int, ...]:
    """What the second line of a *MAT_RIGID holds: CMO, CON1, CON2."""
    second = properties.law(part).second
    return () if second is None else _held(second)


def _held(card: Card) -> tuple[int, ...]:
    """Dofs of the centre of mass that are held, where they are those of every node.

    Raises
    ------
    InputError : they are held in a local system, or some translations while the body turns.
    """
    kind = card.real(0)
    if kind == 0.0:
        return ()
    if kind != 1.0:
        raise card.wrong(0, "CMO 1 (global axes) or 0", "Hold the nodes by *BOUNDARY_SPC instead.")
    moved, turned = directions(card, 1), directions(card, 2)
    if moved and len(turned) < len(ROTATIONS):
        raise card.wrong(
            2, "7 (no rotation) where translations are held: creak holds no centre of mass", "Hold nodes instead."
        )
    assert set(moved) <= set(TRANSLATIONS)
    return (*moved, *(3 + d for d in turned))


def _extra_nodes(deck: Deck, sets: Sets) -> Iterator[tuple[Card, int, list[int]]]:
    for named in deck.named("CONSTRAINED_EXTRA_NODES_NODE"):
        for card in named.cards():
            yield card, card.label(0, "p"), [deck.nodes.row(card, 1)]
    for named in deck.named("CONSTRAINED_EXTRA_NODES_SET"):
        for card in named.cards():
            yield card, card.label(0, "p"), referred(sets.nodes, card.label(1, "s"), card, "node set", "*SET_NODE")


def _spotwelds(deck: Deck) -> Iterator[Body]:
    """N1, N2: a rigid beam between two nodes; a line with an id, and one about forces, go with it by its options."""
    for named in deck.named("CONSTRAINED_SPOTWELD"):
        for card in _own_cards(named, 2 if "FORCE" in named.options else 1):
            rows = [deck.nodes.row(card, i) for i in (0, 1)]
            if rows[0] == rows[1]:
                raise card.error("a spotweld joins a node to itself", expected="two nodes")
            yield Body(f"SPOTWELD {card.text(0)} {card.text(1)}", rows, card.where)


def _weld_groups(deck: Deck, sets: Sets) -> Iterator[Body]:
    """NSID: the nodes of a set as one rigid spot; failure in the second line is left out."""
    for named in deck.named("CONSTRAINED_GENERALIZED_WELD_SPOT"):
        for card in _own_cards(named, 2):
            rows = referred(sets.nodes, card.label(0, "s"), card, "node set", "*SET_NODE")
            yield Body(f"WELD {card.text(0)}", list(rows), card.where)


def _own_cards(named: Named, size: int) -> Iterator[Card]:
    """The first card of each record of `size` lines, one more where it has an id; the last lines may be missing."""
    skip = int("ID" in named.options)
    block = named.block
    if len(block.lines) <= skip:
        raise block.cut_off("a line for each weld")
    for i in range(skip, len(block.lines), size + skip):
        yield block.card(block.lines[i])


def _merged(deck: Deck, ids: dict[str, int]) -> Iterator[tuple[int, int]]:
    """PIDL, PIDC of *CONSTRAINED_RIGID_BODIES: parts or nodal rigid bodies."""
    for named in deck.named("CONSTRAINED_RIGID_BODIES"):
        for card in named.cards():
            pair = []
            for i in (0, 1):
                pid = card.label(i, "p")
                found = ids.get(f"PART_{pid}", ids.get(f"NRB_{pid}"))
                if found is None:
                    raise card.wrong(i, "the id of a rigid part or nodal rigid body")
                pair.append(found)
            yield pair[0], pair[1]
