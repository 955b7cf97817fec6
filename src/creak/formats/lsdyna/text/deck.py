"""Cards of an LS-DYNA deck, with fields of fixed width or with commas between them, and what the readers of keywords
share: blocks by name, nodes, elements, and the list of what was not used."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.deck.expressions import Value
from creak.formats.deck.parts import Groups, group_of
from creak.formats.deck.refusals import Placed
from creak.formats.deck.text import Line
from creak.formats.matrices.checks import field_value
from creak.model.materials import Section
from creak.model.mesh import Unread

_INTEGER = re.compile(r"([+-]?[0-9]{1,15})(?:\.0*)?")
TENS = (10,) * 8
"""Widths of most cards."""
EIGHTS = (8,) * 10
"""Widths of connectivity."""
LONG = 20
"""Columns of every field in the long format."""
KINDS = "nepmsfdr"
"""Ids that *INCLUDE_TRANSFORM shifts, in the order of its fields: nodes, elements, parts, materials, sets, functions,
what else *DEFINE names, and all other ids (sections)."""


@dataclass(frozen=True)
class Shift:
    """What *INCLUDE_TRANSFORM does to the file in which a card stands."""

    offsets: tuple[int, ...] = (0,) * len(KINDS)
    """Added to ids of each of `KINDS`."""
    transforms: tuple[tuple[int, str], ...] = ()
    """Ids of the *DEFINE_TRANSFORMATIONs, those of the innermost include first, and where they are asked for."""


@dataclass(frozen=True)
class Block(Placed):
    """One keyword with its data lines; comments are left out, blank lines are cards of defaults."""

    name: str
    """In upper case, without its star."""
    where: str
    lines: tuple[Line, ...]
    long: bool = False
    """Whether every field has `LONG` columns."""
    wide: bool = False
    """Whether fields of 8 columns have 10 (I10=Y)."""
    shift: Shift = field(default=Shift(), repr=False)
    blank: tuple[Line, ...] = ()
    """Blank lines at the end: cards of defaults where a record is not whole without them, else nothing."""
    values: Mapping[str, Value] = field(default_factory=dict, repr=False, compare=False)
    """Those that *PARAMETER gives names to, in small letters."""

    @property
    def filled(self) -> tuple[Line, ...]:
        """The data lines and the blank ones at the end, for records that begin in the former."""
        return self.lines + self.blank

    def card(self, line: Line, widths: tuple[int, ...] = TENS) -> Card:
        """A line in its fields, with the values of &name and -&name in their places.

        Raises
        ------
        InputError : more values between commas than the card has fields; a name without a value.
        """
        card = self._split(line, widths)
        if "&" not in line.text:
            return card
        return Card(self.name, tuple(self._filled(text, line.where) for text in card.fields), line.where, self.shift)

    def _filled(self, text: str, where: str) -> str:
        sign, found, name = text.partition("&")
        if not found or sign.strip() not in ("", "-", "+"):
            return text
        value = self.values.get(name.strip().lower())
        if value is None:
            raise InputError(
                f"&{name} has no value",
                where=where,
                expected="a name that *PARAMETER gives a value, above",
                fix=suggest(name.lower(), self.values) if self.values else "Define it, or write the value.",
            )
        return value if isinstance(value, str) else repr(-value if sign.strip() == "-" else value)

    def _split(self, line: Line, widths: tuple[int, ...]) -> Card:
        if "," in line.text:
            items = [text.strip() for text in line.text.split(",")]
            if any(items[len(widths) :]):
                raise InputError(
                    f"a line of *{self.name} has {len(items)} values",
                    where=line.where,
                    expected=f"at most {len(widths)}",
                    fix="Go on in the next line, or correct the commas.",
                )
            return Card(self.name, tuple(items[: len(widths)]), line.where, self.shift)
        text, fields, at = line.text.expandtabs(8), [], 0
        for width in widths:
            columns = LONG if self.long else 10 if self.wide and width == 8 else width
            fields.append(text[at : at + columns].strip())
            at += columns
        return Card(self.name, tuple(fields), line.where, self.shift)

    def records(self, size: int, expected: str, skip: int = 0) -> list[tuple[Line, ...]]:
        """The lines after the first `skip` in records of `size`.

        Raises
        ------
        InputError : there is none, or the last one is not whole.
        """
        found = [self.filled[i : i + size] for i in range(skip, len(self.lines), size)]
        if not found or len(found[-1]) < size:
            raise self.cut_off(expected)
        return found

    def cut_off(self, expected: str) -> InputError:
        """The error for a keyword with too few lines."""
        return InputError(
            f"*{self.name} has {len(self.filled)} data lines",
            where=self.where,
            expected=expected,
            fix="Is the deck cut off? Blank lines count as cards, comments ($) do not.",
        )


@dataclass(frozen=True)
class Card(Placed):
    """One data line in its fields."""

    keyword: str
    fields: tuple[str, ...]
    where: str
    shift: Shift = Shift()

    @property
    def title(self) -> str:
        """For messages."""
        return f"*{self.keyword}"

    def text(self, i: int) -> str:
        return self.fields[i] if i < len(self.fields) else ""

    def wrong(self, i: int, expected: str, fix: str = "") -> InputError:
        """The error for field i, counted from 0; messages count from 1."""
        return InputError(
            f"field {i + 1} of *{self.keyword} is {self.text(i)!r}", where=self.where, expected=expected, fix=fix
        )

    def integer(self, i: int, default: int | None = 0) -> int:
        """Field i as an integer, also as 2.0; the default where it is blank."""
        text = self.text(i)
        if not text and default is not None:
            return default
        found = _INTEGER.fullmatch(text)
        if found is None:
            raise self.wrong(i, "an integer of at most 15 digits")
        return int(found.group(1))

    def real(self, i: int, default: float = 0.0) -> float:
        """Field i as a real number, also in the short form 1.-3; the default where it is blank."""
        text = self.text(i)
        if not text:
            return default
        value = field_value(text)
        if value is None:
            raise self.wrong(i, "a real number")
        return value

    def label(self, i: int, kind: str) -> int:
        """Field i as an id of one of `KINDS`, shifted as its file is; 0 where there is none."""
        value = self.integer(i)
        return value + self.shift.offsets[KINDS.index(kind)] if value else 0

    def defined(self, i: int, kind: str) -> int:
        """The same, of what the card defines: there has to be one.

        Raises
        ------
        InputError : it is blank, zero or negative.
        """
        if self.integer(i) <= 0:
            raise self.wrong(i, "an id above 0")
        return self.label(i, kind)


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
