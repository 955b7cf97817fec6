"""*CONTACT_TIED_... and *CONTACT_SPOTWELD -> ties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.deck.parts import Group
from creak.formats.deck.refusals import referred
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
from creak.formats.lsdyna.text.cards import Card
from creak.formats.lsdyna.text.deck import Deck, Named
from creak.model.constraints import Constraint
from creak.model.shell_facets import SHELL_FACETS, facets_of_shells
from creak.model.solid_faces import FACES, faces_of

TRANSLATIONS_ONLY = ("CONTACT_TIED_NODES_TO_SURFACE", "CONTACT_TIED_SURFACE_TO_SURFACE")
WITH_ROTATIONS = ("CONTACT_TIED_SHELL_EDGE_TO_SURFACE", "CONTACT_SPOTWELD")
SIDES = {0: "segment set", 1: "shell set", 2: "part set", 3: "part", 4: "node set"}
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
    (rows, first), (_, second) = (_side(source, cards[0], i, kinds[i]) for i in (0, 1))
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


def _side(source: _Source, card: Card, i: int, kind: int) -> tuple[IntArray, Side]:
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
        raise card.wrong(i + 2, ", ".join(f"{k} ({what})" for k, what in SIDES.items()))
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
