"""Nastran punch files, read back column by column."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

REAL = re.compile(r" +-?\d\.\d{6}E[+-]\d\d")
"""1PE18.6 or 1PE16.6."""


@dataclass
class Output:
    """One block of data: its head, and a row for each point or instant."""

    head: list[str]
    rows: dict[int | float, list[float]] = field(default_factory=dict)

    def after(self, start: str) -> str:
        """What follows the start of a line of the head."""
        (found,) = (line[len(start) :].strip() for line in self.head if line.startswith(start))
        return found


def reals(text: str) -> list[float]:
    """Three fields of 18 columns."""
    assert len(text) == 54
    found = [text[k : k + 18] for k in (0, 18, 36)]
    assert all(REAL.fullmatch(x) for x in found), text
    return [float(x) for x in found]


def punched(path) -> list[Output]:
    """All blocks; every line has 80 columns, the last eight its number."""
    lines = path.read_bytes().decode("ascii").split("\n")
    assert lines.pop() == ""
    found: list[Output] = []
    before = ""
    for number, line in enumerate(lines, start=1):
        assert len(line) == 80
        assert line[72:] == f"{number:8d}"
        first, data = line[:18], line[18:72]
        if line.startswith("$"):
            if line.startswith("$TITLE   ="):
                found.append(Output([]))
            found[-1].head.append(line[:72].rstrip())
        elif first == "-CONT-" + " " * 12:
            assert before not in ("", "-CONT-")
            rows = found[-1].rows
            rows[next(reversed(rows))] += reals(data)
        else:
            by_time = any("IDENTIFIED BY TIME" in words for words in found[-1].head)
            assert first[17] == "G"
            assert REAL.fullmatch(first[:16]) if by_time else first[:10].strip().isdigit()
            assert first[16 if by_time else 10 : 17].strip() == ""
            key = float(first[:16]) if by_time else int(first[:10])
            assert key not in found[-1].rows
            found[-1].rows[key] = reals(data)
        before = line[:6]
    return found
