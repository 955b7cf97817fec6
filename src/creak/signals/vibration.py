"""Test signals of vibration laboratories: random motion with a power spectral density, sine sweeps, shocks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from creak.arrays import FloatArray
from creak.signals.signal import Curve, Lines

PER_PERIOD = 40
"""Points in the shortest period between which splines go: 1e-6 of the amplitude."""


@dataclass(frozen=True)
class RandomVibration(Lines):
    """Random-phase sum with a given one-sided power spectral density S, periodic in `period` T.

    sum_k sqrt(2 S(f_k) / T) cos(2 pi f_k t + phi_k), f_k = k / T: its periodogram is S at every line; the phases are
    uniform from `seed`, so that values are normally distributed in the limit of many lines (Shinozuka and Jan, J. Sound
    Vib. 25, 1972). Between its points S is a power of the frequency, as in test standards; where a point is zero it is
    linear.
    """

    frequency: FloatArray
    """(k,) Hz, increasing."""
    density: FloatArray
    """(k,) unit^2 / Hz."""
    period: float
    """s"""
    seed: int = 1

    @cached_property
    def lines(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(n_line,) circular frequencies, rad/s, amplitudes, and phases, rad."""
        T, f = self.period, self.frequency
        k = np.arange(max(1, int(np.ceil(f[0] * T - 1e-9))), int(np.floor(f[-1] * T + 1e-9)) + 1)
        phase = np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, k.size)
        omega: FloatArray = np.asarray(2.0 * np.pi * k / T, dtype=np.float64)
        return omega, np.sqrt(2.0 * self.at(k / T) / T), phase

    def at(self, f: FloatArray) -> FloatArray:
        """S (n,) at frequencies within the table, Hz."""
        x, y = self.frequency, self.density
        i = np.clip(np.searchsorted(x, f, side="right") - 1, 0, x.size - 2)
        share = np.log(f / x[i]) / np.log(x[i + 1] / x[i])
        both = (y[i] > 0.0) & (y[i + 1] > 0.0)
        low, high = np.where(both, y[i], 1.0), np.where(both, y[i + 1], 1.0)
        straight = y[i] + (y[i + 1] - y[i]) * (f - x[i]) / (x[i + 1] - x[i])
        return np.asarray(np.where(both, low * (high / low) ** share, straight))

    @property
    def rms(self) -> float:
        """Of the signal itself."""
        return float(np.sqrt(0.5 * (self.lines[1] ** 2).sum()))

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """Summed by FFT over one period: exactly where even samples from t = 0 on divide it, else by periodic cubic
        splines through `PER_PERIOD` points of the shortest period.
        """
        count = self._even_samples(t)
        if count is not None:
            return np.asarray(self._one_period(order, count)[np.arange(t.size) % count])
        from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

        count = int(2 ** np.ceil(np.log2(PER_PERIOD * self.frequency[-1] * self.period)))
        x = self._one_period(order, count)
        at = np.linspace(0.0, self.period, count + 1)
        return np.asarray(CubicSpline(at, np.append(x, x[0]), bc_type="periodic")(t % self.period))

    def _even_samples(self, t: FloatArray) -> int | None:
        """Samples of t in a period; None where they are not even, or too few for the highest line."""
        step = t[1] - t[0] if t.size > 1 else np.inf
        count = self.period / step
        even = t.size > 1 and t[0] == 0.0 and np.ptp(np.diff(t)) < 1e-9 * step and abs(count - round(count)) < 1e-6
        return round(count) if even and round(count) > 2 * self.frequency[-1] * self.period else None

    def _one_period(self, order: int, count: int) -> FloatArray:
        """(count,) samples of one period."""
        omega, amplitude, phase = self.lines
        rows = np.rint(omega * self.period / (2.0 * np.pi)).astype(np.int64)
        spectrum = np.zeros(count // 2 + 1, dtype=np.complex128)
        spectrum[rows] = 0.5 * count * amplitude * omega**order * np.exp(1j * (phase + 0.5 * np.pi * order))
        return np.asarray(np.fft.irfft(spectrum, count))


@dataclass(frozen=True)
class SineSweep(Curve):
    """A sin(phi(t)), phi' = 2 pi f(t) from `first` to `last` Hz in `duration` s, after that at `last`.

    f(t) = first + (last - first) t / T (linear), or first (last / first)^(t / T) (logarithmic).
    """

    first: float
    last: float
    amplitude: float
    duration: float
    logarithmic: bool = False

    def _phase(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """phi and its first two derivatives at t (n,)."""
        T, f0, f1 = self.duration, self.first, self.last
        on = np.minimum(t, T)
        if self.logarithmic and f1 != f0:
            rate = np.log(f1 / f0) / T
            f = f0 * np.exp(rate * on)
            phi, bend = (f - f0) / rate, rate * f
        else:
            rate = (f1 - f0) / T
            f, phi, bend = f0 + rate * on, on * (f0 + 0.5 * rate * on), np.full(t.size, rate)
        phi = phi + f1 * (t - on)
        return 2.0 * np.pi * phi, 2.0 * np.pi * f, 2.0 * np.pi * np.where(t < T, bend, 0.0)

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        if order < 0:
            return self._integral(t, -order)
        phi, w, bend = self._phase(t)
        if order == 0:
            return np.asarray(self.amplitude * np.sin(phi))
        if order == 1:
            return np.asarray(self.amplitude * w * np.cos(phi))
        return np.asarray(self.amplitude * (bend * np.cos(phi) - w**2 * np.sin(phi)))

    def _integral(self, t: FloatArray, times: int) -> FloatArray:
        from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

        end = float(t.max(initial=0.0))
        count = max(8, int(np.ceil(PER_PERIOD * max(self.first, self.last) * end)))
        at = np.union1d(np.linspace(0.0, end, count + 1), [min(self.duration, end)])
        return np.asarray(CubicSpline(at, self.derivative(at, 0)).antiderivative(times)(t))


@dataclass(frozen=True)
class HalfSine(Curve):
    """A sin(pi (t - start) / T) for a time T from `start` on, zero else: a shock."""

    sudden: ClassVar[bool] = True
    amplitude: float
    duration: float
    start: float = 0.0

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """Without the kinks at both ends."""
        T, A, w = self.duration, self.amplitude, np.pi / self.duration
        x = np.clip(t - self.start, 0.0, T)
        after = np.maximum(t - self.start - T, 0.0)
        if order >= 0:
            inside = (t >= self.start) & (t <= self.start + T)
            return np.asarray(np.where(inside, A * w**order * np.sin(w * x + 0.5 * np.pi * order), 0.0))
        if order == -1:
            return np.asarray(A / w * (1.0 - np.cos(w * x)))
        return np.asarray(A / w * (x - np.sin(w * x) / w) + 2.0 * A / w * after)


def trapezoid(amplitude: float, rise: float, hold: float, fall: float, start: float) -> tuple[FloatArray, FloatArray]:
    """Points (4,) of a trapezoidal shock: time, s, and value."""
    return start + np.cumsum([0.0, rise, hold, fall]), amplitude * np.array([0.0, 1.0, 1.0, 0.0])
