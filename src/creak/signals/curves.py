"""Functions of time with exact derivatives and integrals: rounded tables, smooth steps, periodic sums."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from creak.arrays import FloatArray
from creak.signals.signal import Curve

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


@dataclass(frozen=True)
class SmoothStep(Curve):
    """From point to point a_1 + (a_2 - a_1) (10 x^3 - 15 x^4 + 6 x^5), x = (t - t_1) / (t_2 - t_1); constant outside.

    First and second derivative are zero at every point.
    """

    sudden: ClassVar[bool] = True
    time: FloatArray
    """(k,) s, strictly increasing, k >= 2."""
    value: FloatArray

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        h, rise = np.diff(self.time), np.diff(self.value)
        c = np.zeros((6, h.size))
        c[:3] = rise * np.array([6.0, -15.0, 10.0])[:, None] / h ** np.array([5, 4, 3])[:, None]
        c[5] = self.value[:-1]
        return _evaluate(_with_ends(self.time, c), t, order)


@dataclass(frozen=True)
class Rounded(Curve):
    """A table, linear between its points, whose corners are parabolas; constant outside.

    The parabola at a point reaches to both sides by `share` times the shorter of the two intervals beside it; outside
    the table the line goes on for ever. At t = 0 there is no corner: the motion starts with the slope it has there.
    """

    time: FloatArray
    """(k,) s, strictly increasing."""
    value: FloatArray
    share: float
    """0 to 0.5"""

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        if self.time.size == 1:
            from scipy.interpolate import PPoly  # see `signals.spectra.low_pass`

            constant = PPoly(np.array([[self.value[0]]]), np.array([0.0, 1.0]))
            return _evaluate(constant, t, order)
        h = np.diff(self.time)
        reach = self.share * np.minimum(np.concatenate([[np.inf], h]), np.concatenate([h, [np.inf]]))
        reach = np.minimum(reach, np.abs(self.time))
        slope = np.concatenate([[0.0], np.diff(self.value) / h, [0.0]])
        breaks, pieces = [], []
        for k, (at, r) in enumerate(zip(self.time, reach, strict=True)):
            if r > 0.0:
                breaks.append(at - r)
                bend = (slope[k + 1] - slope[k]) / (4.0 * r)
                pieces.append((bend, slope[k], self.value[k] - r * slope[k]))
            breaks.append(at + r)
            pieces.append((0.0, slope[k + 1], self.value[k] + r * slope[k + 1]))
        return _evaluate(_joined(np.array(breaks), np.array(pieces), float(self.value[0])), t, order)


@dataclass(frozen=True)
class Periodic(Curve):
    """mean + sum_n A_n cos(n w (t - start)) + B_n sin(n w (t - start)), w = 2 pi frequency, from `start` on.

    Before `start` it is the mean.
    """

    frequency: float
    """Hz"""
    cosine: FloatArray
    """(k,) A_1, A_2, ..."""
    sine: FloatArray
    """(k,) B_1, B_2, ..."""
    mean: float = 0.0
    start: float = 0.0
    """s"""
    terms: FloatArray = field(init=False, repr=False)
    """(k,) circular frequencies, rad/s."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", 2.0 * np.pi * self.frequency * np.arange(1.0, self.cosine.size + 1))

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        begin = max(self.start, 0.0)
        on = np.maximum(t, begin)
        result = self._harmonic(on, order)
        if order < 0:
            result = result - self._harmonic(np.array([begin]), order)
        if order == -2:
            result = result - self._harmonic(np.array([begin]), -1) * (on - begin)
        constant = {0: np.ones_like(t), -1: t, -2: 0.5 * t**2}.get(order, np.zeros_like(t))
        return np.asarray(np.where(t >= begin, result, 0.0) + self.mean * constant)

    def _harmonic(self, t: FloatArray, order: int) -> FloatArray:
        """The sum differentiated term by term; negative orders are its zero-mean integrals."""
        phase = np.outer(t - self.start, self.terms) + 0.5 * np.pi * order
        scale = self.terms**order
        return np.asarray(np.cos(phase) @ (self.cosine * scale) + np.sin(phase) @ (self.sine * scale))


def _with_ends(breaks: FloatArray, c: FloatArray) -> PPoly:
    """Pieces (degree + 1, k - 1) between k breaks, constant outside."""
    from scipy.interpolate import PPoly  # see `signals.spectra.low_pass`

    h = breaks[-1] - breaks[-2]
    last = sum(c[-1 - i, -1] * h**i for i in range(c.shape[0]))
    ends = np.zeros((c.shape[0], 2))
    ends[-1] = c[-1, 0], last
    x = np.concatenate([[breaks[0] - 1.0], breaks, [breaks[-1] + 1.0]])
    return PPoly(np.column_stack([ends[:, :1], c, ends[:, 1:]]), x)


def _joined(breaks: FloatArray, pieces: FloatArray, before: float) -> PPoly:
    """Piece k (degree 2 and below, highest first) starts at break k; constant `before` the first."""
    from scipy.interpolate import PPoly  # see `signals.spectra.low_pass`

    lasts = np.diff(breaks, append=np.inf) > 1e-12 * np.ptp(breaks)
    breaks, pieces = breaks[lasts], pieces[lasts]
    x = np.concatenate([[breaks[0] - 1.0], breaks, [breaks[-1] + 1.0]])
    return PPoly(np.column_stack([[0.0, 0.0, before], pieces.T]), x)


def _evaluate(curve: PPoly, t: FloatArray, order: int) -> FloatArray:
    """The first and last piece go on outside the breaks."""
    if order >= 0:
        return np.asarray((curve.derivative(order) if order else curve)(t))
    once = curve.antiderivative()
    if order == -1:
        return np.asarray(once(t) - once(0.0))
    twice = once.antiderivative()
    return np.asarray(twice(t) - twice(0.0) - once(0.0) * t)
