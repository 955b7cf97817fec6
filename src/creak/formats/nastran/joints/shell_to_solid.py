"""RSSCON: grids of shells clamped to the edges of solids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck
from creak.model.constraints import Constraint, Equation

BESIDE = 0.05
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
    if not (-BESIDE <= share <= 1.0 + BESIDE and beside <= BESIDE * np.sqrt(size)):
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
