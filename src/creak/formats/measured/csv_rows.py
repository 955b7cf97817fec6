"""Rows of CSV text, with one message where a row cannot be read, and cells that no spreadsheet takes for a formula."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from creak.errors import InputError

SEPARATORS = (";", "\t", ",")
NAMES = {",": "commas", ";": "semicolons", "\t": "tabs"}
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d*(?:[eE][+-]?\d+)?")
QUOTED = re.compile(r'"[^"]*"')
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


def separator_of(head: str) -> str:
    """What stands between the cells of a head: the one of `SEPARATORS` that is there most often outside of quotes."""
    bare = QUOTED.sub("", head)
    return max(SEPARATORS, key=bare.count) if any(s in bare for s in SEPARATORS) else ","


def number(text: str) -> float:
    """The number in a cell, its decimals after a point or a comma; nan: there is none."""
    text = text.strip().replace("−", "-")
    try:
        return float(text.replace(",", ".") if DECIMAL_COMMA.fullmatch(text) else text)
    except ValueError:
        return math.nan


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
