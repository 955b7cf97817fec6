"""Displacement of an acceleration, and the running mean that two records of one motion lose alike."""

from __future__ import annotations

import numpy as np
import pytest

from creak.studies.findings.beside_records import displacement_of, less_running_mean


def test_the_second_integral_of_a_sine_is_one():
    """But for a straight line; ten samples a period lose a part in a thousand."""
    t, w = 1e-3 * np.arange(730), 2.0 * np.pi * 100.0
    u = np.sin(w * t + 0.4)
    found = displacement_of(-(w**2) * u, 1e-3)
    line = np.polynomial.Polynomial.fit(t, found - u, 1)(t)
    assert np.abs(found - u - line).max() < 1e-3 * 3.0


def test_half_of_a_sine_of_the_width_is_left_and_no_straight_line():
    """A Hann window of width W passes half of a sine of 1 / W: its transform there is exactly that."""
    t = 1e-3 * np.arange(2000)
    u = np.sin(2.0 * np.pi * 5.0 * t)
    at, left = less_running_mean(t, u + 30.0 - 7.0 * t, 0.2)
    np.testing.assert_allclose(at, t[100:-100])
    np.testing.assert_allclose(left, 0.5 * u[100:-100], atol=1e-9)


@pytest.mark.parametrize("step", [1e-4, 7.3e-4])
def test_two_records_of_one_motion_lose_the_same(step):
    """Of other lengths and steps; sums over a Hann window converge as the cube of the step."""

    def motion(t):
        return np.sin(60.0 * t) + 0.3 * np.sin(173.0 * t + 1.0)

    whole, part = 1e-3 * np.arange(1500), np.arange(0.21, 1.13, step)
    at, one = less_running_mean(whole, motion(whole), 0.19)
    here, other = less_running_mean(part, motion(part), 0.19)
    inside = (at >= here[0]) & (at <= here[-1])
    np.testing.assert_allclose(one[inside], np.interp(at[inside], here, other), atol=2e-3)
