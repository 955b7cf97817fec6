"""Prominence of impulsive sounds after NORDTEST method NT ACOU 112 (2002), which ISO/PAS 1996-3:2022 took over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from creak.arrays import FloatArray
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
