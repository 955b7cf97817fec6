"""*BOUNDARY_SPC_NODE, *BOUNDARY_SPC_SET and the TC and RC fields of *NODE -> supports."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.deck.equations import global_equations
from creak.formats.deck.refusals import referred
from creak.formats.lsdyna.mesh.nodes import Systems
from creak.formats.lsdyna.mesh.sets import Sets
from creak.formats.lsdyna.text.deck import Card, Deck, Named
from creak.model.constraints import Constraint, Fixed

Held = tuple[int, tuple[int, ...], str]
"""Node row, dofs held, and where it says so."""


def read_supports(
    deck: Deck, of_nodes: list[Held], sets: Sets, systems: Systems
) -> tuple[tuple[Fixed, ...], list[Constraint]]:
    """Held dofs: as they are in global axes; in a system of their own as equations on the node alone.

    Raises
    ------
    InputError : an unknown node, set or coordinate system.
    """
    held: dict[int, tuple[set[int], str]] = {}
    for row, dofs, where in of_nodes:
        held.setdefault(row, (set(), where))[0].update(dofs)
    skew: list[tuple[int, tuple[int, ...], FloatArray, str]] = []
    for card, rows in _cards(deck, sets):
        dofs = tuple(k for k in range(1, 7) if card.integer(k + 1))
        system = card.label(1, "d")
        axes = referred(systems, system, card, "coordinate system", "*DEFINE_COORDINATE") if system else np.eye(3)
        turned = system and not np.array_equal(axes, np.eye(3))
        whole = {d for triad in ((1, 2, 3), (4, 5, 6)) if not turned or set(triad) <= set(dofs) for d in triad}
        for row in rows:
            held.setdefault(row, (set(), card.where))[0].update(whole & set(dofs))
            if left := tuple(d for d in dofs if d not in whole):
                skew.append((row, left, axes, card.where))
    by_dofs: dict[tuple[tuple[int, ...], str], list[int]] = {}
    for row, (of_row, where) in held.items():
        if of_row:
            by_dofs.setdefault((tuple(sorted(of_row)), where), []).append(row)
    fixed = tuple(Fixed(np.array(rows, dtype=np.int64), dofs, where) for (dofs, where), rows in by_dofs.items())
    return fixed, [e for row, dofs, axes, where in skew for e in _oblique(row, dofs, axes, where)]


def support_sets(fixed: tuple[Fixed, ...]) -> dict[str, IntArray]:
    """SPC: the rows of all held nodes; SPC.<dofs> too where they hold various dofs."""
    kinds: dict[str, list[int]] = {}
    for f in fixed:
        kinds.setdefault("".join(map(str, f.dofs)), []).extend(f.nodes_idx.tolist())
    found = {f"SPC.{kind}": rows for kind, rows in kinds.items()} if len(kinds) > 1 else {}
    if kinds:
        found["SPC"] = [row for rows in kinds.values() for row in rows]
    return {name: np.array(rows, dtype=np.int64) for name, rows in found.items()}


def _cards(deck: Deck, sets: Sets) -> Iterator[tuple[Card, list[int]]]:
    """Cards with id, system and six flags, and the rows of their nodes."""
    for named in deck.named("BOUNDARY_SPC_NODE"):
        for card in _data(named):
            yield card, [deck.nodes.row(card, 0)]
    for named in deck.named("BOUNDARY_SPC_SET"):
        for card in _data(named):
            yield card, referred(sets.nodes, card.label(0, "s"), card, "node set", "*SET_NODE")


def _data(named: Named) -> list[Card]:
    """All cards; with _ID one, below the line with the id.

    Raises
    ------
    InputError : more than one below an id.
    """
    if "ID" not in named.options:
        return named.cards()
    if len(named.block.lines) != 2:
        raise named.block.cut_off("two lines with _ID: the id, and one support; give each a keyword of its own")
    return [named.block.card(named.block.lines[1])]


def _oblique(row: int, dofs: tuple[int, ...], axes: FloatArray, where: str) -> Iterator[Constraint]:
    """e_d . u = 0 for each held direction."""
    C = np.zeros((len(dofs), 6))
    for k, d in enumerate(dofs):
        first = 3 * ((d - 1) // 3)
        C[k, first : first + 3] = axes[:, (d - 1) % 3]
    yield from global_equations([(row, d) for d in range(1, 7)], C, set(range(6)), where)
