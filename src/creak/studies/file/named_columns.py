"""CSV files as spreadsheets and programs of the trade write them: columns by their names, wherever the head is."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.measured.csv_rows import SEPARATORS, csv_rows, number
from creak.model.units import METRES
from creak.studies.file.quantities import LENGTHS
from creak.studies.file.tables import read_lines

HEAD = 200
"""Lines in which the names of the columns are looked for."""
REMARK = re.compile(r"\s*(#|//|!|%|\$|\*)\s*")
UNIT = re.compile(r"\s*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*|(?:\s+|_|/)(um|µm|mm|cm|m)\s*$", re.IGNORECASE)
OF_UNITS = re.compile(r"\b(units?|einheit(en)?)\b", re.IGNORECASE)
OTHER_LENGTHS = ("ft", "foot", "feet", "dm", "km")
SIGNS = {"+/-": "plusminus", "±": "plusminus", "−": "-"}


@dataclass(frozen=True)
class Wanted:
    """What a kind of file may have in its columns."""

    kind: str
    """What messages call it."""
    forms: tuple[tuple[str, ...], ...]
    """Columns that it has to have; the first of them that fits."""
    synonyms: Mapping[str, str]
    """A name in a file, in small letters and digits alone -> the column that it means; a sign before or behind it is
    `plus` or `minus`."""
    lengths: frozenset[str]
    """Columns of lengths."""
    headers: str
    """The forms in words."""


@dataclass(frozen=True)
class ColumnTable:
    """Rows of a file."""

    path: Path
    form: tuple[str, ...]
    """One of the forms of its kind."""
    head: tuple[str, ...]
    """All names in the file."""
    head_line: int
    """Where they stand."""
    lines: tuple[int, ...]
    """Line of each row in the file."""
    cells: Mapping[str, tuple[str, ...]]
    """Column -> its text in each row."""
    scale: Mapping[str, float]
    """Column of lengths -> the length of the study in one of its file."""

    def where(self, row: int) -> str:
        """file:line"""
        return f"{self.path}:{self.lines[row]}"

    def numbers(self, row: int, columns: Sequence[str]) -> list[float]:
        """The coordinates in a row, in the length of the study.

        Raises
        ------
        InputError : one of them is missing or no finite number.
        """
        texts = [self.cells[column][row] for column in columns]
        values = [number(text) * self.scale.get(column, 1.0) for text, column in zip(texts, columns, strict=True)]
        if not all(map(math.isfinite, values)):
            raise InputError(
                f"got {','.join(texts)!r}",
                where=self.where(row),
                expected=f"three finite numbers: {','.join(columns)}",
                fix="Repair the row.",
            )
        return values

    def number(self, row: int, column: str) -> float | None:
        """The number in a cell, a length in that of the study; None: the cell is blank, or there is no such column.

        Raises
        ------
        InputError : text that is no finite number.
        """
        text = self.cells[column][row] if column in self.cells else ""
        if not text:
            return None
        value = number(text) * self.scale.get(column, 1.0)
        if not math.isfinite(value):
            raise InputError(
                f"got {text!r} for {column}",
                where=self.where(row),
                expected="a finite number",
                fix="Repair the row, or leave the cell blank.",
            )
        return value


def read_columns(path: Path, where: str, wanted: Wanted, named: Mapping[str, str], units: str) -> ColumnTable:
    """The rows of a CSV file.

    The columns may be in any order, with others beside them, between semicolons, tabs or commas, below lines of a head.
    Lengths are in the unit that the head names, as `x1 [mm]` or `units: mm`; without one in that of the study.

    Parameters
    ----------
    where : of the key that names the file. named : column -> what the file calls it; the others go by their synonyms.
    units : of the study.

    Raises
    ------
    InputError : no such file, or unreadable; no line that names the columns of one of the forms; a name that stands
        twice; an unknown unit; no rows; a row that is longer than the head.
    """
    lines = read_lines(path, where, wanted.kind)
    found = next(_heads(lines, wanted, named), None)
    if found is None:
        raise _no_head(path, where, lines, wanted, named)
    at, separator, head = found
    columns = _columns(path, at, head, wanted, named)
    form = next(form for form in wanted.forms if set(form) <= columns.keys())
    rows = [(i, [c.strip() for c in row]) for i, row in csv_rows(lines[at + 1 :], path, separator, start=at + 1)]
    rows = [(i, row) for i, row in rows if any(row) and not REMARK.match(row[0])]
    below = _units_row(rows[0][1], columns, wanted) if rows else {}
    rows = rows[1:] if below else rows
    if not rows:
        raise InputError(
            f"the {wanted.kind} has no rows", where=path, expected=f"{','.join(form)} lines", fix="Add them."
        )
    for i, row in rows:
        if any(row[len(head) :]):
            raise InputError(
                f"the row {separator.join(row)!r} has {len(row)} cells, and the head {len(head)}",
                where=f"{path}:{i}",
                expected="one cell for each column",
                fix="Put semicolons between the cells where decimals have a comma.",
            )
    cells = {name: tuple(row[k] if k < len(row) else "" for _, row in rows) for name, k in columns.items()}
    told = {name: _unit(head[k]) or below.get(name) or _declared(lines[:at]) for name, k in columns.items()}
    scale = {name: _scale(path, at, told[name], units) for name in columns if name in wanted.lengths}
    _require_alike(path, at, {name: told[name] for name in scale})
    return ColumnTable(path, form, tuple(head), at + 1, tuple(i for i, _ in rows), cells, scale)


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in REMARK.sub("", line, count=1).split(separator)]


def _heads(lines: Sequence[str], wanted: Wanted, named: Mapping[str, str]) -> Iterator[tuple[int, str, list[str]]]:
    """Row, separator and cells of the lines that name the columns of a form."""
    for at, line in enumerate(lines[:HEAD]):
        for separator in SEPARATORS:
            cells = _cells(line, separator)
            known = {meaning(cell, wanted, named) for cell in cells}
            if any(set(form) <= known for form in wanted.forms) and {_plain(n) for n in named.values()} <= set(
                map(_plain, cells)
            ):
                yield at, separator, cells


def meaning(cell: str, wanted: Wanted, named: Mapping[str, str]) -> str | None:
    """The column that a name in the head stands for."""
    own = {_plain(name): column for column, name in named.items()}
    if _plain(cell) in own:
        return own[_plain(cell)]
    bare = UNIT.sub("", cell, count=1) if UNIT.search(cell) else cell
    meant = wanted.synonyms.get(_letters(bare))
    return None if meant in named else meant


def _letters(name: str) -> str:
    """A name in small letters and digits, a sign before or behind it in words."""
    for sign, word in SIGNS.items():
        name = name.replace(sign, word)
    name = re.sub(r"^\s*\+|\+\s*$", "plus", name)
    name = re.sub(r"^\s*-|-\s*$", "minus", name)
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _plain(name: str) -> str:
    return " ".join(name.lower().split())


def _columns(path: Path, at: int, head: list[str], wanted: Wanted, named: Mapping[str, str]) -> dict[str, int]:
    columns: dict[str, int] = {}
    for k, cell in enumerate(head):
        meant = meaning(cell, wanted, named)
        if meant in columns:
            raise InputError(
                f"the columns {head[columns[meant]]!r} and {cell!r} are both {meant}",
                where=f"{path}:{at + 1}",
                expected="one of them",
                fix=f'Say which: columns = {{ {meant} = "{cell}" }}.',
            )
        if meant is not None:
            columns[meant] = k
    return columns


def _no_head(path: Path, where: str, lines: Sequence[str], wanted: Wanted, named: Mapping[str, str]) -> InputError:
    if named:
        names = ", ".join(repr(name) for name in named.values())
        return InputError(
            f"no line of {path} names the columns {names} and all that belongs to them",
            where=where,
            expected=wanted.headers,
            fix="Name them in columns as the file does.",
        )
    written = [k for k, line in enumerate(lines[:HEAD]) if line.strip()] or [0]
    known = (
        [max(sum(meaning(c, wanted, {}) is not None for c in _cells(lines[k], s)) for s in SEPARATORS) for k in written]
        if lines
        else [0]
    )
    best = written[known.index(max(known))]
    return InputError(
        f"the table starts with {lines[best].strip()[:80] if lines else 'nothing'}",
        where=f"{path}:{best + 1}",
        expected=f"the header {wanted.headers}",
        fix="Put it before the rows, or say in columns what the file calls them.",
    )


def _unit(cell: str) -> str | None:
    """The unit in a name such as `x1 [mm]`."""
    found = UNIT.search(cell)
    return None if found is None else found[1] or found[2]


def _units_row(row: list[str], columns: Mapping[str, int], wanted: Wanted) -> dict[str, str]:
    """Units below the names: nothing but units, and for lengths each has one."""
    texts = {name: row[k].strip("[]() ") for name, k in columns.items() if k < len(row) and name in wanted.lengths}
    return texts if texts and all(_in_letters(text) in LENGTHS for text in texts.values()) else {}


def _declared(lines: Sequence[str]) -> str | None:
    """The unit that a line above the names tells, as `units: mm`, or `units in mm`."""
    words = [word for line in lines if OF_UNITS.search(line) for word in re.findall(r"[A-Za-zµμ]+", line)]
    found = [word for word in words if _in_letters(word) in (*LENGTHS, *OTHER_LENGTHS)]
    return next((word for word in found if word.lower() != "in"), found[0] if found else None)


def _in_letters(unit: str) -> str:
    """A unit in small letters, its micro sign as u, inches in short."""
    return re.sub("^inch(es)?$", "in", unit.lower().replace("µ", "u").replace("μ", "u"))


def _require_alike(path: Path, at: int, told: Mapping[str, str | None]) -> None:
    """Coordinates have a unit all or none, and so have distances: nobody means one of them alone."""
    for own in ([n for n in told if n[0] in "xyz"], [n for n in told if n[0] not in "xyz"]):
        known, unknown = [n for n in own if told[n]], [n for n in own if not told[n]]
        if known and unknown:
            raise InputError(
                f"the unit {told[known[0]]} stands for {', '.join(known)} and none for {', '.join(unknown)}",
                where=f"{path}:{at + 1}",
                expected="a unit for each of them, or none for any",
                fix="Complete the head.",
            )


def _scale(path: Path, at: int, unit: str | None, units: str) -> float:
    if unit is None:
        return 1.0
    known = _in_letters(unit)
    if known not in LENGTHS:
        raise InputError(
            f"the unit {unit!r} is none of a length",
            where=f"{path}:{at + 1}",
            expected=", ".join(LENGTHS),
            fix="Correct the head.",
        )
    return LENGTHS[known] / METRES[units]
