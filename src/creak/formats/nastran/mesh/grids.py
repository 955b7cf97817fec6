"""GRID, GRDSET and SPOINT -> node rows, places and displacement frames; CORD1 and CORD2 R, C, S -> coordinate
systems."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import BASIC, CoordinateSystem, axes_at, point_in_basic
from creak.formats.nastran.text.bulk_data import Card, id_list
from creak.model.mesh import Nodes


def read_systems(cards: list[Card]) -> dict[int, CoordinateSystem]:
    """All systems of a deck by id; 0 is the basic system.

    Raises
    ------
    InputError : a system is defined twice, refers to one (or to a grid) that is missing or to itself, or its three
        points lie on a line.
    """
    grids = {card.integer(0): card for card in cards if card.name == "GRID"}
    cp = next((card.integer(1, 0) for card in cards if card.name == "GRDSET"), 0)
    resolver = _Resolver(_definitions(cards), grids, cp, {0: BASIC})
    for identifier, definition in resolver.definitions.items():
        resolver.system(identifier, definition.card, ())
    return resolver.systems


@dataclass(frozen=True)
class _Definition:
    """A CORD2 card, or one of the two systems of a CORD1 card."""

    card: Card
    kind: str
    first: int
    """Field after the id (and the reference system)."""
    by_grids: bool


def _definitions(cards: list[Card]) -> dict[int, _Definition]:
    found: dict[int, _Definition] = {}
    for card in cards:
        if card.name not in ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"):
            continue
        by_grids = card.name[4] == "1"
        starts = [i for i in (0, 4) if card.text(i)] if by_grids else [0]
        for start in starts:
            identifier = card.integer(start)
            if identifier in found and found[identifier].card.fields != card.fields:
                first = found[identifier].card.where
                raise card.twice(f"coordinate system {identifier}", first)
            found[identifier] = _Definition(card, card.name[-1], start + (1 if by_grids else 2), by_grids)
    return found


@dataclass(frozen=True)
class _Resolver:
    """Systems may rest on systems and, through CORD1, on grids, which rest on systems."""

    definitions: dict[int, _Definition]
    grids: dict[int, Card]
    cp: int
    systems: dict[int, CoordinateSystem]

    def system(self, identifier: int, user: Card, above: tuple[int, ...]) -> CoordinateSystem:
        if identifier in self.systems:
            return self.systems[identifier]
        if identifier in above or identifier not in self.definitions:
            raise user.error(
                f"{user.name} {user.integer(0)} refers to system {identifier}",
                expected="a CORD1 or CORD2 card of this deck that does not refer back",
                fix="Add the missing card",
            )
        definition = self.definitions[identifier]
        points = self._points(definition, (*above, identifier))
        self.systems[identifier] = CoordinateSystem(definition.kind, points[0], _axes(points, definition.card))
        return self.systems[identifier]

    def _points(self, definition: _Definition, above: tuple[int, ...]) -> list[FloatArray]:
        card, first = definition.card, definition.first
        if definition.by_grids:
            return [self._grid(card, card.integer(i), above) for i in range(first, first + 3)]
        base = self.system(card.integer(1, 0), card, above)
        return [
            point_in_basic(base, np.array([card.real(i, 0.0) for i in range(j, j + 3)]))
            for j in (first, first + 3, first + 6)
        ]

    def _grid(self, user: Card, identifier: int, above: tuple[int, ...]) -> FloatArray:
        card = self.grids.get(identifier)
        if card is None:
            raise user.error(f"{user.name} uses grid {identifier}, which is not defined", fix="Add its GRID card.")
        base = self.system(card.integer(1, self.cp), card, above)
        return point_in_basic(base, np.array([card.real(i, 0.0) for i in (2, 3, 4)]))


def _axes(points: list[FloatArray], card: Card) -> FloatArray:
    """z from A to B, C in the xz-plane."""
    z, in_plane = points[1] - points[0], points[2] - points[0]
    y = np.cross(z, in_plane)
    if np.linalg.norm(y) <= 1e-10 * np.linalg.norm(z) * np.linalg.norm(in_plane):
        raise card.error(f"the three points of {card.name} {card.integer(0)} lie on a line")
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


LARGEST = 1e100
"""Coordinate whose square is still a number."""


@dataclass
class Grids:
    """The points of a deck; rows are those of the model's nodes."""

    ids: list[int] = field(default_factory=list)
    coords: list[FloatArray] = field(default_factory=list)
    row_of: dict[int, int] = field(default_factory=dict)
    axes: dict[int, FloatArray] = field(default_factory=dict)
    """Row -> (3, 3), columns are the displacement directions, of grids that do not move in the basic frame."""
    scalar: set[int] = field(default_factory=set)
    """Rows of scalar points: nodes of which only dof 1 is used."""
    fluid: dict[int, Card] = field(default_factory=dict)
    """Ids of fluid points (CD = -1), which are no nodes."""
    _largest: int = 0
    """Id, once nodes were added."""

    def row(self, identifier: int, card: Card) -> int:
        """Row of a grid or scalar point that a card uses."""
        if identifier in self.fluid:
            raise card.error(
                f"{card.title} uses grid {identifier}, which is a fluid point (CD = -1)",
                expected="points of the structure",
                fix="creak has no fluid elements.",
            )
        if identifier not in self.row_of:
            raise card.error(
                f"{card.title} uses grid {identifier}, which is not defined", fix="Add its GRID card or correct the id."
            )
        return self.row_of[identifier]

    def place(self, row: int) -> FloatArray:
        return self.coords[row]

    def direction(self, row: int, dof: int) -> FloatArray:
        """(3,) direction of local dof 1..6 of a node in the basic frame."""
        axes = self.axes.get(row)
        unit = np.eye(3)[:, (dof - 1) % 3]
        return unit if axes is None else axes[:, (dof - 1) % 3]

    def six(self, row: int, dof: int) -> FloatArray:
        """(6,) local dof 1..6 of a node in its global (u, theta)."""
        out = np.zeros(6)
        first = 3 if dof > 3 else 0
        out[first : first + 3] = self.direction(row, dof)
        return out

    def add(self, place: FloatArray) -> int:
        """A further node, with an id above all others by which no card finds it."""
        self._largest = (self._largest or max(self.ids, default=0)) + 1
        self.ids.append(self._largest)
        self.coords.append(np.asarray(place, dtype=np.float64))
        return len(self.ids) - 1

    def nodes(self) -> Nodes:
        ids, coords = np.array(self.ids, dtype=np.int64), np.array(self.coords, dtype=np.float64).reshape(-1, 3)
        return Nodes(ids, coords, scalar=np.array(sorted(self.scalar), dtype=np.int64))


@dataclass(frozen=True)
class Permanent:
    """Dofs that a GRID card holds (PS)."""

    row: int
    dofs: tuple[int, ...]
    where: str


def read_grids(by_name: dict[str, list[Card]], systems: dict[int, CoordinateSystem]) -> tuple[Grids, list[Permanent]]:
    """All points in the order of the deck, scalar points last.

    Raises
    ------
    InputError : a grid is defined twice in different places, or in a system that is missing.
    """
    default = next(iter(by_name.get("GRDSET", [])), Card("GRDSET", (), ""))
    grids, held = Grids(), list[Permanent]()
    first: dict[int, Card] = {}
    for card in by_name.get("GRID", []):
        identifier = card.integer(0)
        if identifier in first:
            if first[identifier].fields != card.fields:
                raise card.twice(f"grid {identifier}", first[identifier].where)
            continue
        first[identifier] = card
        if card.integer(5, default.integer(5, 0)) == -1:
            grids.fluid[identifier] = card
            continue
        place, axes = _placed(card, default, systems)
        grids.row_of[identifier] = len(grids.ids)
        if not np.array_equal(axes, np.eye(3)):
            grids.axes[len(grids.ids)] = axes
        if card.text(6) or default.text(6):
            dofs = card.components(6, default.text(6))
            held.append(Permanent(len(grids.ids), dofs, card.where))
        grids.ids.append(identifier)
        grids.coords.append(place)
    _add_scalars(by_name, grids)
    return grids, held


def _placed(card: Card, default: Card, systems: dict[int, CoordinateSystem]) -> tuple[FloatArray, FloatArray]:
    cp, cd = (card.integer(i, default.integer(i, 0)) for i in (1, 5))
    for i, system in ((1, cp), (5, cd)):
        if system not in systems:
            raise InputError(
                f"GRID {card.integer(0)} needs coordinate system {system}, which is not defined",
                where=card.place(i),
                fix="Add its CORD card.",
            )
    place = point_in_basic(systems[cp], np.array([card.real(i, 0.0) for i in (2, 3, 4)]))
    if not (np.abs(place) < LARGEST).all():
        raise card.error(f"GRID {card.integer(0)} has coordinates too large to compute with", fix="Correct them.")
    return place, axes_at(systems[cd], place)


_POINTS_OF = dict.fromkeys(("CELAS3", "CDAMP3", "CMASS3", "CELAS4", "CDAMP4", "CMASS4"), (2, 3))
"""Scalar elements whose points need no SPOINT card, and where they stand."""


def _add_scalars(by_name: dict[str, list[Card]], grids: Grids) -> None:
    middle = np.mean(grids.coords, axis=0) if grids.coords else np.zeros(3)

    def add(identifier: int) -> None:
        grids.row_of[identifier] = len(grids.ids)
        grids.scalar.add(len(grids.ids))
        grids.ids.append(identifier)
        grids.coords.append(middle)

    for card in by_name.get("SPOINT", []):
        for identifier in id_list(card):
            if identifier in grids.row_of and grids.row_of[identifier] not in grids.scalar:
                raise card.error(f"point {identifier} is both a GRID and an SPOINT")
            if identifier not in grids.row_of:
                add(identifier)
    for name, fields in _POINTS_OF.items():
        for card in by_name.get(name, []):
            for i in fields:
                identifier = card.integer(i, 0)
                if identifier and identifier not in grids.row_of and identifier not in grids.fluid:
                    add(identifier)
