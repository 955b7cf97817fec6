"""Data sets of a universal file: lines between two marks of -1, with where they stand.

A binary one (58b) has eleven lines, then bytes.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import plain_file

MARK = re.compile(rb"^[ \t]*-1[ \t]*\r?$", re.MULTILINE)
AFTER_BYTES = re.compile(rb"\s*-1[ \t]*\r?$", re.MULTILINE)
BEHIND_BYTES = re.compile(rb"    -1[ \t]*\r?$", re.MULTILINE)
"""The mark behind bytes, which may end no line: where they are as many as the head says, and where they are more."""
BINARY = "58b"
ORDERS = {1: "<", 2: ">"}
IEEE = 2


@dataclass(frozen=True)
class DataSet:
    """One data set; `lines` are those after its number."""

    path: Path
    number: str
    lines: list[str]
    at: int
    """Line of the file that `lines` begins with."""
    ended: bool
    """The mark at its end is there."""
    data: bytes = b""
    """What follows the lines of a binary one."""
    order: str = ""
    """Of its bytes: < or >."""

    def where(self, row: int = 0) -> str:
        """file:line"""
        return f"{self.path}:{self.at + row}"

    def line(self, row: int) -> str:
        """A line.

        Raises
        ------
        InputError : the set is cut short.
        """
        if row >= len(self.lines):
            raise self.short()
        return self.lines[row]

    def integers(self, row: int, count: int = 0, width: int = 10) -> list[int]:
        """The whole numbers in the fields of a line, the first `count` of them, or as many as there are."""
        text = self.line(row)
        fields = [text[a : a + width] for a in range(0, count * width or len(text.rstrip()), width)]
        try:
            return [int(field) for field in fields]
        except ValueError as error:
            raise InputError(
                f"{text.rstrip()!r} cannot be read",
                where=self.where(row),
                expected=f"{count or 'some'} whole numbers in fields of {width} characters",
                fix="Export the file again.",
            ) from error

    def numbers(self, row: int, start: int = 0, width: int = 13) -> list[float]:
        """The numbers in the fields of a line from a column on.

        Raises
        ------
        InputError : one of them is no finite number.
        """
        text, found = self.line(row).rstrip(), []
        for a in range(start, len(text), width):
            field = text[a : a + width]
            try:
                value = float(field.replace("D", "E").replace("d", "e"))
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise InputError(f"{field.strip()!r} is no number", where=self.where(row), fix="Export the file again.")
            found.append(value)
        return found

    def short(self) -> InputError:
        """The one message for a file that ends too early."""
        return InputError(
            f"data set {self.number} is cut short",
            where=self.where(max(len(self.lines) - 1, 0)),
            fix="Export it again.",
        )


def data_sets(path: Path) -> list[DataSet]:
    """All data sets of a file, in its order.

    Raises
    ------
    InputError : no plain file, or the head of a binary set cannot be read. OSError : it is not there, or may not be
        read.
    """
    raw = plain_file(path).read_bytes()
    raw = raw if b"\n" in raw else raw.replace(b"\r", b"\n")
    found, start, line = list[DataSet](), 0, 1
    while mark := MARK.search(raw, start):
        line += raw.count(b"\n", start, mark.end()) + 1
        head, text = _line(raw, mark.end() + 1)
        words = head.split()
        if not words:
            break
        is_binary = words[0].lower() == BINARY
        end = MARK.search(raw, text)
        if is_binary:
            order, lines, size = _binary(words, f"{path}:{line}")
            data = text
            for _ in range(lines):
                data = _line(raw, data)[1]
            end = AFTER_BYTES.match(raw, data + size) or BEHIND_BYTES.search(raw, data + size)
            stop = end.start() if end else len(raw)
            one = DataSet(path, BINARY, _lines(raw[text:data]), line + 1, end is not None, raw[data:stop], order)
        else:
            stop = end.start() if end else len(raw)
            one = DataSet(path, words[0], _lines(raw[text:stop]), line + 1, end is not None)
        found.append(one)
        if end is None:
            break
        start = end.end()
        line += raw.count(b"\n", mark.end() + 1, start)
    return found


def _line(raw: bytes, start: int) -> tuple[str, int]:
    """A line, and where the next one starts."""
    end = raw.find(b"\n", start)
    end = len(raw) if end < 0 else end
    return raw[start:end].decode("latin-1"), min(end + 1, len(raw))


def _lines(raw: bytes) -> list[str]:
    return [line.decode("latin-1") for line in raw.splitlines()]


def _binary(words: list[str], where: str) -> tuple[str, int, int]:
    """Order of the bytes, number of lines and of bytes that follow."""
    try:
        order, form, lines, size = map(int, words[1:5])
    except ValueError as error:
        raise InputError(
            "the head of a binary function (58b) cannot be read", where=where, fix="Export it again, or as text (58)."
        ) from error
    if order not in ORDERS or form != IEEE or min(lines, size) < 0:
        raise InputError(
            f"a binary function (58b) of byte order {order} and format {form}",
            where=where,
            expected=f"byte order 1 or 2, format {IEEE} (IEEE)",
            fix="Export it as text (58).",
        )
    return ORDERS[order], lines, size
