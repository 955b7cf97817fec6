"""*DEFINE_COORDINATE_SYSTEM, _NODES, _VECTOR and *DEFINE_SD_ORIENTATION -> axes and directions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.formats.lsdyna.mesh.nodes import Transforms
from creak.formats.lsdyna.text.deck import Card, Deck, Named, once

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
