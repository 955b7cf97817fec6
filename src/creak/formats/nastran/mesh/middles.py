"""Grids that an element leaves out at the middles of its sides."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, Middle
from creak.model.constraints import Equation

FIRST = 2
"""Field of G1."""


def rows_with_middles(
    deck: Deck, card: Card, sides: Sequence[tuple[int, int]], order: Sequence[int], dofs: tuple[int, ...]
) -> list[int]:
    """Rows of corners and middle nodes, in creak's order; of the corners alone where the card has no middle grid.

    A middle grid that is left out becomes a node half-way between the ends of its side, whose motion is the mean of
    theirs. In the sum h_i u_i it gives each end half of its shape function: the element whose side is straight and
    linear (Bathe, Finite Element Procedures (1996), fig. 5.5: elements of a variable number of nodes).

    Parameters
    ----------
    sides : corners (from 0) between which the middle nodes lie, in creak's order.
    order : creak's node k is grid G(order[k] + 1) of the card.
    dofs : those that move: translations of solids, all of shells.

    Raises
    ------
    InputError : a grid is not defined, or there twice; a corner is missing.
    """
    n = len(order) - len(sides)
    given = [k for k in range(len(order)) if k < n or card.text(FIRST + order[k]) not in ("", "0")]
    there = dict(zip(given, deck.nodes(card, tuple(FIRST + order[k] for k in given)), strict=True))
    if len(given) == n:
        return list(there.values())
    if len(given) < len(order):
        why = "sides without a middle grid are straight and linear, as in Nastran"
        deck.note(card, why, changes=False, what=f"{card.name} without some middle grids")
    ends = {n + k: (there[i], there[j]) for k, (i, j) in enumerate(sides)}
    return [there[k] if k in there else _middle(deck, ends[k], dofs, card) for k in range(len(order))]


def _middle(deck: Deck, ends: tuple[int, int], dofs: tuple[int, ...], card: Card) -> int:
    """Row of the node half-way, one for all elements that leave it out."""
    side = (min(ends), max(ends))
    if side not in deck.middles:
        place = 0.5 * (deck.grids.place(ends[0]) + deck.grids.place(ends[1]))
        deck.middles[side] = Middle(deck.grids.add(place), dofs, card.where)
    elif len(dofs) > len(deck.middles[side].dofs):
        deck.middles[side] = Middle(deck.middles[side].row, dofs, card.where)
    return deck.middles[side].row


def middle_equations(deck: Deck) -> Iterator[Equation]:
    """u_middle = (u_a + u_b)/2, dof by dof, of every node that stands for a grid left out."""
    for (a, b), middle in deck.middles.items():
        for dof in middle.dofs:
            nodes = np.array([middle.row, a, b])
            yield Equation(nodes, np.array([dof] * 3), np.array([1.0, -0.5, -0.5]), middle.where)
