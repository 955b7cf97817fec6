"""CSV files that a study points to."""

from __future__ import annotations

import codecs
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.csv_rows import csv_rows, number, separator_of
from creak.formats.measured.files import chosen_channel, is_measured
from creak.formats.measured.unit_words import SECONDS, name_and_unit, scale_of
from creak.model.magnitude import LARGEST, computable

HEAD = 1 << 16
"""Bytes in which the first line of a table ends."""


def read_table(path: Path, where: str, header: tuple[str, str] = ("time", "value")) -> tuple[FloatArray, FloatArray]:
    """Both columns, each (n,), of a CSV file with that header; the first increases.

    Raises
    ------
    InputError : no such file, wrong header, a value that is no finite number, a first column that does not increase.
    """
    return _increasing(path, read_rows(path, where, "table", [*header]), header)


def _increasing(path: Path, rows: Rows, header: tuple[str, str]) -> tuple[FloatArray, FloatArray]:
    values = np.array([row_numbers(path, i, row, header) for i, row in rows]).reshape(-1, 2)
    if values.shape[0] < 2:
        raise InputError(f"the table has {values.shape[0]} row(s)", where=path, expected="two or more")
    back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if back.size:
        line = rows[int(back[0]) + 1][0]
        raise InputError(f"{header[0]} does not increase", where=f"{path}:{line}", fix="Sort the rows, drop doubles.")
    return values[:, 0], values[:, 1]


def read_signal(path: Path, channel: str | None, where: str) -> tuple[FloatArray, FloatArray]:
    """Time and values, each (n,), of a course in time: a CSV file, RPC III or a universal file.

    Parameters
    ----------
    channel : name or number (from 1) of a channel; of a CSV file the name of a column, the first of which is time.
        None: the only one; of a CSV file the column `value`, or the only one beside time.

    Raises
    ------
    InputError : no such file or channel; cut short; a value that is no finite number; times that do not increase.
    """
    if is_measured(path):
        found = chosen_channel(path, _name_or_number(channel), where)
        if not np.isfinite(found.values).all() or np.abs(found.values).max(initial=0.0) > LARGEST:
            raise InputError(f"channel {found.name!r} has values that are no numbers", where=path)
        return found.time, found.values
    lines = read_lines(path, where, "table")
    header, rows = header_of(lines, path)
    if channel is None and header[:2] == ["time", "value"]:
        return _increasing(path, rows, ("time", "value"))
    return table_column(path, header, rows, channel or _only_column(path, lines))


def _only_column(path: Path, lines: Sequence[str]) -> str:
    """`value`, or the only column beside time, as its head is written: the first of the lines.

    Raises
    ------
    InputError : there are several, or no heads.
    """
    first = next((line for line in lines if line.strip()), "")
    written = [cell.strip() for _, row in csv_rows([first], path, separator_of(first)) for cell in row]
    if [cell.lower() for cell in written[:2]] == ["time", "value"]:
        return "value"
    named = [cell for cell in written[1:] if cell and not np.isfinite(number(cell))]
    if len(written) == 2 and named:
        return written[1]
    raise InputError(
        f"the table starts with {','.join(written) or 'nothing'}",
        where=f"{path}:1",
        expected="the header time,value, or times and one column with a name",
        fix=f"Name the column in the study: channel = {named[0]!r}." if named else "Put it into the first line.",
    )


def _name_or_number(channel: str | None) -> str | int | None:
    return int(channel) if channel is not None and channel.isdigit() else channel


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
    narrow = [(i, [row[0], row[k]] if k < len(row) else [row[0]]) for i, row in rows]
    time, values = _increasing(path, narrow, (header[0], channel))
    return head_of_axis(path, header[0], SECONDS, "the times")[1] * time, values


def signal_unit(path: Path, channel: str | None, where: str) -> str:
    """The unit that a file tells of a course in time; empty where it tells none. Parameters and errors as
    `read_signal`; of a CSV file the head of the column tells it."""
    if is_measured(path):
        return chosen_channel(path, _name_or_number(channel), where).unit
    return name_and_unit(channel or _only_column(path, read_lines(path, where, "table", HEAD)))[1]


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


def read_lines(path: Path, where: str, kind: str, most: int = -1) -> list[str]:
    """Lines of a text file: UTF-8, UTF-16 where it starts with the mark of that, else Latin-1.

    Parameters
    ----------
    most : bytes that are read, whose last line may be cut; -1: all.

    Raises
    ------
    InputError : no such file, or unreadable.
    """
    try:
        with plain_file(path, where).open("rb") as file:
            data = file.read(most)
        encoding = "utf-16" if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"
        try:
            return codecs.getincrementaldecoder(encoding)().decode(data, final=most < 0).splitlines()
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
            fix="Write decimals with a point, or semicolons between the cells, and leave out further columns.",
        )
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise InputError(
            f"got {','.join(row)!r}",
            where=f"{path}:{line}",
            expected=f"{words} finite numbers: {names}",
            fix="Repair the row.",
        )
    return numbers
