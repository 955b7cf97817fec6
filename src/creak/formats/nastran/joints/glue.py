"""Glued contact: BGSET of NX, IGLUE of BCTABLE and BCONPRG of MSC -> ties."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.deck.tying import (
    DEFAULT_TOLERANCE,
    NO_SHEET,
    MainSurface,
    Meeting,
    main_surface,
    meet,
    sheet_of,
    skins_of,
    ties_of,
)
from creak.formats.nastran.mesh.optistruct import surface_elements
from creak.formats.nastran.text.bulk_data import Card, id_list
from creak.formats.nastran.text.deck import Deck, referred, unique_cards
from creak.model.constraints import Constraint
from creak.model.face_shapes import FaceShapes, shapes_of
from creak.model.shell_facets import SHELL_FACETS, facets_of_shells
from creak.model.solid_faces import FACES, face_numbers, faces_of, free_faces

CARDS = {
    *("BGSET", "BGADD", "BGPARM", "BCTABLE", "BCTABL1", "BCONECT", "BCONPRG", "BCBODY", "BCBODY1"),
    *("BSURF", "BSURFS", "BCPROP", "BCPROPS"),
}
"""Read where a deck is glued."""
SEARCH = 10.0
"""Default of SDIST."""
BESIDE = 0.05
"""Share of the mean edge length of the main surface by which a node may lie beside it."""
WITH_MOMENTS = {3, 4, -3, -4}
"""IGLUE that carries moments; BGSET does as well."""


@dataclass(frozen=True)
class Glue:
    """Two regions that are joined."""

    card: Card
    first: int
    second: int
    """Regions: the body of MSC, the surface of NX."""
    reach: float | None
    """Largest distance; None: 5 % of the mean edge length."""
    rotations: bool
    follows: bool = False
    """Whether the first region follows the second; else the one with more nodes in reach follows the other."""


@dataclass(frozen=True)
class _Region:
    corners: IntArray
    """(n, 4) node rows of its facets."""
    sheets: FloatArray
    """(n, 2) as of a `MainSurface`."""
    solid: list[bool]
    shapes: FaceShapes

    def main(self, coords: FloatArray) -> MainSurface:
        return main_surface(self.shapes, self.corners, self.sheets, np.array(self.solid), coords)


def read_glue(deck: Deck) -> list[Constraint]:
    """Ties of every glued pair that the case control takes (BGSET, BCONTACT), or the only one of a deck without.

    Of the two sides that with more nodes in reach follows the other. Nodes that both share are joined already.

    Raises
    ------
    InputError : a region that is missing, rigid or of edges; surfaces that do not meet.
    """
    found: list[Constraint] = []
    taken: set[int] = set()
    pairs = list(_pairs(deck))
    coords = np.array(deck.grids.coords)
    regions: dict[tuple[str, int], _Region] = {}
    for pair in pairs:
        sides = []
        for identifier in (pair.first, pair.second):
            key = (pair.card.name, identifier)
            if key not in regions:
                regions[key] = _region(deck, pair, identifier)
            sides.append(regions[key])
        found += _tied(deck, pair, (sides[0], sides[1]), coords, taken)
    return found


def _pairs(deck: Deck) -> Iterator[Glue]:
    yield from _glue_sets(deck)
    yield from _optistruct(deck)
    chosen = _chosen(deck, deck.case.contact, ("BCTABLE", "BCTABL1"))
    for card in deck.cards("BCTABLE"):
        if card.integer(0) == chosen:
            yield from _of_table(deck, card)
    programs = unique_cards(deck.cards("BCONPRG"), "BCONPRG")
    connections = unique_cards(deck.cards("BCONECT"), "BCONECT")
    for card in deck.cards("BCTABL1"):
        for i in id_list(card, 1) if card.integer(0) == chosen else ():
            connection = referred(connections, i, card, "contact pair", "BCONECT")
            program = programs.get(connection.integer(1, 0))
            flag, reach = _parameters(program)
            if flag:
                first = _bodies(connection, 3, ("SECN", "SLAV"))
                second = _bodies(connection, 4, ("PRIM", "MAST"))
                yield from (Glue(connection, a, b, reach, flag in WITH_MOMENTS) for a in first for b in second)


def _chosen(deck: Deck, command: str, names: tuple[str, ...]) -> int:
    """The set that the case control takes; in a deck without case control the only one; -1: none."""
    there = sorted({card.integer(0) for card in deck.cards(*names)})
    if command.isdigit():
        return int(command)
    return there[0] if not deck.case.given and len(there) == 1 else -1


def _optistruct(deck: Deck) -> Iterator[Glue]:
    """TIE, and CONTACT of type FREEZE: the secondary side follows the main one, in translations unless DOF has more."""
    for card in deck.cards("TIE"):
        moments = bool({4, 5, 6} & set(card.components(4, "123")))
        yield Glue(card, card.integer(2), card.integer(3), card.real(5, 0.0) or None, moments, follows=True)
    for card in deck.cards("CONTACT"):
        if card.text(1).upper() == "FREEZE":
            yield Glue(card, card.integer(2), card.integer(3), card.real(5, 0.0) or None, False, follows=True)
        else:
            deck.note(card, "the study file defines contact (SURF are surfaces of the same name)", changes=False)


def _glue_sets(deck: Deck) -> Iterator[Glue]:
    left, done = [_chosen(deck, deck.case.glue, ("BGSET", "BGADD"))], set()
    while left:
        chosen = left.pop()
        if chosen in done:
            continue
        done.add(chosen)
        for card in deck.cards("BGADD"):
            left += list(id_list(card, 1)) if card.integer(0) == chosen else []
        for card in deck.cards("BGSET"):
            for i in range(1, len(card.fields), 8) if card.integer(0) == chosen else ():
                if card.text(i) or card.text(i + 1):
                    yield Glue(card, card.integer(i), card.integer(i + 1), card.real(i + 2, SEARCH), True)


def _of_table(deck: Deck, card: Card) -> Iterator[Glue]:
    """SECNDRY (SLAVE) lines with IGLUE, each with the bodies of its PRIMARY (MASTERS) lines."""
    glued = contact = primary = False
    first, reach, flag = 0, None, 0
    for at in range(8, len(card.fields), 8):
        word = card.text(at).upper()
        if word[:4] in ("SECN", "SLAV"):
            first, flag = card.integer(at + 1), card.integer(at + 6, 0)
            reach = card.real(at + 2, 0.0) or None
            glued, contact = glued or bool(flag), contact or not flag
            primary = False
        elif word[:4] in ("PRIM", "MAST"):
            primary = True
        elif word:
            primary = False
        if first and flag and primary:
            for i in range(at + 1, at + 8):
                if card.text(i):
                    yield Glue(card, first, card.integer(i), reach, flag in WITH_MOMENTS)
    if glued and contact:
        deck.note(card, "pairs without IGLUE are contact, which the study file defines", changes=False)


def _parameters(card: Card | None) -> tuple[int, float | None]:
    """IGLUE and ERROR of a BCONPRG."""
    flag, reach = 0, None
    for i, text in enumerate(card.fields if card else ()):
        assert card is not None
        if text.upper() == "IGLUE":
            flag = card.integer(i + 1, 0)
        elif text.upper() == "ERROR":
            reach = card.real(i + 1, 0.0) or None
    return flag, reach


def _bodies(card: Card, field: int, words: tuple[str, ...]) -> list[int]:
    """IDs of one side of a BCONECT: a field of its own, or a list after a word."""
    if card.text(field):
        return [card.integer(field)]
    found: list[int] = []
    inside = False
    for at in range(8, len(card.fields), 8):
        if card.text(at):
            inside = card.text(at).upper()[:4] in words
        found += [card.integer(i) for i in range(at + 1, at + 8) if inside and card.text(i)]
    return found


def _region(deck: Deck, pair: Glue, identifier: int) -> _Region:
    """Facets of a region: shells, free faces of solids, or the faces that BSURFS names."""
    faces: dict[int, list[int]] = {}
    elements: list[int] = []
    if pair.card.name in ("TIE", "CONTACT"):
        elements, faces = surface_elements(deck, identifier)
    elif pair.card.name != "BGSET":
        identifier = _surface_of_body(deck, pair, identifier)
    for card in deck.cards("BSURF", "BCPROP", "BCPROPS"):
        if card.integer(0) == identifier:
            ids = list(id_list(card, 1))
            own = set(ids)
            elements += ids if card.name == "BSURF" else [e for e, p in deck.property_of.items() if p in own]
    for card in deck.cards("BSURFS"):
        for i in range(4, len(card.fields), 4) if card.integer(0) == identifier else ():
            if card.text(i):
                faces[card.integer(i)] = [deck.grids.row(card.integer(i + k), card) for k in (1, 2, 3)]
    region = _facets(deck, set(elements), faces)
    if not region.corners.size:
        raise InputError(
            f"{pair.card.name} {pair.card.text(0)} glues region {identifier} without shells or solids",
            where=pair.card.where,
            expected="BSURF, BSURFS, BCPROP, BCPROPS or SURF with elements that creak reads",
            fix="Glue of edges is not read: join it with RBE2 or shared grids, or take the pair out.",
        )
    return region


def _surface_of_body(deck: Deck, pair: Glue, identifier: int) -> int:
    bodies = unique_cards(deck.cards("BCBODY", "BCBODY1"), "contact body")
    body = referred(bodies, identifier, pair.card, "contact body", "BCBODY or BCBODY1")
    at = 1 if body.name == "BCBODY" else 2
    if body.text(at + 1).upper()[:5] not in ("", "DEFOR"):
        raise InputError(
            f"{pair.card.name} {pair.card.text(0)} glues body {identifier}, which is {body.text(at + 1)}",
            where=body.where,
            expected="a deformable body",
            fix="Hold the grids with SPC1 instead, or take the pair out.",
        )
    return body.integer(at + 2)


def _facets(deck: Deck, elements: set[int], faces: dict[int, list[int]]) -> _Region:
    corners: list[IntArray] = []
    sheets: list[tuple[float, float]] = []
    solid: list[bool] = []
    wanted: list[IntArray] = []
    groups = [(g, np.array(g.nodes, dtype=np.int64)) for g in deck.groups.values()]
    for group, nodes in groups:
        rows = [k for k, e in enumerate(group.ids) if e in elements]
        if group.kind in SHELL_FACETS and rows:
            corners.append(facets_of_shells(group.kind, nodes[rows]).reshape(-1, 4))
            sheets += [sheet_of(group.section)] * len(corners[-1])
            solid += [False] * len(corners[-1])
        elif group.kind in FACES:
            wanted.append(faces_of(group.kind, nodes[rows]).reshape(-1, 4))
            number = face_numbers(group.kind)
            for k in (k for k, e in enumerate(group.ids) if e in faces):
                facets = faces_of(group.kind, nodes[k : k + 1])[0]
                for face in np.unique(number):
                    mine = facets[number == face]
                    if set(faces[group.ids[k]]) <= set(mine.ravel().tolist()):
                        corners.append(mine)
                        sheets += [NO_SHEET] * len(mine)
                        solid += [True] * len(mine)
    of_solids = np.concatenate(wanted) if wanted else np.zeros((0, 4), dtype=np.int64)
    if of_solids.size:
        every = [faces_of(g.kind, nodes).reshape(-1, 4) for g, nodes in groups if g.kind in FACES]
        free = of_solids[free_faces(of_solids, every)]
        corners.append(free)
        sheets += [NO_SHEET] * len(free)
        solid += [True] * len(free)
    table = np.concatenate(corners) if corners else np.zeros((0, 4), dtype=np.int64)
    shapes = shapes_of(table, [(g.kind, nodes) for g, nodes in groups])
    return _Region(table, np.array(sheets).reshape(-1, 2), solid, shapes)


def _tied(
    deck: Deck, pair: Glue, sides: tuple[_Region, _Region], coords: FloatArray, taken: set[int]
) -> list[Constraint]:
    """The side with more nodes in reach follows the other."""
    met = [_meeting(pair, a, b.main(coords), coords, taken) for a, b in (sides, sides[::-1])]
    best = 0 if pair.follows or met[0].tied.sum() >= met[1].tied.sum() else 1
    found, main = met[best], sides[1 - best].main(coords)
    name = f"{pair.card.name} {pair.card.text(0)}"
    count = int(found.tied.sum())
    shared = np.intersect1d(sides[0].corners, sides[1].corners).size
    if not count and not shared:
        raise InputError(
            f"{name} glues regions {pair.first} and {pair.second}, which do not meet within {found.tolerance:.4g}",
            where=pair.card.where,
            expected="surfaces that lie against each other",
            fix="Raise the search distance (SDIST, ERROR), or take the pair out.",
        )
    taken.update(found.rows[found.tied].tolist())
    far = f", arms up to {np.linalg.norm(found.arm[found.tied], axis=1).max():.3g} long" if count else ""
    why = f"{count} grids are tied, {shared} are shared{far}"
    deck.note(pair.card, why, changes=False, what=f"{name}, regions {pair.first} and {pair.second}", used=True)
    return ties_of(name, pair.card.where, main, found, rotations=pair.rotations)


def _meeting(pair: Glue, side: _Region, main: MainSurface, coords: FloatArray, taken: set[int]) -> Meeting:
    rows = np.setdiff1d(side.corners, np.array(sorted(taken | set(main.nodes_idx.ravel().tolist())), dtype=np.int64))
    tolerance = DEFAULT_TOLERANCE * main.size if pair.reach is None else pair.reach
    skins = skins_of(side.corners, side.sheets, coords).at(rows)
    return meet(coords[rows], rows, skins, main, tolerance, BESIDE * main.size)
