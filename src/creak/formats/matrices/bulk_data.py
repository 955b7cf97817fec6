"""Cards of Nastran bulk data in small, large and free field."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.matrices.checks import number, read_text

_BEGIN_BULK = re.compile(r"\s*BEGIN\s+BULK\b", re.I)


@dataclass(frozen=True)
class Card:
    """One bulk data entry with its continuations."""

    name: str
    fields: tuple[str, ...]
    """Data fields from the second on, eight per small and four per large line, blank where not given."""
    where: str
    """File and line, for messages."""

    def text(self, i: int) -> str:
        return self.fields[i] if i < len(self.fields) else ""

    def integer(self, i: int, default: int | None = None) -> int:
        """Field i (from 0) as an integer; the default where it is blank."""
        text = self.text(i)
        if not text and default is not None:
            return default
        try:
            return int(text)
        except ValueError as error:
            raise InputError(f"field {i + 2} of {self.name} is {text!r}", where=self.where,
                             expected="an integer") from error  # fmt: skip

    def real(self, i: int, default: float | None = None) -> float:
        """Field i (from 0) as a real number, also in Nastran's short form 1.-3; the default where it is blank."""
        text = self.text(i)
        if not text and default is not None:
            return default
        try:
            value = number(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"field {i + 2} of {self.name} is {text!r}", where=self.where, expected="a real number")
        return value


def read_cards(path: Path) -> list[Card]:
    """All cards of a bulk data file (.asm, .pch, .bdf); what stands before BEGIN BULK is skipped.

    INCLUDE files are not followed.
    """
    lines = read_text(path).splitlines()
    begin = next((i for i, line in enumerate(lines, start=1) if _BEGIN_BULK.match(line)), 0)
    found: list[tuple[str, list[str], str]] = []
    for i, raw in enumerate(lines[begin:], start=begin + 1):
        line = raw.split("$")[0].expandtabs(8).rstrip()
        if not line:
            continue
        head, fields = _split(line)
        if head and head[0] not in "+*":
            found.append((head.rstrip("*").strip().upper(), fields, f"{path}:{i}"))
        elif found:
            found[-1][1].extend(fields)
    return [Card(name, tuple(fields), where) for name, fields, where in found]


def _split(line: str) -> tuple[str, list[str]]:
    """First field and the data fields of one line."""
    if "," in line:
        head, *items = (item.strip() for item in line.split(","))
    else:
        head = line[:8].strip()
        width = 16 if "*" in head else 8
        items = [line[i : i + width].strip() for i in range(8, 72, width)]
    count = 4 if "*" in head else 8
    return head, (items + [""] * count)[:count]


def id_list(card: Card, start: int = 0) -> Iterator[int]:
    """Ids of a list with THRU, from field `start` on."""
    fields = [text.upper() for text in card.fields[start:]]
    i = 0
    while i < len(fields):
        if not fields[i]:
            i += 1
        elif i + 2 < len(fields) and fields[i + 1] == "THRU":
            yield from range(card.integer(start + i), card.integer(start + i + 2) + 1)
            i += 3
        else:
            yield card.integer(start + i)
            i += 1


def free_card(name: str, fields: Iterable[object], per_line: int = 8) -> str:
    """A free-field card; with per_line = 4 in large field, whose numbers keep their digits."""
    items = ["" if f is None else str(f) for f in fields]
    star = "*" if per_line == 4 else ""
    lines = [",".join([star if i else name + star, *items[i : i + per_line]]) for i in range(0, len(items), per_line)]
    return "\n".join(lines) + "\n"


def real(value: float) -> str:
    """Shortest decimal that reads back exactly, with Nastran's double precision exponent."""
    text = repr(float(value)).upper().replace("E", "D")
    return text if "." in text or "D" in text else f"{text}."
