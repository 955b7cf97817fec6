"""*NODE -> node rows, places, and the dofs that its TC and RC fields hold; *DEFINE_TRANSFORMATION -> where the nodes of
included files lie; *DEFINE_COORDINATE_SYSTEM, _NODES, _VECTOR and *DEFINE_SD_ORIENTATION -> axes and directions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.refusals import referred
from creak.formats.lsdyna.text.deck import Card, Deck, Named, Shift, once


class Transforms:
    """The transformations of a deck, and what they make of the files that ask for them."""

    def __init__(self, deck: Deck) -> None:
        self._of: dict[int, tuple[FloatArray, str]] = {}
        self._shifts: dict[Shift, FloatArray] = {}
        for named in deck.named("DEFINE_TRANSFORMATION"):
            cards = named.cards()
            if not cards:
                raise named.block.cut_off("the id of the transformation, then its options")
            identifier = cards[0].defined(0, "d")
            once(self._of, identifier, "transformation", self._of.get(identifier, (0, ""))[1], cards[0])
            self._of[identifier] = _product(cards[1:]), cards[0].where

    def matrix(self, shift: Shift) -> FloatArray:
        """(3, 4) A and b of x' = A x + b for what stands in a file with this shift.

        Raises
        ------
        InputError : a transformation is not defined.
        """
        if shift not in self._shifts:
            whole = np.eye(4)
            for identifier, where in shift.transforms:
                card = Card("INCLUDE_TRANSFORM", (), where)
                whole = referred(self._of, identifier, card, "transformation", "*DEFINE_TRANSFORMATION")[0] @ whole
            self._shifts[shift] = whole[:3]
        return self._shifts[shift]

    def point(self, x: FloatArray, shift: Shift) -> FloatArray:
        """A place of the file in the model."""
        if not shift.transforms:
            return x
        M = self.matrix(shift)
        return np.asarray(M[:, :3] @ x + M[:, 3])

    def direction(self, v: FloatArray, shift: Shift) -> FloatArray:
        """A vector of the file in the model."""
        return np.asarray(self.matrix(shift)[:, :3] @ v) if shift.transforms else v

    def mirrors(self, shift: Shift) -> bool:
        """Whether the file is reflected, so that solids turn inside out."""
        return bool(shift.transforms) and float(np.linalg.det(self.matrix(shift)[:, :3])) < 0.0


def _product(cards: list[Card]) -> FloatArray:
    """(4, 4) all options of a transformation, the first one first."""
    points: dict[int, FloatArray] = {}
    whole = np.eye(4)
    for card in cards:
        option = card.text(0).upper()
        v = np.array([card.real(i) for i in range(1, 8)])
        if option == "POINT":
            points[card.integer(1)] = v[1:4]
        elif option == "ROTATE" and not v[3:].any():
            a, b = (referred(points, card.integer(i), card, "point", "POINT before it") for i in (1, 2))
            whole = _rotation(card, b - a, a, float(v[2])) @ whole
        elif option in _OPTIONS:
            whole = _OPTIONS[option](card, v) @ whole
        else:
            raise card.wrong(0, "TRANSL, ROTATE, SCALE, MIRROR or POINT", "Write the transformation by these.")
    return whole


def _about(A: FloatArray, centre: FloatArray) -> FloatArray:
    """x' = c + A (x - c)."""
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = A, centre - A @ centre
    return M


def _translation(card: Card, v: FloatArray) -> FloatArray:
    M = np.eye(4)
    M[:3, 3] = v[:3]
    return M


def _scale(card: Card, v: FloatArray) -> FloatArray:
    factors = np.where(v[:3] == 0.0, 1.0, v[:3])
    return np.diag([*factors.tolist(), 1.0])


def _rotation(card: Card, axis: FloatArray, centre: FloatArray, degrees: float) -> FloatArray:
    """A = cos I + sin [e x] + (1 - cos) e e' (Rodrigues)."""
    e = _unit(card, axis)
    angle = math.radians(degrees)
    cross = np.array([[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]])
    A = math.cos(angle) * np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * np.outer(e, e)
    return _about(A, centre)


def _turn(card: Card, v: FloatArray) -> FloatArray:
    """An axis, a point on it, and an angle in degrees."""
    return _rotation(card, v[:3], v[3:6], float(v[6]))


def _mirror(card: Card, v: FloatArray) -> FloatArray:
    """About the plane through the first point, whose normal leads to the second."""
    n = _unit(card, v[3:6] - v[:3])
    return _about(np.eye(3) - 2.0 * np.outer(n, n), v[:3])


def _unit(card: Card, v: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(v))
    if not length > 0.0:
        raise card.error(
            f"{card.text(0).upper()} of *DEFINE_TRANSFORMATION has no direction",
            expected="an axis, or two points that differ",
        )
    return np.asarray(v / length)


_OPTIONS = {
    "TRANSL": _translation,
    "SCALE": _scale,
    "MIRROR": _mirror,
    "ROTATE": _turn,
}


WIDTHS = (8, 16, 16, 16, 8, 8)
LARGEST = 1e100
"""Coordinate whose square is still a number."""
DIRECTIONS: tuple[tuple[int, ...], ...] = ((), (1,), (2,), (3,), (1, 2), (2, 3), (1, 3), (1, 2, 3))
"""Dofs that a constraint code 0 to 7 holds: none, x, y, z, xy, yz, zx, xyz."""


def read_nodes(deck: Deck, transforms: Transforms) -> list[tuple[int, tuple[int, ...], str]]:
    """Fill the deck's nodes; returns node row, dofs that it holds, and where. Of a node that is there twice both cards
    hold.

    Raises
    ------
    InputError : no nodes, a node twice in different places, a number that is none.
    """
    nodes, held = deck.nodes, list[tuple[int, tuple[int, ...], str]]()
    for named in deck.named("NODE"):
        for card in named.cards(WIDTHS):
            label = card.defined(0, "n")
            place = transforms.point(np.array([card.real(i) for i in (1, 2, 3)]), card.shift)
            if not (np.abs(place) < LARGEST).all():
                raise card.error(f"node {label} has coordinates too large to compute with", fix="Correct them.")
            row = nodes.row_of.setdefault(label, len(nodes.ids))
            if row == len(nodes.ids):
                nodes.ids.append(label)
                nodes.coords.append(place)
            elif not np.array_equal(nodes.coords[row], place):
                raise card.error(
                    f"node {label} is defined twice, in different places",
                    fix="Give one of them another id, or the included file an offset (*INCLUDE_TRANSFORM).",
                )
            dofs = (*directions(card, 4), *(3 + d for d in directions(card, 5)))
            if dofs:
                held.append((row, dofs, card.where))
    nodes.array = np.array(nodes.coords, dtype=np.float64).reshape(-1, 3)
    return held


def directions(card: Card, i: int) -> tuple[int, ...]:
    """The constraint code in field i."""
    code = card.integer(i)
    if not 0 <= code < len(DIRECTIONS):
        raise card.wrong(i, "a constraint code from 0 to 7")
    return DIRECTIONS[code]


Systems = dict[int, FloatArray]
"""Id -> (3, 3), columns are the axes."""


def read_systems(deck: Deck, transforms: Transforms) -> Systems:
    """Axes of every coordinate system.

    Raises
    ------
    InputError : an id twice, a node that is missing, points on a line.
    """
    readers: dict[str, Callable[[Deck, Named, Transforms], list[tuple[Card, FloatArray]]]] = {
        "DEFINE_COORDINATE_SYSTEM": _of_points,
        "DEFINE_COORDINATE_NODES": _of_nodes,
        "DEFINE_COORDINATE_VECTOR": _of_vectors,
    }
    found: Systems = {}
    places: dict[int, str] = {}
    for keyword, reader in readers.items():
        for named in deck.named(keyword):
            for card, axes in reader(deck, named, transforms):
                identifier = card.defined(0, "d")
                once(found, identifier, "coordinate system", places.get(identifier, ""), card)
                found[identifier], places[identifier] = axes, card.where
    return found


def read_orientations(deck: Deck, transforms: Transforms) -> dict[int, FloatArray]:
    """Unit vectors (3,) of *DEFINE_SD_ORIENTATION that are fixed in space (IOP 0), by id.

    Raises
    ------
    InputError : an id twice, no direction, or one that moves or lies in a plane.
    """
    found: dict[int, FloatArray] = {}
    places: dict[int, str] = {}
    for named in deck.named("DEFINE_SD_ORIENTATION"):
        for card in named.cards():
            identifier = card.defined(0, "d")
            once(found, identifier, "orientation", places.get(identifier, ""), card)
            places[identifier] = card.where
            if card.integer(1):
                raise card.wrong(1, "IOP 0, a vector that is fixed in space", "Give the direction as a vector.")
            v = transforms.direction(_three(card, 2), card.shift)
            if not np.linalg.norm(v) > 0.0:
                raise card.error(f"orientation {identifier} has no direction", expected="XT, YT, ZT")
            found[identifier] = v / np.linalg.norm(v)
    return found


def _three(card: Card, first: int) -> FloatArray:
    return np.array([card.real(first + i) for i in range(3)])


def _of_points(deck: Deck, named: Named, transforms: Transforms) -> list[tuple[Card, FloatArray]]:
    """Origin, a point on x; in the next line a point in the xy plane."""
    cards = named.cards()
    if len(cards) % 2 or not cards:
        raise named.block.cut_off("two lines for each system: CID, origin and a point on x; a point in the xy plane")
    found = []
    for first, second in zip(cards[::2], cards[1::2], strict=True):
        points = [transforms.point(p, first.shift) for p in (_three(first, 1), _three(first, 4), _three(second, 0))]
        found.append((first, _axes(first, points[1] - points[0], points[2] - points[0])))
    return found


def _of_nodes(deck: Deck, named: Named, transforms: Transforms) -> list[tuple[Card, FloatArray]]:
    """Nodes at the origin, on axis x and in the xy plane, where they lie at first."""
    found = []
    for card in named.cards():
        a, b, c = (deck.nodes.array[deck.nodes.row(card, i)] for i in (1, 2, 3))
        if card.text(5).upper() not in ("", "X", "0"):
            raise card.wrong(5, "DIR blank or X", "Order the nodes so that the second lies on axis x.")
        found.append((card, _axes(card, b - a, c - a)))
    return found


def _of_vectors(deck: Deck, named: Named, transforms: Transforms) -> list[tuple[Card, FloatArray]]:
    """Axis x and a vector in the xy plane."""
    found = []
    for card in named.cards():
        if card.integer(7):
            raise card.wrong(7, "a system that no node turns (NID blank)", "creak's systems are fixed in space.")
        x, xy = (transforms.direction(_three(card, i), card.shift) for i in (1, 4))
        found.append((card, _axes(card, x, xy)))
    return found


def _axes(card: Card, x: FloatArray, xy: FloatArray) -> FloatArray:
    z = np.cross(x, xy)
    if not np.linalg.norm(z) > 1e-9 * np.linalg.norm(x) * np.linalg.norm(xy):
        raise card.error(
            f"coordinate system {card.text(0)} has its points on a line", expected="an axis x and a point beside it"
        )
    e, n = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return np.stack([e, np.cross(n, e), n], axis=1)
