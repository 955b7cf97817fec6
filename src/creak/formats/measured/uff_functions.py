"""Data set 58 of universal files: functions of time and of frequency, as text or binary (58b).

Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE, Channel
from creak.formats.measured.uff_points import units_told
from creak.formats.measured.uff_sets import BINARY, DataSet, data_sets
from creak.formats.measured.unit_words import (
    HERTZ,
    MOTIONS,
    NEWTONS,
    PER_SECOND,
    SECONDS,
    plain_unit,
    scale_of,
    unit_named,
)
from creak.model.units import LENGTHS

FUNCTION = "58"
HEAD = 11
"""Lines before the values."""
REAL, COMPLEX = (2, 4), (5, 6)
"""Ordinate types, single and double precision."""
SINGLE, DOUBLE = 13, 20
"""Characters of a number; an abscissa has 13."""
LINE = 80
TIME = 17
ORDERS = {8: RECEPTANCE, 11: MOBILITY, 12: ACCELERANCE}
FORCES = (9, 13)
"""Kinds of ordinate: motion, and how often a receptance is differentiated to be it; forces."""
AXES = {1: "X", 2: "Y", 3: "Z", 4: "RX", 5: "RY", 6: "RZ", 0: ""}


@dataclass(frozen=True)
class Axis:
    """What an axis of a function counts."""

    kind: int
    """0: unknown, 8: displacement, 9: reaction force, 11: velocity, 12: acceleration, 13: excitation force, 17: time,
    18: frequency."""
    unit: str


@dataclass(frozen=True)
class MeasuredFunction:
    """One data set 58, its values not read yet."""

    of: DataSet
    title: str
    kind: int
    """1: time response, 4: frequency response, 6: coherence."""
    response: tuple[int, int]
    """Node and direction, 1 to 6 with a sign; 0: none."""
    reference: tuple[int, int]
    data: int
    """A key of `REAL` or `COMPLEX`."""
    count: int
    even: bool
    start: float
    """In the unit of the abscissa, as `step`."""
    step: float
    abscissa: Axis
    ordinate: Axis
    denominator: Axis

    @property
    def name(self) -> str:
        """`1017 Z`, or `1017 Z / 1 -X` of a response and its reference."""
        response, reference = _place(self.response), _place(self.reference)
        return f"{response} / {reference}" if self.reference[1] else response

    def where(self) -> str:
        """file:line"""
        return self.of.where()

    def scale(self) -> float:
        """What the unit of the abscissa is in s, of times, or in Hz.

        Raises
        ------
        InputError : no such unit.
        """
        table, what = (SECONDS, "the times") if self.abscissa.kind == TIME else (HERTZ, "the frequencies")
        return scale_of(self.abscissa.unit, table, f"{what} of the function {self.name}", self.of.where(7))

    def values(self) -> tuple[FloatArray, Any]:
        """Abscissa (n,) in s, of times, or in Hz, and values (n,), complex where the file's are.

        Raises
        ------
        InputError : a value is no number, or there are fewer than the head says; as `scale`.
        """
        parts = 2 if self.data in COMPLEX else 1
        wide = self.data in (REAL[1], COMPLEX[1])
        columns = parts + (not self.even)
        if self.of.number == BINARY:
            flat = self._unpacked(columns, wide)
        else:
            widths = [DOUBLE if wide else SINGLE] * parts
            flat = self._numbers(widths if self.even else [SINGLE, *widths])
        if flat.size < self.count * columns or self.count < 2:
            raise _short(self.of)
        table = flat[: self.count * columns].reshape(self.count, columns)
        x = self.start + self.step * np.arange(self.count) if self.even else table[:, 0]
        if not (np.diff(x) > 0.0).all():
            raise InputError("a function whose abscissa does not rise", where=self.where(), fix="Export it again.")
        y = table[:, -parts:]
        return np.asarray(self.scale() * x, dtype=np.float64), y[:, 0] + 1j * y[:, 1] if parts == 2 else y[:, 0]

    def _unpacked(self, columns: int, wide: bool) -> FloatArray:
        """Numbers of a binary set; an uneven abscissa has four bytes, or as many as a value, as some programs write."""
        data, order = self.of.data, self.of.order
        dtype = np.dtype(f"{order}f{8 if wide else 4}")
        if wide and not self.even:
            short = np.dtype([("x", f"{order}f4"), ("y", dtype, (columns - 1,))])
            if len(data) < self.count * columns * dtype.itemsize and len(data) >= self.count * short.itemsize:
                rows = np.frombuffer(data, short, self.count)
                return np.column_stack([rows["x"], rows["y"]]).astype(np.float64).ravel()
        found = np.frombuffer(data, dtype, min(self.count * columns, len(data) // dtype.itemsize)).astype(np.float64)
        if not np.isfinite(found).all():
            raise InputError("a sample is no number", where=self.where(), fix="Export the file again.")
        return found

    def _numbers(self, widths: list[int]) -> FloatArray:
        """Numbers of fixed width, `widths` in turn, as many of them as a line of 80 characters holds."""
        edges = [0]
        while edges[-1] + sum(widths) <= LINE:
            edges += np.cumsum([edges[-1], *widths])[1:].tolist()
        found = []
        for k, line in enumerate(self.of.lines[HEAD:], start=HEAD):
            text = line.rstrip()
            for a, b in pairwise(edges):
                if a >= len(text):
                    break
                try:
                    found.append(float(text[a:b].replace("D", "E")))
                except ValueError:
                    found.append(math.nan)
                if not math.isfinite(found[-1]):
                    raise InputError(f"{text[a:b].strip()!r} is no number", where=self.of.where(k), expected="a sample")
        return np.array(found, dtype=np.float64)


def functions(sets: list[DataSet]) -> Iterator[MeasuredFunction]:
    """The functions of a file's data sets.

    Raises
    ------
    InputError : one is cut short, or its head cannot be read.
    """
    for one in sets:
        if one.number in (FUNCTION, BINARY):
            if not one.ended or len(one.lines) < HEAD:
                raise _short(one)
            yield _function(one)


def read_uff_functions(path: Path) -> list[Channel]:
    """The functions of time in a universal file; named by their first line, or by node and direction.

    What was measured along -X, -Y or -Z is turned: values are along the positive axis. A function without a unit has
    that of data set 164.

    Raises
    ------
    InputError : no such function in it, one that is complex or unevenly sampled, cut short, or over times in a unit
        that is none.
    """
    found, _ = histories_among(data_sets(path))
    if not found:
        raise InputError("no function of time (data set 58) in it", where=path, expected="abscissa of type 17 (time)")
    return found


def histories_among(sets: list[DataSet]) -> tuple[list[Channel], list[DataSet]]:
    """The functions of time among a file's data sets, as `read_uff_functions` has them, and the other data sets."""
    timed = [f for f in functions(sets) if f.abscissa.kind == TIME]
    taken, told = {id(f.of) for f in timed}, units_told(sets) if any(_is_bare(f.ordinate) for f in timed) else None
    return [_channel(f, told) for f in timed], [one for one in sets if id(one) not in taken]


def _channel(f: MeasuredFunction, told: tuple[float, float] | None) -> Channel:
    if f.data not in REAL or not f.even:
        raise InputError(
            "a function that is complex or unevenly sampled",
            where=f.where(),
            expected="real values at even steps",
            fix="Export it so.",
        )
    if not f.step > 0.0:
        raise _short(f.of)
    counts = MOTIONS.get(plain_unit(f.ordinate.unit))
    if counts is not None:
        require_of_kind(f, counts[0], "a function")
    node, direction = f.response
    positive, scale = (node, abs(direction)), f.scale()
    title = f.title if f.title not in ("", "NONE") else _place(positive)
    values = -f.values()[1] if direction < 0 else f.values()[1]
    return Channel(title, _unit(f.ordinate, told), scale * f.start, scale * f.step, values, positive)


def require_of_kind(f: MeasuredFunction, counts: int, what: str) -> None:
    """Check that the unit of an ordinate, which counts one of `ORDERS`, is of its kind, where it has one.

    Raises
    ------
    InputError : it is of another.
    """
    if ORDERS.get(f.ordinate.kind, counts) != counts:
        raise InputError(
            f"{what} of kind {f.ordinate.kind} in {f.ordinate.unit}",
            where=f.of.where(8),
            expected="a kind and a unit of one quantity: displacement (8), velocity (11) or acceleration (12)",
            fix="Correct the unit, or the kind.",
        )


def _is_bare(axis: Axis) -> bool:
    """Whether it is a motion or a force without a unit."""
    return not plain_unit(axis.unit) and axis.kind in (*ORDERS, *FORCES)


def _unit(axis: Axis, told: tuple[float, float] | None) -> str:
    """The label of an ordinate; where it has none, the unit of its kind by data set 164, or one of `BARE`."""
    if not _is_bare(axis):
        return axis.unit
    if axis.kind in FORCES:
        return "" if told is None else unit_named(1.0 / told[1], NEWTONS, "N")
    by = PER_SECOND[ORDERS[axis.kind]]
    if told is not None:
        return unit_named(1.0 / told[0], LENGTHS, "m") + by
    return f"length{by}" if by else ""


def _function(one: DataSet) -> MeasuredFunction:
    lines = one.lines
    try:
        data, count, even = (int(lines[6][a : a + 10]) for a in (0, 10, 20))
        start, step = (float(lines[6][a : a + 13].replace("D", "E")) for a in (30, 43))
        axes = [Axis(int(line[:10].strip() or 0), line[47:67].strip()) for line in lines[7:10]]
        numbers = [int(lines[5][a:b].strip() or 0) for a, b in ((0, 5), (41, 51), (51, 55), (66, 76), (76, 80))]
    except ValueError as error:
        raise InputError("a function whose sixth and seventh records cannot be read", where=one.where()) from error
    if data not in (*REAL, *COMPLEX):
        raise InputError(f"a function of data type {data}", where=one.where(6), expected="2, 4 (real), 5, 6 (complex)")
    response, reference = (numbers[1], numbers[2]), (numbers[3], numbers[4])
    return MeasuredFunction(
        one, lines[0].strip(), numbers[0], response, reference, data, count, even == 1, start, step, *axes
    )


def _place(of: tuple[int, int]) -> str:
    """`1017 Z`"""
    node, direction = of
    return f"{node} {'-' * (direction < 0)}{AXES.get(abs(direction), '')}".strip()


def _short(one: DataSet) -> InputError:
    return InputError("a function is cut short: it has fewer samples than it says", where=one.where())
