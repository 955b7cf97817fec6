"""A synthetic road record: an acceleration with the errors of a sensor, whose displacement is known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import FloatArray

ROAD = (7.5, 95.0)
"""Band of the motion, Hz."""
HUMPS = ((13.0, 3.0, 1.0), (31.0, 6.0, 0.25), (62.0, 9.0, 0.06))
"""Centre and width, Hz, and weight of the resonances that shape the displacement's spectrum."""


@dataclass(frozen=True)
class SensorErrors:
    """What an accelerometer adds."""

    offset: float = 4.0
    """Constant, length/s^2."""
    wander: float = 6.0
    """Root mean square of the slow wander, length/s^2."""
    wander_below: float = 0.2
    """Hz"""
    noise: float = 150.0
    """Standard deviation of white noise, per sample, length/s^2."""


@dataclass(frozen=True)
class RoadRecord:
    """What was measured, and the truth behind it."""

    rate: float
    """Samples per second."""
    time: FloatArray
    """(n,) s"""
    acceleration: FloatArray
    """(n,) measured: the true one and the sensor's errors."""
    displacement: FloatArray
    """(n,) true, with zero mean."""
    errors: SensorErrors

    @property
    def step(self) -> float:
        return 1.0 / self.rate


DEFAULT = SensorErrors()


def road_record(
    seed: int, *, duration: float = 62.0, rate: float = 48000.0, peak: float = 1.9, errors: SensorErrors = DEFAULT
) -> RoadRecord:
    """A random-phase displacement within `ROAD` Hz and its acceleration as a sensor would give it.

    u(t) = sum_k U_k cos(w_k t + phi_k) on the lines w_k = 2 pi k / duration, so that a = u'' = -w^2 U is exact and
    the record is periodic over its length. Measured: a + offset + wander + white noise.

    Parameters
    ----------
    seed : of phases, wander and noise.
    duration : s. rate : samples per second.
    peak : largest |u|; its unit is the unit of length of the record.
    """
    n = round(duration * rate)
    rng = np.random.default_rng(seed)
    freq = np.asarray(np.fft.rfftfreq(n, 1.0 / rate), dtype=np.float64)
    lines = _shape(freq) * np.exp(2j * np.pi * rng.uniform(size=freq.size))
    u = np.fft.irfft(lines, n)
    scale = peak / float(np.abs(u).max())
    a = np.fft.irfft(-((2.0 * np.pi * freq) ** 2) * scale * lines, n)
    slow = _wander(freq, n, errors, rng)
    noise = errors.noise * rng.standard_normal(n)
    return RoadRecord(rate, np.arange(n) / rate, a + errors.offset + slow + noise, scale * u, errors)


def _shape(freq: FloatArray) -> FloatArray:
    """(n_freq,) amplitude of the displacement: resonances within the band, cosine flanks at its ends."""
    low, high = ROAD
    size = sum(w / (1.0 + ((freq - f) / b) ** 2) for f, b, w in HUMPS)
    flank = np.clip(np.minimum((freq - low) / 1.5, (high - freq) / 8.0), 0.0, 1.0)
    return np.asarray(size * 0.5 * (1.0 - np.cos(np.pi * flank)))


def _wander(freq: FloatArray, n: int, errors: SensorErrors, rng: np.random.Generator) -> FloatArray:
    slow = (freq > 0.0) & (freq <= errors.wander_below)
    if not slow.any() or errors.wander == 0.0:
        return np.zeros(n)
    lines = np.where(slow, np.exp(2j * np.pi * rng.uniform(size=freq.size)), 0.0)
    x = np.fft.irfft(lines, n)
    return np.asarray(x * errors.wander / float(np.sqrt((x**2).mean())))


def integrate_in_time(acceleration: FloatArray, step: float) -> FloatArray:
    """Displacement (n,) by the trapezoidal rule twice, from rest: what drifts.

    A constant error b of the acceleration becomes b t^2 / 2.
    """
    v = _running(acceleration, step)
    return _running(v, step)


def _running(x: FloatArray, step: float) -> FloatArray:
    out = np.zeros_like(x)
    np.cumsum(0.5 * step * (x[1:] + x[:-1]), out=out[1:])
    return out


def noise_after_integration(noise: float, rate: float, high_pass: float) -> float:
    """Root mean square displacement that white noise leaves behind omega arithmetic.

    White noise of standard deviation s at f_s samples per second has the one-sided density S = 2 s^2 / f_s; its
    double integral above the cut-off f_c has the mean square int_{f_c}^inf S / (2 pi f)^4 df = S / (3 (2 pi)^4 f_c^3).
    """
    density = 2.0 * noise**2 / rate
    return float(np.sqrt(density / (3.0 * (2.0 * np.pi) ** 4 * high_pass**3)))
