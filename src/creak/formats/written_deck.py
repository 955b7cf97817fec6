"""A deck on its way to a file: numbers that read back exactly, and all of it read back before it appears."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from creak.errors import InputError
from creak.formats.complete_file import complete_file, write_bytes

STEPS = 8
"""Neighbouring floating-point numbers that `inverted` tries to either side."""


def write_checked(path: str | Path, text: str, lost: Callable[[Path], str], *, kind: str, source: str) -> None:
    """Write a deck; the file appears only if nothing of the model is lost.

    Parameters
    ----------
    lost : reads the deck and returns what it lacks of the model, in words; empty: nothing.
    kind : "an Abaqus" or "a Nastran" deck, for messages. source : where the model comes from.

    Raises
    ------
    InputError : the file cannot be written there, or the deck does not read back as the model.
    WriteError : the disk is full, or fails.
    """
    with complete_file(Path(path)) as partial:
        write_bytes(partial, text.encode("utf-8"))
        missing = _said(lost, partial)
        if missing:
            raise InputError(
                f"the model cannot be written as {kind} deck without a loss: {missing}",
                where=source,
                fix="Change this in the model, or keep the deck as it is.",
            )


def _said(lost: Callable[[Path], str], path: Path) -> str:
    """What is lost, or why the deck cannot be read at all."""
    try:
        return lost(path)
    except InputError as error:
        return f"{error.what} {error.expected}".strip()


def inverted(function: Callable[[float], float], wanted: float, guess: float) -> float:
    """x near `guess` with function(x) == wanted to the last bit, the one with fewest digits first; else the guess."""
    tries = [float(f"{guess:.{digits}g}") for digits in range(1, 17)]
    low = high = guess
    for _ in range(STEPS):
        low, high = math.nextafter(low, -math.inf), math.nextafter(high, math.inf)
        tries += [low, high]
    return next((x for x in [*tries[:16], guess, *tries[16:]] if function(x) == wanted), guess)
