"""CGAP and PGAP -> stops between pairs of grids."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.nastran.mesh.coordinate_systems import axes_at
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, referred, unique_cards
from creak.model.steps import Stop

DOFS = ("x", "y", "z")
ALONG = 1e-6
"""Sine of the angle by which a gap may miss a global axis."""
SOFT = 1e-6
"""Stiffness of an open gap over that of a closed one below which it is none."""


@dataclass(frozen=True)
class _Gap:
    ends: tuple[int, int]
    axis: int
    """0 to 2; -1: along no global axis."""
    sign: float
    card: Card
    owner: Card


def read_gaps(deck: Deck) -> tuple[Stop, ...]:
    """Gaps of one property and direction together: u_B - u_A along the gap's axis stays above -U0, then KA pushes back.

    The axis runs from GA to GB, or is the first of CID. Of PGAP U0 and KA are used.

    Raises
    ------
    InputError : unknown grids or properties, grids that coincide without CID, KA that is not positive; a gap along no
        global axis, with friction, a preload, or a stiffness while open.
    """
    found = _named(_gaps(deck))
    for gaps in found.values():
        for gap in gaps:
            _check(gap)
    return tuple(_stop(name, gaps) for name, gaps in found.items())


def list_gaps(deck: Deck) -> tuple[Stop, ...]:
    """The gaps of a study, each group noted with what it must say of it; without those that are no stops."""
    stops: list[Stop] = []
    for name, gaps in _named(_gaps(deck)).items():
        try:
            for gap in gaps:
                _check(gap)
        except InputError as error:
            deck.note(gaps[0].card, f"{error.what}. {error.fix}", changes=True)
            continue
        stop = _stop(name, gaps)
        side = f"lower = {stop.lower:g}" if stop.lower is not None else f"upper = {stop.upper:g}"
        why = (
            f'give it in the study, as `creak new` does: [[connector]] type = "play", '
            f'nodes = ["{name}.A", "{name}.B"], dof = "{DOFS[stop.dof - 1]}", {side}, stiffness = {stop.stiffness:g}'
        )
        deck.note(gaps[0].card, why, changes=True)
        stops.append(stop)
    return tuple(stops)


def _gaps(deck: Deck) -> Iterator[_Gap]:
    properties = unique_cards(deck.cards("PGAP"), "property")
    for card in deck.cards("CGAP"):
        pid = card.integer(1, card.integer(0))
        deck.new_element(card, pid)
        owner = referred(properties, pid, card, "property", "PGAP")
        rows = [deck.grids.row(card.integer(i), card) for i in (2, 3)]
        line = _line(deck, card, rows)
        axis = int(np.argmax(np.abs(line)))
        off = np.linalg.norm(np.delete(line, axis)) > ALONG * np.linalg.norm(line)
        yield _Gap((rows[0], rows[1]), -1 if off else axis, float(np.sign(line[axis])), card, owner)


def _line(deck: Deck, card: Card, rows: list[int]) -> FloatArray:
    start, end = (deck.grids.place(row) for row in rows)
    if card.text(7):
        return axes_at(deck.system(card.integer(7), card), start)[:, 0]
    if not np.linalg.norm(end - start) > 0.0:
        raise card.error(
            f"the grids of CGAP {card.text(0)} coincide",
            expected="CID",
            fix="Give the coordinate system whose first axis is the gap's.",
        )
    return end - start


def _check(gap: _Gap) -> None:
    card, owner = gap.card, gap.owner
    name = f"CGAP {card.text(0)}"
    preload, closed, opened = (owner.real(i, 0.0) for i in (2, 3, 4))
    if not closed > 0.0:
        raise owner.wrong(3, "the stiffness KA of the closed gap, above 0")
    if gap.axis < 0:
        raise card.error(
            f"{name} lies along no global axis",
            expected="an axis x, y or z",
            fix="Give it as contact of surfaces in the study ([contact.NAME]).",
        )
    if owner.real(6, 0.0) > 0.0 or owner.real(7, 0.0) > 0.0:
        raise owner.error(
            f"{name} has friction, MU1 = {owner.real(6, 0.0):g}",
            expected="MU1 and MU2 blank or 0: creak's stops between two grids do not rub",
            fix="Give it as contact of surfaces in the study, [contact.NAME] with friction.",
        )
    if preload:
        raise owner.error(
            f"{name} has a preload, F0 = {preload:g}",
            expected="F0 blank or 0",
            fix="Give it in the study, [[connector]] with preload.",
        )
    if opened > SOFT * closed:
        raise owner.error(
            f"{name} is stiff while open, KB = {opened:g}",
            expected=f"KB below {SOFT:g} KA",
            fix="Give KB as CELAS2 beside it.",
        )


def _named(found: Iterable[_Gap]) -> dict[str, list[_Gap]]:
    """The gaps of one property and direction under GAP_<property>, with a number where it has several directions."""
    groups: dict[tuple[int, int, float], list[_Gap]] = {}
    for gap in found:
        groups.setdefault((gap.owner.integer(0), gap.axis, gap.sign), []).append(gap)
    count: dict[int, int] = {}
    alone = [pid for pid, _, _ in groups]
    out = {}
    for (pid, _, _), gaps in groups.items():
        count[pid] = count.get(pid, 0) + 1
        out[f"GAP_{pid}" + (f"_{count[pid]}" if alone.count(pid) > 1 else "")] = gaps
    return out


def _stop(name: str, gaps: list[_Gap]) -> Stop:
    first, owner = gaps[0], gaps[0].owner
    opening = owner.real(1, 0.0)
    a, b = (np.array([g.ends[i] for g in gaps], dtype=np.int64) for i in (0, 1))
    lower, upper = (0.0 - opening, None) if first.sign > 0.0 else (None, opening)
    return Stop(name, a, b, first.axis + 1, lower, upper, owner.real(3), first.card.where)
