"""SPC, SPC1, the PS field of GRID and TIC -> supports and initial velocities."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.deck.equations import global_equations
from creak.formats.deck.text import plain_name
from creak.formats.nastran.joints.rigid import combined, selected
from creak.formats.nastran.mesh.grids import Permanent
from creak.formats.nastran.text.bulk_data import Card, id_list, id_ranges, ids_among
from creak.formats.nastran.text.deck import Deck
from creak.model.constraints import Constraint, Fixed

Held = dict[int, tuple[set[int], str]]
"""Node row -> local dofs held and where it says so."""


def read_supports(deck: Deck, permanent: list[Permanent], own_run: bool) -> tuple[list[Fixed], list[Constraint]]:
    """Held dofs: as they are where they are global, else as equations.

    A displacement D of an SPC is taken as zero, which is no change in modes, and one in the deck's own run.

    Raises
    ------
    InputError : an unknown grid or set.
    """
    held: Held = {}
    for p in permanent:
        _hold(held, p.row, p.dofs, p.where)
    for card in (*_taken(deck, "SPC"), *_taken(deck, "SPC1")):
        for row, dofs in _dofs_of(deck, card):
            _hold(held, row, dofs, card.where)
    for card in _taken(deck, "SPC"):
        if any(card.text(i) and card.real(i + 2, 0.0) for i in (1, 4)):
            why = "what it moves is held: at zero in modes and by itself, as in Nastran; drive it in the study"
            deck.note(card, why, changes=own_run, what="SPC, D")
    return _as_constraints(deck, held)


def _dofs_of(deck: Deck, card: Card, *, known: bool = False) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Node row and dofs that an SPC or SPC1 card holds; `known` leaves out grids that are not there."""
    if card.name == "SPC":
        for i in (1, 4):
            if card.text(i) and not (known and card.integer(i) not in deck.grids.row_of):
                yield _one(deck, card, i)
        return
    many = known or any(text.upper() == "THRU" for text in card.fields)  # ids that THRU spans need not all exist
    for identifier in ids_among(id_ranges(card, 2), deck.grids.row_of) if many else id_list(card, 2):
        row = deck.grids.row(identifier, card)
        yield row, (1,) if row in deck.grids.scalar else card.components(1)


def _taken(deck: Deck, name: str) -> list[Card]:
    chosen = combined(deck, "SPCADD", selected(deck, "SPC", deck.case.spc))
    return [card for card in deck.cards(name) if card.integer(0) in chosen]


def _one(deck: Deck, card: Card, i: int) -> tuple[int, tuple[int, ...]]:
    row = deck.grids.row(card.integer(i), card)
    return row, (1,) if row in deck.grids.scalar else card.components(i + 1)


def _hold(held: Held, row: int, dofs: tuple[int, ...], where: str) -> None:
    held.setdefault(row, (set(), where))[0].update(dofs)


def support_sets(deck: Deck, names: dict[int, str]) -> dict[str, IntArray]:
    """SPC_<id>, and the name in the comments, of every set of SPC and SPC1 cards: the rows of its grids.

    SPC_<id>.<dofs> too where a set holds various dofs.
    """
    sets: dict[int, dict[int, set[int]]] = {}
    for card in deck.cards("SPC", "SPC1"):
        for row, dofs in _dofs_of(deck, card, known=True):
            if row not in deck.grids.scalar:
                sets.setdefault(card.integer(0), {}).setdefault(row, set()).update(dofs)
    found: dict[str, list[int]] = {}
    for identifier, held in sets.items():
        found[f"SPC_{identifier}"] = list(held)
        if identifier in names:
            found.setdefault(plain_name(names[identifier]), list(held))
        kinds = {row: "".join(map(str, sorted(dofs))) for row, dofs in held.items()}
        for row, kind in kinds.items() if len(set(kinds.values())) > 1 else ():
            found.setdefault(f"SPC_{identifier}.{kind}", []).append(row)
    return {name: np.array(rows, dtype=np.int64) for name, rows in found.items()}


def _as_constraints(deck: Deck, held: Held) -> tuple[list[Fixed], list[Constraint]]:
    by_dofs: dict[tuple[tuple[int, ...], str], list[int]] = {}
    skew: list[tuple[int, set[int], str]] = []
    for row, (dofs, where) in held.items():
        turned = row in deck.grids.axes
        whole = {d for group in ({1, 2, 3}, {4, 5, 6}) if not turned or group <= dofs for d in dofs & group}
        if whole:
            by_dofs.setdefault((tuple(sorted(whole)), where), []).append(row)
        if dofs - whole:
            skew.append((row, dofs - whole, where))
    fixed = [Fixed(np.array(rows, dtype=np.int64), dofs, where) for (dofs, where), rows in by_dofs.items()]
    return fixed, [e for row, dofs, where in skew for e in _along_axes(deck, row, sorted(dofs), where)]


def _along_axes(deck: Deck, row: int, dofs: list[int], where: str) -> Iterator[Constraint]:
    """e_d . u = 0 for each held direction e_d."""
    C = np.array([deck.grids.six(row, dof) for dof in dofs])
    yield from global_equations([(row, d) for d in range(1, 7)], C, set(range(6)), where)


def read_initial_velocity(deck: Deck) -> tuple[tuple[int, int, float], ...]:
    """V0 of the TIC set that the case control takes (IC), turned to global dofs."""
    velocity: dict[int, FloatArray] = {}
    for card in deck.cards("TIC"):
        if not deck.case.initial or card.integer(0) != deck.case.initial:
            deck.note(card, "the case control does not take this set (IC)", changes=False)
            continue
        row = deck.grids.row(card.integer(1), card)
        dof = 1 if row in deck.grids.scalar else card.integer(2)
        if card.real(3, 0.0):
            deck.note(card, "creak starts from the undeformed place: U0 is left out", changes=True, what="TIC, U0")
        velocity.setdefault(row, np.zeros(6))[:] += card.real(4, 0.0) * deck.grids.six(row, dof)
    return tuple((row, dof + 1, float(v)) for row, six in velocity.items() for dof, v in enumerate(six) if v)
