"""Systems of units that a study can name: what their results are labelled with, and what they are in SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

UnitsName = Literal["mm-t-s", "m-kg-s", "in-lbf-s"]


@dataclass(frozen=True)
class Units:
    """Labels of the quantities in a system of units, and its length and mass."""

    length: str
    force: str
    energy: str
    stress: str
    density: str
    mass: str
    per_metre: float
    """Units of length in 1 m."""
    to_kg: float
    """Unit of mass in kg."""
    time: str = "s"

    @property
    def newton(self) -> float:
        """N in the unit of force."""
        return self.to_kg / self.per_metre

    @property
    def speed(self) -> str:
        return f"{self.length}/{self.time}"

    @property
    def stiffness(self) -> str:
        return f"{self.force}/{self.length}"

    def of_motion(self, turns: bool) -> tuple[str, str]:
        """Of how far something moves, or turns, and of what pushes, or turns, it."""
        return ("rad", f"{self.force} {self.length}") if turns else (self.length, self.force)

    @property
    def impulse(self) -> str:
        return f"{self.force} {self.time}"


LENGTHS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
"""m in units of length that files and people write."""
GRAVITY = 9.80665
"""m/s^2 in 1 g."""
POUND = 4.4482216152605
"""N in 1 lbf."""
INCH = LENGTHS["in"]
UNITS: dict[str, Units] = {
    "mm-t-s": Units("mm", "N", "mJ", "MPa", "t/mm^3", "t", 1000.0, 1000.0),
    "m-kg-s": Units("m", "N", "J", "Pa", "kg/m^3", "kg", 1.0, 1.0),
    "in-lbf-s": Units("in", "lbf", "in lbf", "psi", "lbf s^2/in^4", "lbf s^2/in", 1.0 / INCH, POUND / INCH),
}
METRES = {name: 1.0 / units.per_metre for name, units in UNITS.items()}
"""m in the length of each system."""
