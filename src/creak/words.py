"""Numbers and lists in plain words, for messages, advice and the terminal; pages have `report.words.text`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from itertools import islice
from typing import Any

ROUND_OFF = 1e-6
"""Per cent below which nothing is left but round-off."""
FEW = 5
"""Names that a sentence gives of many."""


def percent(x: float, digits: int = 2) -> str:
    """A share: `0.34 %`, `54 %`, `120 %`, `0 %` for what is round-off."""
    size = abs(100.0 * x)
    return f"{100.0 * x:.{digits}g} %" if ROUND_OFF <= size < 10.0 ** (digits - 1) else f"{100.0 * x:.0f} %"


def listed(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def first_few(items: Collection[Any], most: int = FEW, name: Callable[[Any], str] = str) -> str:
    """`a, b and 7 more`: the names of the first `most` items, and how many there are besides."""
    shown = ", ".join(map(name, islice(items, most)))
    return f"{shown} and {len(items) - most} more" if len(items) > most else shown


def duration(seconds: float) -> str:
    """`21 us`, `4.2 ms`, `38 s`, `12 min`, `5.2 h`."""
    if seconds < 1e-3:
        return f"{_two_digits(1e6 * seconds)} us"
    if seconds < 0.1:
        return f"{_two_digits(1e3 * seconds)} ms"
    if seconds < 100.0:
        return f"{_two_digits(seconds)} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{_two_digits(seconds / 3600.0)} h"


def _two_digits(x: float) -> str:
    """At least two digits, and no power of ten of what is large."""
    return f"{x:.2g}" if x < 99.5 else f"{x:.0f}"
