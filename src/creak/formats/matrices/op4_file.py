"""Matrices of a Nastran OUTPUT4 file: binary of both endiannesses and word lengths, and text; dense and sparse.

Layout: MSC Nastran DMAP Programmer's Guide, OUTPUT4. A matrix is a header (columns, rows, form, type, name), one record
per column that is not zero (column, first row, words, values) and a closing record with the column number past the
last. First row 0 means strings: (words + 1, row) where the header gives the number of rows as negative (BIGMAT),
else one packed number row + 65536 (words + 1).
"""

from __future__ import annotations

import re
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import number, read_bytes

SYMMETRIC_FORM, REAL_DOUBLE = 6, 2
_WORDS = {1: 1, 2: 2, 3: 2, 4: 4}
"""Words of four bytes per value by type: real single, real double, complex single, complex double."""
LARGEST = 10**9
"""Entries of a matrix: 8 GB."""


@dataclass(frozen=True)
class Header:
    columns: int
    rows: int
    big: bool
    """Strings carry their row as a number of its own."""
    kind: int
    name: str

    def empty(self) -> FloatArray:
        if self.rows * self.columns > LARGEST:
            raise _Incomplete(f"its header says that {self.name} is {self.rows} x {self.columns}, beyond {LARGEST:,}")
        return np.zeros((self.rows, self.columns))


class _Incomplete(ValueError):
    """The file ends too early or its records do not follow the format."""


def read_op4_matrices(path: Path, wanted: Collection[str]) -> dict[str, FloatArray]:
    """The matrices of these names, as arrays; of matrices with the same name the first.

    Raises
    ------
    InputError : the file is missing, cut off or no OUTPUT4 file, or a wanted matrix is complex.
    """
    data = read_bytes(path)
    binary = data[:4] in (b"\x18\0\0\0", b"\0\0\0\x18", b"\x30\0\0\0", b"\0\0\0\x30")
    try:
        return _read_binary(data, wanted, path) if binary else _read_text(data, wanted, path)
    except _Incomplete as error:
        raise InputError(
            f"this is no complete OUTPUT4 file: {error}",
            where=path,
            fix="Copy it again in binary mode, or write it again",
        ) from error


def _store(found: dict[str, FloatArray], header: Header, matrix: FloatArray | None, path: Path) -> None:
    if matrix is None or header.name in found:
        return
    if header.kind > REAL_DOUBLE:
        raise InputError(
            f"matrix {header.name} is complex",
            where=path,
            expected="real matrices",
            fix="Write stiffness and structural damping as separate real matrices",
        )
    found[header.name] = matrix


def _place(matrix: FloatArray | None, values: NDArray, row: int, column: int) -> None:
    """Put values into a column from this row (from 1) on."""
    if matrix is None or np.iscomplexobj(values):
        return
    if not (row >= 1 and row - 1 + values.size <= matrix.shape[0] and 1 <= column <= matrix.shape[1]):
        raise _Incomplete(f"row {row} of column {column} lies outside the {' x '.join(map(str, matrix.shape))} matrix")
    matrix[row - 1 : row - 1 + values.size, column - 1] = values


# ------------------------------------------------------------------------------------------------ binary
def _records(data: bytes, order: str) -> Iterator[memoryview]:
    """Fortran records: length, bytes, length."""
    view, at = memoryview(data), 0
    while at < len(data):
        if at + 4 > len(data):
            raise _Incomplete(f"it ends within the record at byte {at}")
        (length,) = struct.unpack_from(order + "i", data, at)
        end = at + 4 + length
        if length < 0 or end + 4 > len(data) or struct.unpack_from(order + "i", data, end)[0] != length:
            raise _Incomplete(f"it ends within the record at byte {at}")
        yield view[at + 4 : end]
        at = end + 4


def _read_binary(data: bytes, wanted: Collection[str], path: Path) -> dict[str, FloatArray]:
    order = "<" if data[0] else ">"
    found: dict[str, FloatArray] = {}
    records = _records(data, order)
    for record in records:
        header, word = _binary_header(record, order)
        matrix = header.empty() if header.name in wanted else None
        _read_columns(records, header, matrix, order, word)
        _store(found, header, matrix, path)
    return found


def _binary_header(record: memoryview, order: str) -> tuple[Header, int]:
    """Header and bytes per word."""
    if len(record) not in (24, 48):
        raise _Incomplete(f"a matrix header of {len(record)} bytes, not 24 or 48")
    word = len(record) // 6
    columns, rows, _form, kind = np.frombuffer(record[: 4 * word], dtype=f"{order}i{word}").tolist()
    name = bytes(record[4 * word :]).decode("latin-1").strip().upper()
    return _header(columns, rows, kind, name), word


def _header(columns: int, rows: int, kind: int, name: str) -> Header:
    if kind not in _WORDS or columns < 0:
        raise _Incomplete(f"matrix {name!r} has {columns} columns and type {kind}")
    return Header(columns, abs(rows), rows < 0, kind, name)


def _read_columns(
    records: Iterator[memoryview], header: Header, matrix: FloatArray | None, order: str, word: int
) -> None:
    double = word == 8 or header.kind in (2, 4)
    letter, size = ("f", 4) if header.kind <= REAL_DOUBLE else ("c", 8)
    kind = np.dtype(f"{order}{letter}{2 * size if double else size}")
    whole = np.dtype(f"{order}i{word}")
    for record in records:
        if len(record) < 3 * word:
            raise _Incomplete(f"a column record of {len(record)} bytes in matrix {header.name}")
        column, row, words = np.frombuffer(record[: 3 * word], dtype=whole).tolist()
        if column > header.columns:
            return
        body = record[3 * word : (3 + words) * word]
        if len(body) != words * word:
            raise _Incomplete(f"column {column} of matrix {header.name} has fewer words than announced")
        if row > 0:
            _place(matrix, _values(body, kind), row, column)
        elif matrix is not None:
            for first, values in _strings(body, header, whole, kind):
                _place(matrix, values, first, column)
    raise _Incomplete(f"matrix {header.name} has no closing record")


def _values(body: memoryview, kind: np.dtype) -> NDArray:
    return np.frombuffer(body[: len(body) - len(body) % kind.itemsize], dtype=kind)


def _strings(body: memoryview, header: Header, whole: np.dtype, kind: np.dtype) -> Iterator[tuple[int, NDArray]]:
    """(first row, values) of each string of a sparse column."""
    word, at = whole.itemsize, 0
    while at < len(body):
        if header.big and at + 2 * word > len(body):
            raise _Incomplete(f"a string of matrix {header.name} is cut off")
        head = np.frombuffer(body[at : at + (2 if header.big else 1) * word], dtype=whole).tolist()
        row, words = (head[1], head[0] - 1) if header.big else (head[0] % 65536, head[0] // 65536 - 1)
        at += len(head) * word
        if words < 1 or at + words * word > len(body):
            raise _Incomplete(f"a string of matrix {header.name} is cut off")
        yield row, _values(body[at : at + words * word], kind)
        at += words * word


# ------------------------------------------------------------------------------------------------ text
class _Lines:
    """The lines of a file, looked at one ahead."""

    def __init__(self, data: bytes) -> None:
        self.lines = [line for line in data.decode("latin-1").splitlines() if line.strip()]
        self.at = 0

    @property
    def ended(self) -> bool:
        return self.at >= len(self.lines)

    def next(self) -> str:
        if self.ended:
            raise _Incomplete(f"it ends after line {self.at}")
        self.at += 1
        return self.lines[self.at - 1]

    def values(self, kind: int) -> NDArray:
        """All numbers up to the next line of integers."""
        numbers: list[float] = []
        while not self.ended and "." in self.lines[self.at] and not _HEADER.match(self.lines[self.at]):
            line = self.next()
            if _NUMBER.sub("", line).strip():
                raise _Incomplete(f"line {self.at} is no line of numbers")
            numbers += [number(text) for text in _NUMBER.findall(line)]
        values = np.array(numbers)
        if kind > REAL_DOUBLE and values.size % 2:
            raise _Incomplete(f"line {self.at} ends within a complex number")
        return values if kind <= REAL_DOUBLE else values[0::2] + 1j * values[1::2]

    def integers(self) -> list[int]:
        line = self.next()
        try:
            return [int(c) for c in line.split()]
        except ValueError as error:
            raise _Incomplete(f"line {self.at} should be integers, it is {line.strip()!r}") from error


_HEADER = re.compile(r"^([ \d]{8})([- \d]{8})([ \d]{8})([ \d]{8})(\S.{7})\s*(?:1P,?)?\s*\d*[ED]\d+\.\d+", re.I)
_NUMBER = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+)(?:[ED][-+]?\d{1,3}|[-+]\d{3})?", re.I)
"""Neighbours may touch: 1.5E+00-2.5E+00; an exponent of three digits may have lost its E."""


def _read_text(data: bytes, wanted: Collection[str], path: Path) -> dict[str, FloatArray]:
    lines = _Lines(data)
    found: dict[str, FloatArray] = {}
    while not lines.ended:
        match = _HEADER.match(lines.next())
        if not match or not all(match[i].strip() for i in range(1, 5)):
            raise _Incomplete(f"line {lines.at} is no matrix header such as '  12  12   6   2KXX     1P,3E23.16'")
        columns, rows, _form, kind = (int(match[i]) for i in range(1, 5))
        header = _header(columns, rows, kind, match[5].strip().upper())
        matrix = header.empty() if header.name in wanted else None
        _read_text_columns(lines, header, matrix)
        _store(found, header, matrix, path)
    if not found and not data.strip():
        raise _Incomplete("it is empty")
    return found


def _read_text_columns(lines: _Lines, header: Header, matrix: FloatArray | None) -> None:
    while True:
        head = lines.integers()
        if len(head) != 3:
            raise _Incomplete(f"line {lines.at} is no column header of matrix {header.name}")
        column, row, words = head
        if column > header.columns:
            if not lines.values(REAL_DOUBLE).size:
                raise _Incomplete(f"matrix {header.name} has no closing number")
            return
        if row > 0:
            values = lines.values(header.kind)
            _check_count(values, words, header, lines)
            _place(matrix, values, row, column)
        else:
            _read_text_strings(lines, header, matrix, column, words)


def _read_text_strings(lines: _Lines, header: Header, matrix: FloatArray | None, column: int, words: int) -> None:
    while words > 0:
        head = lines.integers()
        if len(head) != (2 if header.big else 1):
            raise _Incomplete(f"line {lines.at} is no string header of matrix {header.name}")
        row, length = (head[1], head[0] - 1) if header.big else (head[0] % 65536, head[0] // 65536 - 1)
        values = lines.values(header.kind)
        _check_count(values, length, header, lines)
        _place(matrix, values, row, column)
        words -= len(head) + length


def _check_count(values: NDArray, words: int, header: Header, lines: _Lines) -> None:
    """Text files count numbers or words of four bytes, depending on the program that wrote them."""
    numbers = values.size * (1 if header.kind <= REAL_DOUBLE else 2)
    if words not in (numbers, values.size * _WORDS[header.kind]):
        raise _Incomplete(
            f"matrix {header.name} announces {words} words before line {lines.at + 1}, there are {numbers} numbers"
        )


# ------------------------------------------------------------------------------------------------ writing
def write_op4_matrices(matrices: dict[str, FloatArray], path: Path) -> None:
    """Write symmetric real matrices: binary, little endian, 32-bit integers, double precision, dense columns."""
    with complete_file(path) as partial, partial.open("wb") as file:
        for name, matrix in matrices.items():
            rows, columns = matrix.shape
            head = struct.pack("<4i8s", columns, rows, SYMMETRIC_FORM, REAL_DOUBLE, f"{name:<8s}".encode("ascii"))
            file.write(_framed(head))
            for j in range(columns):
                filled = np.flatnonzero(matrix[:, j])
                if filled.size:
                    values = matrix[filled[0] : filled[-1] + 1, j]
                    file.write(_framed(_column(j + 1, int(filled[0]) + 1, values)))
            file.write(_framed(_column(columns + 1, 1, np.ones(1))))


def _column(column: int, row: int, values: FloatArray) -> bytes:
    return struct.pack("<3i", column, row, 2 * values.size) + values.astype("<f8").tobytes()


def _framed(payload: bytes) -> bytes:
    length = struct.pack("<i", len(payload))
    return length + payload + length
