"""DAREA, FORCE, MOMENT, LOAD, GRAV, SPCD and pressures of one set -> forces and motions of dofs, gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.refusals import referred
from creak.formats.nastran.loads.pressures import CARDS as PRESSURES
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck

Dof = tuple[int, int]
"""Node row and global dof 1..6."""
_NOT_READ = "FORCE1, FORCE2, MOMENT1, MOMENT2, PLOAD1, PLOADB3, PLOADX1, RFORCE, RFORCE1, SLOAD, ACCEL,ACCEL1, SPCR"
NOT_READ = tuple(name.strip() for name in _NOT_READ.split(","))
"""Loads of a set that creak does not know."""
READ = ("DAREA", "FORCE", "MOMENT", "LOAD", "SPCD", "LSEQ")
_OF_SETS = ("DAREA", "FORCE", "MOMENT", "SPCD", "GRAV", "LOAD", *PRESSURES, *NOT_READ)
DEPTH = 20


@dataclass
class LoadSet:
    """What a set of loads asks for, by global dof."""

    forces: dict[Dof, float] = field(default_factory=dict)
    motion: dict[Dof, float] = field(default_factory=dict)
    gravity: FloatArray = field(default_factory=lambda: np.zeros(3))
    pressures: list[tuple[Card, float]] = field(default_factory=list)
    """Cards of pressure and their factors."""
    where: str = ""
    """Of its first card; empty: the deck has none."""


def load_set(deck: Deck, identifier: int, user: Card) -> LoadSet:
    """The loads that EXCITEID of a TLOAD card names, those that LSEQ gives it included.

    Raises
    ------
    InputError : no card of the set, or one of a kind that creak does not read.
    """
    cards = cards_by_set(deck, *_OF_SETS)
    found = static_set(deck, identifier, cards)
    for card in deck.cards("LSEQ"):
        if deck.case.loadset and card.integer(0) == deck.case.loadset and card.integer(1) == identifier:
            _add(deck, cards, card.integer(2), 1.0, found, 0)
    if not found.where:
        raise user.error(
            f"{user.title} uses load set {identifier}, which is not defined",
            expected="DAREA, FORCE, MOMENT or SPCD cards of this set",
        )
    if found.gravity.any() or found.pressures:
        name = "GRAV" if found.gravity.any() else found.pressures[0][0].name
        raise InputError(
            f"{name} of load set {identifier} is not read by creak in a transient load",
            where=found.where,
            expected="DAREA, FORCE, MOMENT and SPCD",
            fix="Put it into a static subcase before the transient, or write the load as forces on grids.",
        )
    return found


def static_set(deck: Deck, identifier: int, cards: Cards | None = None) -> LoadSet:
    """The loads of a set as LOAD in the case control takes them, with no card where there are none.

    Parameters
    ----------
    cards : those of all sets, `cards_by_set`; None: they are looked up.

    Raises
    ------
    InputError : a load of a kind that creak does not read.
    """
    found = LoadSet()
    _add(deck, cards_by_set(deck, *_OF_SETS) if cards is None else cards, identifier, 1.0, found, 0)
    return found


Cards = Mapping[str, Sequence[Card]]
"""Of each set, by its number as it is written."""


def cards_by_set(deck: Deck, *names: str) -> dict[str, list[Card]]:
    """Cards of these names by the number in their first field."""
    found: dict[str, list[Card]] = {}
    for card in deck.cards(*names):
        found.setdefault(str(card.integer(0)) if card.is_integer(0) else card.text(0), []).append(card)
    return found


def _add(deck: Deck, cards: Cards, identifier: int, factor: float, found: LoadSet, depth: int) -> None:
    for card in cards.get(str(identifier), ()):
        if card.name in NOT_READ:
            raise card.error(
                f"{card.name} of load set {identifier} is not read by creak",
                expected="DAREA, FORCE, MOMENT, GRAV, PLOAD, PLOAD2, PLOAD4 and SPCD",
                fix="Write the load as forces on grids.",
            )
    for card in cards.get(str(identifier), ()):
        found.where = found.where or card.where
        if card.name == "LOAD":
            if depth > DEPTH:
                raise card.error(f"LOAD {identifier} refers to itself", fix="Remove the reference.")
            for i in range(2, len(card.fields), 2):
                if card.text(i + 1):
                    other = referred(cards, str(card.integer(i + 1)), card, "load set", "FORCE, MOMENT, GRAV or SPCD")
                    share = factor * card.real(1, 1.0) * card.real(i)
                    _add(deck, cards, other[0].integer(0), share, found, depth + 1)
        elif card.name in ("FORCE", "MOMENT"):
            _add_vector(deck, card, factor, found)
        elif card.name in PRESSURES:
            found.pressures.append((card, factor))
        elif card.name == "GRAV":
            direction = np.array([card.real(i, 0.0) for i in (3, 4, 5)])
            if not direction.any():
                raise card.error(f"GRAV {identifier} has no direction", expected="N1, N2, N3")
            axes = axes_at(deck.system(card.integer(1, 0), card), np.zeros(3))
            found.gravity = found.gravity + factor * card.real(2) * (axes @ direction)
        else:
            _add_components(deck, card, factor, found)


def _add_vector(deck: Deck, card: Card, factor: float, found: LoadSet) -> None:
    row = deck.grids.row(card.integer(1), card)
    axes = axes_at(deck.system(card.integer(2, 0), card), deck.grids.place(row))
    vector = factor * card.real(3) * axes @ np.array([card.real(i, 0.0) for i in (4, 5, 6)])
    first = 1 if card.name == "FORCE" else 4
    for axis, value in enumerate(vector.tolist()):
        if value:
            found.forces[row, first + axis] = found.forces.get((row, first + axis), 0.0) + value


def _add_components(deck: Deck, card: Card, factor: float, found: LoadSet) -> None:
    """Two of grid, dof and value, in the displacement frame of the grid."""
    for i in (1, 4):
        if not card.text(i):
            continue
        row = deck.grids.row(card.integer(i), card)
        for dof in (1,) if row in deck.grids.scalar else card.components(i + 1):
            value = factor * card.real(i + 2, 0.0)
            if card.name == "DAREA":
                for k, share in enumerate(deck.grids.six(row, dof).tolist(), start=1):
                    if share:
                        found.forces[row, k] = found.forces.get((row, k), 0.0) + share * value
            elif row in deck.grids.axes:
                raise card.error(
                    f"SPCD moves grid {card.text(i)} along turned axes (field CD)", fix="Move it along global axes."
                )
            else:
                found.motion[row, dof] = value
