"""Nastran coordinate systems CORD2R, CORD2C, CORD2S and the places and frames of grids in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.matrices.bulk_data import Card


@dataclass(frozen=True)
class CoordinateSystem:
    """A rectangular (R), cylindrical (C: r, theta, z) or spherical (S: r, theta, phi; degrees) system."""

    kind: str
    origin: FloatArray
    axes: FloatArray
    """(3, 3), columns are the x, y and z axis in the basic frame."""


BASIC = CoordinateSystem("R", np.zeros(3), np.eye(3))


def point_in_basic(system: CoordinateSystem, coordinates: FloatArray) -> FloatArray:
    """Place (3,) in the basic frame of a point given in a system."""
    a, b, c = coordinates
    if system.kind == "C":
        local = np.array([a * np.cos(np.radians(b)), a * np.sin(np.radians(b)), c])
    elif system.kind == "S":
        theta, phi = np.radians(b), np.radians(c)
        local = a * np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    else:
        local = np.array(coordinates, dtype=float)
    return system.origin + system.axes @ local


def axes_at(system: CoordinateSystem, place: FloatArray) -> FloatArray:
    """(3, 3): columns are the displacement directions of a grid at this place: u_basic = axes u_local.

    On the axis of a cylindrical or spherical system the angles are undefined; theta (and phi) = 0 is taken there.
    """
    if system.kind == "R":
        return system.axes
    x, y, z = system.axes.T @ (place - system.origin)
    phi = np.arctan2(y, x)
    around = np.array([-np.sin(phi), np.cos(phi), 0.0])
    if system.kind == "C":
        local = [np.array([np.cos(phi), np.sin(phi), 0.0]), around, np.array([0.0, 0.0, 1.0])]
    else:
        theta = np.arctan2(np.hypot(x, y), z)
        outward = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        local = [outward, np.cross(around, outward), around]
    return system.axes @ np.stack(local, axis=1)


def read_systems(cards: list[Card]) -> dict[int, CoordinateSystem]:
    """All systems of a deck by id; 0 is the basic system.

    Raises
    ------
    InputError : a system refers to one that is missing or to itself, or its three points lie on a line.
    """
    by_id = {card.integer(0): card for card in cards if card.name in ("CORD2R", "CORD2C", "CORD2S")}
    systems = {0: BASIC}
    for identifier in by_id:
        _resolve(identifier, by_id, systems, ())
    return systems


def _resolve(identifier: int, cards: dict[int, Card], systems: dict[int, CoordinateSystem],
             above: tuple[int, ...]) -> CoordinateSystem:  # fmt: skip
    if identifier in systems:
        return systems[identifier]
    card = cards[identifier]
    reference = card.integer(1, 0)
    if reference in (*above, identifier) or (reference not in systems and reference not in cards):
        raise InputError(f"{card.name} {identifier} refers to system {reference}", where=card.where,
                         expected="a CORD2R, CORD2C or CORD2S card of this file that does not refer back",
                         fix="Add the missing card")  # fmt: skip
    base = _resolve(reference, cards, systems, (*above, identifier))
    points = [point_in_basic(base, np.array([card.real(i, 0.0) for i in range(j, j + 3)])) for j in (2, 5, 8)]
    systems[identifier] = CoordinateSystem(card.name[-1], points[0], _axes(points, card))
    return systems[identifier]


def _axes(points: list[FloatArray], card: Card) -> FloatArray:
    """z from A to B, C in the xz-plane."""
    z, in_plane = points[1] - points[0], points[2] - points[0]
    y = np.cross(z, in_plane)
    if np.linalg.norm(y) <= 1e-10 * np.linalg.norm(z) * np.linalg.norm(in_plane):
        raise InputError(f"the three points of {card.name} {card.integer(0)} lie on a line", where=card.where)
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)
