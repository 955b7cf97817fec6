"""What sounds are ranked by besides their loudness: sharpness, roughness and impulsiveness, each as one figure.

Prominence of impulsive sounds is after NORDTEST method NT ACOU 112 (2002), which ISO/PAS 1996-3:2022 took over."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from creak.arrays import BoolArray, FloatArray
from creak.sound.loudness import FAINT, Loudness
from creak.sound.roughness import DEEPEST, WINDOW, roughness_at, window_starts
from creak.sound.third_octave import a_weighted, at_48k
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE

FAST = 0.125
"""s, time weighting F of IEC 61672-1."""
EVERY = 0.01
"""s between two levels."""
STEP = round(EVERY * RATE)
STEEP = 10.0
"""dB/s from which a level that rises is an onset."""
SHORT = 0.05
"""s: a shorter irregularity on an onset does not end it."""
QUIETEST = 0.0
"""dB(A), about the threshold of hearing: no level is lower."""
FROM = 5.0
"""Prominence from which a sound is impulsive."""
PER_UNIT = 1.8
"""dB of adjustment per unit of prominence above."""


@dataclass(frozen=True)
class Onset:
    """A rise of the level."""

    start: float
    """s from the record's first sample."""
    end: float
    """s"""
    rate: float
    """dB/s of the straight line that fits it best."""
    difference: float
    """dB from its start to its end."""

    @property
    def prominence(self) -> float:
        """Predicted prominence P = 3 lg(rate / (dB/s)) + 2 lg(difference / dB); some 15 at most, below 5 none is heard
        as an impulse. A rise that falls so much amid it that no line through it rises is none: 0."""
        if self.rate <= 0.0:
            return 0.0
        return 3.0 * float(np.log10(self.rate)) + 2.0 * float(np.log10(self.difference))


def adjustment(prominence: float) -> float:
    """K_I = 1.8 (P - 5) dB that the impulse adds to the equivalent level, 0 below P = 5."""
    return max(0.0, PER_UNIT * (prominence - FROM))


def fast_levels(pressure: ArrayLike, rate: float, *, steady: float = QUIETEST, silent: bool = True) -> FloatArray:
    """Levels L_pAF (n,) in dB(A) every 10 ms, A weighting and time weighting F.

    Parameters
    ----------
    pressure : (n,) Pa. rate : Hz. steady : dB(A) that is there besides.
    silent : nothing was there before the record; else what its first 125 ms have.

    Raises
    ------
    InputError : as `at_48k`.
    """
    x = at_48k(pressure, rate)
    power = a_weighted(x)[: x.size] ** 2
    whole = np.concatenate([power, np.zeros(-power.size % STEP)]).reshape(-1, STEP)
    # Of each step of 10 ms the filter's own mean with its exponential weights, then from step to step exactly.
    left = np.exp(-1.0 / (FAST * RATE))
    weights = (1.0 - left) * left ** np.arange(STEP - 1, -1, -1.0)
    added, factor = whole @ weights, left**STEP
    from scipy.signal import lfilter  # see `signals.spectra.low_pass`

    before = 0.0 if silent else float(power[: round(FAST * RATE)].mean())
    fast = lfilter([1.0], [1.0, -factor], added, zi=np.array([factor * before]))[0]
    floor = 10.0 ** (0.1 * max(steady, QUIETEST))
    return np.asarray(10.0 * np.log10(fast / REFERENCE_PRESSURE**2 + floor))


def onsets(levels: FloatArray) -> tuple[Onset, ...]:
    """Where levels (n,) every 10 ms rise by more than 10 dB/s, from the first such step to the first that is not; what
    is flatter for less than 50 ms and goes on higher does not end it."""
    rising = np.diff(levels) > STEEP * EVERY
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rising, [False]]).astype(np.int8)))
    joined: list[tuple[int, int]] = []
    for first, last in edges.reshape(-1, 2).tolist():
        near = bool(joined) and (first - joined[-1][1]) * EVERY < SHORT
        if near and levels[last] > levels[joined[-1][1]]:
            joined[-1] = joined[-1][0], last
        else:
            joined.append((first, last))
    return tuple(_onset(levels, first, last) for first, last in joined)


def _onset(levels: FloatArray, first: int, last: int) -> Onset:
    """Samples from the first to the last."""
    rise = levels[first : last + 1]
    time = EVERY * (np.arange(rise.size) - 0.5 * (rise.size - 1))
    # A level stands at the end of its step of 10 ms.
    return Onset((first + 1) * EVERY, (last + 1) * EVERY, float(time @ rise / (time @ time)), float(rise[-1] - rise[0]))


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
