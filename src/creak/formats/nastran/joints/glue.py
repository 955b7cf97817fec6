"""Glued contact: BGSET of NX, IGLUE of BCTABLE and BCONPRG of MSC -> ties."""

from __future__ import annotations

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
from creak.formats.nastran.joints.region_pairs import RegionPair, glued_pairs
from creak.formats.nastran.mesh.optistruct import surface_elements
from creak.formats.nastran.mesh.regions import Faces, region
from creak.formats.nastran.text.deck import Deck
from creak.model.constraints import Constraint
from creak.model.face_shapes import FaceShapes, shapes_of
from creak.model.shell_facets import SHELL_FACETS, facets_of_shells
from creak.model.solid_faces import FACES, face_numbers, faces_of, free_faces

CARDS = {
    *("BGSET", "BGADD", "BGPARM", "BCTABLE", "BCTABL1", "BCONECT", "BCONPRG", "BCBODY", "BCBODY1"),
    *("BSURF", "BSURFS", "BCPROP", "BCPROPS"),
}
"""Read where a deck is glued."""
BESIDE = 0.05
"""Share of the mean edge length of the main surface by which a node may lie beside it."""


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
    pairs = list(glued_pairs(deck))
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


def _region(deck: Deck, pair: RegionPair, identifier: int) -> _Region:
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


def _facets(deck: Deck, elements: set[int], faces: Faces) -> _Region:
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
                    if any(rows <= set(mine.ravel().tolist()) for rows in faces[group.ids[k]]):
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
    deck: Deck, pair: RegionPair, sides: tuple[_Region, _Region], coords: FloatArray, taken: set[int]
) -> list[Constraint]:
    """The side with more nodes in reach follows the other."""
    met = [_meeting(pair, a, b.main(coords), coords, taken) for a, b in (sides, sides[::-1])]
    best = 0 if pair.follows or met[0].tied.sum() >= met[1].tied.sum() else 1
    found, main = met[best], sides[1 - best].main(coords)
    name = pair.name
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


def _meeting(pair: RegionPair, side: _Region, main: MainSurface, coords: FloatArray, taken: set[int]) -> Meeting:
    rows = np.setdiff1d(side.corners, np.array(sorted(taken | set(main.nodes_idx.ravel().tolist())), dtype=np.int64))
    tolerance = DEFAULT_TOLERANCE * main.size if pair.reach is None else pair.reach
    skins = skins_of(side.corners, side.sheets, coords).at(rows)
    return meet(coords[rows], rows, skins, main, tolerance, BESIDE * main.size)
