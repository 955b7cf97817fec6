"""What the readers of single cards share: the cards by name, points, those that elements leave out at the middles of
their sides, parameters, and the list of what was not used."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.coordinate_systems import BASIC, CoordinateSystem
from creak.formats.deck.parts import Group, group_of
from creak.formats.nastran.mesh.grids import Grids
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.case_control import CaseControl
from creak.model.constraints import Equation
from creak.model.materials import Section
from creak.model.mesh import Unread

K = TypeVar("K", int, str)
T = TypeVar("T")


MODAL = {
    *("103", "107", "108", "109", "110", "111", "112", "SEMODES", "SEDCEIG", "SEMCEIG", "SEDFREQ", "SEMFREQ"),
    *("SEDTRAN", "SEMTRAN"),
}
"""Solutions of linear dynamics."""
LINEAR = MODAL | {"", "101", "SESTATIC", "105"}
"""Linear solutions; a deck without SOL is taken for one."""
BY_FREQUENCY = ("108", "111", "SEDFREQ", "SEMFREQ")
"""Frequency responses, in which springs may depend on the frequency."""
WORDS = {"YES": 1.0, "NO": -1.0}
"""Values of parameters that may be words."""
DISCRETE = ("CONM1", "CONM2", "CMASS1", "CMASS2", "CMASS3", "CMASS4", "CVISC")
"""Elements that may share an id with an element of another kind."""


@dataclass(frozen=True)
class Middle:
    """A node at the middle of a side whose grid an element leaves out."""

    row: int
    dofs: tuple[int, ...]
    """Those that are the mean of the ends'."""
    where: str


@dataclass
class Deck:
    """The deck while it is read."""

    by_name: dict[str, list[Card]]
    case: CaseControl
    systems: dict[int, CoordinateSystem]
    grids: Grids
    params: dict[str, Card]
    unread: list[Unread] = field(default_factory=list)
    groups: dict[tuple[object, ...], Group] = field(default_factory=dict)
    """By a key that tells sections apart."""
    element_at: dict[int, str] = field(default_factory=dict)
    """Element id -> file and line."""
    property_of: dict[int, int] = field(default_factory=dict)
    """Element id -> property id, of elements that have one."""
    middles: dict[tuple[int, int], Middle] = field(default_factory=dict)
    """By the rows of the ends of the side, the lower one first."""
    whole: dict[int, int] = field(default_factory=dict)
    """Id of a further element that stands for one of the deck together with it (a piece of a tapered bar) -> the id
    of that one."""
    further: int = 0
    """Largest id given to an element beside those of the deck."""

    def cards(self, *names: str) -> Iterator[Card]:
        for name in names:
            yield from self.by_name.get(name, [])

    noted: set[tuple[str, str, str]] = field(default_factory=set)
    """Names and reasons in `unread`."""
    once: dict[str, Counter[str]] = field(default_factory=dict)
    """How often each id stands on cards of a name."""

    def note(
        self,
        card: Card,
        why: str,
        *,
        changes: bool,
        what: str = "",
        damps: bool = False,
        used: bool = False,
        share: float = 0.0,
        share_of: str = "",
    ) -> None:
        """List something that creak does not use, or what it made of it."""
        entry = Unread(what or card.name, card.where, changes, why, damps, used, share, share_of)
        if (entry.keyword, why, share_of) not in self.noted:
            self.noted.add((entry.keyword, why, share_of))
            self.unread.append(entry)

    def param(self, name: str, default: float) -> float:
        card = self.params.get(name)
        if card is None:
            return default
        word = WORDS.get(card.text(1).upper())
        return card.real(1) if word is None else word

    @property
    def mass_factor(self) -> float:
        """PARAM,WTMASS: weight to mass."""
        return self.param("WTMASS", 1.0)

    def system(self, identifier: int, card: Card) -> CoordinateSystem:
        """A coordinate system that a card uses.

        Raises
        ------
        InputError : it is not defined.
        """
        if identifier == 0:
            return BASIC
        if identifier not in self.systems:
            raise card.error(
                f"{card.title} uses coordinate system {identifier}, which is not defined", fix="Add its CORD card."
            )
        return self.systems[identifier]

    def new_element(self, card: Card, pid: int | None = None) -> int:
        """Id of an element, checked to be new.

        Raises
        ------
        InputError : another element has this id.
        """
        identifier = card.integer(0)
        if identifier in self.element_at and card.name in DISCRETE and self._once(card):
            other = self.free_id()
            why = (
                f"its id is that of another element ({self.element_at[identifier]}) too: it is element {other} in creak"
            )
            self.note(card, why, changes=False, what=f"{card.name} {identifier}")
            identifier = other
        if identifier in self.element_at:
            raise card.twice(f"element {identifier} ({card.name})", self.element_at[identifier])
        self.element_at[identifier] = card.where
        if pid is not None:
            self.property_of[identifier] = pid
        return identifier

    def nodes(self, card: Card, fields: range | tuple[int, ...]) -> list[int]:
        """Rows of the grids in these fields.

        Raises
        ------
        InputError : one is missing, not defined, a scalar point, or there twice.
        """
        rows = [self.grids.row(card.integer(i), card) for i in fields]
        for i, row in zip(fields, rows, strict=True):
            if row in self.grids.scalar:
                raise card.error(f"{card.title} uses scalar point {card.text(i)}", expected="a GRID")
        if len(set(rows)) < len(rows):
            raise card.error(
                f"{card.title} uses a grid twice",
                expected="distinct grids",
                fix="A collapsed CQUAD4 is a CTRIA3, a collapsed CHEXA a CPENTA.",
            )
        return rows

    def _once(self, card: Card) -> bool:
        if card.name not in self.once:
            self.once[card.name] = Counter(c.text(0) for c in self.cards(card.name))
        return self.once[card.name][card.text(0)] == 1

    def property_name(self, group: Group, identifier: int) -> str | None:
        """PID_<id> of an element that has a property."""
        pid = self.property_of.get(identifier)
        return None if pid is None else f"PID_{pid}"

    def further_piece(self, identifier: int) -> int:
        """Id of a further element that stands for an element of the deck together with it, and is in all lists with
        it."""
        piece = self.free_id()
        self.whole[piece] = identifier
        self.element_at[piece] = self.element_at[identifier]
        if identifier in self.property_of:
            self.property_of[piece] = self.property_of[identifier]
        return piece

    def free_id(self) -> int:
        """An id that no element of the deck has."""
        if not self.further:
            cards = (card for name, cards in self.by_name.items() if name.startswith("C") for card in cards)
            self.further = max((int(card.text(0)) for card in cards if card.is_integer(0)), default=0)
        self.further += 1
        return self.further

    def add(
        self,
        key: tuple[object, ...],
        kind: str,
        section: Section,
        identifier: int,
        nodes: list[int],
        card: Card,
        **own: FloatArray,
    ) -> None:
        """Put an element into the group of its kind, section and of what it has of its own."""
        group_of(self.groups, key, kind, section, card.where, own).put(identifier, nodes, own)


def unique_cards(cards: Iterator[Card], what: str) -> dict[int, Card]:
    """Cards by their id; a card that is there twice with the same fields counts once.

    Raises
    ------
    InputError : two different cards have one id.
    """
    found: dict[int, Card] = {}
    for card in cards:
        identifier = card.integer(0)
        first = found.get(identifier)
        if first is not None and (first.name, first.fields) != (card.name, card.fields):
            raise card.twice(f"{what} {identifier}", first.where)
        found[identifier] = card
    return found


FIRST = 2
"""Field of G1."""


def rows_with_middles(
    deck: Deck, card: Card, sides: Sequence[tuple[int, int]], order: Sequence[int], dofs: tuple[int, ...]
) -> list[int]:
    """Rows of corners and middle nodes, in creak's order; of the corners alone where the card has no middle grid.

    A middle grid that is left out becomes a node half-way between the ends of its side, whose motion is the mean of
    theirs. In the sum h_i u_i it gives each end half of its shape function: the element whose side is straight and
    linear (Bathe, Finite Element Procedures (1996), fig. 5.5: elements of a variable number of nodes).

    Parameters
    ----------
    sides : corners (from 0) between which the middle nodes lie, in creak's order.
    order : creak's node k is grid G(order[k] + 1) of the card.
    dofs : those that move: translations of solids, all of shells.

    Raises
    ------
    InputError : a grid is not defined, or there twice; a corner is missing.
    """
    n = len(order) - len(sides)
    given = [k for k in range(len(order)) if k < n or card.text(FIRST + order[k]) not in ("", "0")]
    there = dict(zip(given, deck.nodes(card, tuple(FIRST + order[k] for k in given)), strict=True))
    if len(given) == n:
        return list(there.values())
    if len(given) < len(order):
        why = "sides without a middle grid are straight and linear, as in Nastran"
        deck.note(card, why, changes=False, what=f"{card.name} without some middle grids")
    ends = {n + k: (there[i], there[j]) for k, (i, j) in enumerate(sides)}
    return [there[k] if k in there else _middle(deck, ends[k], dofs, card) for k in range(len(order))]


def _middle(deck: Deck, ends: tuple[int, int], dofs: tuple[int, ...], card: Card) -> int:
    """Row of the node half-way, one for all elements that leave it out."""
    side = (min(ends), max(ends))
    if side not in deck.middles:
        place = 0.5 * (deck.grids.place(ends[0]) + deck.grids.place(ends[1]))
        deck.middles[side] = Middle(deck.grids.add(place), dofs, card.where)
    elif len(dofs) > len(deck.middles[side].dofs):
        deck.middles[side] = Middle(deck.middles[side].row, dofs, card.where)
    return deck.middles[side].row


def middle_equations(deck: Deck) -> Iterator[Equation]:
    """u_middle = (u_a + u_b)/2, dof by dof, of every node that stands for a grid left out."""
    for (a, b), middle in deck.middles.items():
        for dof in middle.dofs:
            nodes = np.array([middle.row, a, b])
            yield Equation(nodes, np.array([dof] * 3), np.array([1.0, -0.5, -0.5]), middle.where)
