"""CSV files that a study points to."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.csv_rows import csv_rows
from creak.model.magnitude import computable


def read_table(path: Path, where: str, header: tuple[str, str] = ("time", "value")) -> tuple[FloatArray, FloatArray]:
    """Both columns, each (n,), of a CSV file with that header; the first increases.

    Raises
    ------
    InputError : no such file, wrong header, a value that is no finite number, a first column that does not increase.
    """
    rows = read_rows(path, where, "table", [*header])
    values = np.array([_numbers(path, i, row, ",".join(header)) for i, row in rows]).reshape(-1, 2)
    if values.shape[0] < 2:
        raise InputError(f"the table has {values.shape[0]} row(s)", where=path, expected="two or more")
    back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if back.size:
        line = rows[int(back[0]) + 1][0]
        raise InputError(f"{header[0]} does not increase", where=f"{path}:{line}", fix="Sort the rows, drop doubles.")
    return values[:, 0], values[:, 1]


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
    return read_one_of(path, where, kind, [header])[1]


def read_one_of(path: Path, where: str, kind: str, headers: list[list[str]]) -> tuple[list[str], Rows]:
    """The same with the header, of several, that the file has."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except FileNotFoundError as error:
        raise InputError(f"no such {kind}: {path}", where=where, fix="Check the path.") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read the {kind} {path}: {error}", where=where) from error
    rows = [(i, row) for i, row in csv_rows(lines, path) if any(cell.strip() for cell in row)]
    found = [cell.strip().lower() for cell in rows[0][1]] if rows else []
    known = next((h for h in headers if found[: len(h)] == h), None)
    if known is None:
        raise InputError(
            f"the table starts with {','.join(found) or 'nothing'}",
            where=f"{path}:1",
            expected=f"the header {' or '.join(','.join(h) for h in headers)}",
            fix="Put it into the first line.",
        )
    return known, rows[1:]


def _numbers(path: Path, line: int, row: list[str], header: str) -> list[float]:
    try:
        numbers = [computable(float(cell)) for cell in row[:2]]
    except ValueError:
        numbers = []
    if len(row) > 2 and any(cell.strip() for cell in row[2:]):
        raise InputError(
            f"the row {','.join(row)!r} has {len(row)} values",
            where=f"{path}:{line}",
            expected=f"two: {header}",
            fix="Write decimals with a point, and leave out further columns.",
        )
    if len(numbers) != 2 or not np.isfinite(numbers).all():
        raise InputError(
            f"got {','.join(row)!r}",
            where=f"{path}:{line}",
            expected=f"two finite numbers: {header}",
            fix="Repair the row.",
        )
    return numbers
