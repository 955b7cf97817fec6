"""*CONTACT PAIR and *CLEARANCE, and what a deck says of contact in all its steps."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.interactions import OPTIONS, read_interactions
from creak.formats.abaqus.text.fields import Registry, qualified, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.formats.deck.refusals import noted
from creak.model.steps import DeckContact, Interaction, SurfacePair

KEYWORDS = ("CONTACT PAIR", "SURFACE INTERACTION", "CLEARANCE", *OPTIONS)
EDGES = ("E1", "E2", "E3", "E4")
_METHODS = {"NODE TO SURFACE": "node-to-surface", "SURFACE TO SURFACE": "surface-to-surface"}
_PAIR = (
    "TYPE, INTERACTION, SMALL SLIDING, ADJUST, CPSET, MECHANICAL CONSTRAINT, HCRIT, EXTENSION ZONE, SMOOTH,"
    "SUPPLEMENTARY CONSTRAINTS, TRACKING, WEIGHT"
)
GAPS, GAPS_OF = "CONTACT INITIALIZATION DATA", "CONTACT INITIALIZATION ASSIGNMENT"
LAWS_OF, TOGETHER, APART = "CONTACT PROPERTY ASSIGNMENT", "CONTACT INCLUSIONS", "CONTACT EXCLUSIONS"
UNUSED = ("CONTACT INTERFERENCE", "CHANGE FRICTION", "SURFACE PROPERTY ASSIGNMENT")
"""What bears on gaps and friction, of any contact."""
Two = frozenset[str]


def read_pairs(
    deck: Outline, blocks: Sequence[Block], interactions: Mapping[str, Interaction], surfaces: Iterable[str]
) -> tuple[SurfacePair, ...]:
    """Contact pairs with their clearances.

    Raises
    ------
    InputError : unknown interaction or surface, a pair of one surface, an unknown TYPE, a clearance without pair.
    """
    known = set(surfaces)
    pairs: list[SurfacePair] = []
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name != "CONTACT PAIR":
            continue
        first = len(pairs)
        pairs += some_pairs(deck, block, interactions, known)
        sets.setdefault(block.get("CPSET").upper(), []).extend(range(first, len(pairs)))
    for block in blocks:
        if block.name == "CLEARANCE":
            clear(deck, block, pairs, sets, known)
    return tuple(pairs)


def some_pairs(
    deck: Outline, block: Block, interactions: Mapping[str, Interaction], surfaces: set[str]
) -> list[SurfacePair]:
    name = block.need("INTERACTION").upper()
    if name not in interactions:
        raise block.error(f"unknown surface interaction {name!r}", fix=suggest(name, interactions))
    kind = block.option("TYPE", "NODE TO SURFACE")
    if kind not in _METHODS:
        raise block.error(f"*CONTACT PAIR has TYPE={kind}", expected=" or ".join(_METHODS), fix=suggest(kind, _METHODS))
    list_params(deck, block, _PAIR)
    _check_adjust(deck, block)
    result = []
    for fields, where in block.rows():
        if len(fields) < 2:
            raise InputError(
                "*CONTACT PAIR names one surface",
                expected="secondary surface, main surface",
                where=where,
                fix="Name both; creak has no self-contact.",
            )
        secondary, main = (surface_name(deck, f, surfaces, where) for f in fields[:2])
        if secondary == main:
            raise InputError(
                f"surface {secondary!r} touches itself",
                expected="two surfaces",
                where=where,
                fix="creak has no self-contact.",
            )
        if any(fields[2:]):
            deck.note(block, "creak does not read the orientation of a contact pair", changes=False)
        result.append(SurfacePair(secondary, main, name, _METHODS[kind], block.has("SMALL SLIDING"), where=where))
    return result


def _check_adjust(deck: Outline, block: Block) -> None:
    """ADJUST=0 only removes overclosure, as creak does; a band or a set moves nodes that are apart."""
    given = block.option("ADJUST", "NO")
    if given == "NO":
        return
    try:
        moves = to_float(given, block.where, "ADJUST") != 0.0
    except InputError:
        moves = True
    if moves:
        deck.note(
            block,
            "creak does not move nodes onto the main surface; give the gap as *CLEARANCE",
            changes=True,
            what="*CONTACT PAIR, ADJUST",
        )


def surface_name(deck: Outline, name: str, surfaces: set[str], where: str) -> str:
    """The name of a surface as the model has it.

    Raises
    ------
    InputError : there is none of this name.
    """
    key = name.upper()
    if key not in surfaces and deck.assembly:
        key = key.removeprefix(f"{deck.assembly}.")
    if key not in surfaces:
        raise InputError(f"unknown surface {name!r}", where=where, fix=suggest(name, surfaces))
    return key


def list_node_areas(deck: Outline, pairs: Iterable[SurfacePair], interactions: Mapping[str, Interaction]) -> None:
    """List surfaces of nodes with areas of their own, and of edges, where a law of pressure would need an area."""
    pressed = {p.secondary for p in pairs if interactions[p.interaction].law in ("linear", "tabular")}
    for scope, block in deck.blocks("SURFACE"):
        key = qualified(scope.name, block.get("NAME"))
        if not pressed & {key, block.get("NAME").upper()}:
            continue
        if block.option("TYPE") != "NODE":
            if any(len(fields) > 1 and fields[1].upper() in EDGES for fields, _ in block.rows()):
                deck.note(block, "creak gives an edge no area", changes=True, what="*SURFACE of edges")
        elif any(len(fields) > 1 and to_float(fields[1], where, "area") != 1.0 for fields, where in block.rows()):
            deck.note(
                block,
                "creak gives every node of a node surface the area 1",
                changes=True,
                what="*SURFACE, TYPE=NODE with areas",
            )


def clear(
    deck: Outline,
    block: Block,
    pairs: list[SurfacePair],
    sets: Mapping[str, Sequence[int]],
    surfaces: set[str],
    nodes: Registry | None = None,
) -> None:
    """Give the pairs of a *CLEARANCE its value, or (TABULAR) those of its nodes.

    Parameters
    ----------
    sets : rows of pairs by their CPSET.
    nodes : what nodes are called; None: TABULAR is not used.
    """
    known = "CPSET, VALUE, MASTER, SLAVE, MAIN, SECONDARY"
    list_params(deck, block, f"{known}, TABULAR" if nodes else known)
    if block.has("TABULAR") and not block.has("VALUE"):
        if nodes is None:
            return
        rows = list(block.rows())
        if any(len(fields) > 2 for fields, _ in rows):
            deck.note(block, "creak takes the direction from the surfaces", changes=True, what="*CLEARANCE, normals")
        each = [(nodes.find(f[0], "", where), to_float("".join(f[1:2]), where, "clearance")) for f, where in rows]
        value: float | dict[int, float] = {row: gap for found, gap in each for row in found.tolist()}
        least = min((gap for _, gap in each), default=0.0)
    else:
        value = least = to_float(block.need("VALUE"), block.where, "clearance")
    if block.has("CPSET"):
        chosen = list(sets.get(block.get("CPSET").upper(), []))
    else:
        main = surface_name(deck, block.get("MAIN") or block.need("MASTER"), surfaces, block.where)
        other = surface_name(deck, block.get("SECONDARY") or block.need("SLAVE"), surfaces, block.where)
        chosen = [i for i, p in enumerate(pairs) if (p.secondary, p.main) == (other, main)]
    if not chosen:
        raise block.error(
            "*CLEARANCE for a contact pair that the deck does not have",
            expected="CPSET= or the surfaces of a *CONTACT PAIR",
            fix="Check the names.",
        )
    if least < 0.0:
        raise block.error(f"clearance of {least:g}", expected="zero or more", fix="creak has no press fits.")
    for i in chosen:
        pairs[i] = replace(pairs[i], clearance=value)


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
