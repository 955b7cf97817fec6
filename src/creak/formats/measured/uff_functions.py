"""Data set 58 of universal files: time responses, evenly sampled, real, as text.

Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.measured.channel import Channel
from creak.formats.measured.uff_sets import data_sets

FUNCTION = "58"
HEAD = 11
"""Lines before the values."""
WIDTHS = {2: 13, 4: 20}
"""Ordinate type -> characters of a number: real, single and double precision."""
TIME = 17
AXES = {1: "X", 2: "Y", 3: "Z", 4: "RX", 5: "RY", 6: "RZ", 0: ""}


def read_uff_functions(path: Path) -> list[Channel]:
    """The functions of time in a universal file; named by their first line, or by node and direction.

    Raises
    ------
    InputError : no such function in it, a binary one, one that is complex or unevenly sampled, or cut short.
    """
    found = []
    for one in data_sets(path):
        if one.number.startswith("58b"):
            raise InputError("a binary function (58b)", where=one.where(-1), fix="Export it as text (58).")
        if one.number == FUNCTION:
            if not one.ended:
                raise _short(path, one.at - 3)
            channel = _function(path, one.lines, one.at)
            if channel is not None:
                found.append(channel)
    if not found:
        raise InputError("no function of time (data set 58) in it", where=path, expected="abscissa in s (type 17)")
    return found


def _function(path: Path, lines: list[str], at: int) -> Channel | None:
    if len(lines) < HEAD:
        raise _short(path, at)
    try:
        kind, count, even = (int(lines[6][a : a + 10]) for a in (0, 10, 20))
        start, step = (float(lines[6][a : a + 13]) for a in (30, 43))
        abscissa = int(lines[7][:10])
    except ValueError as error:
        raise InputError("a function whose sixth and seventh records cannot be read", where=f"{path}:{at}") from error
    if abscissa != TIME:
        return None
    if kind not in WIDTHS or even != 1:
        raise InputError(
            "a function that is complex or unevenly sampled",
            where=f"{path}:{at}",
            expected="real values at even steps",
            fix="Export it so.",
        )
    values = _values(path, lines[HEAD:], WIDTHS[kind], at + HEAD)
    if values.size < count or count < 2 or not step > 0.0:
        raise _short(path, at)
    title, unit = lines[0].strip(), lines[8][47:67].strip()
    return Channel(title if title not in ("", "NONE") else _place(lines[5]), unit, start, step, values[:count])


def _values(path: Path, lines: list[str], width: int, at: int) -> FloatArray:
    found = []
    for k, line in enumerate(lines):
        for a in range(0, len(line.rstrip()), width):
            try:
                found.append(float(line[a : a + width].replace("D", "E")))
            except ValueError:
                found.append(math.nan)
            if not math.isfinite(found[-1]):
                text = line[a : a + width].strip()
                raise InputError(f"{text!r} is no number", where=f"{path}:{at + k}", expected="a sample")
    return np.array(found, dtype=np.float64)


def _place(line: str) -> str:
    """`1017 Z` of the response."""
    try:
        return f"{int(line[41:51])} {AXES.get(abs(int(line[51:55])), '')}".strip()
    except ValueError:
        return "NONE"


def _short(path: Path, at: int) -> InputError:
    return InputError("a function is cut short: it has fewer samples than it says", where=f"{path}:{at + 1}")
