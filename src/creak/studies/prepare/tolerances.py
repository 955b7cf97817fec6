"""What scatter may take of the gap at each point: the rows of tables of tolerances, found at the points of E-lines."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.named_nodes import REACH
from creak.studies.file.case import Lines
from creak.studies.file.quantities import length_in
from creak.studies.file.scatter_tables import GapTolerance, ToleranceFile, read_tolerances, table_of
from creak.studies.warned import Warned
from creak.words import first_few

SAME = 1e-9
"""Of the model's size, at which two places are one."""


@dataclass(frozen=True)
class Points:
    """Points of all lines of a study."""

    names: Sequence[str]
    """(p,) `line:point`."""
    group: Sequence[str]
    """(p,) the line."""
    labels: Sequence[str]
    """(p,) of the node on the secondary side."""
    positions: FloatArray
    """(p, 3)"""
    gap0: FloatArray
    """(p,) gap at rest."""
    size: float
    """Of the model, length."""

    def of(self, lines: Collection[str]) -> BoolArray:
        """(p,) whether it is on one of these lines."""
        return np.array([g in lines for g in self.group], dtype=bool)


def points_of(points: GapOperator, model: Model) -> Points:
    """Those of gap channels."""
    X, rows = model.nodes.coords, points.nodes_idx
    labels = [model.nodes.label(row) for row in rows.tolist()]
    return Points(points.names, points.group, labels, X[rows], points.gap0, float(np.linalg.norm(np.ptp(X, axis=0))))


@dataclass(frozen=True)
class PointTolerances:
    """What scatter may take of the gaps."""

    below: FloatArray
    """(p,) length."""
    source: tuple[tuple[str, str], ...]
    """Line -> where it is from, and which side it is of; lines with a number of the study are not in it."""
    notes: tuple[str, ...]


def point_tolerances(given: Lines, points: Points) -> PointTolerances:
    """The tolerance of each point: that of its line, or else of [limit].

    A row of a table holds for the points that it names, or for the nearest one to its place; the other points of the
    line take that of the nearest point that has one.

    Raises
    ------
    InputError : a table that cannot be read (`read_tolerances`), a row of no point, a line without a row.
    """
    lines = list(dict.fromkeys(points.group))
    own = {name: given.elines[name].tolerance for name in lines if name in given.elines}
    below, source = np.zeros(len(points.group)), dict[str, str]()
    notes: list[str] = []
    tables: dict[str, tuple[ToleranceFile, list[str]]] = {}
    for name in lines:
        value = given.tolerance if own.get(name) is None else own[name]
        table = table_of(value)
        if table is not None:
            tables.setdefault(table.model_dump_json(), (table, []))[1].append(name)
        elif isinstance(value, str):
            below[points.of([name])] = length_in(value, given.units)
    for table, mine in tables.values():
        asked = [name for name in mine if own.get(name) is not None]
        key = ("eline", asked[0], "tolerance") if asked else ("limit", "tolerance")
        where = given.places.where(*key)
        rows = read_tolerances(given.places.sibling(table.file), where, table.columns, given.units)
        hit = rows_hit(rows, points, mine, UNITS[given.units].length)
        at = spread(hit, points, mine)
        taken = at >= 0
        below[taken] = np.array([row.below for row in rows])[at[taken]]
        for name in mine:
            sides = sorted({rows[k].side for k in at[points.of([name])].tolist() if k >= 0})
            if sides:
                source[name] = f"{table.file}, {' and '.join(sides)}"
            elif name in asked:
                raise no_row(table.file, points, name, given.places.where("eline", name, "tolerance"))
        left = [name for name in mine if name not in source]
        if left:
            notes.append(
                Warned(f"{table.file} has no row for {', '.join(left)}: no tolerance is taken of the gaps there")
            )
        notes += _nominal_notes(table.file, rows, points, hit, UNITS[given.units].length)
    return PointTolerances(below, tuple(source.items()), tuple(notes))


def no_row(file: str, points: Points, line: str, where: str) -> InputError:
    """What to say of a table without a row for the points of a line."""
    mine = [name for name, group in zip(points.names, points.group, strict=True) if group == line]
    return InputError(
        f"{file} has no row for a point of the line {line!r}",
        where=where,
        expected=f"a row named {line} or as its points: {first_few(mine)}",
        fix="Add one, or give the line a tolerance of its own.",
    )


def spread(hit: IntArray, points: Points, lines: Collection[str]) -> IntArray:
    """(p,) the row of each point of some lines: its own, or that of the nearest point that has one; -1: none has.

    Parameters
    ----------
    hit : as `rows_hit` finds them.
    """
    at = hit.copy()
    for name in lines:
        own = points.of([name])
        known, rest = np.flatnonzero(own & (hit >= 0)), np.flatnonzero(own & (hit < 0))
        if known.size:
            apart = points.positions[rest][:, None] - points.positions[known][None]
            at[rest] = hit[known[np.linalg.norm(apart, axis=2).argmin(axis=1)]]
    return at


def rows_hit(rows: Sequence[GapTolerance], points: Points, lines: Collection[str], unit: str) -> IntArray:
    """(p,) the row that names each point of some lines or lies at it; -1: none does. unit : of length.

    Raises
    ------
    InputError : a row of no point of any line; two rows of one point.
    """
    named, mine = _by_names(points), points.of(lines)
    hits = [
        _named(row, named) if row.place is None else _placed(row, np.array(row.place), points, mine, unit)
        for row in rows
    ]
    at = np.full(len(points.group), -1, dtype=np.int64)
    for k in sorted(range(len(rows)), key=lambda k: -hits[k].size):
        row = rows[k]
        for j in hits[k][mine[hits[k]]].tolist():
            other = int(at[j])
            if other >= 0 and row.place is not None and rows[other].place is not None:
                at[j] = k if row.below > rows[other].below else other  # two places at one node: the larger is safe
                continue
            if other >= 0 and hits[other].size == hits[k].size:
                raise InputError(
                    f"{row.name} and {rows[other].name} are both the point {points.names[j]}",
                    where=row.where,
                    expected=f"one row for each point; the other is {rows[other].where}",
                    fix="Remove one of them.",
                )
            at[j] = k
    return at


def _by_names(points: Points) -> dict[str, IntArray]:
    """Name in small letters -> points: the line; `line:point`, what it begins with up to a colon, `line:node`, and
    these without the line."""
    found: dict[str, list[int]] = {}
    for k, (name, line) in enumerate(zip(points.names, points.group, strict=True)):
        words = name.removeprefix(f"{line}:").split(":")
        own = [points.labels[k], *(":".join(words[:n]) for n in range(1, len(words) + 1))]
        for text in {line, *own, *(f"{line}:{text}" for text in own)}:
            found.setdefault(text.casefold(), []).append(k)
    return {text: np.array(rows, dtype=np.int64) for text, rows in found.items()}


def _named(row: GapTolerance, named: dict[str, IntArray]) -> IntArray:
    found = named.get(row.point.casefold())
    if found is None:
        raise InputError(
            f"there is no point or line {row.point!r}",
            where=row.where,
            expected="a point as `line:point`, its name or node alone, or the name of a line",
            fix=suggest(row.point, named) if len(named) < 10_000 else "Correct the name.",
        )
    return found


def _placed(row: GapTolerance, place: FloatArray, points: Points, mine: BoolArray, unit: str) -> IntArray:
    """The nearest points of the lines that take the table; none where another line is what lies there."""
    off = np.linalg.norm(points.positions - place, axis=1)
    if off.min(initial=np.inf) > REACH * points.size:
        nearest = int(off.argmin())
        raise InputError(
            f"no point within {REACH * points.size:.6g} {unit} of {row.name}: the nearest, {points.names[nearest]}, is "
            f"{off[nearest]:.6g} {unit} away",
            where=row.where,
            expected="a place on an E-line, in the deck's axes and units",
            fix='Correct it, name its unit in the head, as x [mm], or go by names: columns = { point = "..." }.',
        )
    least = np.where(mine, off, np.inf)
    if least.min() > REACH * points.size:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(least <= least.min() + SAME * points.size)


def _nominal_notes(file: str, rows: Sequence[GapTolerance], points: Points, at: IntArray, unit: str) -> list[str]:
    """Where nominal gaps of a table are not those of the model."""
    off = []
    for j in np.flatnonzero(at >= 0).tolist():
        row, gap = rows[int(at[j])], float(points.gap0[j])
        if row.nominal is not None and not -row.below <= gap - row.nominal <= row.above:
            off.append((abs(gap - row.nominal), j, row, gap))
    if not off:
        return []
    _, j, row, gap = max(off, key=lambda one: one[0])
    many = f" So are {len(off) - 1} more points." if len(off) > 1 else ""
    return [
        Warned(
            f"{file}: the nominal gap of {row.name} is {row.nominal:g} {unit}, and the gap of the model at "
            f"{points.names[j]} {gap:.4g} {unit}: they differ by more than the tolerance, -{row.below:g} "
            f"+{row.above:g} {unit} ({row.where}).{many} Margins are those of the model"
        )
    ]
