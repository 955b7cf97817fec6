"""Words for units in files of tests."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from creak.errors import InputError
from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE
from creak.model.units import GRAVITY, LENGTHS, POUND

PER_SECOND = {RECEPTANCE: "", MOBILITY: "/s", ACCELERANCE: "/s^2"}
"""What a motion counts -> what follows its unit of length."""
MOTIONS = {f"{name}{by}": (of, m) for of, by in PER_SECOND.items() for name, m in LENGTHS.items()}
MOTIONS |= {"g": (ACCELERANCE, GRAVITY)}
"""Label of a unit -> what it counts, and what it is in m and s."""
BARE = {f"length{by}": of for of, by in PER_SECOND.items() if of != RECEPTANCE}
"""What stands for the unit of a velocity or an acceleration, in the length of the run, where a file tells none."""
NEWTONS = {"n": 1.0, "kn": 1e3, "lbf": POUND, "lb": POUND}
PASCALS = {"pa": 1.0, "": 1.0}
ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}
TURNS = {f"{name}{by}": (of, size) for of, by in PER_SECOND.items() for name, size in ANGLES.items()}
TURNS |= {"rpm": (MOBILITY, math.pi / 30.0)}
"""As `MOTIONS`, of rotations, in rad and s."""
MOMENTS = {f"{force}{arm}": n * LENGTHS[arm] for force, n in NEWTONS.items() for arm in ("m", "mm", "in", "ft")}
MOMENTS |= {f"{arm}lbf": POUND * LENGTHS[arm] for arm in ("in", "ft")}
"""Label of a unit, without the sign of the product -> N m."""
FACTORS = {
    1000.0: "metres and millimetres",
    GRAVITY: "g and m/s^2",
    LENGTHS["in"] / LENGTHS["mm"]: "inches and millimetres",
    POUND: "lbf and N",
}
NEAR = 0.05
"""Relative difference up to which a factor is one of these."""
SAME = 1e-3
"""Relative difference up to which two factors are one."""

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
HERTZ = {"Hz": 1.0, "kHz": 1e3, "1/s": 1.0, "rad/s": 0.5 / math.pi, "rpm": 1.0 / 60.0, "1/min": 1.0 / 60.0}
IN_BRACKETS = re.compile(r"\(((?:[^()]|\([^()]*\))*)\)\s*$")
NONE = "none"
"""What universal files write where there is no unit."""
WORDS = {r"sec(ond)?s?": "s", r"minutes?": "min", r"milli(?=s)": "m", r"micro(?=s)": "u", "hertz": "hz", "/s/s": "/s^2"}
WORDS |= {r"deg(ree)?s?|°": "deg", r"radians?": "rad"}
WORDS |= {r"[.*·⋅]?s(\^?-2|⁻²)": "/s^2", r"[.*·⋅]?s(\^?-1|⁻¹)": "/s"}


def mixed_up(ratio: float) -> list[tuple[float, str]]:
    """Factors that units make which a ratio between two levels, or its inverse, is near to, and the units."""
    size = max(ratio, 1.0 / ratio) if ratio > 0.0 else 1.0
    return [(factor, what) for factor, what in FACTORS.items() if abs(size / factor - 1.0) <= NEAR]


def plain_unit(unit: str) -> str:
    """`(m/sec**2)/N` and `m s^-2/N` as `m/s^2/n`; no unit, and `NONE`, as an empty text."""
    text = re.sub(r"[\s()\[\]]", "", unit.lower()).replace("**", "^").replace("µ", "u").replace("μ", "u")
    for word, short in WORDS.items():
        text = re.sub(word, short, text)
    return re.sub(r"s2$|s2(?=/)", "s^2", text.replace("²", "^2")) if text != NONE else ""


def name_and_unit(head: str) -> tuple[str, str]:
    """What the head of a column names, and its unit: `13 Z [um]`, or `13 Z (um)` where the word is a unit."""
    name, bracket, unit = head.partition("[")
    if not bracket and (match := IN_BRACKETS.search(head)) and plain_unit(match[1]) in {*MOTIONS, *NEWTONS, *PASCALS}:
        name, unit = head[: match.start()], match[1]
    return name.strip(), unit.strip().removesuffix("]").rstrip()


def unit_named(size: float, table: Mapping[str, float], base: str) -> str:
    """The name in a table of a unit of that size; `0.3 m` where none has it."""
    return next((name for name, each in table.items() if abs(size / each - 1.0) <= SAME), f"{size:.6g} {base}")


def scale_of(unit: str, table: Mapping[str, float], what: str, where: str) -> float:
    """What a unit is in the first one of `SECONDS` or `HERTZ`; 1 where none is told.

    Parameters
    ----------
    what : is counted in it, for messages.

    Raises
    ------
    InputError : the table does not know the unit.
    """
    known = {plain_unit(name): factor for name, factor in table.items()}
    first, word = next(iter(table)), plain_unit(unit)
    if word and word not in known:
        raise InputError(
            f"{what} are in {unit.strip(' []()')}",
            where=where,
            expected=f"one of {', '.join(table)}",
            fix=f"Correct the unit; without one it is {first}.",
        )
    return known.get(word, 1.0)
