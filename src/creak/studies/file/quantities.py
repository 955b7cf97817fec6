"""Numbers with their unit, as a study writes limits: "0.3 mm"."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any

from pydantic import BeforeValidator

from creak.model.units import METRES

LENGTHS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
"""m"""
FORM = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z]*)\s*")


def length_in(text: str, units: str) -> float:
    """A length like "0.3 mm" in the length of a system of units."""
    value, unit = _parts(text)
    return value * LENGTHS[unit] / METRES[units]


def _length(value: Any) -> str:
    """A length that is not negative, with its unit.

    Raises
    ------
    ValueError : no unit, another unit, a negative number, or no number at all.
    """
    known = ", ".join(LENGTHS)
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise ValueError(f'a length without its unit; write "{value} mm" (units: {known})')
    if not isinstance(value, str) or FORM.fullmatch(value) is None:
        raise ValueError(f'no length; write a number and its unit as "0.3 mm" (units: {known})')
    number, unit = _parts(value)
    if unit not in LENGTHS:
        what = f"the unit {unit!r} is none of a length" if unit else "a length without its unit"
        raise ValueError(f'{what}; write it as "{number:g} mm" (units: {known})')
    if number < 0.0 or not math.isfinite(number):
        raise ValueError("a length that is negative or not finite; write 0 or more")
    return value


def _parts(text: str) -> tuple[float, str]:
    found = FORM.fullmatch(text)
    assert found is not None
    return float(found[1]), found[2]


Length = Annotated[str, BeforeValidator(_length)]
"""A length of 0 or more with its unit: "0.3 mm"."""
