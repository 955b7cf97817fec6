"""The figures of one sound: loudness, level and third octaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.sound.loudness import added_loudness, loudness
from creak.sound.third_octave import LOWER_EDGES, SILENCE, a_weighted_level, third_octave_levels
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE


@dataclass(frozen=True)
class Heard:
    """One sound over the verification window."""

    n5: float | None
    """sone; None: it is beyond what ISO 532-1 covers."""
    n_max: float | None
    level: float
    """Equivalent continuous level, dB(A) re 20 uPa."""
    third_octaves: FloatArray
    """(28,) dB re 20 uPa, 25 Hz to 12.5 kHz."""
    energy: float
    """Mean square of the A-weighted pressure, Pa^2."""
    n5_added: float | None = None
    """sone that it adds to the study's background; None: there is none, or it is beyond the standard."""
    n_max_added: float | None = None
    n5_modes: float | None = None
    """sone of what the modes of the reduction tell of it, the lower part of the band; None: they tell all."""

    @property
    def rank(self) -> tuple[float, float, float]:
        """What counts when sounds are ranked: N5, where equal Nmax, where equal level; beside a background, added."""
        beside = self.n5_added is not None
        n5, n_max = (self.n5_added, self.n_max_added) if beside else (self.n5, self.n_max)
        return (np.inf if n5 is None else n5, np.inf if n_max is None else n_max, self.level)


def heard_of(
    pressure: FloatArray,
    window: tuple[float, float],
    background: FloatArray | None,
    start: int = 0,
    highest: float = np.inf,
) -> Heard:
    """One pressure (n,) at 48 kHz, over the window. Sample `start` is at t = 0; nothing is above `highest`, Hz."""
    shown = window[0] + start / RATE, window[1] + start / RATE
    levels, level = third_octave_levels(pressure, RATE, shown), a_weighted_level(pressure, RATE, shown)
    levels[highest <= LOWER_EDGES] = SILENCE  # what is left there is the skirt of the filter, not the sound
    energy = REFERENCE_PRESSURE**2 * 10.0 ** (0.1 * level) if pressure.any() else 0.0
    try:
        found = loudness(pressure, RATE)
    except InputError:
        return Heard(None, None, level, levels, energy)
    inside = (found.time >= shown[0]) & (found.time <= shown[1])
    inside = inside if inside.any() else np.ones_like(inside)
    added: tuple[float | None, float | None] = (None, None)
    if background is not None:
        added = _n5_and_most(added_loudness(pressure, RATE, background)[inside])
    return Heard(*_n5_and_most(found.total[inside]), level, levels, energy, *added)


def _n5_and_most(total: FloatArray) -> tuple[float, float]:
    return float(np.percentile(total, 95.0)), float(total.max())
