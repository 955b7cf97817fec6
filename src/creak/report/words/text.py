"""Numbers as words for people."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from creak.model.units import UNITS

MINUS = "\N{MINUS SIGN}"
NONE = "\N{EN DASH}"
THIN = "\N{NARROW NO-BREAK SPACE}"


def with_minus(text: str) -> str:
    """A sentence of the terminal for the page: minus signs before numbers in place of hyphens."""
    return re.sub(r"(?<![^\s(=])-(?=\d)", MINUS, text)


def number(value: float | int | None, digits: int = 4) -> str:
    """A number with `digits` significant digits; whole numbers in full, thousands apart.

    >>> number(14859), number(0.0012345), number(1.2e-9)
    """
    if value is None or not math.isfinite(value):
        return NONE
    if isinstance(value, int):
        return f"{value:,}".replace(",", THIN).replace("-", MINUS)
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if exponent < -4 or exponent > 8:
        mantissa, power = f"{value:.{max(digits - 2, 0)}e}".split("e")
        return f"{mantissa}e{int(power)}".replace("-", MINUS)
    text = f"{value:,.{max(digits - 1 - exponent, 0)}f}"
    return text.replace(",", THIN).replace("-", MINUS)


def force_unit(summary: Mapping[str, Any]) -> str:
    """Of the forces of a result."""
    return UNITS[summary["units"]].force


def tidy(value: float) -> str:
    """A number that a person wrote, as it was written: 10, 0.5, 1500."""
    if value == 0.0 or 1e-4 <= abs(value) < 1e9:
        text = f"{value:.9f}".rstrip("0").rstrip(".")
        return text.replace("-", MINUS) if float(f"{value:.9g}") == float(text) else number(value, 6)
    return number(value, 4)


def fixed(value: float | None, decimals: int) -> str:
    """A number with so many decimals, for columns that line up."""
    if value is None or not math.isfinite(value):
        return NONE
    text = f"{value:,.{decimals}f}"
    if float(text.replace(",", "")) == 0.0:
        text = text.lstrip("-")
    return text.replace(",", THIN).replace("-", MINUS)


def four(value: float | None) -> str:
    """Four decimals, cut rather than rounded where rounding would lift a value to the bar of .99."""
    if value is None:
        return NONE
    if value < 0.99 <= round(value, 4):
        value = math.floor(value * 1e4) / 1e4
    return fixed(value, 4) if value > -10.0 else number(value, 3)


def percent(ratio: float | None, decimals: int = 1) -> str:
    """A ratio minus one as per cent: 1.005 -> +0.5 %."""
    if ratio is None or not math.isfinite(ratio):
        return NONE
    value = round(100.0 * (ratio - 1.0), decimals) + 0.0
    sign = "+" if value > 0.0 else ""
    return f"{sign}{value:.{decimals}f}{THIN}%".replace("-", MINUS)


def share(fraction: float | None) -> str:
    """A fraction as per cent, tiny ones as a bound: 0.0326 -> 3.3 %, 1e-10 -> below 0.001 %."""
    if fraction is None or not math.isfinite(fraction):
        return NONE
    value = 100.0 * fraction
    if 0.0 < abs(value) < 1e-3:
        return f"below 0.001{THIN}%"
    return f"{number(value, 2) if value else '0'}{THIN}%"


def ratio(a: float | None, b: float | None) -> float | None:
    """a / b where that is a number."""
    if a is None or b is None or not b:
        return None
    return a / b


def plural(count: int, noun: str) -> str:
    """`1 event`, `3 events`, `no events`."""
    return f"{number(count) if count else 'no'} {noun}{'' if count == 1 else 's'}"


def as_sentence(note: str) -> str:
    """A note with a capital and a full stop."""
    return f"{note[:1].upper()}{note[1:]}."


def times(factor: float) -> str:
    """A speed-up in words: `190 times`, `1.7 times`."""
    return f"{factor:.1f} times" if factor < 10.0 else f"{number(round(factor))} times"


def setting(value: Any) -> str:
    """A value of a study."""
    if value is None:
        return NONE
    return f"{value:g}" if isinstance(value, float) else str(value)
