"""Nastran coordinate systems CORD1 and CORD2 R, C, S."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.coordinate_systems import BASIC, CoordinateSystem, point_in_basic
from creak.formats.nastran.text.bulk_data import Card


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
