"""Modes of a test, as files of the trade hold them: universal files (data set 55) and CSV."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from creak.arrays import ComplexArray, FloatArray

PER_METRE = {"mm": 1000.0, "m": 1.0, "in": 1.0 / 0.0254}
"""Units of length that files of tests are in -> how many are in 1 m."""


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
