"""Rows of CSV text, with one message where a row cannot be read, and cells that no spreadsheet takes for a formula."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from creak.errors import InputError

NAMES = {",": "commas", ";": "semicolons", "\t": "tabs"}
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""How a cell starts that a spreadsheet computes."""


def csv_rows(
    lines: Iterable[str], path: Path, separator: str = ",", *, start: int = 0
) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row.

    Parameters
    ----------
    start : lines of the file before these.

    Raises
    ------
    InputError : a cell is longer than the 131,072 characters that Python's reader takes, or holds a zero byte.
    """
    rows = csv.reader(lines, delimiter=separator)
    while True:
        try:
            row = next(rows)
        except StopIteration:
            return
        except csv.Error as error:
            raise InputError(
                f"this row cannot be read ({error})",
                where=f"{path}:{start + rows.line_num}",
                expected=f"cells with {NAMES[separator]} between them",
                fix="Is this a CSV file? Look for a quote without its partner.",
            ) from error
        yield start + rows.line_num, row


def plain_cell(value: object) -> object:
    """Text that starts like a formula gets a quote before it, as spreadsheets ask for; numbers stay."""
    if not isinstance(value, str) or not value.startswith(FORMULA):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def plain_row(row: Sequence[object]) -> list[object]:
    """All cells of a row so."""
    return [plain_cell(value) for value in row]
