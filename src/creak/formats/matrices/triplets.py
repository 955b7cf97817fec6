"""Text files with one matrix entry per line."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from scipy import sparse

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.matrices.checks import compact, number, read_text

LARGEST = 2.0**53
"""Of a label: what a float holds exactly."""


def read_table(path: Path, columns: int, what: str) -> FloatArray:
    """(lines, columns) numbers separated by commas or blanks; lines that start with *, % or # are comments.

    Raises
    ------
    InputError : the file is missing or empty, or a line does not have that many numbers; it names the line.
    """
    lines = read_text(path).splitlines()
    data = [line for line in lines if _is_entry(line)]
    if not data:
        raise InputError("there are no entries", where=path, expected=what, fix="Copy or write the file again")
    try:
        table = np.loadtxt([line.replace(",", " ") for line in data], comments=None, ndmin=2)
    except ValueError:
        table = np.empty((0, 0))
    table = table if table.shape[1] == columns else _line_by_line(lines, columns, what, path)
    labels = table[:, :-1]
    wrong = np.flatnonzero(~((np.abs(labels) < LARGEST) & (labels == np.rint(labels))).all(axis=1))
    if wrong.size:
        line = next(itertools.islice((i for i, text in enumerate(lines, 1) if _is_entry(text)), int(wrong[0]), None))
        raise _no_entry(lines[line - 1], what, f"{path}:{line}")
    return table


def _is_entry(line: str) -> bool:
    return bool(line.strip()) and line.strip()[0] not in "*%#"


def _no_entry(line: str, what: str, where: str) -> InputError:
    return InputError(
        f"{line.strip()!r} is no entry of a matrix",
        where=where,
        expected=what,
        fix="If this is the last line, the file was cut off: copy it again",
    )


def _line_by_line(lines: list[str], columns: int, what: str, path: Path) -> FloatArray:
    """The same for Fortran's ways to write a number, and to find the line that is wrong."""
    rows = []
    for i, line in enumerate(lines, start=1):
        if not _is_entry(line):
            continue
        try:
            rows.append([number(cell) for cell in line.replace(",", " ").split()])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != columns:
            raise _no_entry(line, what, f"{path}:{i}")
    return np.array(rows)


def from_entries(rows: IntArray, columns: IntArray, values: FloatArray, n: int) -> Matrix:
    """n x n matrix; an entry whose mirror image is not listed stands for both (one triangle is enough)."""
    given = sparse.csr_array((values, (rows, columns)), shape=(n, n))
    listed = sparse.csr_array((np.ones(rows.size), (rows, columns)), shape=(n, n))
    listed.data[:] = 1.0
    alone = listed - listed.multiply(listed.T)
    return compact(sparse.csr_array(given + given.multiply(alone).T))


def lower_entries(matrix: FloatArray) -> tuple[IntArray, IntArray]:
    """Rows and columns of the lower triangle's entries that are not zero, and of the whole diagonal."""
    lower = np.tril(matrix) != 0.0
    np.fill_diagonal(lower, True)
    i, j = np.nonzero(lower)
    return i.astype(np.int64), j.astype(np.int64)
