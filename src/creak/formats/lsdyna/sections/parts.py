"""*PART -> which section and material its elements have."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from creak.formats.deck.refusals import referred
from creak.formats.lsdyna.sections.materials import Law, elastic
from creak.formats.lsdyna.text.cards import Block, Card
from creak.formats.lsdyna.text.deck import Deck, Named, once
from creak.model.materials import Material

_NO_LAW = re.compile(r"MAT_(ADD|THERMAL)_|MAT_T\d")
"""Failure, damage and the like, with the id of the material they are added to; thermal laws, under a TMID."""
SECTIONS = ("SECTION_SHELL", "SECTION_SOLID", "SECTION_BEAM", "SECTION_DISCRETE")


@dataclass(frozen=True)
class PartCard:
    """One part of the deck."""

    card: Card
    title: str

    @property
    def identifier(self) -> int:
        return self.card.label(0, "p")

    @property
    def name(self) -> str:
        return f"PART_{self.identifier}"


@dataclass(frozen=True)
class SectionCards:
    """One section of the deck, its lines as cards."""

    keyword: str
    cards: tuple[Card, ...]


@dataclass
class Properties:
    """Parts, sections and materials by id, and which keywords of the latter two are not read."""

    deck: Deck
    parts: dict[int, PartCard]
    sections: dict[int, SectionCards]
    laws: dict[int, Law]
    unread: dict[tuple[str, int], str]
    """SECTION or MAT, and id -> keyword that creak does not read."""

    def part(self, card: Card, i: int) -> PartCard:
        """The part in field i of a card.

        Raises
        ------
        InputError : it is not defined.
        """
        return referred(self.parts, card.label(i, "p"), card, "part", "*PART")

    def section(self, part: PartCard, keyword: str) -> SectionCards | None:
        """The section of a part; None where creak reads its keyword, or that of its material, not.

        Raises
        ------
        InputError : it is not defined, or is of another kind of elements.
        """
        identifier = part.card.label(1, "r")
        if self._left_out("SECTION", identifier, part) or self._left_out("MAT", part.card.label(2, "m"), part):
            return None
        found = referred(self.sections, identifier, part.card, "section", f"*{keyword}")
        if found.keyword != keyword:
            raise part.card.wrong(1, f"the id of a *{keyword}, which its elements need")
        return found

    def material(self, part: PartCard) -> Material:
        """The elastic material of a part.

        Raises
        ------
        InputError : it is not defined, or not that of an elastic body.
        """
        return elastic(self.law(part), part.card.label(2, "m"))

    def law(self, part: PartCard) -> Law:
        return referred(self.laws, part.card.label(2, "m"), part.card, "material", "*MAT_ELASTIC")

    def is_rigid(self, part: PartCard) -> bool:
        law = self.laws.get(part.card.label(2, "m"))
        return law is not None and law.is_rigid

    def _left_out(self, what: str, identifier: int, part: PartCard) -> bool:
        keyword = self.unread.get((what, identifier))
        if keyword is None:
            return False
        parts = self.deck.left_out.setdefault(keyword, [])
        parts += [] if part.name in parts else [part.name]
        return True


def read_properties(deck: Deck, laws: dict[int, Law], unread: Iterable[Block]) -> Properties:
    """All parts and sections.

    Parameters
    ----------
    unread : the blocks that no reader takes.

    Raises
    ------
    InputError : an id twice, lines that are missing.
    """
    parts: dict[int, PartCard] = {}
    for named in deck.named("PART"):
        for part in _parts_of(named):
            identifier = part.card.defined(0, "p")
            once(parts, identifier, "part", parts[identifier].card.where if identifier in parts else "", part.card)
            parts[identifier] = part
    sections: dict[int, SectionCards] = {}
    for keyword in SECTIONS:
        for named in deck.named(keyword):
            for found in _sections_of(keyword, named):
                identifier = found.cards[0].defined(0, "r")
                first = sections[identifier].cards[0].where if identifier in sections else ""
                once(sections, identifier, "section", first, found.cards[0])
                sections[identifier] = found
    unknown = {key: keyword for key, keyword in _unread_ids(unread) if key[0] != "MAT" or key[1] not in laws}
    return Properties(deck, parts, sections, laws, unknown)


def _parts_of(named: Named) -> list[PartCard]:
    """A title and a line of ids each; with _CONTACT a further line that is about contact alone."""
    size = 3 if "CONTACT" in named.options else 2
    found = named.block.records(size, f"{size} lines for each part, the title first")
    return [PartCard(named.block.card(lines[1]), lines[0].text.strip()) for lines in found]


def _sections_of(keyword: str, named: Named) -> list[SectionCards]:
    """Records of one line (solids) or two; angles of layers (ICOMP) follow those of shells."""
    size, found = 1 if keyword == "SECTION_SOLID" else 2, []
    lines, i = named.block.filled, 0
    while i < len(named.block.lines):
        i += named.titled
        cards = tuple(named.block.card(line) for line in lines[i : i + size])
        if len(cards) < size:
            raise named.block.cut_off(f"{size} lines for each section")
        i += size
        if keyword == "SECTION_SHELL" and cards[0].integer(6) == 1:
            i += -(-max(cards[0].integer(3), 1) // 8)
        found.append(SectionCards(keyword, cards))
    return found


def _unread_ids(blocks: Iterable[Block]) -> Iterable[tuple[tuple[str, int], str]]:
    """Sections and materials of parts; not what is added to a material, and carries its id, nor what has another id."""
    for block in blocks:
        if _NO_LAW.match(block.name):
            continue
        what = block.name.split("_")[0]
        at = 1 if block.name.endswith("_TITLE") else 0
        if what not in ("SECTION", "MAT") or len(block.lines) <= at:
            continue
        card = block.card(block.lines[at]) if "," not in block.lines[at].text else _first(block, at)
        if card.text(0).isdigit():
            yield (what, card.label(0, "r" if what == "SECTION" else "m")), f"*{block.name}"


def _first(block: Block, at: int) -> Card:
    line = block.lines[at]
    return Card(block.name, (line.text.split(",")[0].strip(),), line.where, block.shift)
