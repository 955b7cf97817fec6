"""Words for units in files of tests."""

from __future__ import annotations

import re

from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
MOTIONS = {
    **{name: (RECEPTANCE, m) for name, m in METRES.items()},
    **{f"{name}/s": (MOBILITY, m) for name, m in METRES.items()},
    **{f"{name}/s^2": (ACCELERANCE, m) for name, m in METRES.items()},
    "g": (ACCELERANCE, 9.80665),
}
"""Label of a unit -> what it counts, and what it is in m and s."""
NEWTONS = {"n": 1.0, "kn": 1e3, "lbf": 4.4482216152605, "lb": 4.4482216152605}


def plain_unit(unit: str) -> str:
    """`(m/sec**2)/N` as `m/s^2/n`."""
    text = re.sub(r"[\s()\[\]]", "", unit.lower()).replace("**", "^").replace("sec", "s").replace("µ", "u")
    return re.sub(r"s2$|s2(?=/)", "s^2", text.replace("²", "^2"))
