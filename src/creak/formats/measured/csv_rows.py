"""Rows of CSV text, with one message where a row cannot be read, and cells that no spreadsheet takes for a formula;
labels, values and titles as the text formats of results hold them."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
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


SMALLEST = 1e-99
"""Smaller values are written as 0: their exponent has three digits, which the fields cannot hold."""


def unique_labels(ids: IntArray) -> IntArray:
    """Labels as they are, or 1, 2, ... where they repeat."""
    return ids if np.unique(ids).size == ids.size else np.arange(1, ids.size + 1)


def holdable(values: FloatArray) -> FloatArray:
    """The values with 0 for those that are too small for a field."""
    return np.where(np.abs(values) < SMALLEST, 0.0, values)


def plain_text(words: str, width: int) -> str:
    """In ASCII and on one line; the end of it where it is too long."""
    return " ".join(words.split()).encode("ascii", "replace").decode()[-width:]
