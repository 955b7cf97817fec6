"""*CONTACT_TIED_... and *CONTACT_SPOTWELD -> ties; *CONTACT_AUTOMATIC_... and its kin -> what a deck says of contact,
for a study that is proposed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.deck.parts import Group
from creak.formats.deck.refusals import noted, referred
from creak.formats.deck.tying import (
    DEFAULT_TOLERANCE,
    MainSurface,
    Meeting,
    Piece,
    Side,
    facets_of_elements,
    meet,
    sheet_of,
    skins_of,
    ties_of,
)
from creak.formats.lsdyna.mesh.sets import FaceFinder, Segment, Sets, nodes_of
from creak.formats.lsdyna.sections.parts import Properties
from creak.formats.lsdyna.text.deck import Card, Deck, Named
from creak.formats.lsdyna.text.keywords import CONTACT_PAIRS, GENERAL_CONTACT
from creak.model.constraints import Constraint
from creak.model.faces import FACES, SHELL_FACETS, faces_of, facets_of_shells
from creak.model.mesh import ElementBlock, Surface
from creak.model.steps import DeckContact, Interaction, SurfacePair

SIDES = {0: "SET_SEGMENT", 1: "SET_SHELL", 2: "SET_PART", 3: "PART", 4: "SET_NODE"}
"""What a side is by its type; a name of the model with its id."""
ALL = 5
"""The type of everything that the deck has."""
_OWN = "its stiffness, damping and search are creak's own"


def described_contact(
    deck: Deck, properties: Properties, sets: Sets, blocks: Sequence[ElementBlock], surfaces: Mapping[str, Surface]
) -> tuple[DeckContact | None, dict[str, Surface]]:
    """Pairs of surfaces that touch and contact of all parts, with their friction; and the surfaces that they need: of
    nodes, and (SET_SEGMENT_<id>.BOTH) both sides of segments that are shells, which automatic contact looks at.

    mu(v) = FD + (FS - FD) exp(-DC v). What is wrong with a contact, or not followed, stops nothing, but is told as a
    flaw.

    Parameters
    ----------
    surfaces : the model's.
    """
    pairs, laws = dict[tuple[str, str], SurfacePair](), dict[str, Interaction]()
    flaws, added, everywhere = list[str](), dict[str, Surface](), ""
    for named in deck.named(*CONTACT_PAIRS):
        with noted(flaws):
            cards = _cards(named)
            law = _law(cards, flaws)
            card = cards[0]
            kinds = card.integer(2, 4 if "NODES" in named.block.name else 0), card.integer(3, 0)
            if not cards[0].integer(1) or ALL in kinds:
                everywhere = _all(named, cards[0], law, everywhere, flaws)
            else:
                sides = [_side(named, cards[0], i, kinds[i], surfaces, sets) for i in (0, 1)]
                if kinds[0] == 4:
                    rows = np.array(sets.nodes[cards[0].label(0, "s")], dtype=np.int64)
                    none = np.zeros((0, 2), dtype=np.int64)
                    added[sides[0]] = Surface(sides[0], none, none[:, 0], np.unique(rows), cards[0].where)
                    flaws += _thin(named, cards[0], rows, blocks)
                both = {name: found for name in sides if (found := _both_sides(named, name, blocks, surfaces))}
                added |= {found.name: found for found in both.values()}
                first, second = (both[name].name if name in both else name for name in sides)
                method = "node-to-surface" if "NODES" in named.block.name else "surface-to-surface"
                pairs[first, second] = SurfacePair(first, second, law.name, method, False, where=cards[0].where)
            laws[law.name] = law
            flaws += _unfollowed(named, cards)
            _note(deck, named)
    for named in deck.named(*GENERAL_CONTACT):
        with noted(flaws):
            cards = _cards(named)
            law = _law(cards, flaws)
            everywhere = _all(named, cards[0], law, everywhere, flaws)
            laws[law.name] = law
            flaws += [*_some_parts(named, cards[0], properties, sets), *_unfollowed(named, cards)]
            _note(deck, named)
    if not (pairs or everywhere or flaws):
        return None, {}
    return DeckContact(laws, tuple(pairs.values()), everywhere, tuple(flaws)), added


def _note(deck: Deck, named: Named) -> None:
    why = f"friction and sides are for `creak new`, {_OWN}; a run has the contact of its study"
    deck.note(named.block.where, f"*{named.block.name}", why, changes=False, used=True)


def _cards(named: Named) -> list[Card]:
    """The two sides, then friction, then thicknesses; blank lines are cards of defaults."""
    skip = int(bool(named.options & {"ID", "TITLE"}))
    if "MPP" in named.options:
        skip += 1 + any(line.text.startswith("&") for line in named.block.lines[skip + 1 : skip + 2])
    cards = [named.block.card(line) for line in named.block.filled[skip : skip + 3]]
    if not cards:
        raise named.block.cut_off("the two sides, friction, thicknesses")
    return cards


def _side(named: Named, card: Card, i: int, kind: int, surfaces: Mapping[str, Surface], sets: Sets) -> str:
    if kind not in SIDES:
        raise card.wrong(i + 2, ", ".join(f"{k} (*{what})" for k, what in SIDES.items()))
    name = f"{SIDES[kind]}_{card.label(i, 'p' if kind == 3 else 's')}"
    if kind == 4 and i == 0:
        referred(sets.nodes, card.label(i, "s"), card, "node set", "*SET_NODE")
        return name
    if name not in surfaces:
        raise InputError(
            f"*{named.block.name} uses {name}, which has no shells or solids",
            where=card.where,
            expected="a part or set of elements that creak reads",
            fix="Correct its id, or the type of the side.",
        )
    return name


def _thin(named: Named, card: Card, rows: IntArray, blocks: Sequence[ElementBlock]) -> Iterator[str]:
    """A sentence where nodes of shells are one side of automatic contact, which takes half their thickness off."""
    of_shells = any(np.isin(rows, b.nodes_idx).any() for b in blocks if b.kind in SHELL_FACETS)
    if "AUTOMATIC" in named.block.name and of_shells:
        yield (
            f"*{named.block.name} ({card.where}): nodes of SET_NODE_{card.text(0)} have no thickness in the study, "
            "where LS-DYNA takes half that of their shells off the gap; name their part or segments as secondary, or "
            "give the clearance"
        )


def _both_sides(
    named: Named, name: str, blocks: Sequence[ElementBlock], surfaces: Mapping[str, Surface]
) -> Surface | None:
    """Segments that are shells, seen from both sides; None where nothing changes by that."""
    surface = surfaces.get(name) if name.startswith("SET_SEGMENT_") and "AUTOMATIC" in named.block.name else None
    if surface is None:
        return None
    shells = np.array([blocks[b].kind in SHELL_FACETS for b in surface.facets[:, 0].tolist()], dtype=bool)
    return replace(surface, name=f"{name}.BOTH", side=np.where(shells, 0, surface.side)) if shells.any() else None


def _law(cards: list[Card], flaws: list[str]) -> Interaction:
    static, kinetic, decay = (cards[1].real(i) for i in range(3)) if len(cards) > 1 else (0.0, 0.0, 0.0)
    where = cards[0].where
    if static < 0.0 or kinetic < 0.0:
        flaws.append(f"{where}: FS = {static:g}, friction by part or table; it is 0 in the study")
        static = kinetic = 0.0
    elif kinetic > static and decay:
        flaws.append(
            f"{where}: friction that grows from FS = {static:g} to FD = {kinetic:g} as it slides; creak's falls: it is "
            f"{static:g} at any speed in the study"
        )
        decay = 0.0
    if not decay or kinetic == static:
        kinetic, decay = static, 0.0
    speed = float(f"{1.0 / decay:.6g}") if decay else 0.0
    name = f"friction {static:g} {kinetic:g} {decay:g}"
    return Interaction(name, friction=(static, kinetic, speed), where=where)


def _all(named: Named, card: Card, law: Interaction, before: str, flaws: list[str]) -> str:
    if before and before != law.name:
        flaws.append(f"*{named.block.name} ({card.where}) has other friction than a general contact before it")
        return before
    return law.name


def _some_parts(named: Named, card: Card, properties: Properties, sets: Sets) -> Iterator[str]:
    """A sentence where a general contact is one of some parts."""
    kind, identifier = card.integer(2, 0), card.integer(0)
    mine = set(sets.parts.get(card.label(0, "s"), [])) if kind == 2 else set[int]()
    if identifier and kind != ALL and not mine >= set(properties.parts):
        yield (
            f"*{named.block.name} ({card.where}) is one of some parts; its friction is that of all that is near in the "
            "study"
        )


def _unfollowed(named: Named, cards: list[Card]) -> Iterator[str]:
    """Boxes and other thicknesses than those of the shells, a sentence each."""
    where = f"*{named.block.name} ({cards[0].where})"
    if cards[0].integer(4) or cards[0].integer(5):
        yield f"{where} acts in a box; the study has it wherever the surfaces are near"
    if len(cards) > 2:
        fields = (("SST", 2, 0.0), ("MST", 3, 0.0), ("SFST", 4, 1.0), ("SFMT", 5, 1.0))
        other = [f"{name} = {x:g}" for name, i, usual in fields if (x := cards[2].real(i, usual)) not in (usual, 0.0)]
        if other:
            yield f"{where} has thicknesses of its own, {', '.join(other)}; gaps of the study are those of the shells"


TRANSLATIONS_ONLY = ("CONTACT_TIED_NODES_TO_SURFACE", "CONTACT_TIED_SURFACE_TO_SURFACE")
WITH_ROTATIONS = ("CONTACT_TIED_SHELL_EDGE_TO_SURFACE", "CONTACT_SPOTWELD")
TIED_SIDES = {0: "segment set", 1: "shell set", 2: "part set", 3: "part", 4: "node set"}
"""Kinds of sides, by SSTYP and MSTYP."""


@dataclass(frozen=True)
class _Source:
    deck: Deck
    properties: Properties
    sets: Sets
    groups: list[Group]
    shapes: list[tuple[str, IntArray]]
    """Kind and nodes of each group."""
    finder: FaceFinder


def read_ties(deck: Deck, properties: Properties, sets: Sets, joined: list[Constraint]) -> list[Constraint]:
    """Every tied contact: the nodes of its first side follow the nearest points of the second.

    A node is tied within 5 % of the mean edge of the second side, measured between the faces of shells, or within
    |SST| where that is negative; nodes are not moved, rigid arms bridge what is left.

    Parameters
    ----------
    joined : constraints so far; nodes that follow others in them are not tied as well.

    Raises
    ------
    InputError : an unknown set or part, a second side without faces, no node within reach.
    """
    groups = list(deck.groups.values())
    shapes = nodes_of(groups)
    source = _Source(deck, properties, sets, groups, shapes, FaceFinder(shapes))
    taken = {row for c in joined for row in c.dependents.tolist()}
    found: list[Constraint] = []
    for keyword in (*TRANSLATIONS_ONLY, *WITH_ROTATIONS):
        for named in deck.named(keyword):
            new = _tied(source, named, taken, rotations=keyword in WITH_ROTATIONS)
            taken |= {row for c in new for row in c.dependents.tolist()}
            found += new
    return found


def _tied(source: _Source, named: Named, taken: set[int], *, rotations: bool) -> list[Constraint]:
    skip = int(bool(named.options & {"ID", "TITLE"}))
    cards = [named.block.card(line) for line in named.block.lines[skip:]]
    if not cards:
        raise named.block.cut_off("the two sides, then parameters")
    kinds = [cards[0].integer(i, default) for i, default in ((2, 4 if "NODES" in named.block.name else 0), (3, 0))]
    (rows, first), (_, second) = (_tied_side(source, cards[0], i, kinds[i]) for i in (0, 1))
    name = f"*{named.block.name}, {cards[0].text(0)} to {cards[0].text(1)}"
    if not second.corners.size:
        raise InputError(
            f"the second side of *{named.block.name} has no faces",
            where=cards[0].where,
            expected="a segment set, or shells or solids of a set or part",
            fix="Exchange the sides: nodes stand first.",
        )
    coords = source.deck.nodes.array
    main = second.main(source.shapes, coords)
    found = _meeting(cards, (rows, first), main, coords, taken)
    count, shared = int(found.tied.sum()), int(np.isin(rows, second.corners).sum())
    if not count and not shared:
        raise InputError(
            f"{name} ties no node: {found.rows.size} lie farther than {found.tolerance:.4g} from the second side, or "
            "follow other nodes already",
            where=cards[0].where,
            expected="surfaces that lie against each other",
            fix="Give the distance as a negative SST, or take the contact out.",
        )
    far = float(np.linalg.norm(found.arm[found.tied], axis=1).max()) if count else 0.0
    why = f"{count} of {rows.size} nodes are tied, {shared} are shared, with arms up to {far:.3g} long"
    source.deck.note(cards[0].where, name, why, changes=False, used=True)
    return ties_of(name, cards[0].where, main, found, rotations=rotations)


def _meeting(
    cards: list[Card], side: tuple[IntArray, Side], main: MainSurface, coords: FloatArray, taken: set[int]
) -> Meeting:
    passed = np.array([*taken, *main.nodes_idx.ravel().tolist()], dtype=np.int64)
    rows, first = np.setdiff1d(side[0], passed), side[1]
    given = cards[2].real(2) if len(cards) > 2 else 0.0
    skins = skins_of(first.corners, first.sheets, coords).at(rows)
    return meet(coords[rows], rows, skins, main, -given if given < 0.0 else DEFAULT_TOLERANCE * main.size)


def _tied_side(source: _Source, card: Card, i: int, kind: int) -> tuple[IntArray, Side]:
    """All nodes, and the facets, of the side in field i."""
    sets, groups = source.sets, source.deck.groups
    if kind == 0:
        segments = referred(sets.segments, card.label(i, "s"), card, "segment set", "*SET_SEGMENT")
        return _of_segments(source, segments)
    if kind == 4:
        rows = referred(sets.nodes, card.label(i, "s"), card, "node set", "*SET_NODE")
        return np.unique(np.array(rows, dtype=np.int64)), Side.of([])
    if kind == 1:
        shells = {i: ids for (family, i), ids in sets.elements.items() if family == "shell"}
        wanted = set(referred(shells, card.label(i, "s"), card, "shell set", "*SET_SHELL"))
        chosen = [
            [e in wanted for e in g.ids] if g.kind in SHELL_FACETS else [False] * len(g.ids) for g in source.groups
        ]
        return _of_elements(source, chosen)
    if kind == 2:
        pids = referred(sets.parts, card.label(i, "s"), card, "part set", "*SET_PART")
    elif kind == 3:
        pids = [source.properties.part(card, i).identifier]
    else:
        raise card.wrong(i + 2, ", ".join(f"{k} ({what})" for k, what in TIED_SIDES.items()))
    return _of_elements(source, [[key[1] in pids] * len(g.ids) for key, g in groups.items()])


def _of_segments(source: _Source, segments: list[Segment]) -> tuple[IntArray, Side]:
    facets: list[Piece] = []
    for segment in segments:
        face = source.finder.face(segment)
        group = source.groups[face.element[0]]
        nodes = np.array([group.nodes[face.element[1]]], dtype=np.int64)
        of_solid = group.kind in FACES
        every = faces_of(group.kind, nodes)[0] if of_solid else facets_of_shells(group.kind, nodes)[0]
        facets.append((every[list(face.facets)], sheet_of(group.section), of_solid))
    rows = np.array([row for s in segments for row in s.nodes], dtype=np.int64)
    return np.unique(np.concatenate([rows, *(f.ravel() for f, _, _ in facets)])), Side.of(facets)


def _of_elements(source: _Source, chosen: list[list[bool]]) -> tuple[IntArray, Side]:
    """Shells, and the free faces of solids, of the chosen elements of each group; nodes of beams as well."""
    facets = facets_of_elements(source.groups, chosen)
    both = zip(source.shapes, chosen, strict=True)
    rows = [nodes[np.array(mask, dtype=bool)].ravel() for (kind, nodes), mask in both if kind not in FACES]
    return np.unique(np.concatenate([*rows, facets[-1][0].ravel()])), Side.of(facets)
