"""DAREA, FORCE, MOMENT, LOAD, GRAV, SPCD and pressures of one set -> forces and motions of dofs, gravity; sets of
static loads and temperatures: those that a study may name, and those of the subcase before a transient."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.pressure import point_loads
from creak.formats.deck.refusals import referred
from creak.formats.nastran.loads.pressures import CARDS as PRESSURES
from creak.formats.nastran.loads.pressures import pressure_forces
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.case_control import StaticCase
from creak.formats.nastran.text.deck import Deck
from creak.model.steps import NodeTemperatures, PointLoad, Prescribed, StaticLoads

Dof = tuple[int, int]
"""Node row and global dof 1..6."""
_NOT_READ = "FORCE1, FORCE2, MOMENT1, MOMENT2, PLOAD1, PLOADB3, PLOADX1, RFORCE, RFORCE1, SLOAD, ACCEL,ACCEL1, SPCR"
NOT_READ = tuple(name.strip() for name in _NOT_READ.split(","))
"""Loads of a set that creak does not know."""
READ = ("DAREA", "FORCE", "MOMENT", "LOAD", "SPCD", "LSEQ")
_OF_SETS = ("DAREA", "FORCE", "MOMENT", "SPCD", "GRAV", "LOAD", *PRESSURES, *NOT_READ)
DEPTH = 20


@dataclass
class LoadSet:
    """What a set of loads asks for, by global dof."""

    forces: dict[Dof, float] = field(default_factory=dict)
    motion: dict[Dof, float] = field(default_factory=dict)
    gravity: FloatArray = field(default_factory=lambda: np.zeros(3))
    pressures: list[tuple[Card, float]] = field(default_factory=list)
    """Cards of pressure and their factors."""
    where: str = ""
    """Of its first card; empty: the deck has none."""


def load_set(deck: Deck, identifier: int, user: Card) -> LoadSet:
    """The loads that EXCITEID of a TLOAD card names, those that LSEQ gives it included.

    Raises
    ------
    InputError : no card of the set, or one of a kind that creak does not read.
    """
    cards = cards_by_set(deck, *_OF_SETS)
    found = static_set(deck, identifier, cards)
    for card in deck.cards("LSEQ"):
        if deck.case.loadset and card.integer(0) == deck.case.loadset and card.integer(1) == identifier:
            _add(deck, cards, card.integer(2), 1.0, found, 0)
    if not found.where:
        raise user.error(
            f"{user.title} uses load set {identifier}, which is not defined",
            expected="DAREA, FORCE, MOMENT or SPCD cards of this set",
        )
    if found.gravity.any() or found.pressures:
        name = "GRAV" if found.gravity.any() else found.pressures[0][0].name
        raise InputError(
            f"{name} of load set {identifier} is not read by creak in a transient load",
            where=found.where,
            expected="DAREA, FORCE, MOMENT and SPCD",
            fix="Put it into a static subcase before the transient, or write the load as forces on grids.",
        )
    return found


def static_set(deck: Deck, identifier: int, cards: Cards | None = None) -> LoadSet:
    """The loads of a set as LOAD in the case control takes them, with no card where there are none.

    Parameters
    ----------
    cards : those of all sets, `cards_by_set`; None: they are looked up.

    Raises
    ------
    InputError : a load of a kind that creak does not read.
    """
    found = LoadSet()
    _add(deck, cards_by_set(deck, *_OF_SETS) if cards is None else cards, identifier, 1.0, found, 0)
    return found


Cards = Mapping[str, Sequence[Card]]
"""Of each set, by its number as it is written."""


def cards_by_set(deck: Deck, *names: str) -> dict[str, list[Card]]:
    """Cards of these names by the number in their first field."""
    found: dict[str, list[Card]] = {}
    for card in deck.cards(*names):
        found.setdefault(str(card.integer(0)) if card.is_integer(0) else card.text(0), []).append(card)
    return found


def _add(deck: Deck, cards: Cards, identifier: int, factor: float, found: LoadSet, depth: int) -> None:
    for card in cards.get(str(identifier), ()):
        if card.name in NOT_READ:
            raise card.error(
                f"{card.name} of load set {identifier} is not read by creak",
                expected="DAREA, FORCE, MOMENT, GRAV, PLOAD, PLOAD2, PLOAD4 and SPCD",
                fix="Write the load as forces on grids.",
            )
    for card in cards.get(str(identifier), ()):
        found.where = found.where or card.where
        if card.name == "LOAD":
            if depth > DEPTH:
                raise card.error(f"LOAD {identifier} refers to itself", fix="Remove the reference.")
            for i in range(2, len(card.fields), 2):
                if card.text(i + 1):
                    other = referred(cards, str(card.integer(i + 1)), card, "load set", "FORCE, MOMENT, GRAV or SPCD")
                    share = factor * card.real(1, 1.0) * card.real(i)
                    _add(deck, cards, other[0].integer(0), share, found, depth + 1)
        elif card.name in ("FORCE", "MOMENT"):
            _add_vector(deck, card, factor, found)
        elif card.name in PRESSURES:
            found.pressures.append((card, factor))
        elif card.name == "GRAV":
            direction = np.array([card.real(i, 0.0) for i in (3, 4, 5)])
            if not direction.any():
                raise card.error(f"GRAV {identifier} has no direction", expected="N1, N2, N3")
            axes = axes_at(deck.system(card.integer(1, 0), card), np.zeros(3))
            found.gravity = found.gravity + factor * card.real(2) * (axes @ direction)
        else:
            _add_components(deck, card, factor, found)


def _add_vector(deck: Deck, card: Card, factor: float, found: LoadSet) -> None:
    row = deck.grids.row(card.integer(1), card)
    axes = axes_at(deck.system(card.integer(2, 0), card), deck.grids.place(row))
    vector = factor * card.real(3) * axes @ np.array([card.real(i, 0.0) for i in (4, 5, 6)])
    first = 1 if card.name == "FORCE" else 4
    for axis, value in enumerate(vector.tolist()):
        if value:
            found.forces[row, first + axis] = found.forces.get((row, first + axis), 0.0) + value


def _add_components(deck: Deck, card: Card, factor: float, found: LoadSet) -> None:
    """Two of grid, dof and value, in the displacement frame of the grid."""
    for i in (1, 4):
        if not card.text(i):
            continue
        row = deck.grids.row(card.integer(i), card)
        for dof in (1,) if row in deck.grids.scalar else card.components(i + 1):
            value = factor * card.real(i + 2, 0.0)
            if card.name == "DAREA":
                for k, share in enumerate(deck.grids.six(row, dof).tolist(), start=1):
                    if share:
                        found.forces[row, k] = found.forces.get((row, k), 0.0) + share * value
            elif row in deck.grids.axes:
                raise card.error(
                    f"SPCD moves grid {card.text(i)} along turned axes (field CD)", fix="Move it along global axes."
                )
            else:
                found.motion[row, dof] = value


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
