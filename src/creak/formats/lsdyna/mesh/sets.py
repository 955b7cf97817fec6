"""*SET_NODE, *SET_PART, *SET_SHELL, *SET_SOLID, *SET_BEAM, *SET_SEGMENT -> what they hold."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

from creak.errors import InputError
from creak.formats.lsdyna.text.cards import Card
from creak.formats.lsdyna.text.deck import Deck, Named, once

MAX_LIST = 1_000_000
"""Ids of one set."""
ELEMENT_SETS = {"SET_SHELL": "shell", "SET_SOLID": "solid", "SET_BEAM": "beam", "SET_DISCRETE": "discrete"}
"""Sets of elements, and their family."""


@dataclass(frozen=True)
class Segment:
    """A face by its corners."""

    nodes: tuple[int, ...]
    """Rows, three or four."""
    where: str


@dataclass
class Sets:
    """The sets of a deck by their ids; node rows, part ids, element ids, segments."""

    nodes: dict[int, list[int]] = field(default_factory=dict)
    parts: dict[int, list[int]] = field(default_factory=dict)
    elements: dict[tuple[str, int], list[int]] = field(default_factory=dict)
    """By family and id."""
    segments: dict[int, list[Segment]] = field(default_factory=dict)
    titles: dict[tuple[str, int], str] = field(default_factory=dict)
    """Keyword without options, and id -> title."""


def read_sets(deck: Deck) -> Sets:
    """All sets of a deck.

    Raises
    ------
    InputError : an id twice, an unknown node, a list that is too long.
    """
    found = Sets()
    for named in deck.named("SET_NODE"):
        identifier, members = _members(named, "n", deck.nodes.row_of, found.nodes, found)
        adds = "ADD" in named.options
        rows = _united(members, found.nodes) if adds else [deck.nodes.row_of[i] for i in members]
        found.nodes[identifier] = list(dict.fromkeys(rows))
    for named in deck.named("SET_PART"):
        identifier, members = _members(named, "p", None, found.parts, found)
        found.parts[identifier] = _united(members, found.parts) if "ADD" in named.options else members
    for keyword, family in ELEMENT_SETS.items():
        own: dict[int, list[int]] = {}
        known = {i: 0 for of, i in deck.element_at if of == family}
        for named in deck.named(keyword):
            identifier, members = _members(named, "e", known, own, found)
            own[identifier] = members
        found.elements |= {(family, i): ids for i, ids in own.items()}
    for named in deck.named("SET_SEGMENT"):
        _add_segments(deck, named, found)
    return found


def _add_segments(deck: Deck, named: Named, found: Sets) -> None:
    identifier, cards = _head(named, found.segments, found)
    segments = []
    for card in cards:
        n = 3 if card.integer(3) in (0, card.integer(2)) else 4
        segments.append(Segment(tuple(deck.nodes.row(card, i) for i in range(n)), card.where))
    found.segments[identifier] = segments


def _head(named: Named, taken: object, found: Sets) -> tuple[int, list[Card]]:
    """Id of a set, and the cards below."""
    cards = named.cards()
    if not cards:
        raise named.block.cut_off("the id of the set, then what it holds")
    identifier = cards[0].defined(0, "s")
    base = "_".join(named.block.name.split("_")[:2])
    once(taken, identifier, f"*{base}", "another place", cards[0])  # type: ignore[arg-type]
    if named.title:
        found.titles[base, identifier] = named.title
    return identifier, cards[1:]


def _members(
    named: Named, kind: str, known: dict[int, int] | None, taken: object, found: Sets
) -> tuple[int, list[int]]:
    """Id of a set and its members: lists, or with _GENERATE pairs of first and last, of those that there are."""
    identifier, cards = _head(named, taken, found)
    if "ADD" in named.options:
        return identifier, [card.label(i, "s") for card in cards for i in range(8) if card.integer(i)]
    if "GENERATE" not in named.options:
        members = [(card, card.label(i, kind)) for card in cards for i in range(8) if card.integer(i)]
        for card, label in members:
            if known is not None and label not in known:
                raise card.error(
                    f"*{named.block.name} {identifier} holds {label}, which is not defined",
                    expected="ids that the deck has",
                    fix="Correct the id, or use _GENERATE, which passes over ids that are not there.",
                )
        return identifier, list(dict.fromkeys(label for _, label in members))
    ranges = [range(*pair) for card in cards for pair in _pairs(card, kind)]
    if known is not None:
        few = (r if len(r) <= len(known) else sorted(i for i in known if i in r) for r in ranges)
        return identifier, [i for i in dict.fromkeys(itertools.chain.from_iterable(few)) if i in known]
    if sum(map(len, ranges)) > MAX_LIST:
        raise InputError(
            f"*{named.block.name} {identifier} spans too many ids",
            where=named.block.where,
            expected=f"at most {MAX_LIST:,}",
            fix="Give the last id that there is.",
        )
    return identifier, list(dict.fromkeys(itertools.chain.from_iterable(ranges)))


def _pairs(card: Card, kind: str) -> Iterator[tuple[int, int]]:
    for i in range(0, 8, 2):
        if card.integer(i):
            yield card.label(i, kind), card.label(i + 1, kind) + 1


def _united(ids: list[int], sets: dict[int, list[int]]) -> list[int]:
    """The members of sets that stand before this one.

    Raises
    ------
    InputError : there is no such set.
    """
    for i in ids:
        if i not in sets:
            raise InputError(f"set {i} is added to another one, and is not defined before it", fix="Correct its id.")
    return list(dict.fromkeys(member for i in ids for member in sets[i]))
