"""What is known of a run at one time."""

from __future__ import annotations

from dataclasses import dataclass

from creak.arrays import BoolArray, FloatArray
from creak.dynamics.state import Outside, State


@dataclass(frozen=True)
class Works:
    """Work in the step that ends at an instant, and energy there, where the step knows them better than its ends do."""

    damping: float
    external: float
    kinetic: float
    """Of the coordinates alone."""
    strain: float


@dataclass
class Instant:
    """Motion, prescribed motion, gaps and channel forces at one time."""

    row: int
    """Row of the loads."""
    x: State
    support: FloatArray
    """(3, n_support) prescribed displacement, velocity, acceleration."""
    gap: FloatArray
    """(m,)"""
    rate: FloatArray
    """(m,) of the gaps; zero where nothing asks for it."""
    force: FloatArray
    """(m + 2 f,): p >= 0 of all channels, then both friction forces of each rubbing one."""
    sliding: FloatArray
    """(2 f,) slip velocity of the rubbing channels."""
    stuck: BoolArray
    """(f,) sticking, or open."""
    recent: bool = False
    """A channel pressed in the output step that ends here."""
    outside: Outside | None = None
    """What acts from outside, where it is known."""
    works: Works | None = None
    """None: to be told from both ends of the step."""

    @property
    def p(self) -> FloatArray:
        """(m,) normal forces."""
        return self.force[: self.gap.size]

    @property
    def tau(self) -> FloatArray:
        """(2 f,) friction forces."""
        return self.force[self.gap.size :]
