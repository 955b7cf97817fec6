"""*INITIAL_VELOCITY, _NODE and _GENERATION -> velocities of nodes at the start."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.refusals import referred
from creak.formats.lsdyna.mesh.nodes import Systems
from creak.formats.lsdyna.mesh.sets import Sets
from creak.formats.lsdyna.text.deck import Card, Deck
from creak.model.constraints import Constraint

GENERATED, OF_SETS, OF_NODES = "INITIAL_VELOCITY_GENERATION", "INITIAL_VELOCITY", "INITIAL_VELOCITY_NODE"
BY_NODES = -999
"""NX of an axis that leads from node NY to node NZ."""
Velocities = dict[int, FloatArray]
"""Node row -> (6,) translational and angular velocity in global axes."""


def read_initial_velocity(
    deck: Deck, sets: Sets, systems: Systems, constraints: Iterable[Constraint]
) -> tuple[tuple[int, int, float], ...]:
    """Node row, dof and velocity; of a node that is there more than once the last one counts, as in LS-DYNA.

    Nodes without a velocity start at rest: it is given to those that constraints tie to moving ones, whose momentum the
    assembly shares, but not where IVATN lets them follow. Not read, and listed: a box, IRIGID, files that
    *INCLUDE_TRANSFORM moves, and both *INITIAL_VELOCITY and _GENERATION in a deck, which LS-DYNA has not either.

    Raises
    ------
    InputError : an unknown node, set, part or coordinate system; a rotation without an axis; lines that are missing.
    """
    given: Velocities = {}
    following = _generated(deck, sets, systems, given)
    if not any(True for _ in deck.named(GENERATED)):
        _of_sets(deck, sets, systems, given)
        _of_nodes(deck, systems, given)
    else:
        for named in deck.named(OF_SETS, OF_NODES):
            _leave(deck, named.block.where, named.block.name, "a deck with *INITIAL_VELOCITY_GENERATION has no other")
    moving = {row for row, six in given.items() if six.any()}
    heavy = {row for group in deck.groups.values() for nodes in group.nodes for row in nodes} if moving else set()
    for c in () if following else constraints:
        rows = set(c.nodes.tolist())
        for row in sorted(rows & heavy) if rows & moving else ():
            given.setdefault(row, np.zeros(6))
    entries = ((row, dof, float(v)) for row, six in given.items() for dof, v in enumerate(six, 1) if v or dof <= 3)
    return tuple(entries) if moving else ()


def _leave(deck: Deck, where: str, keyword: str, why: str) -> None:
    deck.note(where, f"*{keyword}", f"{why}; creak leaves it out", changes=True)


def _stays(deck: Deck, card: Card) -> bool:
    """Whether the card's file is where it was written; else it is listed."""
    if card.shift.transforms:
        _leave(deck, card.where, card.keyword, "creak does not turn velocities with a file (*INCLUDE_TRANSFORM)")
    return not card.shift.transforms


def _axes(card: Card, i: int, systems: Systems) -> FloatArray:
    """(3, 3), columns are the axes of the system in field i."""
    system = card.label(i, "d")
    return referred(systems, system, card, "coordinate system", "*DEFINE_COORDINATE") if system else np.eye(3)


def _three(card: Card, first: int) -> FloatArray:
    return np.array([card.real(first + k) for k in range(3)])


def _six(card: Card, first: int, axes: FloatArray) -> FloatArray:
    return np.concatenate([axes @ _three(card, first), axes @ _three(card, first + 3)])


def _generated(deck: Deck, sets: Sets, systems: Systems, given: Velocities) -> bool:
    """v = V + omega e x (r - c), theta' = omega e. Returns whether constrained nodes follow (IVATN).

    Fields: ID, STYP, OMEGA, VX, VY, VZ, IVATN, ICID; XC, YC, ZC, NX, NY, NZ, PHASE, IRIGID (of *PART_INERTIA).
    """
    following = False
    for named in deck.named(GENERATED):
        expected = "two lines: whose velocity, OMEGA and VX to VZ; the axis XC to NZ"
        for first, second in named.block.records(2, expected):
            card, axis = named.block.card(first), named.block.card(second)
            if not _stays(deck, card):
                continue
            following |= card.integer(6) != 0
            if axis.integer(6):
                why = "PHASE 1 gives the velocity after dynamic relaxation; creak has none, and gives it at the start"
                deck.note(axis.where, f"*{GENERATED}, PHASE", why, changes=False)
            frame, omega = _axes(card, 7, systems), np.zeros(3)
            if card.real(2):
                omega = card.real(2) * _direction(deck, axis, frame)
            for row in _rows(deck, sets, card):
                arm = deck.nodes.array[row] - _three(axis, 0)
                given[row] = np.concatenate([frame @ _three(card, 3) + np.cross(omega, arm), omega])
    return following


def _direction(deck: Deck, card: Card, frame: FloatArray) -> FloatArray:
    if card.real(3) == BY_NODES:
        e = deck.nodes.array[deck.nodes.row(card, 5)] - deck.nodes.array[deck.nodes.row(card, 4)]
    else:
        e = frame @ _three(card, 3)
    if not e.any():
        raise card.error(f"*{GENERATED} has OMEGA and no axis", expected="NX, NY, NZ", fix="Give its direction.")
    return np.asarray(e / np.linalg.norm(e))


def _rows(deck: Deck, sets: Sets, card: Card) -> list[int]:
    """Nodes of a part set (STYP 1), part (2) or node set (3); without an id all."""
    if not card.integer(0):
        return list(deck.nodes.row_of.values())
    style = card.integer(1)
    if style == 3:
        return referred(sets.nodes, card.label(0, "s"), card, "node set", "*SET_NODE")
    if style not in (1, 2):
        raise card.wrong(1, "STYP 1 (part set), 2 (part) or 3 (node set)")
    of_set = style == 1
    parts = referred(sets.parts, card.label(0, "s"), card, "part set", "*SET_PART") if of_set else [card.label(0, "p")]
    groups = [group for (_, pid, *_), group in deck.groups.items() if pid in parts]
    if not groups:
        raise card.error(
            f"*{GENERATED} names {'part set' if of_set else 'part'} {card.text(0)}, which has no elements",
            expected="parts of the deck",
            fix="Correct the id.",
        )
    return list(dict.fromkeys(row for group in groups for nodes in group.nodes for row in nodes))


def _of_sets(deck: Deck, sets: Sets, systems: Systems, given: Velocities) -> None:
    """NSID (0: all), NSIDEX, BOXID, IRIGID, ICID; six velocities; with NSIDEX those of the nodes of that set."""
    for named in deck.named(OF_SETS):
        cards = [named.block.card(line) for line in named.block.filled]
        i = 0
        while i < len(named.block.lines):
            head, size = cards[i], 3 if cards[i].integer(1) else 2
            record, i = cards[i : i + size], i + size
            if len(record) < size:
                raise named.block.cut_off("a line of sets, then VX to VZR, and with NSIDEX those of its nodes")
            if head.integer(2) or head.integer(3):
                _leave(deck, head.where, head.keyword, "creak reads it without BOXID and IRIGID")
            elif _stays(deck, head):
                _give(deck, sets, _axes(head, 4, systems), record, given)


def _give(deck: Deck, sets: Sets, axes: FloatArray, record: list[Card], given: Velocities) -> None:
    head = record[0]
    chosen, exempt = (
        referred(sets.nodes, head.label(k, "s"), head, "node set", "*SET_NODE") if head.integer(k) else None
        for k in (0, 1)
    )
    rows = list(deck.nodes.row_of.values()) if chosen is None else chosen
    given |= dict.fromkeys(rows, _six(record[1], 0, axes))
    if exempt is not None:
        given |= dict.fromkeys(exempt, _six(record[2], 0, axes))


def _of_nodes(deck: Deck, systems: Systems, given: Velocities) -> None:
    """NID, VX to VZR, ICID; as *INITIAL_VELOCITY, of which the same node may have no other one."""
    before = dict(given)
    for named in deck.named(OF_NODES):
        for card in named.cards():
            if not _stays(deck, card):
                continue
            row = deck.nodes.row(card, 0)
            given[row] = _six(card, 1, _axes(card, 7, systems))
            if row in before and not np.array_equal(before[row], given[row]):
                why = f"node {card.text(0)} has another one by *{OF_SETS}: which is the later one is not read"
                _leave(deck, card.where, card.keyword, why)
