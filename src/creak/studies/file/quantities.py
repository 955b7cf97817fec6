"""Numbers with their unit, as a study writes limits: "0.3 mm", "2 sone"."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator

from creak.model import units
from creak.model.units import METRES

LENGTHS = {name: units.LENGTHS[name] for name in ("um", "mm", "cm", "m", "in")}
"""m"""
FORCES = {"mN": 1e-3, "N": 1.0, "kN": 1e3, "lbf": units.POUND}
"""N"""
SONES = {"sone": 1.0}
LEVELS = {"dB(A)": 1.0}
ACUMS = {"acum": 1.0}
ASPERS = {"asper": 1.0}
DECIBELS = {"dB": 1.0}
TIMES = {"ms": 1e-3, "s": 1.0}
"""s"""
FORM = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z()]*)\s*")


def length_in(text: str, units: str) -> float:
    """A length like "0.3 mm" in the length of a system of units."""
    value, unit = _parts(text)
    return value * LENGTHS[unit] / METRES[units]


def in_base(text: str) -> float:
    """A force in N, a loudness in sone, a level in dB(A), a sharpness in acum, a roughness in asper, a time in s."""
    value, unit = _parts(text)
    return value * (FORCES | SONES | LEVELS | ACUMS | ASPERS | DECIBELS | TIMES)[unit]


def _of(units: dict[str, float], what: str) -> Callable[[Any], str]:
    """Check of a quantity with one of these units, 0 or more; `what` is its name with its article."""
    known, usual = ", ".join(units), "mm" if "mm" in units else "N" if "N" in units else next(iter(units))

    def checked(value: Any) -> str:
        """Raise ValueError where there is no unit, another unit, a negative number, or no number at all."""
        if isinstance(value, int | float) and not isinstance(value, bool):
            raise ValueError(f'{what} without its unit; write "{value} {usual}" (units: {known})')
        if not isinstance(value, str) or FORM.fullmatch(value) is None:
            raise ValueError(
                f'no {what.split(" ", 1)[1]}; write a number and its unit as "0.3 {usual}" (units: {known})'
            )
        number, unit = _parts(value)
        if unit not in units:
            wrong = f"the unit {unit!r} is none of {what}" if unit else f"{what} without its unit"
            raise ValueError(f'{wrong}; write it as "{number:g} {usual}" (units: {known})')
        if number < 0.0 or not math.isfinite(number):
            raise ValueError(f"{what} that is negative or not finite; write 0 or more")
        return value

    return checked


def _parts(text: str) -> tuple[float, str]:
    found = FORM.fullmatch(text)
    assert found is not None
    return float(found[1]), found[2]


checked_length = _of(LENGTHS, "a length")
Length = Annotated[str, BeforeValidator(checked_length)]
"""A length of 0 or more with its unit: "0.3 mm"."""
Force = Annotated[str, BeforeValidator(_of(FORCES, "a force"))]
"""A force of 0 or more with its unit: "5 N"."""
LoudnessText = Annotated[str, BeforeValidator(_of(SONES, "a loudness"))]
"""A loudness of 0 or more with its unit: "2 sone"."""
LevelText = Annotated[str, BeforeValidator(_of(LEVELS, "a level"))]
"""A level of 0 or more with its unit and weighting: "40 dB(A)"."""
SharpnessText = Annotated[str, BeforeValidator(_of(ACUMS, "a sharpness"))]
"""A sharpness of 0 or more with its unit: "2 acum"."""
RoughnessText = Annotated[str, BeforeValidator(_of(ASPERS, "a roughness"))]
"""A roughness of 0 or more with its unit: "0.5 asper"."""
DecibelText = Annotated[str, BeforeValidator(_of(DECIBELS, "a number of decibels"))]
"""A difference of levels of 0 or more with its unit: "5 dB"."""
Time = Annotated[str, BeforeValidator(_of(TIMES, "a time"))]
"""A time of 0 or more with its unit: "0.2 s"."""
