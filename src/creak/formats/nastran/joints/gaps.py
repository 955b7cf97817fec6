"""CGAP and PGAP -> stops between pairs of grids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.refusals import referred
from creak.formats.deck.stops import Gap, in_a_study, stops_of
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.steps import Stop

SOFT = 1e-6
"""Stiffness of an open gap over that of a closed one below which it is none."""


def read_gaps(deck: Deck) -> tuple[Stop, ...]:
    """Gaps of one property and direction together: (u_B - u_A) along the gap's axis stays above -U0, then KA pushes.

    The axis runs from GA to GB, or is the first of CID. Of PGAP U0, KA, MU1 and MU2 are used.

    Raises
    ------
    InputError : unknown grids or properties, grids that coincide without CID, KA that is not positive; a gap with
        friction that differs across or grows as it slides, a preload, or a stiffness while open.
    """
    found = list(_gaps(deck))
    for _, card, owner in found:
        _check(card, owner)
    return stops_of(gap for gap, _, _ in found)


def list_gaps(deck: Deck) -> tuple[Stop, ...]:
    """The gaps of a study, each group noted with what it must say of it; without those that are no stops."""
    sound, told = list[Gap](), set[str]()
    cards = dict[str, Card]()
    for gap, card, owner in _gaps(deck):
        cards[gap.where] = card
        try:
            _check(card, owner)
        except InputError as error:
            if owner.where not in told:
                deck.note(card, f"{error.what}. {error.fix}", changes=True)
            told.add(owner.where)
            continue
        sound.append(gap)
    stops = stops_of(sound)
    for stop in stops:
        deck.note(cards[stop.where], in_a_study(stop), changes=True)
    return stops


def _gaps(deck: Deck) -> Iterator[tuple[Gap, Card, Card]]:
    """Each gap with its card and that of its property."""
    properties = unique_cards(deck.cards("PGAP"), "property")
    for card in deck.cards("CGAP"):
        pid = card.integer(1, card.integer(0))
        deck.new_element(card, pid)
        owner = referred(properties, pid, card, "property", "PGAP")
        rows = [deck.grids.row(card.integer(i), card) for i in (2, 3)]
        opening, stiffness = owner.real(1, 0.0), owner.real(3, 0.0)
        line, ends, rubs = _line(deck, card, rows), (rows[0], rows[1]), _friction(owner)
        yield Gap(str(pid), ends, line, opening, stiffness, card.where, rubs), card, owner


def _friction(owner: Card) -> tuple[float, float, float]:
    """MU1 while it sticks, MU2 (without it MU1) while it slides; static, kinetic, decay speed."""
    static = owner.real(6, 0.0)
    return static, owner.real(7, static), 0.0


def _line(deck: Deck, card: Card, rows: list[int]) -> FloatArray:
    start, end = (deck.grids.place(row) for row in rows)
    if card.text(7):
        return axes_at(deck.system(card.integer(7), card), start)[:, 0]
    if not np.linalg.norm(end - start) > 0.0:
        raise card.error(
            f"the grids of CGAP {card.text(0)} coincide",
            expected="CID",
            fix="Give the coordinate system whose first axis is the gap's.",
        )
    return end - start


def _check(card: Card, owner: Card) -> None:
    name = f"CGAP {card.text(0)}"
    preload, closed, opened = (owner.real(i, 0.0) for i in (2, 3, 4))
    static, kinetic, _ = _friction(owner)
    if not closed > 0.0:
        raise owner.wrong(3, "the stiffness KA of the closed gap, above 0")
    if not 0.0 <= kinetic <= static:
        raise owner.error(
            f"{name} has friction MU1 = {static:g} and MU2 = {kinetic:g}",
            expected="MU1 (sticking) not below MU2 (sliding), neither below 0",
            fix="Swap them.",
        )
    if owner.real(8, 0.0) < 0.0 and static != kinetic:
        raise owner.error(
            f"{name} rubs with {static:g} one way across and with {kinetic:g} the other (TMAX below 0)",
            expected="MU1 = MU2: creak's friction is the same in both",
            fix="Give the larger one in both fields.",
        )
    if preload:
        raise owner.error(
            f"{name} has a preload, F0 = {preload:g}",
            expected="F0 blank or 0",
            fix="Give it in the study, [[connector]] with preload.",
        )
    if opened > SOFT * closed:
        raise owner.error(
            f"{name} is stiff while open, KB = {opened:g}",
            expected=f"KB below {SOFT:g} KA",
            fix="Give KB as CELAS2 beside it.",
        )
