"""Data sets of a universal file: lines between two marks of -1, with where they stand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import plain_file

MARK = "-1"


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
    InputError : no plain file. OSError : it is not there, or may not be read.
    """
    lines = plain_file(path).read_text(encoding="latin-1").splitlines()
    marks = [k for k, line in enumerate(lines) if line.strip() == MARK]
    return [
        DataSet(path, lines[a + 1].strip(), lines[a + 2 : b], a + 3, b < len(lines))
        for a, b in zip(marks[::2], [*marks[1::2], len(lines)], strict=False)
        if a + 1 < len(lines)
    ]
