"""*SET_NODE, *SET_PART, *SET_SHELL, *SET_SOLID, *SET_BEAM, *SET_SEGMENT -> what they hold; faces of elements: those of
segments, of sets and of parts."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.parts import Group
from creak.formats.lsdyna.text.deck import Card, Deck, Named, once
from creak.model.faces import FACES, N_CORNER, SHELL_FACETS, face_numbers, solid_corners
from creak.model.mesh import ElementBlock, Surface

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


Element = tuple[int, int]
"""Row of a group or block, row in it."""


@dataclass(frozen=True)
class Face:
    """One face of an element."""

    element: Element
    facets: tuple[int, ...]
    """Rows of its facets in `SHELL_FACETS` or `FACES`."""
    side: int
    """Of a shell: 1 where the segment looks as its normal does, else -1; 0 of a solid."""


class FaceFinder:
    """Finds the elements that segments lie on; a shell goes before a solid."""

    def __init__(self, elements: Iterable[tuple[str, IntArray]]) -> None:
        """Kind and nodes (n, n_node) of groups or blocks, in their order."""
        self._shells: dict[frozenset[int], tuple[Element, tuple[int, ...], str]] = {}
        self._solids: dict[frozenset[int], Face] = {}
        for b, (kind, nodes) in enumerate(elements):
            if kind in SHELL_FACETS:
                for k, row in enumerate(nodes[:, : N_CORNER[kind]].tolist()):
                    self._shells[frozenset(row)] = (b, k), tuple(row), kind
            elif kind in FACES:
                self._add_solids(b, kind, nodes)

    def _add_solids(self, b: int, kind: str, nodes: IntArray) -> None:
        number = face_numbers(kind)
        faces = [
            (corners, tuple(np.flatnonzero(number == face).tolist()))
            for face, corners in enumerate(solid_corners(kind), 1)
        ]
        for k, row in enumerate(nodes.tolist()):
            for corners, facets in faces:
                self._solids[frozenset(row[c] for c in corners)] = Face((b, k), facets, 0)

    def face(self, segment: Segment) -> Face:
        """The face that a segment is.

        Raises
        ------
        InputError : no shell or solid has it.
        """
        key = frozenset(segment.nodes)
        if key in self._shells:
            element, corners, kind = self._shells[key]
            at = corners.index(segment.nodes[0])
            ahead = corners[(at + 1) % len(corners)] == segment.nodes[1]
            return Face(element, tuple(range(len(SHELL_FACETS[kind]))), 1 if ahead else -1)
        if key in self._solids:
            return self._solids[key]
        raise InputError(
            "a segment of *SET_SEGMENT is no face of a shell or solid",
            where=segment.where,
            expected="the corners of an element that creak reads, in order",
            fix="Correct its nodes, or make the set anew from the mesh.",
        )


def nodes_of(groups: Iterable[Group | ElementBlock]) -> list[tuple[str, IntArray]]:
    """Kind and nodes of groups or blocks."""
    return [(g.kind, g.nodes_idx if isinstance(g, ElementBlock) else np.array(g.nodes, dtype=np.int64)) for g in groups]


def segment_surface(name: str, segments: list[Segment], finder: FaceFinder) -> Surface:
    """The surface of a segment set: shells on the side that their segments look to, faces of solids."""
    facets: list[Element] = []
    sides: list[int] = []
    for segment in segments:
        face = finder.face(segment)
        for facet in (0,) if face.side else face.facets:
            facets.append(face.element)
            sides.append(face.side or facet + 1)
    nodes = np.unique(np.array([row for s in segments for row in s.nodes], dtype=np.int64))
    table = np.array(facets, dtype=np.int64).reshape(-1, 2)
    where = segments[0].where if segments else ""
    return Surface(name, table, np.array(sides, dtype=np.int64), nodes, where)
