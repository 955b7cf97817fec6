"""Numbers that can be computed with: products of them, and their fourth powers, stay within floating point."""

from __future__ import annotations

import math

LARGEST = 1e60
SMALLEST = 1e-60


def computable(value: float) -> float:
    """The number; 0 where it is nearer to it than `SMALLEST`, nan where it is not finite or beyond `LARGEST`."""
    if not abs(value) <= LARGEST:
        return math.nan
    return value if abs(value) >= SMALLEST else 0.0
