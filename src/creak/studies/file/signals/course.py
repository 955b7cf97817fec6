"""What a signal of a study says of itself: its frequencies, its period, what it can drive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from creak.arrays import FloatArray
from creak.signals.signal import Signal
from creak.studies.file.table import Finite, Table

Shown = Callable[[float], str]
"""A number as its reader wants it."""


class Course(Table):
    """What a signal says of itself; so say those that know no better. Each has `words(unit, shown)` for the page."""

    stated: ClassVar[bool] = False
    """Whether `highest` is all that it holds."""

    @property
    def highest(self) -> float:
        """Highest frequency that it is known to hold, Hz; 0: not known."""
        return 0.0

    @property
    def repeats(self) -> float | None:
        """s after which it begins again."""
        return None

    @property
    def fade(self) -> float:
        """s over which motion that it prescribes fades in."""
        return 0.0

    @property
    def resolving(self) -> float | None:
        """s of the longest flight step, where the highest frequency does not tell it."""
        return None

    @property
    def random(self) -> int | None:
        """Seed of its random phases."""
        return None

    def made(self) -> Signal | None:
        """The function of time; None: its points are in a file."""
        return None

    def check(self, kind: str, dof: str) -> None:
        """Raise ValueError where an excitation of a kind along a dof cannot have it."""


def columns(points: list[tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
    """Both columns of a table."""
    table = np.array(points, dtype=np.float64)
    return table[:, 0], table[:, 1]


Points = Annotated[list[tuple[Finite, Finite]], Field(min_length=1)]
"""[[time, value], ...], s, times that increase."""
PER_FLANK = 5.0
"""Flight steps in a flank of a trapezoid or of a smooth step."""


def check_lines(f_min: float, f_max: float, period: float, most: int) -> None:
    """Raise ValueError for more lines than a signal may have, or none: they are whole multiples of 1 / period."""
    if (lines := (f_max - f_min) * period) > most:
        raise ValueError(
            f"{lines:.3g} lines, 1 / {period:g} s apart from {f_min:g} to {f_max:g} Hz: a signal has at most {most:,}; "
            "shorten what it repeats after, or the band"
        )
    if np.floor(f_max * period + 1e-9) < max(1.0, np.ceil(f_min * period - 1e-9)):
        raise ValueError(
            f"what repeats after {period:g} s has lines at whole multiples of {1.0 / period:g} Hz, none of them "
            f"between {f_min:g} and {f_max:g} Hz"
        )
