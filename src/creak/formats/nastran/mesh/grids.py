"""GRID, GRDSET and SPOINT -> node rows, places and displacement frames."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import CoordinateSystem, axes_at, point_in_basic
from creak.formats.nastran.text.bulk_data import Card, id_list
from creak.model.mesh import Nodes

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
