"""Channels, modes and frequency response functions of a test, as files of the trade hold them: universal ones, CSV."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.model.units import LENGTHS


@dataclass(frozen=True)
class Channel:
    """One measured quantity, evenly sampled."""

    name: str
    unit: str
    start: float
    """s"""
    step: float
    """s"""
    values: FloatArray
    """(n,)"""
    at: tuple[int, int] = (0, 0)
    """Node and direction, 1 to 6, where the file tells them; 0: none. Values are along the positive axis."""

    @property
    def time(self) -> FloatArray:
        """(n,) s"""
        return np.asarray(self.start + self.step * np.arange(self.values.size), dtype=np.float64)


PER_METRE = {name: 1.0 / LENGTHS[name] for name in ("mm", "m", "in")}
"""Units of length that files of tests are in -> how many are in 1 m."""


HIGH = 0.2
"""Damping above this share of critical is seldom of a mode."""


def high_damping(damping: FloatArray) -> list[str]:
    """The question about damping that is too high for a mode; none where it is not."""
    odd = damping[damping > HIGH]
    return [f"damping of {100.0 * odd.max():.0f} % of critical: is it per cent that the file has?"] if odd.size else []


class Measured(Protocol):
    """What sensors measured, whatever it is. A channel is one direction at one point."""

    @property
    def path(self) -> Path: ...
    @property
    def sensors(self) -> tuple[str, ...]:
        """(n_channel,) name of the point of each."""

    @property
    def points(self) -> FloatArray:
        """(n_channel, 3) in the axes and the length of the file; nan where it does not tell."""

    @property
    def directions(self) -> FloatArray:
        """(n_channel, 3) unit vectors in global axes."""

    @property
    def per_metre(self) -> float | None:
        """Units of length in 1 m, where the file tells."""


@dataclass(frozen=True)
class MeasuredModes:
    """Frequencies, damping and shapes at sensors. A channel is one direction at one point."""

    path: Path
    frequencies: FloatArray
    """(n_mode,) Hz, rising."""
    damping: FloatArray
    """(n_mode,) share of critical damping; nan where the file does not tell."""
    shapes: ComplexArray
    """(n_channel, n_mode) motion along `directions`, any scale."""
    sensors: tuple[str, ...]
    """(n_channel,) name of the point of each."""
    points: FloatArray
    """(n_channel, 3) in the axes and the length of the file; nan where it does not tell."""
    directions: FloatArray
    """(n_channel, 3) unit vectors in global axes."""
    per_metre: float | None = None
    """Units of length in 1 m, where the file tells."""
    lines: tuple[tuple[str, str], ...] = ()
    """Names of points that are joined in drawings."""
    notes: tuple[str, ...] = ()
    """What was left out or taken for granted."""


RECEPTANCE, MOBILITY, ACCELERANCE = 0, 1, 2
"""Displacement, velocity or acceleration over force: times so many i omega a receptance."""
QUANTITIES = {
    RECEPTANCE: ("receptance", "m/N"),
    MOBILITY: ("mobility", "m/s/N"),
    ACCELERANCE: ("accelerance", "m/s^2/N"),
}


@dataclass(frozen=True)
class MeasuredFrf:
    """A frequency response function: motion along one channel over the force along another."""

    name: str
    """`17 Z / 1 -X`"""
    where: str
    """file:line"""
    response: int
    """Row of the channel."""
    reference: int
    order: int
    """A key of `QUANTITIES`."""
    freq: FloatArray
    """(n,) Hz, rising, above 0."""
    values: ComplexArray
    """(n,) in m, s and N; in length, s and force of the model where `has_units` is False."""
    has_units: bool
    coherence: FloatArray | None = None
    """(n,) 0 to 1."""


@dataclass(frozen=True)
class MeasuredFrfs:
    """Frequency response functions of one test; channels as in `MeasuredModes`."""

    path: Path
    functions: tuple[MeasuredFrf, ...]
    sensors: tuple[str, ...]
    points: FloatArray
    directions: FloatArray
    per_metre: float | None = None
    notes: tuple[str, ...] = ()
