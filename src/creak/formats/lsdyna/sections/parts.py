"""*PART -> which section and material its elements have; *MAT_ELASTIC and the elastic side of other laws ->
materials."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from creak.formats.deck.refusals import referred
from creak.formats.deck.text import Line
from creak.formats.lsdyna.text.deck import Block, Card, Deck, Named, once
from creak.model.materials import Material

ELASTIC = {
    "MAT_ELASTIC": 1,
    "MAT_PLASTIC_KINEMATIC": 2,
    "MAT_RIGID": 3,
    "MAT_PIECEWISE_LINEAR_PLASTICITY": 4,
    "MAT_SPOTWELD": 2,
}
"""Materials that begin with MID, RO, E, PR, and their number of lines."""
SPRINGS = ("MAT_SPRING_ELASTIC", "MAT_DAMPER_VISCOUS")
"""MID and the stiffness, or the damping, of discrete elements."""
BEYOND = {
    "MAT_PLASTIC_KINEMATIC": "plasticity",
    "MAT_PIECEWISE_LINEAR_PLASTICITY": "plasticity",
    "MAT_SPOTWELD": "plasticity and failure",
}
"""What creak leaves out of a law."""


@dataclass(frozen=True)
class Law:
    """One material as the deck has it."""

    keyword: str
    card: Card
    """Its first line."""
    second: Card | None
    title: str

    @property
    def is_rigid(self) -> bool:
        return self.keyword == "MAT_RIGID"


def read_laws(deck: Deck) -> dict[int, Law]:
    """Every material that creak reads, by id.

    Raises
    ------
    InputError : an id twice, or lines that are missing.
    """
    found: dict[int, Law] = {}
    for keyword, n_lines in (*ELASTIC.items(), *((name, 1) for name in SPRINGS)):
        for named in deck.named(keyword):
            for title, lines in records(named.block, n_lines, titled=named.titled):
                cards = [named.block.card(line) for line in lines[:2]]
                identifier = cards[0].defined(0, "m")
                once(
                    found, identifier, "material", found[identifier].card.where if identifier in found else "", cards[0]
                )
                found[identifier] = Law(keyword, cards[0], cards[1] if len(cards) > 1 else None, title)
            if keyword in BEYOND:
                why = f"creak takes its elastic constants, which hold at small strain, and no {BEYOND[keyword]}"
                deck.note(named.block.where, f"*{named.block.name}", why, changes=False)
    return found


def records(block: Block, n_lines: int, *, titled: bool) -> Iterator[tuple[str, tuple[Line, ...]]]:
    """Title and lines of each record of a keyword that may hold several; the last lines of a single one may be missing.

    Raises
    ------
    InputError : no data, or a number of lines that makes no whole records.
    """
    size = n_lines + titled
    lines = f"{size} lines" if size > 1 else "a line"
    expected = f"{lines} for each of them{', the title first' if titled else ''}"
    single = titled < len(block.lines) <= size
    for chunk in [block.filled[:size]] if single else block.records(size, expected):
        yield (chunk[0].text.strip() if titled else ""), chunk[titled:]


def elastic(law: Law, identifier: int) -> Material:
    """RO, E and PR of a material.

    Raises
    ------
    InputError : they are those of no elastic body, or the material is that of springs.
    """
    card = law.card
    if law.keyword in SPRINGS:
        raise card.error(
            f"material {identifier} is a *{law.keyword}",
            expected="a material of solids, shells or beams",
            fix="*ELEMENT_DISCRETE alone takes it.",
        )
    density, youngs, poisson = card.real(1), card.real(2), card.real(3)
    if not youngs > 0.0:
        raise card.wrong(2, "E > 0")
    if not -1.0 < poisson < 0.5:
        raise card.wrong(3, "Poisson's ratio above -1 and below 0.5")
    if density < 0.0:
        raise card.wrong(1, "a density of zero or more")
    return Material(law.title or f"MAT {identifier}", youngs, poisson, density)


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
