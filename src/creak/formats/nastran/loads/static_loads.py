"""Sets of static loads and temperatures: those that a study may name, and those of the subcase before a transient."""

from __future__ import annotations

import numpy as np

from creak.errors import InputError
from creak.formats.deck.pressure import point_loads
from creak.formats.nastran.loads.pressures import CARDS as PRESSURES
from creak.formats.nastran.loads.pressures import pressure_forces
from creak.formats.nastran.loads.sets import NOT_READ, READ, Cards, LoadSet, cards_by_set, static_set
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.case_control import StaticCase
from creak.formats.nastran.text.deck import Deck
from creak.model.steps import NodeTemperatures, PointLoad, Prescribed, StaticLoads

HEAT = ("TEMP", "TEMPD")
HEAT_NOT_READ = ("TEMPP1", "TEMPP3", "TEMPRB", "TEMPF", "TEMPN1", "TEMPAX")
"""Gradients through shells and bars, and temperatures that functions give."""
CARDS = {"GRAV", "LOAD", *PRESSURES, *HEAT}
"""Read for a static subcase."""
_LOADS = tuple(name for name in (*READ, "GRAV", *PRESSURES, *NOT_READ) if name not in ("DAREA", "LSEQ"))


def named_loads(deck: Deck) -> dict[str, StaticLoads]:
    """Loads and temperatures of each set under its number; one that creak cannot read has a flaw."""
    loads, heat = cards_by_set(deck, *_LOADS), _heat_by_set(deck)
    numbers = sorted({int(key) for key in (*loads, *heat) if key.isdigit()})
    return {str(n): _tried(deck, n, loads, heat) for n in numbers}


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
    loads, heat = cards_by_set(deck, *_LOADS), _heat_by_set(deck)
    for number, kind, known in ((case.load, "LOAD", loads), (case.temperature, "TEMPERATURE", heat)):
        if number and str(number) not in known:
            raise InputError(
                f"{kind} = {number} in the case control, but no card has this number",
                where=case.where,
                expected="GRAV, FORCE, MOMENT, PLOAD4, SPCD or LOAD cards" if kind == "LOAD" else "TEMP or TEMPD cards",
            )
    return _loads(deck, static_set(deck, case.load, loads), case.load, _warm(deck, case.temperature, heat), case.where)


def temperatures(deck: Deck, number: int) -> NodeTemperatures | None:
    """TEMP and TEMPD of a set; None where it has none.

    Raises
    ------
    InputError : a gradient, or an unknown grid.
    """
    return _warm(deck, number, _heat_by_set(deck)) if number else None


def _heat_by_set(deck: Deck) -> dict[str, list[Card]]:
    """Cards of each set; a TEMPD gives up to four sets a temperature."""
    found = cards_by_set(deck, "TEMP", *HEAT_NOT_READ)
    for card in deck.cards("TEMPD"):
        for i in range(0, len(card.fields), 2):
            if card.text(i):
                found.setdefault(str(card.integer(i)), []).append(card)
    return found


def _warm(deck: Deck, number: int, cards: Cards) -> NodeTemperatures | None:
    found: dict[int, float] = {}
    mine = cards.get(str(number), ())
    for card in sorted(mine, key=lambda c: c.name != "TEMPD"):
        if card.name in HEAT_NOT_READ:
            raise card.error(
                f"{card.name} of temperature set {number} is not read by creak",
                expected="TEMP and TEMPD, one temperature of each grid",
                fix="creak heats shells and bars evenly through the thickness: give the mean at the grids.",
            )
        if card.name == "TEMPD":
            at = next(i for i in range(0, len(card.fields), 2) if card.text(i) and card.integer(i) == number)
            found.update(dict.fromkeys(range(len(deck.grids.ids)), card.real(at + 1)))
        else:
            for i in (1, 3, 5):
                if card.text(i):
                    found[deck.grids.row(card.integer(i), card)] = card.real(i + 1)
    if not found:
        return None
    for (a, b), middle in deck.middles.items():
        if a in found and b in found:
            found[middle.row] = 0.5 * (found[a] + found[b])
    return NodeTemperatures(np.array(list(found), dtype=np.int64), np.array(list(found.values()), dtype=np.float64))


def _tried(deck: Deck, number: int, loads: Cards, heat: Cards) -> StaticLoads:
    try:
        return _loads(deck, static_set(deck, number, loads), number, _warm(deck, number, heat), "")
    except InputError as error:
        return StaticLoads((0.0, 0.0, 0.0), (), error.where, flaw=error)


def _loads(deck: Deck, found: LoadSet, load: int, warm: NodeTemperatures | None, where: str) -> StaticLoads:
    x, y, z = found.gravity.tolist()
    forces, moved = [], []
    for (dof, value), rows in by_value(found.forces).items():
        forces.append(PointLoad(np.array(rows, dtype=np.int64), dof, value, "", _name(deck, rows, load), found.where))
    for (dof, value), rows in by_value(found.motion).items():
        nodes = np.array(rows, dtype=np.int64)
        moved.append(Prescribed(nodes, dof, "displacement", value, "", _name(deck, rows, load), found.where))
    if found.pressures:
        forces += point_loads(*pressure_forces(deck, found.pressures), f"SET {load}", found.where)
    return StaticLoads((x, y, z), tuple(forces), where or found.where, warm, tuple(moved))


def _name(deck: Deck, rows: list[int], number: int) -> str:
    return f"GRID {deck.grids.ids[rows[0]]}" if len(rows) == 1 else f"SET {number}"


def by_value(values: dict[tuple[int, int], float]) -> dict[tuple[int, float], list[int]]:
    """(dof, value) -> node rows, from (node row, dof) -> value."""
    found: dict[tuple[int, float], list[int]] = {}
    for (row, dof), value in values.items():
        found.setdefault((dof, value), []).append(row)
    return found
