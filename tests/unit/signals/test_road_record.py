"""The synthetic road record: its truth is exact, its drift and noise follow closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from creak.signals.sources import Record, displacement_motion, integrate_twice
from creak_thesis.record import (
    DEFAULT,
    HIGH_PASS,
    ROAD,
    STEP,
    SensorErrors,
    content,
    excitation_of,
    integrate_in_time,
    noise_after_integration,
    road_record,
    study_record,
)

RECORDED = {"section": "signals", "source": "the motion it was made from"}

NO_ERRORS = SensorErrors(offset=0.0, wander=0.0, noise=0.0)
SHORT = {"duration": 8.0, "rate": 4800.0}


def test_record_has_the_peak_and_the_band_asked_for():
    record = road_record(3, peak=1.9, **SHORT)
    assert np.abs(record.displacement).max() == pytest.approx(1.9, rel=1e-12)
    freq = np.fft.rfftfreq(record.time.size, record.step)
    size = np.abs(np.fft.rfft(record.displacement))
    outside = (freq < ROAD[0]) | (freq > ROAD[1])
    assert size[outside].max() < 1e-10 * size.max()
    assert record.time.size == 38400


def test_omega_arithmetic_gives_the_truth_back_without_sensor_errors(measured):
    """All lines lie on the record's own frequencies: exact to round-off."""
    record = road_record(3, errors=NO_ERRORS, **SHORT)
    u = integrate_twice(record.acceleration, record.step, HIGH_PASS)[0]
    bound = 1e-12 * 1.9 * record.time.size
    measured(
        "road record without sensor errors: displacement, error",
        np.abs(u - record.displacement).max(),
        at_most=bound,
        unit="mm",
    )


def test_offset_alone_drifts_with_half_b_t_squared():
    """Trapezoidal sums of a constant: b t^2 / 2 exactly."""
    b = replace(NO_ERRORS, offset=4.0)
    with_offset, without = road_record(3, errors=b, **SHORT), road_record(3, errors=NO_ERRORS, **SHORT)
    drift = integrate_in_time(with_offset.acceleration - without.acceleration, with_offset.step)
    assert drift == pytest.approx(0.5 * 4.0 * with_offset.time**2, abs=1e-8)


def test_offset_and_wander_leave_nothing_behind_the_cut_off():
    slow = replace(DEFAULT, noise=0.0)
    record = road_record(3, errors=slow, **SHORT)
    u = integrate_twice(record.acceleration, record.step, HIGH_PASS)[0]
    assert np.abs(u - record.displacement).max() < 1e-8
    assert np.abs(integrate_in_time(record.acceleration, record.step)[-1]) > 10.0 * 1.9


def test_noise_left_over_is_what_theory_says(measured):
    """About (7 Hz) x 8 s = 56 independent lines per 7 Hz carry the error: its mean square scatters by some 15 %."""
    record = road_record(3, **SHORT)
    u = integrate_twice(record.acceleration, record.step, HIGH_PASS)[0]
    rms = np.sqrt(((u - record.displacement) ** 2).mean())
    expected = noise_after_integration(DEFAULT.noise, record.rate, HIGH_PASS)
    measured("road record: noise left over", rms, expected, rel=0.3, unit="mm", source="spectrum of white noise")


def test_same_seed_same_record():
    one, two, other = (road_record(seed, **SHORT) for seed in (3, 3, 4))
    assert np.array_equal(one.acceleration, two.acceleration)
    assert not np.array_equal(one.displacement, other.displacement)


def test_study_finds_band_peak_and_zero_mean():
    found = study_record(1, **SHORT)
    assert abs(found.mean) < 1e-12
    noise = found.error_expected
    assert found.peak == pytest.approx(1.9, abs=5.0 * noise)
    assert found.error_rms == pytest.approx(noise, rel=0.3)
    assert found.drift > 10.0 * found.peak
    assert HIGH_PASS <= found.band[0] <= 10.0
    assert 80.0 <= found.band[1] <= 100.0
    assert found.signal.f_max == pytest.approx(100.0)
    assert found.signal.amplitude == found.peak
    # white noise: density 2 s^2 / rate
    assert found.floor == pytest.approx(2.0 * DEFAULT.noise**2 / found.rate, rel=0.25)


def test_record_signal_of_a_study_moves_like_the_truth(measured):
    """The `record` signal interpolates the filtered record: noise is all that separates it from the truth."""
    record = road_record(1, **SHORT)
    t = record.time[:: round(STEP * record.rate)]
    true = record.displacement[:: round(STEP * record.rate)]
    moved = displacement_motion(Record(record.time, record.acceleration, HIGH_PASS), t).displacement
    settled = t > 2.0 / HIGH_PASS
    noise = noise_after_integration(DEFAULT.noise, record.rate, HIGH_PASS)
    measured(
        "road record in a study: displacement, error",
        np.abs(moved - true)[settled].max(),
        at_most=5.0 * noise,
        unit="mm",
    )
    assert study_record(1, **SHORT).record_signal_error < 5.0 * noise


def test_content_ignores_noise_and_what_was_cut():
    freq = np.arange(0.0, 200.0)
    density = np.ones(200)
    density[3], density[20], density[80], density[150] = 1e6, 1e3, 11.0, 9.0
    assert content(freq, density, 1.0) == (20.0, 80.0)
    assert excitation_of((20.0, 80.5), 2.0).f_max == 90.0
