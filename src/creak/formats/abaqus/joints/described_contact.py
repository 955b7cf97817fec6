"""What a deck says of contact in all its steps: contact pairs, and general contact of surfaces that it names."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.contact import clear, some_pairs, surface_name
from creak.formats.abaqus.joints.interactions import read_interactions
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry
from creak.formats.abaqus.text.numbers import to_float
from creak.formats.abaqus.text.outline import Outline
from creak.formats.deck.refusals import noted
from creak.model.steps import DeckContact, Interaction, SurfacePair

GAPS, GAPS_OF = "CONTACT INITIALIZATION DATA", "CONTACT INITIALIZATION ASSIGNMENT"
LAWS_OF, TOGETHER, APART = "CONTACT PROPERTY ASSIGNMENT", "CONTACT INCLUSIONS", "CONTACT EXCLUSIONS"
UNUSED = ("CONTACT INTERFERENCE", "CHANGE FRICTION", "SURFACE PROPERTY ASSIGNMENT")
"""What bears on gaps and friction, of any contact."""
Two = frozenset[str]


def described_contact(deck: Outline, surfaces: Collection[str], nodes: Registry) -> DeckContact | None:
    """Contact pairs, their interactions and those of general contact, for a study of the deck; nothing is listed of it.

    What is wrong with them, or not used, stops nothing, but is told as a flaw.
    """
    deck, known, flaws = replace(deck, unread={}), set(surfaces), list[str]()
    interactions = read_interactions(deck, deck.set_aside, flaws)
    blocks = [*deck.set_aside, *(b for step in deck.steps for b in step.blocks)]
    found, sets = dict[Two, SurfacePair](), dict[str, list[Two]]()
    for block in blocks:
        if block.name == "CONTACT PAIR":
            with noted(flaws):
                for p in some_pairs(deck, block, interactions, known):
                    found[Two((p.secondary, p.main))] = p
                    sets.setdefault(block.get("CPSET").upper(), []).append(Two((p.secondary, p.main)))
    general = _general(deck, blocks, interactions, known, flaws)
    pairs = [*found.values(), *(p for two, p in general.pairs().items() if two not in found)]
    if any(not p.interaction for p in pairs):
        interactions[""] = Interaction("")
    at = {name: [[*found].index(two) for two in of] for name, of in sets.items()}
    for block in deck.set_aside:
        if block.name == "CLEARANCE":
            with noted(flaws):
                clear(deck, block, pairs, at, known, nodes)
    flaws += [f"{u.keyword} ({u.where}): {u.why}" for u in deck.unread if u.changes_answer]
    contact = DeckContact(interactions, tuple(pairs), general.everywhere, tuple(flaws), tuple(general.apart))
    return contact if pairs or flaws or general.everywhere or general.apart else None


@dataclass
class _General:
    """What the keywords of general contact say."""

    everywhere: str = ""
    """Interaction of all that has none of its own."""
    laws: dict[Two, str] = field(default_factory=dict)
    gaps: dict[Two, float] = field(default_factory=dict)
    named: dict[Two, tuple[str, str, str]] = field(default_factory=dict)
    """First, second, place."""
    apart: dict[tuple[str, str], None] = field(default_factory=dict)
    """In order; an empty name stands for all that there is."""

    def pairs(self) -> dict[Two, SurfacePair]:
        """Of two surfaces that are named together and not kept apart."""
        apart, found = [Two(filter(None, two)) for two in self.apart], dict[Two, SurfacePair]()
        for two, (first, second, where) in self.named.items():
            law, gap = self.laws.get(two, self.everywhere), self.gaps.get(two)
            if not any(names <= two for names in apart):
                found[two] = SurfacePair(first, second, law, "surface-to-surface", False, gap, where)
        return found


def _general(
    deck: Outline, blocks: list[Block], interactions: Mapping[str, Interaction], surfaces: set[str], flaws: list[str]
) -> _General:
    found, gaps = _General(), dict[str, float]()
    for block in blocks:
        with noted(flaws):
            if block.name == GAPS and block.has("INITIAL CLEARANCE"):
                gaps[block.need("NAME").upper()] = to_float(block.get("INITIAL CLEARANCE"), block.where, "clearance")
            elif block.name in UNUSED or block.name == GAPS:
                deck.note(block, "creak does not follow it: check gaps and friction in the study", changes=True)
    tables: dict[str, Collection[str]] = {LAWS_OF: interactions, GAPS_OF: gaps, TOGETHER: (), APART: ()}
    for block in blocks:
        for fields, where in block.rows(blanks=True) if block.name in tables else ():
            with noted(flaws):
                first, second = (surface_name(deck, f, surfaces, where) if f else "" for f in [*fields, "", ""][:2])
                name, table = "".join(fields[2:3]).upper(), tables[block.name]
                if block.name in (LAWS_OF, GAPS_OF) and name not in table:
                    raise InputError(f"*{block.name} names {name!r}", where=where, fix=suggest(name, table))
                _take(found, block.name, (first, second), name, where, gaps)
    return found


def _take(
    found: _General, keyword: str, names: tuple[str, str], name: str, where: str, gaps: Mapping[str, float]
) -> None:
    """A line of two surfaces: without the first it is of all that there is, without the second of the first alone."""
    two, pair = Two(names), names[0] != names[1] and all(names)
    if keyword == APART:
        found.apart |= {names: None} if names[1] and names[0] != names[1] else {}
    elif pair:
        found.named.setdefault(two, (*names, where))
        found.laws |= {two: name} if keyword == LAWS_OF else {}
        found.gaps |= {two: gaps[name]} if keyword == GAPS_OF else {}
    elif keyword == LAWS_OF and not any(names):
        found.everywhere = name
    elif keyword != TOGETHER:
        raise InputError(f"*{keyword} of one surface", where=where, expected="two surfaces, or none for all")
