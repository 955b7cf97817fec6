"""From a road record to the excitation (thesis 3.1.1 and 3.2), on a synthetic record whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import welch

from creak import Multisine, Record, displacement_motion, integrate_twice
from creak_thesis.arrays import FloatArray
from creak_thesis.road_record import RoadRecord, integrate_in_time, noise_after_integration, road_record

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
        duration,
        record.rate,
        record.time,
        drifting,
        filtered,
        float(abs(drifting[-1])),
        float(filtered.mean()),
        peak,
        float(np.abs(record.displacement).max()),
        float(np.sqrt((error**2).mean())),
        float(np.abs(error).max()),
        noise_after_integration(record.errors.noise, record.rate, HIGH_PASS),
        freq[shown],
        density[shown],
        floor,
        band,
        signal,
        float(np.abs(signal.derivative(np.arange(0.0, 1.0, 1e-4), 0)).max()),
        _record_signal_error(record),
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
