"""Noise of a sphere that is knocked, against the closed form of Koss and Alfredson and the dipole that is its limit."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.sound.acceleration_noise import acceleration_noise, equivalent_radius
from creak.sound.rayleigh import AIR

RECORDED = {"section": "sound"}

RHO, C = AIR.density, AIR.speed
RATE, RADIUS, CONTACT, PEAK = 1e6, 0.019, 1.2e-4, 3e4
"""Hz, m, s, m/s^2: steel balls of 38 mm that meet at about 2 m/s."""


def half_sine(t: np.ndarray) -> np.ndarray:
    return np.where((t >= 0) & (t < CONTACT), PEAK * np.sin(np.pi * t / CONTACT), 0.0)


def closed_form(t: np.ndarray, distance: float, cosine: float) -> np.ndarray:
    """Pressure at t since the sound of the first touch arrived, of a half sine of acceleration.

    x'' + 2 l x' + 2 l^2 x = sin(b t) from rest is sine, cosine and e^(-l t) of both; from the end of the contact on the
    same again, later, takes the sine away.
    """
    pace, b = C / RADIUS, np.pi / CONTACT
    steady = 1 / (2 * pace**2 - b**2 + 2j * pace * b)
    c1 = -steady.imag
    c2 = c1 - (1j * b * steady).imag / pace

    def x_and_rate(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        on, s = s >= 0, np.maximum(s, 0)
        wave, fall = steady * np.exp(1j * b * s), np.exp(-pace * s)
        cos, sin = np.cos(pace * s), np.sin(pace * s)
        x = wave.imag + fall * (c1 * cos + c2 * sin)
        v = (1j * b * wave).imag + pace * fall * ((c2 - c1) * cos - (c1 + c2) * sin)
        return on * x, on * v

    x, v = (first + second for first, second in zip(x_and_rate(t), x_and_rate(t - CONTACT), strict=True))
    return RHO * RADIUS**3 * pace**2 * PEAK * cosine * (v / (C * distance) + x / distance**2)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 85.0])
@pytest.mark.parametrize("away", [0.06, 0.4])
def test_two_spheres_that_meet(angle, away, measured):
    """Both are heard, the farther one later and the other way round."""
    listener = away * np.array([np.sin(np.radians(angle)), 0, np.cos(np.radians(angle))])
    t = np.arange(4000) / RATE
    found, wanted = np.zeros(t.size), np.zeros(t.size)
    for sign in (1.0, -1.0):
        centre = np.array([0, 0, sign * RADIUS])
        acceleration = np.zeros((t.size, 3))
        acceleration[:, 2] = sign * half_sine(t)
        found += acceleration_noise(acceleration, RATE, RADIUS, centre, listener)
        distance = np.linalg.norm(listener - centre)
        cosine = sign * (listener - centre)[2] / distance
        wanted += closed_form(t - (distance - RADIUS) / C, distance, cosine)
    error = np.abs(found - wanted).max() / np.abs(wanted).max()
    measured("two spheres that meet: largest error over the peak", error, at_most=2e-3, source="closed form")


def test_the_closed_form_starts_at_rest_and_rings_down():
    t = np.linspace(-1e-4, 3e-3, 5000)
    p = closed_form(t, 0.4, 1.0)
    assert not p[t < 0].any()
    assert np.abs(p[t > 2e-3]).max() < 1e-6 * np.abs(p).max()


def test_slow_motion_is_a_dipole():
    """rho a^3 / 2 (A' / (c r) + A / r^2), ka = .006: also where a sample is longer than the sphere rings."""
    rate, distance, omega = 48_000.0, 0.5, 2 * np.pi * 100.0
    t = np.arange(4800) / rate
    acceleration = np.zeros((t.size, 3))
    acceleration[:, 0] = np.sin(omega * t)
    found = acceleration_noise(acceleration, rate, 0.003, np.zeros(3), np.array([distance, 0, 0]))
    s = t - (distance - 0.003) / C
    wanted = RHO * 0.003**3 / 2 * (omega * np.cos(omega * s) / (C * distance) + np.sin(omega * s) / distance**2)
    late = slice(200, None)
    assert np.abs(found - wanted)[late].max() < 0.01 * np.abs(wanted).max()


@pytest.mark.parametrize("freq", [200.0, 3000.0, 9000.0])
def test_a_sphere_that_swings(freq):
    """Amplitude by the spherical wave of order one, also where the sphere is not small: ka = .07 to 3.1."""
    rate, distance = 192_000.0, 0.3
    t = np.arange(9600) / rate
    acceleration = np.zeros((t.size, 3))
    acceleration[:, 1] = np.cos(2 * np.pi * freq * t)
    found = acceleration_noise(acceleration, rate, RADIUS, np.zeros(3), np.array([0, distance, 0]))
    k = 2 * np.pi * freq / C
    wave = (1j * k / distance + 1 / distance**2) * np.exp(-1j * k * distance)
    slope = (k**2 / RADIUS - 2j * k / RADIUS**2 - 2 / RADIUS**3) * np.exp(-1j * k * RADIUS)
    wanted = abs(RHO * wave / slope)
    assert np.abs(found[4800:]).max() == pytest.approx(wanted, rel=0.01)


def test_across_its_way_a_sphere_is_silent():
    acceleration = np.zeros((500, 3))
    acceleration[:, 2] = half_sine(np.arange(500) / RATE)
    assert not acceleration_noise(acceleration, RATE, RADIUS, np.zeros(3), np.array([0.3, 0, 0])).any()


def test_equivalent_radius():
    assert equivalent_radius(4 / 3 * np.pi * 0.02**3) == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"listener": np.array([0.0, 0.01, 0.0])}, "from the middle"),
        ({"radius": 0.0}, "radius of 0"),
        ({"acceleration": np.zeros(5)}, "shape"),
    ],
)
def test_wrong_input_gets_one_clear_message(change, message):
    given = {
        "acceleration": np.zeros((5, 3)),
        "rate": 48e3,
        "radius": 0.02,
        "centre": np.zeros(3),
        "listener": np.array([0.0, 0.0, 1.0]),
    }
    with pytest.raises(InputError, match=message):
        acceleration_noise(**{**given, **change})
