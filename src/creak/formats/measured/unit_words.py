"""Words for units in files of tests."""

from __future__ import annotations

import re

from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE
from creak.model.units import GRAVITY, LENGTHS, POUND

MOTIONS = {
    **{name: (RECEPTANCE, m) for name, m in LENGTHS.items()},
    **{f"{name}/s": (MOBILITY, m) for name, m in LENGTHS.items()},
    **{f"{name}/s^2": (ACCELERANCE, m) for name, m in LENGTHS.items()},
    "g": (ACCELERANCE, GRAVITY),
}
"""Label of a unit -> what it counts, and what it is in m and s."""
NEWTONS = {"n": 1.0, "kn": 1e3, "lbf": POUND, "lb": POUND}

SECONDS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}


def plain_unit(unit: str) -> str:
    """`(m/sec**2)/N` as `m/s^2/n`."""
    text = re.sub(r"[\s()\[\]]", "", unit.lower()).replace("**", "^").replace("sec", "s").replace("µ", "u")
    return re.sub(r"s2$|s2(?=/)", "s^2", text.replace("²", "^2"))
