"""What sounds are ranked by besides their loudness: sharpness, roughness and impulsiveness, each as one figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.sound.impulsiveness import QUIETEST, adjustment, fast_levels, onsets
from creak.sound.loudness import FAINT, Loudness
from creak.sound.roughness import DEEPEST, WINDOW, roughness_at, window_starts
from creak.sound.zwicker_tables import RATE

SHARP = 2.0
"""acum above which time counts as sharp, unless another is given; speech has some 1.5, a squeak 2 to 4."""
PERCENT = 5.0
"""Sharpness and roughness are those exceeded in this share of the time that is heard."""
TOO_FAINT = f"too faint to be heard (below {FAINT:g} sone)"
STEADY = "the level with time weighting F rises nowhere by more than 10 dB/s"
NOTHING_THERE = (TOO_FAINT, STEADY)
"""Reasons for which a figure is none that no limit can be broken by."""
BEYOND = "beyond ISO 532-1 (120 dB at low frequency)"
TOO_SHORT = f"shorter than the {1e3 * WINDOW:.0f} ms of the roughness model"
TOO_LOUD = "a component above 120 dB + 1150 Hz / f, where the roughness model ends"
TOO_LOW = f"nothing is heard from {DEEPEST:.0f} Hz up, where the roughness model begins"
FIGURES = ("n10", "sharpness", "sharp_time", "roughness", "prominence", "impulse_adjustment")
"""Names of the figures of `Quality`."""


@dataclass(frozen=True)
class Quality:
    """Figures of a sound over a window; None where a method does not hold, `missing` says why."""

    n10: float | None = None
    """Loudness exceeded in 10 % of the time, sone."""
    sharpness: float | None = None
    """DIN 45692, acum, exceeded in 5 % of the time at which .1 sone or more are heard."""
    sharp_time: float | None = None
    """s in which sharpness is above a level."""
    roughness: float | None = None
    """Daniel and Weber 1997, asper, exceeded in 5 % of the windows of 200 ms in which .1 sone or more are heard."""
    prominence: float | None = None
    """NT ACOU 112: of the most prominent onset."""
    impulse_adjustment: float | None = None
    """dB, K_I of NT ACOU 112."""
    missing: Mapping[str, str] = field(default_factory=dict)
    """Figure -> why it is none."""

    @property
    def figures(self) -> dict[str, float | None]:
        """By name."""
        return {name: getattr(self, name) for name in FIGURES}


def quality_of(
    x: FloatArray,
    heard: Loudness | None,
    window: tuple[float, float],
    *,
    sharp: float = SHARP,
    steady: float = QUIETEST,
    silent: bool = True,
) -> Quality:
    """Figures of x (n,) in Pa at 48 kHz over a window, s from its first sample.

    Parameters
    ----------
    heard : its loudness over time; None: it is beyond ISO 532-1. sharp : acum above which time counts as sharp.
    steady : dB(A) of what is there besides. silent : nothing was there before the first sample.
    """
    missing: dict[str, str] = {}
    n10, sharpness, sharp_time = _of_loudness(heard, window, sharp, missing)
    rough = _roughness(x, heard, window, missing)
    found = onsets(fast_levels(x, RATE, steady=steady, silent=silent))
    prominence = max((o.prominence for o in found if window[0] <= o.end and o.start <= window[1]), default=None)
    if prominence is None:
        missing["prominence"] = STEADY
    added = 0.0 if prominence is None else adjustment(prominence)
    return Quality(n10, sharpness, sharp_time, rough, prominence, added, missing)


def within(time: FloatArray, window: tuple[float, float]) -> BoolArray:
    """Which instants (n,) are in a window; all where none is."""
    inside = (time >= window[0]) & (time <= window[1])
    return inside if inside.any() else np.ones_like(inside)


def _of_loudness(
    heard: Loudness | None, window: tuple[float, float], sharp: float, missing: dict[str, str]
) -> tuple[float | None, float | None, float | None]:
    """N10, sharpness and the time that is sharp."""
    if heard is None:
        missing.update(dict.fromkeys(("n10", "sharpness", "sharp_time"), BEYOND))
        return None, None, None
    inside = within(heard.time, window)
    n10, acum = float(np.percentile(heard.total[inside], 90.0)), heard.sharpness[inside]
    audible = acum[acum > 0.0]
    if not audible.size:
        missing["sharpness"] = TOO_FAINT
        return n10, None, 0.0
    apart = float(heard.time[1] - heard.time[0]) if heard.time.size > 1 else 0.0
    return n10, float(np.percentile(audible, 100.0 - PERCENT)), apart * float(np.count_nonzero(acum > sharp))


def _roughness(
    x: FloatArray, heard: Loudness | None, window: tuple[float, float], missing: dict[str, str]
) -> float | None:
    """Only windows in which something is heard are looked at: the others cost as much."""
    first, last = (round(min(max(t * RATE, 0.0), x.size)) for t in window)
    starts = first + window_starts(last - first)
    if not starts.size:
        missing["roughness"] = TOO_SHORT
        return None
    if heard is not None:
        loud = np.array([(heard.total[_steps(k, heard.time)] >= FAINT).any() for k in (starts / RATE).tolist()])
        starts = starts[loud]
        if not starts.size:
            missing["roughness"] = TOO_FAINT
            return None
    found = roughness_at(x, starts)
    if found is None:
        missing["roughness"] = TOO_LOUD
        return None
    known = found[np.isfinite(found)]
    if not known.size:
        missing["roughness"] = TOO_LOW
        return None
    return float(np.percentile(known, 100.0 - PERCENT))


def _steps(start: float, time: FloatArray) -> slice:
    """Instants in the window of the roughness model that begins at `start`, s."""
    first, last = np.searchsorted(time, [start, start + WINDOW])
    return slice(int(first), int(last))
