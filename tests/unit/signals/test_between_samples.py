"""Records between their samples, against the courses that they were sampled from.

The largest value of a motion between the instants at which it is known.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from creak.signals.between_samples import SIDE, between_samples, even_step
from creak.signals.sources import Record, acceleration_motion
from creak.signals.spectra import largest

LINE = 100.0
"""Hz"""


@pytest.mark.parametrize("rate", [256, 300, 500, 2048])
def test_a_record_moves_its_base_as_the_sine_it_was_sampled_from(rate):
    """A sine up to .39 of the sampling rate has its amplitude and no line beside it, at the rate less its own."""
    own, t = np.arange(2 * rate) / rate, np.arange(1500, 4500) / 3000.0
    record = Record(own, np.sin(2.0 * np.pi * LINE * own), 5.0)
    w = 2.0 * np.pi * LINE
    exact = np.sin(w * t)
    whole = np.arange(4800) / 3000.0  # ends before the record does: it is not faded out
    for order in range(3):
        motion = record.motion(whole, order)
        for moved, true in (
            (motion.displacement * w**2, -exact),
            (motion.velocity * w, -np.cos(w * t)),
            (motion.acceleration, exact),
        ):
            lines = np.abs(np.fft.rfft(moved[1500:4500])) * 2.0 / t.size
            assert lines[100] == pytest.approx(1.0, abs=1e-4)
            assert np.delete(lines, 100).max() < 1e-4
            np.testing.assert_allclose(moved[1500:4500], true, atol=1e-4)
    np.testing.assert_allclose(record.values(t), exact, atol=1e-4)


def test_velocity_is_the_rate_of_displacement_also_near_the_ends():
    rate = 256
    own, t = np.arange(2 * rate) / rate, np.arange(0.0, 1.99, 1e-5)
    motion = acceleration_motion(Record(own, np.sin(2.0 * np.pi * 40.0 * own + 1.0) + 0.3 * own, 5.0), t)
    for moved, rate_of_it in ((motion.displacement, motion.velocity), (motion.velocity, motion.acceleration)):
        error = np.abs(np.gradient(moved, t) - rate_of_it)[1:-1] / np.abs(rate_of_it).max()
        assert error[(t < 1.8)[1:-1]].max() < 2e-3
        assert error.max() < 5e-2  # the last samples are followed by a spline


@pytest.mark.parametrize("frequency", [0.0, 0.003, 0.02, 0.1, 0.2])
def test_ends_of_what_is_not_periodic_are_those_of_a_spline(frequency):
    """Nowhere is a course with a trend met worse than by the spline through its samples."""
    at = np.arange(0.0, 299.0, 0.07)

    def course(k):
        return np.cos(2.0 * np.pi * frequency * k + 0.7) + 0.02 * k

    x = course(np.arange(300.0))
    found, spline = between_samples(x[None], at)[0], CubicSpline(np.arange(300), x)(at)
    for here in (at < 3, (at > 3) & (at < SIDE), (at > SIDE) & (at < 250), at > 296):
        error, before = (np.abs(y - course(at))[here].max() for y in (found, spline))
        assert error <= 1.05 * before + 2e-4
    np.testing.assert_allclose(
        between_samples(x[None], np.array([-5.0, 0.0, 17.0, 299.0, 310.0]))[0], x[[0, 0, 17, 299, 299]], rtol=1e-14
    )


@pytest.mark.parametrize("n", [2, 3, 5, 40, 129])
def test_short_records_keep_their_samples_and_straight_lines(n):
    x = np.stack([3.0 - 0.5 * np.arange(n), np.arange(n) % 3])
    np.testing.assert_allclose(between_samples(x, np.arange(n)), x, atol=1e-12)
    at = np.linspace(0.0, n - 1.0, 50)
    np.testing.assert_allclose(between_samples(x, at)[0], 3.0 - 0.5 * at, atol=2e-4 * n)


def test_only_what_rounding_explains_counts_as_even():
    even = np.arange(200) / 2048.0
    assert even_step(even) == pytest.approx(1.0 / 2048.0)
    for decimals in (5, 6, 9):
        assert even_step(np.round(1000.0 + even, decimals)) == pytest.approx(1.0 / 2048.0, rel=1e-3)
    jitter = even + 0.04 / 2048.0 * np.sin(np.arange(200.0))
    assert even_step(jitter) is None
    for gap in (1, 100, 198):
        assert even_step(np.delete(even, gap)) is None
        assert even_step(np.delete(np.round(even, 5), gap)) is None
    assert even_step(np.cumsum(np.where(np.arange(200) < 100, 1.0, 1.001))) is None


@pytest.mark.parametrize("per_period", [8, 10, 20])
def test_top_of_a_sine_lies_between_samples(per_period):
    """All phases: the largest sample is off by (pi / k)^2 / 2 at worst, the top of the parabola by .38 (pi / k)^4."""
    late = np.linspace(-0.5, 0.5, 101)
    x = np.cos(2.0 * np.pi / per_period * (np.arange(-3, 4)[:, None] + late))
    step = np.pi / per_period
    assert (1.0 - x.max(axis=0)).max() > 0.4 * step**2
    assert np.abs(largest(x) - 1.0).max() < 0.4 * step**4


def test_ends_and_plateaus_are_samples():
    x = np.array([[3.0, 0.0, 1.0], [2.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
    np.testing.assert_array_equal(largest(x), [3.0, 2.0, 1.0])
    np.testing.assert_array_equal(largest(x[:1]), x[0])


def test_a_parabola_is_exact():
    t = np.arange(5.0)[:, None]
    np.testing.assert_allclose(largest(2.0 - 0.3 * (t - np.array([1.7, 2.4])) ** 2), 2.0, rtol=1e-14)
