"""Measures at the points of E-lines, on motions whose figures are known."""

from __future__ import annotations

import numpy as np
import pytest

from creak.verify.elines import joined, largest_swing, measure

TIME = np.arange(4000) / 4000.0


def moved(x, y, z):
    return np.stack([np.broadcast_to(a, TIME.shape) for a in (x, y, z)], axis=-1)[:, None, :]


def test_the_largest_swing_of_an_ellipse_is_its_long_axis():
    """Half axes .3 and .1, turned by 30 degrees: .6, whatever the frame; sampled at the ends of the axis."""
    phase, turn = 2.0 * np.pi * 5.0 * TIME, np.radians(30.0)
    a, b = 0.3 * np.cos(phase), 0.1 * np.sin(phase)
    x, y = a * np.cos(turn) - b * np.sin(turn), a * np.sin(turn) + b * np.cos(turn)
    width, along = largest_swing(np.column_stack([x, y]))
    assert width == pytest.approx(0.6, rel=1e-12)
    np.testing.assert_allclose(np.abs(along), np.abs(a), atol=1e-12)
    found = measure(moved(x, y, 0.0), 95.0)
    assert found.in_plane[0] == pytest.approx(0.6, rel=1e-12)
    # Along the axes of the frame it is less: 2 sqrt(a^2 cos^2 + b^2 sin^2), to the sampling.
    expected = [
        2.0 * np.hypot(0.3 * np.cos(turn), 0.1 * np.sin(turn)),
        2.0 * np.hypot(0.3 * np.sin(turn), 0.1 * np.cos(turn)),
    ]
    np.testing.assert_allclose(found.along[0], expected, rtol=1e-4)


def test_the_largest_swing_is_no_less_than_that_of_any_direction():
    rng = np.random.default_rng(1)
    path = np.cumsum(rng.normal(size=(500, 2)), axis=0)
    width, _ = largest_swing(path)
    angle = np.linspace(0.0, np.pi, 2001)
    widths = np.ptp(path @ np.stack([np.cos(angle), np.sin(angle)]), axis=0)
    assert widths.max() <= width * (1.0 + 1e-12)
    # Between two of the directions the width falls by no more than 1 - cos of half their angle.
    assert widths.max() >= width * np.cos(np.pi / 4000) * (1.0 - 1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.7, np.inf])
def test_motion_on_a_line_and_rest(slope):
    s = np.sin(2.0 * np.pi * 3.0 * TIME + 0.4)
    direction = np.array([0.0, 1.0]) if np.isinf(slope) else np.array([1.0, slope]) / np.hypot(1.0, slope)
    width, along = largest_swing(s[:, None] * direction)
    assert width == pytest.approx(np.ptp(s), rel=1e-12)
    assert np.ptp(along) == pytest.approx(np.ptp(s), rel=1e-12)
    assert largest_swing(np.zeros((50, 2)))[0] == 0.0
    assert largest_swing(np.full((50, 2), 3.0))[0] == 0.0


def test_peaks_and_percentile_of_the_closing_displacement():
    """Nine cycles of amplitude .1 and one of .5 about zero: ten peaks, one of them large."""
    amplitude = np.where((TIME >= 0.3) & (TIME < 0.4), 0.5, 0.1)
    z = -amplitude * np.sin(2.0 * np.pi * 10.0 * TIME)
    found = measure(moved(0.0, 0.0, z), 90.0)
    assert found.closing[0] == pytest.approx(0.5, rel=1e-12)
    assert found.across[0] == pytest.approx(1.0, rel=1e-12)
    peaks = [0.1] * 9 + [0.5]
    assert found.closing_percentile[0] == pytest.approx(np.percentile(peaks, 90.0), rel=1e-9)
    assert measure(moved(0.0, 0.0, z), 100.0).closing_percentile[0] == found.closing[0]


def test_a_ripple_on_a_cycle_is_no_peak_of_its_own():
    slow = 1.0 + 0.5 * np.sin(2.0 * np.pi * 2.0 * TIME)
    found = measure(moved(0.0, 0.0, -(slow + 0.01 * np.sin(2.0 * np.pi * 200.0 * TIME))), 1.0)
    assert found.closing_percentile[0] == pytest.approx(1.5, abs=0.011)


def test_a_single_dip_leaves_a_peak():
    z = np.where(np.arange(TIME.size) == 100, 1.0, -0.5)
    assert measure(moved(0.0, 0.0, z), 95.0).closing_percentile[0] == pytest.approx(0.5)


def test_swings_in_the_plane():
    """Extremes +1 -1 +1 -3 +3: swings 2, 2, 4, 6; the largest swing is the peak-to-peak."""
    extremes = np.array([1.0, -1.0, 1.0, -3.0, 3.0])
    x = np.interp(np.linspace(0, 4, 401), np.arange(5), extremes)
    motion = np.zeros((401, 1, 3))
    motion[:, 0, 0] = x
    for share, expected in ((100.0, 6.0), (50.0, 3.0), (1e-9, 2.0)):
        assert measure(motion, share).in_plane_percentile[0] == pytest.approx(expected)
    assert measure(motion, 50.0).in_plane[0] == pytest.approx(6.0)


def test_points_are_measured_alone():
    rng = np.random.default_rng(2)
    motion = rng.normal(size=(200, 3, 3))
    whole = measure(motion, 80.0)
    pieces = joined([measure(motion[:, :1], 80.0), measure(motion[:, 1:], 80.0)])
    for name in whole.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(whole, name), getattr(pieces, name))
