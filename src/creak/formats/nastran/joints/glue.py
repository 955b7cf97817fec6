"""Glued contact, BGSET of NX, IGLUE of BCTABLE and BCONPRG of MSC -> ties; RSSCON: grids of shells clamped to the edges
of solids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.tying import (
    DEFAULT_TOLERANCE,
    NO_SHEET,
    MainSurface,
    Meeting,
    Piece,
    Side,
    facets_of_elements,
    meet,
    skins_of,
    ties_of,
)
from creak.formats.nastran.joints.region_pairs import RegionPair, glued_pairs
from creak.formats.nastran.mesh.sets import Faces, region, surface_elements
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck
from creak.model.constraints import Constraint, Equation
from creak.model.faces import FACES, face_numbers, faces_of

CARDS = {
    *("BGSET", "BGADD", "BGPARM", "BCTABLE", "BCTABL1", "BCONECT", "BCONPRG", "BCBODY", "BCBODY1"),
    *("BSURF", "BSURFS", "BCPROP", "BCPROPS"),
}
"""Read where a deck is glued."""
BESIDE = 0.05
"""Share of the mean edge length of the main surface by which a node may lie beside it."""


def read_glue(deck: Deck) -> list[Constraint]:
    """Ties of every glued pair that the case control takes (BGSET, BCONTACT), or the only one of a deck without.

    Of the two sides that with more nodes in reach follows the other. Nodes that both share are joined already.

    Raises
    ------
    InputError : a region that is missing, rigid or of edges; surfaces that do not meet.
    """
    found: list[Constraint] = []
    taken: set[int] = set()
    pairs = list(glued_pairs(deck))
    coords = np.array(deck.grids.coords)
    groups = [*deck.groups.values()]
    elements = [(g.kind, np.array(g.nodes, dtype=np.int64)) for g in groups]
    regions: dict[tuple[str, int], tuple[Side, MainSurface]] = {}
    for pair in pairs:
        sides = []
        for identifier in (pair.first, pair.second):
            key = (pair.card.name, identifier)
            if key not in regions:
                side = _region(deck, pair, identifier)
                regions[key] = side, side.main(elements, coords)
            sides.append(regions[key])
        found += _tied(deck, pair, (sides[0], sides[1]), coords, taken)
    return found


def _region(deck: Deck, pair: RegionPair, identifier: int) -> Side:
    """Facets of a region: shells, free faces of solids, or the faces that its cards name."""
    number = pair.surface(deck, identifier)
    elements, faces = surface_elements(deck, number) if pair.follows else region(deck, number)
    found = _facets(deck, set(elements), faces)
    if not found.corners.size:
        raise InputError(
            f"{pair.name} glues region {number} without shells or solids",
            where=pair.card.where,
            expected="BSURF, BSURFS, BCPROP, BCPROPS or SURF with elements that creak reads",
            fix="Glue of edges is not read: join it with RBE2 or shared grids, or take the pair out.",
        )
    return found


def _facets(deck: Deck, elements: set[int], faces: Faces) -> Side:
    groups = [*deck.groups.values()]
    named: list[Piece] = []
    for group in groups:
        if group.kind not in FACES:
            continue
        number = face_numbers(group.kind)
        for k in (k for k, e in enumerate(group.ids) if e in faces):
            facets = faces_of(group.kind, np.array(group.nodes[k : k + 1], dtype=np.int64))[0]
            for mine in (facets[number == face] for face in np.unique(number)):
                if any(rows <= set(mine.ravel().tolist()) for rows in faces[group.ids[k]]):
                    named.append((mine, NO_SHEET, True))
    *shells, free = facets_of_elements(groups, [[e in elements for e in g.ids] for g in groups])
    return Side.of([*shells, *named, free])


def _tied(
    deck: Deck,
    pair: RegionPair,
    sides: tuple[tuple[Side, MainSurface], tuple[Side, MainSurface]],
    coords: FloatArray,
    taken: set[int],
) -> list[Constraint]:
    """The side with more nodes in reach follows the other."""
    met = [_meeting(pair, a, main, coords, taken) for (a, _), (_, main) in (sides, sides[::-1])]
    best = 0 if pair.follows or met[0].tied.sum() >= met[1].tied.sum() else 1
    found, main = met[best], sides[1 - best][1]
    name = pair.name
    count = int(found.tied.sum())
    shared = np.intersect1d(sides[0][0].corners, sides[1][0].corners).size
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


def _meeting(pair: RegionPair, side: Side, main: MainSurface, coords: FloatArray, taken: set[int]) -> Meeting:
    rows = np.setdiff1d(side.corners, np.array(sorted(taken | set(main.nodes_idx.ravel().tolist())), dtype=np.int64))
    tolerance = DEFAULT_TOLERANCE * main.size if pair.reach is None else pair.reach
    skins = skins_of(side.corners, side.sheets, coords).at(rows)
    return meet(coords[rows], rows, skins, main, tolerance, BESIDE * main.size)


BESIDE_LINE = 0.05
"""Share of the distance of its two grids of the solid by which a grid of the shell may lie beside their line."""
NEGLIGIBLE = 1e-14
"""Coefficients below this are left out."""


def read_shell_to_solid(deck: Deck) -> list[Constraint]:
    """Every RSSCON of TYPE GRID; those of elements are listed as changing the answer.

    Raises
    ------
    InputError : an unknown grid, a grid of the shell that does not lie between those of the solid.
    """
    found: list[Constraint] = []
    for card in deck.cards("RSSCON"):
        if card.text(1).upper() != "GRID":
            why = "creak reads RSSCON by grids: TYPE = GRID, the grid of the shell and two of the solid"
            deck.note(card, why, changes=True, what=f"RSSCON, TYPE = {card.text(1).upper() or 'ELEM'}")
            continue
        for at in (2, 5):
            if card.text(at):
                found += _clamped(deck, card, *deck.nodes(card, (at, at + 1, at + 2)))
    return found


def _clamped(deck: Deck, card: Card, shell: int, first: int, second: int) -> Iterator[Equation]:
    """u = (1 - a) u_A + a u_B, and of the rotations those across d = x_B - x_A: theta x d = u_B - u_A."""
    start = deck.grids.place(first)
    d, at = deck.grids.place(second) - start, deck.grids.place(shell) - start
    size = float(d @ d)
    share = float(at @ d) / size if size else np.nan
    beside = float(np.linalg.norm(at - share * d))
    if not (-BESIDE_LINE <= share <= 1.0 + BESIDE_LINE and beside <= BESIDE_LINE * np.sqrt(size)):
        raise card.error(
            f"grid {deck.grids.ids[shell]} of RSSCON {card.text(0)} does not lie between grids "
            f"{deck.grids.ids[first]} and {deck.grids.ids[second]}",
            expected="a grid of the shell on the line between two grids of the solid",
            fix="Correct the grids, or project the shell's edge on the solid's.",
        )
    for axis in range(3):
        yield _equation(card, [(shell, axis + 1, 1.0), (first, axis + 1, share - 1.0), (second, axis + 1, -share)])
    along = int(np.argmax(np.abs(d)))
    eliminated = [k for k in range(3) if k != along]
    across: FloatArray = np.linalg.svd(d[None])[2][1:]
    rows = np.linalg.solve(across[:, eliminated], across)
    for k, row in zip(eliminated, rows, strict=True):
        turned = np.cross(row, d) / size
        terms = [(shell, k + 4, 1.0), (shell, along + 4, float(row[along]))]
        terms += [(first, j + 1, float(turned[j])) for j in range(3)]
        yield _equation(card, terms + [(second, j + 1, float(-turned[j])) for j in range(3)])


def _equation(card: Card, terms: list[tuple[int, int, float]]) -> Equation:
    kept = [t for t in terms if abs(t[2]) > NEGLIGIBLE]
    nodes, dofs, factors = zip(*kept, strict=True)
    return Equation(np.array(nodes, dtype=np.int64), np.array(dofs, dtype=np.int64), np.array(factors), card.where)
