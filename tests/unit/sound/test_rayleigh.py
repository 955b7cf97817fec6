"""Sound of vibrating surfaces against closed forms: baffled piston, simply supported plate, pulsating sphere."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import j1

from creak.errors import InputError
from creak.sound.rayleigh import AIR, PressureRows, equivalent_power, pressure_weights
from helpers_sound import pressure_rows

RECORDED = {"section": "sound", "source": "closed form"}

RATE = 48_000.0
RHO, C = AIR.density, AIR.speed
RADIUS = 0.1
SIDES = 0.455, 0.379


def response(rows: PressureRows, freq: float) -> np.ndarray:
    """Pressure (n_listener, n_mode) per modal acceleration of e^(i w t)."""
    delay = rows.start[:, None] + np.arange(rows.rows.shape[1])
    return np.einsum("lt,ltm->lm", np.exp(-2j * np.pi * freq / rows.rate * delay), rows.rows)


def disk(rings: int = 100, around: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Points of a disk in z = 0 and the area of each."""
    r = (np.arange(rings) + 0.5) * RADIUS / rings
    phi = 2 * np.pi * np.arange(around) / around
    x, y = np.outer(r, np.cos(phi)).ravel(), np.outer(r, np.sin(phi)).ravel()
    return np.column_stack([x, y, 0 * x]), np.repeat(2 * np.pi * r * RADIUS / rings / around, around)


def plate(nx: int = 90, ny: int = 80) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (n, 3) of a rectangle in z = 0 of nx by ny pieces, their areas (n,) and mode (3, 2) there, 1 m high."""
    x, y = np.meshgrid(np.linspace(0, SIDES[0], nx + 1), np.linspace(0, SIDES[1], ny + 1), indexing="ij")
    share = [np.r_[0.5, np.ones(n - 1), 0.5] * side / n for n, side in zip((nx, ny), SIDES, strict=True)]
    shape = np.sin(3 * np.pi * x / SIDES[0]) * np.sin(2 * np.pi * y / SIDES[1])
    return np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), np.outer(*share).ravel(), shape.ravel()


@pytest.fixture(scope="module")
def mode():
    """Points and volumes (n, 1) of mode (3, 2) of the simply supported plate, normal displacement of 1 m."""
    points, areas, shape = plate()
    return points, (areas * shape)[:, None]


WAVENUMBER = np.hypot(3 * np.pi / SIDES[0], 2 * np.pi / SIDES[1])
"""Of that mode in the plate, rad/m."""


@pytest.mark.parametrize("height", [0.03, 0.1, 0.6])
def test_piston_on_its_axis_over_time(height, measured):
    """rho c (v(t - z / c) - v(t - sqrt(z^2 + a^2) / c)) for a pulse of velocity, near and far."""
    points, areas = disk()
    rows = pressure_rows(points, areas[:, None], [[0, 0, height]], RATE)
    t, width, middle = np.arange(480) / RATE, 1e-4, 1.5e-3

    def velocity(s: np.ndarray) -> np.ndarray:
        return np.exp(-(((s - middle) / width) ** 2))

    acceleration = -2 * (t - middle) / width**2 * velocity(t)
    start = int(rows.start[0])  # below 0: before the first instant
    found = np.concatenate([np.zeros(max(start, 0)), np.convolve(acceleration, rows.rows[0, :, 0])[max(-start, 0) :]])
    found = found[: t.size]
    exact = RHO * C * (velocity(t - height / C) - velocity(t - np.hypot(height, RADIUS) / C))
    error = np.abs(found - exact).max() / np.abs(exact).max()
    measured("baffled piston on its axis, pulse: largest error over the peak", error, at_most=0.01)


@pytest.mark.parametrize("ka", [1.0, 4.0, 8.0])
def test_directivity_of_a_piston(ka, measured):
    """2 J1(ka sin) / (ka sin), 50 m away; on the axis rho A a / (2 r)."""
    points, areas = disk()
    angle, distance = np.radians([0.0, 10, 25, 40, 60, 80, 89]), 50.0
    listeners = distance * np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])
    found = np.abs(response(pressure_rows(points, areas[:, None], listeners, RATE), ka * C / RADIUS / 2 / np.pi)[:, 0])
    u = ka * np.sin(angle)
    wanted = np.where(u > 0, 2 * j1(u) / np.where(u > 0, u, 1), 1.0) * RHO * RADIUS**2 / (2 * distance)
    error = np.abs(found - np.abs(wanted)).max() / wanted[0]
    measured("directivity of a piston, worst error over the axis", error, at_most=0.01)


@pytest.mark.parametrize("over", [0.4, 0.9, 1.6])
def test_plate_below_and_above_coincidence_far_away(mode, over, measured):
    """Far field of a plate mode, k = `over` times its wavenumber: separate sums of sin over each side."""
    k, distance = over * WAVENUMBER, 400.0
    theta, phi = np.radians([5.0, 20, 40, 60, 80]), np.radians([10.0, 35, 50, 70, 85])
    towards = np.column_stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    found = response(pressure_rows(*mode, distance * towards, RATE), k * C / 2 / np.pi)[:, 0]

    def side(number: int, length: float, along: np.ndarray) -> np.ndarray:
        """int sin(n pi x / L) e^(i k along x) dx."""
        b = number * np.pi / length
        return b * (1 - (-1) ** number * np.exp(1j * k * along * length)) / (b**2 - (k * along) ** 2)

    wanted = RHO / (2 * np.pi * distance) * side(3, SIDES[0], towards[:, 0]) * side(2, SIDES[1], towards[:, 1])
    error = np.abs(np.abs(found) - np.abs(wanted)).max() / np.abs(wanted).max()
    measured("simply supported plate, far field below and above coincidence", error, at_most=0.01)


@pytest.mark.parametrize("over", [0.4, 1.6])
def test_plate_near_by_is_the_integral(mode, over):
    """At 0.1 and 0.6 m, where no closed form is: Gauss points, 40 to a side of each half wave, instead of nodes."""
    k = over * WAVENUMBER
    listeners = np.array([[0.1, 0.2, 0.1], [0.3, 0.1, 0.6]])
    found = response(pressure_rows(*mode, listeners, RATE), k * C / 2 / np.pi)[:, 0]
    g, w = np.polynomial.legendre.leggauss(120)
    x, y = (0.5 * (g + 1) * side for side in SIDES)
    weight = np.outer(w, w) * np.prod(SIDES) / 4
    shape = np.outer(np.sin(3 * np.pi * x / SIDES[0]), np.sin(2 * np.pi * y / SIDES[1]))
    r = np.sqrt(
        (listeners[:, :1, None] - x[:, None]) ** 2 + (listeners[:, 1:2, None] - y) ** 2 + listeners[:, 2:, None] ** 2
    )
    wanted = RHO / 2 / np.pi * (weight * shape * np.exp(-1j * k * r) / r).sum(axis=(1, 2))
    assert np.abs(found - wanted).max() < 0.01 * np.abs(wanted).max()


def test_a_small_sphere_that_breathes(measured):
    """rho a^2 A / r, ka = .05, in free space; beyond, its own shadow makes it 1 / sqrt(1 + (ka)^2)."""
    n, radius, distance = 2000, 0.02, 1.0
    z = 1 - 2 * (np.arange(n) + 0.5) / n
    turn = np.pi * (1 + 5**0.5) * np.arange(n)
    points = radius * np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])
    volumes = np.full((n, 1), 4 * np.pi * radius**2 / n)
    rows = pressure_rows(points, volumes, [[distance, 0, 0]], RATE, baffled=False)
    found = abs(response(rows, 0.05 * C / radius / 2 / np.pi)[0, 0])
    wanted = RHO * radius**2 / distance / np.hypot(1, 0.05)
    measured("small pulsating sphere", found, wanted, rel=0.01, unit="Pa")


def test_delays_between_samples():
    """One node: amplitude and phase within 1e-5 up to .8 of half the rate."""
    for distance in (0.4001, 0.4037, 0.02):
        rows = pressure_rows(np.zeros((1, 3)), np.ones((1, 1)), [[0, 0, distance]], RATE)
        for freq in (0.0, 1000.0, 0.4 * RATE):
            wanted = RHO / (2 * np.pi * distance) * np.exp(-2j * np.pi * freq * distance / C)
            assert abs(response(rows, freq)[0, 0] - wanted) < 1e-5 * abs(wanted)


def test_a_low_band_needs_few_taps(mode):
    """Up to 300 Hz at 1.2 kHz: less than a third of the taps at 48 kHz, and the sum over the nodes to 1e-5."""
    points, volumes = mode
    listener, band = np.array([0.1, 0.2, 0.6]), 300.0
    weights, start = pressure_weights(points, listener, 4.0 * band, band)
    fine = pressure_rows(points, volumes, [listener], RATE)
    assert 3 * weights.shape[0] < fine.rows.shape[1]
    rows = PressureRows((weights @ volumes)[None], np.array([start]), 4.0 * band, band)
    distance = np.linalg.norm(points - listener, axis=1)
    for freq in (20.0, 150.0, band):
        each = np.exp(-2j * np.pi * freq * distance / C) / distance
        wanted = RHO / (2 * np.pi) * (each @ volumes)[0]
        size = RHO / (2 * np.pi) * (abs(each) @ abs(volumes))[0]
        assert abs(response(rows, freq)[0, 0] - wanted) < 1e-5 * size


def test_equivalent_power_of_a_piston_and_of_a_plate_mode():
    """rho c S v^2, of a sine mode a quarter of it."""
    _, areas, shape = plate(60, 60)
    full = RHO * C * np.prod(SIDES)
    assert equivalent_power(areas, 2.0 * np.stack([np.ones_like(shape), shape])) == pytest.approx(
        [4 * full, full], rel=1e-6
    )


@pytest.mark.parametrize(
    ("listener", "rate", "band", "message"),
    [(np.zeros(3), RATE, 0.4 * RATE, "on the radiating surface"), (np.ones(3), 1000.0, 500.0, "below half the rate")],
)
def test_wrong_input_gets_one_clear_message(listener, rate, band, message):
    with pytest.raises(InputError, match=message):
        pressure_weights(np.zeros((1, 3)), listener, rate, band)
