"""Sets of static loads and temperatures: those that a study may name, and those of the subcase before a transient."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

import numpy as np

from creak.errors import InputError
from creak.formats.nastran.bulk_data import Card
from creak.formats.nastran.case_control import StaticCase
from creak.formats.nastran.deck import Deck
from creak.formats.nastran.load_sets import NOT_READ, READ, LoadSet, static_set
from creak.model.steps import NodeTemperatures, PointLoad, Prescribed, StaticLoads

HEAT = ("TEMP", "TEMPD")
HEAT_NOT_READ = ("TEMPP1", "TEMPP3", "TEMPRB", "TEMPF", "TEMPN1", "TEMPAX")
"""Gradients through shells and bars, and temperatures that functions give."""
CARDS = {"GRAV", "LOAD", *HEAT}
"""Read for a static subcase."""
_LOADS = tuple(name for name in (*READ, "GRAV", *NOT_READ) if name not in ("DAREA", "LSEQ"))


def named_loads(deck: Deck) -> dict[str, StaticLoads]:
    """Loads and temperatures of each set under its number; one that creak cannot read has a flaw."""
    cards = deck.cards(*_LOADS, *HEAT, *HEAT_NOT_READ)
    ids = {number for card in cards for number in _set_ids(card)}
    return {str(i): _tried(deck, i, i) for i in sorted(ids)}


def subcase_loads(deck: Deck, case: StaticCase) -> StaticLoads:
    """What a static subcase asks for: LOAD, and TEMPERATURE(LOAD).

    Raises
    ------
    InputError : a set that is not defined, or that holds what creak does not read; other supports than those of the
        transient.
    """
    if case.spc != deck.case.spc:
        raise InputError(
            f"the static subcase takes SPC = {case.spc}, the transient one {deck.case.spc}",
            where=case.where,
            expected="the same",
            fix="Hold in the static subcase what the transient one holds.",
        )
    loads = _loads(deck, case.load, case.temperature, case.where)
    for number, kind in ((case.load, "LOAD"), (case.temperature, "TEMPERATURE")):
        if number and not any(number in _set_ids(c) for c in deck.cards(*(_LOADS if kind == "LOAD" else HEAT))):
            raise InputError(
                f"{kind} = {number} in the case control, but no card has this number",
                where=case.where,
                expected="GRAV, FORCE, MOMENT, SPCD or LOAD cards" if kind == "LOAD" else "TEMP or TEMPD cards",
            )
    return loads


def temperatures(deck: Deck, number: int) -> NodeTemperatures | None:
    """TEMP and TEMPD of a set; None where it has none.

    Raises
    ------
    InputError : a gradient, or an unknown grid.
    """
    refused = next((c for c in deck.cards(*HEAT_NOT_READ) if c.text(0) == str(number)), None)
    if refused is not None:
        _refuse_gradient(refused, number)
    found: dict[int, float] = {}
    for card in deck.cards("TEMPD"):
        for i in range(0, len(card.fields), 2):
            if card.text(i) == str(number):
                found.update(dict.fromkeys(deck.grids.row_of.values(), card.real(i + 1)))
    for card in deck.cards("TEMP"):
        if card.integer(0) == number:
            for i in (1, 3, 5):
                if card.text(i):
                    found[deck.grids.row(card.integer(i), card)] = card.real(i + 1)
    if not found:
        return None
    return NodeTemperatures(np.array(list(found), dtype=np.int64), np.array(list(found.values()), dtype=np.float64))


def _refuse_gradient(card: Card, number: int) -> NoReturn:
    raise InputError(
        f"{card.name} of temperature set {number} is not read by creak",
        where=card.where,
        expected="TEMP and TEMPD, one temperature of each grid",
        fix="creak heats shells and bars evenly through the thickness: give the mean at the grids.",
    )


def _set_ids(card: Card) -> Iterable[int]:
    if card.name == "TEMPD":
        return [card.integer(i) for i in range(0, len(card.fields), 2) if card.text(i)]
    return [card.integer(0)] if card.is_integer(0) else []


def _tried(deck: Deck, load: int, temperature: int) -> StaticLoads:
    try:
        return _loads(deck, load, temperature, "")
    except InputError as error:
        return StaticLoads((0.0, 0.0, 0.0), (), error.where, flaw=error)


def _loads(deck: Deck, load: int, temperature: int, where: str) -> StaticLoads:
    found = static_set(deck, load) if load else LoadSet()
    x, y, z = found.gravity.tolist()
    forces, moved = [], []
    for (dof, value), rows in by_value(found.forces).items():
        forces.append(PointLoad(np.array(rows, dtype=np.int64), dof, value, "", _name(deck, rows, load), found.where))
    for (dof, value), rows in by_value(found.motion).items():
        nodes = np.array(rows, dtype=np.int64)
        moved.append(Prescribed(nodes, dof, "displacement", value, "", _name(deck, rows, load), found.where))
    warm = temperatures(deck, temperature) if temperature else None
    return StaticLoads((x, y, z), tuple(forces), where or found.where, warm, tuple(moved))


def _name(deck: Deck, rows: list[int], number: int) -> str:
    return f"GRID {deck.grids.ids[rows[0]]}" if len(rows) == 1 else f"SET {number}"


def by_value(values: dict[tuple[int, int], float]) -> dict[tuple[int, float], list[int]]:
    """(dof, value) -> node rows, from (node row, dof) -> value."""
    found: dict[tuple[int, float], list[int]] = {}
    for (row, dof), value in values.items():
        found.setdefault((dof, value), []).append(row)
    return found
