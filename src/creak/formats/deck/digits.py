"""Numbers that read back exactly."""

from __future__ import annotations

import math
from collections.abc import Callable

STEPS = 8
"""Neighbouring floating-point numbers that `inverted` tries to either side."""


def inverted(function: Callable[[float], float], wanted: float, guess: float) -> float:
    """x near `guess` with function(x) == wanted to the last bit, the one with fewest digits first; else the guess."""
    tries = [float(f"{guess:.{digits}g}") for digits in range(1, 17)]
    low = high = guess
    for _ in range(STEPS):
        low, high = math.nextafter(low, -math.inf), math.nextafter(high, math.inf)
        tries += [low, high]
    return next((x for x in [*tries[:16], guess, *tries[16:]] if function(x) == wanted), guess)
