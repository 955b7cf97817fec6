"""Ears of a rigid sphere against the closed forms of Woodworth and of Brown and Duda."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.head import RADIUS, Head, Sphere
from creak.sound.rayleigh import AIR

RECORDED = {"section": "sound"}

RATE = 48_000
LEFT, RIGHT = Sphere(np.array([0.0, 1.0, 0.0])), Sphere(np.array([0.0, -1.0, 0.0]))
FAR = 1000.0
"""m"""


def at(degrees: float, distance: float = FAR) -> np.ndarray:
    """A source so far off ahead, to the left."""
    return distance * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 90.0, 150.0])
def test_interaural_delay_is_woodworths(degrees):
    """a / c (theta + sin theta), theta off the middle plane."""
    theta = np.radians(min(degrees, 180 - degrees))
    late = (RIGHT.path(at(degrees)[None]) - LEFT.path(at(degrees)[None]))[0] / AIR.speed
    assert late == pytest.approx(RADIUS / AIR.speed * (theta + np.sin(theta)), abs=2e-8)


def test_paths_are_straight_where_the_ear_sees_and_around_the_head_where_not():
    near = np.array([[0.0, 0.3, 0.0], [0.0, -0.3, 0.0], [0.3, 0.0, 0.0]])
    tangent = np.sqrt(0.3**2 - RADIUS**2)
    last = np.arccos(RADIUS / 0.3)
    around = [tangent + RADIUS * (np.pi - last), tangent + RADIUS * (np.pi / 2 - last)]
    assert LEFT.path(near) == pytest.approx([0.3 - RADIUS, *around])
    turning = np.array([0.3 * np.array([np.sin(x), np.cos(x), 0.0]) for x in (last - 1e-9, last + 1e-9)])
    assert np.ptp(LEFT.path(turning)) < 1e-8


def spectrum(head: Head, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hz, and what becomes of a click."""
    click = np.zeros(RATE)
    click[RATE // 2] = 1.0
    found = np.fft.rfft(head.at_ear(click, RATE, offset)) / np.fft.rfft(click)
    return np.fft.rfftfreq(RATE, 1 / RATE), found


def test_both_ears_hear_a_source_ahead_as_the_middle_of_the_head():
    for offset in (at(0.0), at(180.0), FAR * np.array([0.6, 0.0, 0.8])):
        freq, left = spectrum(LEFT, offset)
        _, right = spectrum(RIGHT, offset)
        np.testing.assert_allclose(left, right, atol=1e-9)
        np.testing.assert_allclose(left[freq < 15_000], 1.0, atol=0.02)  # later by a^2 / (2 d c), 11 ns


def test_level_difference_of_a_source_at_the_side_is_that_of_the_closed_form(measured):
    """|1 + alpha s| of both ears, alpha = 2 at the near one, .281 at the far one: none in long waves, 16 dB in short."""
    left, right = (spectrum(head, at(90.0))[1] for head in (LEFT, RIGHT))
    some = np.array([100, 500, 1000, 4000, 10_000])
    s = 1j * 2 * np.pi * some * RADIUS / (2 * AIR.speed)
    closed = 20 * np.log10(np.abs((1 + 2.0 * s) / (1 + (1.05 + 0.95 * np.cos(1.2 * np.pi)) * s)))
    found = 20 * np.log10(np.abs(left / right))[some]
    np.testing.assert_allclose(found, closed, atol=1e-4)
    assert found[0] < 0.5
    measured("level difference between two ears, source at the side, 10 kHz", found[-1], 16.5, abs=1.5)


def test_delay_of_long_waves_is_longer_than_that_of_short_ones(measured):
    """Woodworth's (1 + pi / 2) a / c and the shade's (2 - .281) a / (2 c); a rigid sphere has 3 a / c (Kuhn 1977)."""
    left, right = (spectrum(head, at(90.0))[1] for head in (LEFT, RIGHT))
    phase = np.unwrap(np.angle(right / left))
    late = -(phase[60] - phase[20]) / (2 * np.pi * 40)
    alpha = 1.05 + 0.95 * np.cos(1.2 * np.pi)
    closed = (1 + np.pi / 2 + (2.0 - alpha) / 2) * RADIUS / AIR.speed
    assert late == pytest.approx(closed, rel=0.01)
    measured("delay between two ears in long waves, a / c", late * AIR.speed / RADIUS, 3.0, abs=0.5)
