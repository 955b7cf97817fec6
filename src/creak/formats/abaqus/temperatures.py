"""Constants that depend on temperature, at the temperature that the deck states."""

from __future__ import annotations

import numpy as np

from creak.errors import InputError
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.numbers import floats, to_float
from creak.formats.abaqus.outline import Outline


def initial_temperature(deck: Outline) -> float | None:
    """The temperature of *INITIAL CONDITIONS, TYPE=TEMPERATURE; None: none is given, which is 0 in Abaqus.

    Raises
    ------
    InputError : it is not one number.
    """
    found: set[float] = set()
    where = ""
    for _, block in deck.blocks("INITIAL CONDITIONS"):
        if block.option("TYPE") == "TEMPERATURE":
            for fields, where in block.rows():
                if len(fields) > 1:
                    found.add(to_float(fields[1], where, "temperature"))
    if len(found) > 1:
        raise InputError(
            f"the deck starts at temperatures from {min(found):g} to {max(found):g}, and materials depend on them",
            expected="one temperature",
            where=where,
            fix="Keep the constants of one temperature in each material.",
        )
    return found.pop() if found else None


def at_temperature(deck: Outline, option: Block, count: int) -> tuple[list[float], str] | None:
    """The constants at the initial temperature, linear between lines, constant beyond; None: one entry only.

    Parameters
    ----------
    count : constants of an entry; its temperature stands after them.

    Raises
    ------
    InputError : the temperatures do not rise, or depend on more.
    """
    rows = list(option.rows())
    lines = -(-(count + 1) // 8)
    if option.has("DEPENDENCIES") or len(rows) <= -(-count // 8) or len(rows) % lines:
        return None
    entries = []
    for k in range(0, len(rows), lines):
        fields = [f for line, _ in rows[k : k + lines - 1] for f in [*line, *[""] * 8][:8]] + rows[k + lines - 1][0]
        entries.append(floats(fields, rows[k][1], f"constant of *{option.name}", count + 1))
    table = np.array(entries)
    if len(table) < 2:
        return None
    if not (np.diff(table[:, -1]) > 0.0).all():
        raise InputError(
            f"the temperatures of *{option.name} do not rise",
            where=rows[-1][1],
            expected="one line for each temperature, rising",
            fix="Sort the lines, or keep one.",
        )
    stated = initial_temperature(deck)
    t = stated or 0.0
    from_where = "of *INITIAL CONDITIONS" if stated is not None else "that Abaqus takes where none is given"
    deck.note(option, f"it depends on temperature; creak takes it at {t:g}, the one {from_where}", changes=False)
    return [float(np.interp(t, table[:, -1], table[:, i])) for i in range(count)], rows[0][1]
