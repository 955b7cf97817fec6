"""CSV files that a study points to."""

from __future__ import annotations

import codecs
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file, will_read
from creak.formats.measured.csv_rows import SEPARATORS, csv_rows, number, separator_of
from creak.formats.measured.files import chosen_channel, is_measured
from creak.formats.measured.unit_words import SECONDS, name_and_unit, scale_of
from creak.given import LARGEST, SMALLEST, computable

POINTS = "Write decimals with a point, or semicolons between the cells, and leave out further columns."
FIRST = "Put it into the first line, with commas, semicolons or tabs between the names, and nothing before it."
MOST_BEFORE = 200
"""Lines before the first row of numbers that are looked at."""
KEPT = 16
"""Signals in memory that were read last."""


def read_table(path: Path, where: str, header: tuple[str, str] = ("time", "value")) -> tuple[FloatArray, FloatArray]:
    """Both columns, each (n,), of a CSV file with that header; the first increases.

    Raises
    ------
    InputError : no such file, wrong header, a value that is no finite number, a first column that does not increase.
    """
    return _increasing(path, read_rows(path, where, "table", [*header]), header)


def _increasing(path: Path, rows: Rows, header: tuple[str, str]) -> tuple[FloatArray, FloatArray]:
    try:
        values = np.array([row for _, row in rows]).astype(np.float64)
    except ValueError:  # uneven rows, decimals after a comma, or no numbers
        values = np.zeros(0)
    if values.shape != (len(rows), 2) or not (np.abs(values) <= LARGEST).all():
        values = np.array([row_numbers(path, i, row, header) for i, row in rows]).reshape(-1, 2)
    values[np.abs(values) < SMALLEST] = 0.0
    if values.shape[0] < 2:
        raise InputError(f"the table has {values.shape[0]} row(s)", where=path, expected="two or more")
    back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if back.size:
        line = rows[int(back[0]) + 1][0]
        raise InputError(f"{header[0]} does not increase", where=f"{path}:{line}", fix="Sort the rows, drop doubles.")
    return values[:, 0], values[:, 1]


@dataclass(frozen=True, eq=False)
class Samples:
    """A course in time as its file has it; the same one for all who ask."""

    time: FloatArray
    """(n,) s"""
    value: FloatArray
    """(n,)"""
    unit: str
    """Empty where the file tells none."""

    def __post_init__(self) -> None:
        self.time.flags.writeable = self.value.flags.writeable = False


def read_signal(path: Path, channel: str | None, where: str) -> Samples:
    """A course in time of a CSV file, RPC III or a universal file; read once as long as the file stays as it is.

    Parameters
    ----------
    channel : name or number (from 1) of a channel; of a CSV file the name of a column, the first of which is time.
        None: the only one; of a CSV file the column `value`, or the only one beside time.

    Raises
    ------
    InputError : no such file or channel; cut short; a value that is no finite number; times that do not increase.
    """
    will_read(path)
    return _read_signal(path, channel, where, _stamp(path))


@lru_cache(maxsize=KEPT)
def _read_signal(path: Path, channel: str | None, where: str, stamp: tuple[int, int] | None) -> Samples:
    if is_measured(path):
        found = chosen_channel(path, int(channel) if channel is not None and channel.isdigit() else channel, where)
        if not np.isfinite(found.values).all() or np.abs(found.values).max(initial=0.0) > LARGEST:
            raise InputError(f"channel {found.name!r} has values that are no numbers", where=path)
        return Samples(found.time, found.values, found.unit)
    lines = read_lines(path, where, "table")
    _refuse_before_heads(path, lines)
    header, rows = header_of(lines, path)
    column = channel or _only_column(path, lines)
    if channel is None and header[:2] == ["time", "value"]:
        return Samples(*_increasing(path, rows, ("time", "value")), "")
    return Samples(*table_column(path, header, rows, column), name_and_unit(column)[1])


def _stamp(path: Path) -> tuple[int, int] | None:
    """What changes when a file is written: when that was, in ns, and its bytes; None: there is no such file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def _only_column(path: Path, lines: Sequence[str]) -> str:
    """`value`, or the only column beside time, as its head is written: the first of the lines.

    Raises
    ------
    InputError : there are several, or no heads.
    """
    first = next((line for line in lines if line.strip()), "")
    written = [cell.strip() for _, row in csv_rows([first.rstrip(" ,;")], path, separator_of(first)) for cell in row]
    if [cell.lower() for cell in written[:2]] == ["time", "value"]:
        return "value"
    named = [cell for cell in written[1:] if cell and not np.isfinite(number(cell)) and cell.lower() != "time"]
    if len(written) == 2 and named:
        return written[1]
    raise InputError(
        f"the table starts with {','.join(written) or 'nothing'}",
        where=f"{path}:1",
        expected="the header time,value, or times and one column with a name",
        fix=f"Name the column in the study: channel = {named[0]!r}." if named else FIRST,
    )


def table_column(path: Path, header: list[str], rows: Rows, channel: str) -> tuple[FloatArray, FloatArray]:
    """Time in s and values, each (n,), of a column of a table that `read_header` read; the first column is time.

    Raises
    ------
    InputError : no such column; a value that is no finite number; times that do not increase, or in no known unit.
    """
    if channel.lower() not in header[1:]:
        raise InputError(
            f"the table has no column {channel!r}", where=f"{path}:1", fix=suggest(channel.lower(), header[1:])
        )
    k = header.index(channel.lower(), 1)
    for i, row in rows:
        if any(cell.strip() for cell in row[len(header) :]):
            raise InputError(
                f"the row {','.join(row)!r} has {len(row)} values",
                where=f"{path}:{i}",
                expected=f"{len(header)}, as the head has names: {','.join(header)}",
                fix=POINTS,
            )
    narrow = [(i, [row[0], row[k]] if k < len(row) else [row[0]]) for i, row in rows]
    time, values = _increasing(path, narrow, (header[0], channel))
    return head_of_axis(path, header[0], SECONDS, "the times")[1] * time, values


def head_of_axis(path: Path, head: str, table: Mapping[str, float], what: str) -> tuple[str, float]:
    """Name of a first column, `time [ms]`, and what its unit is in the first one of a table; 1 without one.

    Raises
    ------
    InputError : as `scale_of`.
    """
    name, _, unit = head.replace("(", "[").replace(")", "]").partition("[")
    return name.strip(), scale_of(unit, table, what, f"{path}:1")


Rows = list[tuple[int, list[str]]]
"""Line numbers and cells."""


def read_rows(path: Path, where: str, kind: str, header: list[str]) -> Rows:
    """Rows with something in them, and their line numbers, of a CSV file whose first columns have these names.

    Parameters
    ----------
    where : of the key that names the file. kind : what messages call it.

    Raises
    ------
    InputError : no such file, unreadable, wrong header.
    """
    found, rows = read_header(path, where, kind)
    if found[: len(header)] != header:
        raise InputError(
            f"the table starts with {','.join(found) or 'nothing'}",
            where=f"{path}:1",
            expected=f"the header {','.join(header)}",
            fix="Put it into the first line.",
        )
    return rows


def read_header(path: Path, where: str, kind: str) -> tuple[list[str], Rows]:
    """The first row, in small letters, and the others that have something in them. Between the cells are commas,
    semicolons or tabs, as in the first row.

    Raises
    ------
    InputError : no such file, or unreadable.
    """
    return header_of(read_lines(path, where, kind), path)


def header_of(lines: Sequence[str], path: Path) -> tuple[list[str], Rows]:
    """The same of lines that `read_lines` read."""
    separator = separator_of(next((line for line in lines if line.strip()), ""))
    rows = [(i, row) for i, row in csv_rows(lines, path, separator) if any(cell.strip() for cell in row)]
    return [cell.strip().lower() for cell in rows[0][1]] if rows else [], rows[1:]


def _refuse_before_heads(path: Path, lines: Sequence[str]) -> None:
    """Name what stands before the heads of columns in time, as loggers write it; a row of units is none of that.

    Raises
    ------
    InputError : there is something.
    """
    before = list[tuple[int, list[str]]]()
    for at, line in enumerate(lines[:MOST_BEFORE], start=1):
        if any(_is_numbers(line.split(separator)) for separator in SEPARATORS):
            break
        if line.strip():
            before.append((at, [cell.strip() for cell in line.split(separator_of(line))]))
    else:
        return
    if len(before) < 2:
        return
    at, head = before[-1]
    units = head[0].strip("[]() ").lower() in SECONDS
    if len(head) > 1 and not units and not any(np.isfinite(number(cell)) for cell in head):
        raise InputError(
            f"the heads of the columns stand in line {at}: {', '.join(head)}",
            where=f"{path}:1",
            expected="the heads in the first line",
            fix=f"Delete the lines before line {at}.",
        )


def _is_numbers(cells: Sequence[str]) -> bool:
    return len(cells) > 1 and all(np.isfinite(number(cell)) for cell in cells if cell.strip())


def read_lines(path: Path, where: str, kind: str) -> list[str]:
    """Lines of a text file: UTF-8, UTF-16 where it starts with the mark of that, else Latin-1.

    Raises
    ------
    InputError : no such file, unreadable, or no text.
    """
    try:
        data = plain_file(path, where).read_bytes()
        marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        if b"\0" in data and not marked:
            raise InputError(f"{path} is no text", where=where, expected=f"a {kind} in CSV", fix="Export it as CSV.")
        encoding = "utf-16" if marked else "utf-8-sig"
        try:
            return data.decode(encoding).splitlines()
        except UnicodeDecodeError:
            return data.decode("latin-1").splitlines()
    except FileNotFoundError as error:
        raise InputError(f"no such {kind}: {path}", where=where, fix="Check the path.") from error
    except OSError as error:
        raise InputError(f"cannot read the {kind} {path}: {error}", where=where) from error


def row_numbers(path: Path, line: int, row: list[str], header: Sequence[str]) -> list[float]:
    """The numbers of a row, as many as the header has names.

    Raises
    ------
    InputError : a cell that is no finite number, too few of them, or too many.
    """
    count, names = len(header), ",".join(header)
    words = {2: "two"}.get(count, str(count))
    numbers = [computable(number(cell)) for cell in row[:count]]
    if len(row) > count and any(cell.strip() for cell in row[count:]):
        raise InputError(
            f"the row {','.join(row)!r} has {len(row)} values",
            where=f"{path}:{line}",
            expected=f"{words}: {names}",
            fix=POINTS,
        )
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise InputError(
            f"got {','.join(row)!r}",
            where=f"{path}:{line}",
            expected=f"{words} finite numbers: {names}",
            fix="Repair the row."
            if np.isfinite(numbers).any()
            else "Drop the row: units stand in the head, as in acc [m/s2].",
        )
    return numbers
