"""TLOAD1 with TABLED1 to 3, and TLOAD2 -> functions of time."""

from __future__ import annotations

import math

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.magnitude import LARGEST
from creak.model.steps import Amplitude

TABLES = ("TABLED1", "TABLED2", "TABLED3")
CLOSEST = 1e-9
"""Share of a step over which a jump of a table is drawn out, half of it to either side: on it the mean holds."""
FLAT = {"TABLED1": 3, "TABLED2": 2, "TABLED3": 3}
"""Field of a table that says how it goes on beyond its ends (FLAT in OptiStruct, EXTRAP in MSC Nastran)."""


def amplitude_of(deck: Deck, card: Card, dt: float, count: int, kind: str) -> Amplitude:
    """The function of a TLOAD card over a run of `count` steps of `dt`.

    TLOAD1: F(t - delay) by a table, linear between its points; beyond its ends as its first and last line, or flat
    where it says so; at a jump the mean; or a constant, where a number stands for the table. TLOAD2:
    s^B exp(C s) cos(2 pi F s + P), s = t - T1 - delay, from T1 to T2; a plain cosine (or constant) over the whole run
    as such, others of forces by their values at the steps.

    Raises
    ------
    InputError : delays by card, tables with logarithmic axes, initial values, motions by a TLOAD2 that starts or ends
        within the run.
    """
    delay = _delay(card)
    if card.name == "TLOAD1":
        if any(card.real(i, 0.0) for i in (5, 6)):
            raise card.error(
                f"TLOAD1 {card.text(0)} has initial values US0, VS0",
                expected="blank or 0",
                fix="creak starts from the undeformed place.",
            )
        if card.text(4) and not card.is_integer(4):
            return _tabular(card, np.array([[0.0, card.real(4)], [dt * count, card.real(4)]]))
        tables = unique_cards(deck.cards(*TABLES, "TABLED4"), "table")
        table = referred(tables, card.integer(4), card, "table", ", ".join(TABLES))
        if table.name not in TABLES:
            raise InputError(
                f"{table.name} {table.text(0)} gives its function by a power series",
                where=table.where,
                expected=f"points: {', '.join(TABLES)}",
                fix="Write its values at some times into a TABLED1.",
            )
        points, end, flat = _points(table), dt * count, _is_flat(table)
        points[:, 0] += delay
        (a, b), (c, d) = points[:2, 0], points[-2:, 0]
        if not flat and ((a == b and a > 0.0) or (c == d and d < end)):
            raise InputError(
                f"{table.name} {table.text(0)} jumps at an end, beyond which it would go on along a line",
                where=table.where,
                expected="two points of the line, or 1 in the field FLAT",
                fix="Add a point.",
            )
        return _tabular(card, _over_run(points, dt, end, flat))
    return _analytic(card, delay, dt, count, kind)


def _delay(card: Card) -> float:
    if card.is_integer(2) and card.integer(2):
        raise card.error(f"{card.title} has a DELAY card", expected="a time in its field DELAY", fix="Shift its table.")
    return 0.0 if card.is_integer(2) else card.real(2, 0.0)


def _name(card: Card) -> str:
    return f"{card.name} {card.integer(0)}"


def _tabular(card: Card, points: FloatArray) -> Amplitude:
    return Amplitude(_name(card), "tabular", points, rounding=0.0, where=card.where)


def _points(table: Card) -> FloatArray:
    """(k, 2) times, which do not fall, and values."""
    axes = [table.text(i).upper() for i in (1, 2)] if table.name == "TABLED1" else ["", ""]
    if "LOG" in axes:
        raise InputError(f"TABLED1 {table.text(0)} has logarithmic axes", where=table.where, expected="LINEAR")
    pairs: list[tuple[float, float]] = []
    for i in range(8, len(table.fields) - 1, 2):
        texts = (table.text(i).upper(), table.text(i + 1).upper())
        if "ENDT" in texts:
            break
        if "SKIP" not in texts and any(texts):
            pairs.append((table.real(i), table.real(i + 1)))
    points = np.array(pairs, dtype=np.float64).reshape(-1, 2)
    if table.name == "TABLED2":
        points[:, 0] += table.real(1, 0.0)
    elif table.name == "TABLED3":
        points[:, 0] = table.real(2, 0.0) * points[:, 0] + table.real(1, 0.0)
    if points.size and points[0, 0] > points[-1, 0]:
        points = points[::-1].copy()
    if len(points) < 2 or (np.diff(points[:, 0]) < 0.0).any() or points[0, 0] == points[-1, 0]:
        raise InputError(
            f"{table.name} {table.text(0)} has {len(points)} points, or times that rise and fall or stand still",
            where=table.where,
            expected="two points or more, in the order of time or against it",
        )
    return points


def _is_flat(table: Card) -> bool:
    """Whether the values at the ends of a table go on beyond them."""
    word = table.text(FLAT[table.name]).upper()
    if word not in ("", "0", "1", "FLAT"):
        raise InputError(
            f"{table.name} {table.text(0)} has {word} for what lies beyond its ends",
            where=table.where,
            expected="blank or 0 (its first and last line), 1 or FLAT (the values at its ends)",
        )
    return word in ("1", "FLAT")


def _over_run(points: FloatArray, dt: float, end: float, flat: bool) -> FloatArray:
    """The table from 0 to `end`, lengthened along its first and last line or flat; jumps take a billionth of a step,
    half of it to either side."""
    t = points[:, 0].copy()
    apart = np.maximum(max(CLOSEST * dt, 2e-12), 4e-16 * np.abs(t))
    _, first, which, count = np.unique(t, return_index=True, return_inverse=True, return_counts=True)
    t += apart * (np.arange(t.size) - first[which] - 0.5 * (count[which] - 1))
    for k in range(1, t.size):
        t[k] = max(t[k], t[k - 1] + apart[k])
    points = np.column_stack([t, points[:, 1]])
    if t[0] > 0.0:
        points = np.concatenate([[_beyond(points[0], points[1], 0.0, flat)], points])
    if t[-1] < end:
        points = np.concatenate([points, [_beyond(points[-1], points[-2], end, flat)]])
    return points


def _beyond(end: FloatArray, inner: FloatArray, time: float, flat: bool) -> tuple[float, float]:
    slope = 0.0 if flat else float((end[1] - inner[1]) / (end[0] - inner[0]))
    return time, float(end[1]) + slope * (time - float(end[0]))


def _analytic(card: Card, delay: float, dt: float, count: int, kind: str) -> Amplitude:
    start, stop = (card.real(i, 0.0) + delay for i in (4, 5))
    frequency, phase, growth, power = (card.real(i, 0.0) for i in (6, 7, 8, 9))
    phase = math.radians(phase)
    end = dt * count
    if start <= 0.0 and stop >= end and not growth and not power:
        shifted = phase - 2.0 * math.pi * frequency * start
        if not frequency:
            return _tabular(card, np.array([[0.0, math.cos(phase)], [end, math.cos(phase)]]))
        cosine, sine = (math.cos(shifted),), (-math.sin(shifted),)
        return Amplitude(_name(card), "periodic", frequency=frequency, cosine=cosine, sine=sine, where=card.where)
    if kind != "force":
        raise card.error(
            f"TLOAD2 {card.text(0)} moves grids by a function that starts, ends or grows within the run",
            expected="T1 = 0, T2 at or after the end, B = C = 0",
            fix="Give the motion by TLOAD1 and a table.",
        )
    t = dt * np.arange(count + 1)
    s = np.maximum(t - start, 0.0)
    on = (t >= start - 1e-9 * dt) & (t <= stop + 1e-9 * dt)
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.where(on, s**power * np.exp(growth * s) * np.cos(2.0 * math.pi * frequency * s + phase), 0.0)
    if not (np.abs(values) <= LARGEST).all():
        raise card.error(f"TLOAD2 {card.text(0)} grows beyond all numbers", fix="Check B and C.")
    return _tabular(card, np.column_stack([t, values]))
