"""From a road record to the excitation (thesis 3.1.1 and 3.2), on a synthetic record whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import welch

from creak import Multisine, Record, displacement_motion, integrate_twice
from creak_thesis.arrays import FloatArray

HIGH_PASS = 7.0
"""Hz; all content below is dropped (thesis 3.1.1)."""
ABOVE_NOISE = 10.0
"""Times the noise floor that counts as content."""
RESOLUTION = 0.5
"""Hz, of the density."""
STEP = 1e-3
"""s, of the motion that the `record` signal gives to a run."""
SHOWN_UP_TO = 250.0
"""Hz, of the density that is kept."""
ROAD = (7.5, 95.0)
"""Band of the motion, Hz."""
HUMPS = ((13.0, 3.0, 1.0), (31.0, 6.0, 0.25), (62.0, 9.0, 0.06))
"""Centre and width, Hz, and weight of the resonances that shape the displacement's spectrum."""


@dataclass(frozen=True)
class RecordStudy:
    """Figures 3.1 to 3.3 and the excitation read from the record; lengths in mm."""

    duration: float
    rate: float
    time: FloatArray
    """(n,) s"""
    drifting: FloatArray
    """(n,) mm, acceleration integrated twice in time."""
    filtered: FloatArray
    """(n,) mm, by omega arithmetic."""
    drift: float
    """mm, |displacement| at the end of the time integration."""
    mean: float
    """mm, of the filtered displacement."""
    peak: float
    """mm, of the filtered displacement."""
    true_peak: float
    error_rms: float
    """mm, filtered against true."""
    error_max: float
    error_expected: float
    """mm, root mean square that theory gives for the sensor's noise."""
    freq: FloatArray
    """(n_freq,) Hz"""
    density: FloatArray
    """(n_freq,) one-sided density of the acceleration, (mm/s^2)^2/Hz."""
    floor: float
    """Density of the noise."""
    band: tuple[float, float]
    """Hz, where the density is above the noise."""
    signal: Multisine
    """The excitation."""
    signal_peak: float
    """mm, of the multisine."""
    record_signal_error: float
    """mm, largest difference of the study file's `record` signal from the truth, after its fade-in."""


def study_record(seed: int = 1, *, duration: float = 62.0, rate: float = 48000.0) -> RecordStudy:
    """Make a record and read the excitation from it."""
    record = road_record(seed, duration=duration, rate=rate)
    filtered = integrate_twice(record.acceleration, record.step, HIGH_PASS)[0]
    drifting = integrate_in_time(record.acceleration, record.step)
    freq, density = welch(record.acceleration, record.rate, nperseg=round(record.rate / RESOLUTION))
    floor = float(np.median(density[freq > 0.25 * record.rate]))
    band, peak = content(freq, density, floor), float(np.abs(filtered).max())
    signal = excitation_of(band, peak)
    error = filtered - record.displacement
    shown = freq <= SHOWN_UP_TO
    return RecordStudy(
        duration=duration,
        rate=record.rate,
        time=record.time,
        drifting=drifting,
        filtered=filtered,
        drift=float(abs(drifting[-1])),
        mean=float(filtered.mean()),
        peak=peak,
        true_peak=float(np.abs(record.displacement).max()),
        error_rms=float(np.sqrt((error**2).mean())),
        error_max=float(np.abs(error).max()),
        error_expected=noise_after_integration(record.errors.noise, record.rate, HIGH_PASS),
        freq=freq[shown],
        density=density[shown],
        floor=floor,
        band=band,
        signal=signal,
        signal_peak=float(np.abs(signal.derivative(np.arange(0.0, 1.0, 1e-4), 0)).max()),
        record_signal_error=_record_signal_error(record),
    )


def content(freq: FloatArray, density: FloatArray, floor: float) -> tuple[float, float]:
    """Lowest and highest frequency above `HIGH_PASS` whose density stands out of the noise, Hz."""
    above = freq[(freq >= HIGH_PASS) & (density > ABOVE_NOISE * floor)]
    return float(above.min()), float(above.max())


def excitation_of(band: tuple[float, float], peak: float) -> Multisine:
    """The thesis's multisine: every whole frequency up to that of the content, each with the record's peak.

    The upper end is rounded up to ten hertz; the lower end is 1 Hz, so that all frequencies of interest are driven.
    """
    return Multisine(1.0, float(10.0 * np.ceil(band[1] / 10.0)), peak, 1.0, 1)


def _record_signal_error(record: RoadRecord) -> float:
    """Motion of the `record` signal type at a run's steps against the true displacement."""
    every = round(STEP * record.rate)
    t, true = record.time[::every], record.displacement[::every]
    motion = displacement_motion(Record(record.time, record.acceleration, HIGH_PASS), t)
    settled = t > 2.0 / HIGH_PASS
    return float(np.abs(motion.displacement - true)[settled].max())


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
    # (n_freq,) amplitude of the displacement: resonances within the band, cosine flanks at its ends.
    low, high = ROAD
    size = sum(w / (1.0 + ((freq - f) / b) ** 2) for f, b, w in HUMPS)
    flank = np.clip(np.minimum((freq - low) / 1.5, (high - freq) / 8.0), 0.0, 1.0)
    lines = np.asarray(size * 0.5 * (1.0 - np.cos(np.pi * flank))) * np.exp(2j * np.pi * rng.uniform(size=freq.size))
    u = np.fft.irfft(lines, n)
    scale = peak / float(np.abs(u).max())
    a = np.fft.irfft(-((2.0 * np.pi * freq) ** 2) * scale * lines, n)
    slow = _wander(freq, n, errors, rng)
    noise = errors.noise * rng.standard_normal(n)
    return RoadRecord(rate, np.arange(n) / rate, a + errors.offset + slow + noise, scale * u, errors)


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
