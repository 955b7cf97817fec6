"""A measured course in time over a computed one: the shift that aligns them, and how far they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from creak.arrays import FloatArray
from creak.signals.spectra import cell_means
from creak.verify.events import contact_stretches
from creak.verify.nrmse import nrmse_fit

Kind = Literal["motion", "gap", "force"]
LEAST = 0.5
"""Share of the shorter record that overlaps at any shift."""
ROUND_OFF = 1e-12
"""Difference of two correlations."""
EQUAL = 1e-3
"""Share by which a correlation may be less than the largest and is as good: so much lies between samples of a peak."""
PRESSED = 0.05
"""Share of the largest force above which a force presses: below it a sensor may be noisy."""


@dataclass(frozen=True)
class Course:
    """A quantity over time."""

    time: FloatArray
    """(n,) s, rising."""
    values: FloatArray
    """(n,)"""


@dataclass(frozen=True)
class RecordFit:
    """A measured and a computed course at the same instants."""

    time: FloatArray
    """(n,) s of the run."""
    test: FloatArray
    model: FloatArray
    fit: float
    """1 - |test - model| / |test - mean(test)|, 1: the same."""
    correlation: float
    """Of the two without their means, -1 to 1; nan where one is constant."""
    freq: FloatArray
    """(k,) Hz"""
    spectra: tuple[FloatArray, FloatArray]
    """Amplitudes of test and model, (k,) each."""
    events: tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]] | None = None
    """Start and end of each contact in the test and in the model, s; None: it is motion."""

    @property
    def rms(self) -> tuple[float, float]:
        """Root mean square of test and model."""
        test, model = (float(np.sqrt(np.mean(x**2))) for x in (self.test, self.model))
        return test, model


def shift_between(pairs: Sequence[tuple[Course, Course]]) -> float:
    """What is added to the times of all measured courses so that they lie over the computed ones, s.

    The sum of the cross-correlations of all pairs (test, model) is largest; of maxima that are `EQUAL` to it, as where
    motion is periodic, the one of the smallest shift is taken. From there the mean correlation of what overlaps leads
    to its own maximum, and a parabola through that and its neighbours gives the fraction of a step.

    Parameters
    ----------
    pairs : the models at even instants, all of them parts of one row; what all cover is taken, of the tests too.
    """
    first, last = max(float(m.time[0]) for _, m in pairs), min(float(m.time[-1]) for _, m in pairs)
    models = [m.values[(m.time >= first) & (m.time <= last)] for _, m in pairs]
    step = float(np.diff(pairs[0][1].time).mean())
    start, end = max(float(t.time[0]) for t, _ in pairs), min(float(t.time[-1]) for t, _ in pairs)
    at = start + step * np.arange(int((end - start) / step + 1e-6) + 1)
    tests = [cell_means(t.time, t.values[:, None], np.minimum(at, end))[:, 0] for t, _ in pairs]
    count, own = at.size, models[0].size
    lag = np.arange(1 - count, own)
    total = sum(map(_cross_correlation, tests, models), np.zeros(lag.size))
    known = np.minimum(count, own - lag) - np.maximum(0, -lag) >= LEAST * min(count, own)
    total = np.where(known, total, -np.inf)
    # Of the maxima that are as good as the largest value the one of the least distance.
    best = float(total.max())
    peak = (total >= np.append(total[1:], -np.inf)) & (total >= np.append(-np.inf, total[:-1]))
    equal = np.flatnonzero(peak & (total >= best - EQUAL * abs(best)))
    k, share = int(equal[np.abs(first - start + step * lag)[equal].argmin()]), 0.0

    def alike(k: int) -> float:
        return float(np.mean([_overlapping(a, b, int(lag[k])) for a, b in zip(tests, models, strict=True)]))

    here = alike(k)
    while 0 < k < lag.size - 1 and known[k - 1 : k + 2].all():
        left, right = alike(k - 1), alike(k + 1)
        if max(left, right) <= here:
            bend = left - 2.0 * here + right
            share = 0.5 * (left - right) / bend if bend < 0.0 and abs(left - right) > ROUND_OFF else 0.0
            break
        k, here = (k + 1, right) if right > left else (k - 1, left)
    return first - start + step * (float(lag[k]) + share)


def _cross_correlation(a: FloatArray, b: FloatArray) -> FloatArray:
    """Of each lag of a behind b, from the first at which they overlap to the last; 1: all of both is the same."""
    n = a.size + b.size - 1
    a, b = a - a.mean(), b - b.mean()
    size = float(np.linalg.norm(a) * np.linalg.norm(b)) or 1.0
    return np.roll(np.fft.irfft(np.fft.rfft(b, n) * np.conj(np.fft.rfft(a, n)), n), a.size - 1) / size


def _overlapping(a: FloatArray, b: FloatArray, lag: int) -> float:
    """Correlation of what overlaps where a begins `lag` steps after b; 0 where one is constant."""
    count = min(a.size, b.size - lag)
    x, y = a[max(0, -lag) : count], b[max(0, lag) : count + lag]
    spread = float(np.std(x) * np.std(y))
    return float(np.mean((x - x.mean()) * (y - y.mean()))) / spread if spread else 0.0


def fitted(test: Course, model: Course, shift: float, *, kind: Kind, f_max: float) -> RecordFit | None:
    """Both at the instants of the model that the shifted test covers; None where fewer than four are left.

    Parameters
    ----------
    kind : a force presses above `PRESSED` of the largest, a gap at 0 or below; contacts are merged into events by the
        rules of `verify.events` with `f_max`, Hz.
    """
    time = test.time + shift
    inside = (model.time >= time[0]) & (model.time <= time[-1])
    if inside.sum() < 4:
        return None
    t, y = model.time[inside], model.values[inside]
    x = cell_means(time, test.values[:, None], t)[:, 0]
    spread = float(np.std(x) * np.std(y))
    correlation = float(np.mean((x - x.mean()) * (y - y.mean()))) / spread if spread else float("nan")
    freq = np.asarray(np.fft.rfftfreq(t.size, float(np.diff(t).mean())), dtype=np.float64)
    window = np.hanning(t.size)
    spectra = [np.abs(np.fft.rfft((v - v.mean()) * window)) * (2.0 / window.sum()) for v in (x, y)]
    events = None
    if kind != "motion":
        bar = PRESSED * max(float(x.max()), float(y.max()))
        test_events, model_events = (
            contact_stretches(t, v > bar if kind == "force" else v <= 0.0, f_max) for v in (x, y)
        )
        events = test_events, model_events
    return RecordFit(t, x, y, nrmse_fit(x, y), correlation, freq, (spectra[0], spectra[1]), events)
