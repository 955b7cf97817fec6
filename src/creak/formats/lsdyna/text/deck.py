"""What the readers of keywords share: blocks by name, nodes, elements, and the list of what was not used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.parts import Groups, group_of
from creak.formats.deck.text import Line
from creak.formats.lsdyna.text.cards import TENS, Block, Card
from creak.model.materials import Section
from creak.model.mesh import Unread

T = TypeVar("T")


@dataclass
class NodeTable:
    """The nodes of a deck; rows are those of the model."""

    ids: list[int] = field(default_factory=list)
    coords: list[FloatArray] = field(default_factory=list)
    row_of: dict[int, int] = field(default_factory=dict)
    array: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    """(n_node, 3) the coordinates, once all are read."""

    def row(self, card: Card, i: int) -> int:
        """Row of the node in field i of a card.

        Raises
        ------
        InputError : it is not defined.
        """
        label = card.label(i, "n")
        if label not in self.row_of:
            raise card.error(
                f"*{card.keyword} uses node {label or card.text(i)!r}, which is not defined",
                expected="the id of a node of *NODE",
                fix="Add the node or correct the id.",
            )
        return self.row_of[label]


@dataclass(frozen=True)
class Named:
    """A block as its reader takes it: what it is, and the options in its name."""

    block: Block
    options: frozenset[str]

    @property
    def titled(self) -> bool:
        return "TITLE" in self.options

    @property
    def lines(self) -> tuple[Line, ...]:
        """The data lines after the title."""
        return self.block.lines[1:] if self.titled else self.block.lines

    @property
    def title(self) -> str:
        return self.block.lines[0].text.strip() if self.titled and self.block.lines else ""

    def cards(self, widths: tuple[int, ...] = TENS) -> list[Card]:
        """Every line after the title that is not blank as a card."""
        return [self.block.card(line, widths) for line in self.lines if line.text.strip()]


@dataclass
class Deck:
    """The deck while it is read."""

    by_name: Mapping[str, list[Named]]
    """By the name of the keyword without its options, in the order of the deck."""
    nodes: NodeTable = field(default_factory=NodeTable)
    groups: Groups = field(default_factory=dict)
    element_at: dict[tuple[str, int], str] = field(default_factory=dict)
    """Family (shell, solid, beam, discrete, mass) and element id -> file and line."""
    part_of: dict[tuple[str, int], int] = field(default_factory=dict)
    """The same -> part id, of elements that belong to a part."""
    unread: list[Unread] = field(default_factory=list)
    left_out: dict[str, list[str]] = field(default_factory=dict)
    """Keywords of materials and sections that are not read -> parts whose elements were left out for them."""

    def named(self, *names: str) -> Iterator[Named]:
        for name in names:
            yield from self.by_name.get(name, [])

    def note(self, where: str, what: str, why: str, *, changes: bool, damps: bool = False, used: bool = False) -> None:
        """List something that creak does not use, or what it made of it, once."""
        if not any(u.keyword == what and u.why == why for u in self.unread):
            self.unread.append(Unread(what, where, changes, why, damps, used))

    def take_id(self, family: str, identifier: int, part: int, card: Card) -> None:
        """Note an element of a part (0: of none).

        Raises
        ------
        InputError : another element of its family has this id.
        """
        key = (family, identifier)
        if key in self.element_at:
            raise card.twice(f"{family} element {identifier}", self.element_at[key])
        self.element_at[key] = card.where
        if part:
            self.part_of[key] = part

    def add(
        self,
        family: str,
        part: int,
        kind: str,
        section: Section,
        identifier: int,
        nodes: list[int],
        card: Card,
        **own: FloatArray,
    ) -> None:
        """An element of a part (0: of none).

        Raises
        ------
        InputError : another element of its family has this id, or a node is there twice.
        """
        self.take_id(family, identifier, part, card)
        if len(set(nodes)) < len(nodes):
            raise card.error(f"{family} element {identifier} uses a node twice", expected="distinct nodes")
        group_of(self.groups, (part, section), kind, section, card.where, own).put(identifier, nodes, own)


def once(found: Mapping[int, T], identifier: int, what: str, first: str, card: Card) -> None:
    """Refuse an id that is taken; `first` says where it was defined.

    Raises
    ------
    InputError : it is.
    """
    if identifier in found:
        raise card.twice(f"{what} {identifier}", first)
