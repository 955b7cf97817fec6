"""*NODE -> node rows, places, and the dofs that its TC and RC fields hold."""

from __future__ import annotations

import numpy as np

from creak.formats.lsdyna.mesh.transforms import Transforms
from creak.formats.lsdyna.text.cards import Card
from creak.formats.lsdyna.text.deck import Deck

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
