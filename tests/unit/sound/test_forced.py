"""Sound of forces on a structure against closed forms and other ways to compute it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from creak.errors import InputError
from creak.sound import forced
from creak.sound.answering import Modes
from creak.sound.forced import sound_of_forces
from creak.sound.rayleigh import AIR
from helpers_sound import faded, pressure_rows

RECORDED = {"section": "sound"}

RATE, RADIUS, HEIGHT, BAND = 48_000.0, 0.1, 0.6, 4000.0
TIME = np.arange(14_400) / RATE
MASS, STIFFNESS, DAMPING = 0.3, 0.3 * (2 * np.pi * 180.0) ** 2, 0.02 * 2 * 0.3 * 2 * np.pi * 180.0
LENGTH, PEAK = 2e-3, 50.0
"""s and N of the half sine."""


def half_sine(t: np.ndarray) -> np.ndarray:
    return np.where((t > 0.01) & (t < 0.01 + LENGTH), PEAK * np.sin(np.pi * (t - 0.01) / LENGTH), 0.0)


def means(t: np.ndarray) -> np.ndarray:
    """Of the half sine over the sampling intervals around t."""
    fine = (np.arange(64) + 0.5) / 64 - 0.5
    return half_sine(t[:, None] + fine / RATE).mean(axis=1)


def piston():
    """Rows of a baffled piston for a listener on its axis."""
    rings, around = 60, 120
    r, phi = (np.arange(rings) + 0.5) * RADIUS / rings, 2 * np.pi * np.arange(around) / around
    x, y = np.outer(r, np.cos(phi)).ravel(), np.outer(r, np.sin(phi)).ravel()
    areas = np.repeat(2 * np.pi * r * RADIUS / rings / around, around)
    return pressure_rows(np.column_stack([x, y, 0 * x]), areas[:, None], np.array([[0, 0, HEIGHT]]), RATE)


def in_band(p: np.ndarray) -> np.ndarray:
    """What the fades leave of a record, silent before and after."""
    n = 4 * p.size
    return np.fft.irfft(np.fft.rfft(p, n) * faded(np.fft.rfftfreq(n, 1 / RATE), BAND), n)[: p.size]


def test_piston_on_a_spring_struck_by_a_half_sine(measured):
    """rho c (v(t - z / c) - v(t - sqrt(z^2 + a^2) / c)) with v from a Runge-Kutta integration to 1e-10."""

    def rate(t, y):
        return [y[1], (half_sine(np.array(t)) - DAMPING * y[1] - STIFFNESS * y[0]) / MASS]

    motion = solve_ivp(
        rate, (0, TIME[-1]), [0, 0], rtol=1e-10, atol=1e-14, dense_output=True, max_step=2e-4, method="DOP853"
    ).sol

    def velocity(s: np.ndarray) -> np.ndarray:
        return np.where(s > 0, motion(np.maximum(s, 0))[1], 0.0)

    exact = (
        AIR.density
        * AIR.speed
        * (velocity(TIME - HEIGHT / AIR.speed) - velocity(TIME - np.hypot(HEIGHT, RADIUS) / AIR.speed))
    )
    exact = in_band(exact)
    modes = Modes(*(np.array([x]) for x in (MASS, DAMPING, STIFFNESS)), np.array([[1.0]]))
    found = sound_of_forces(modes, means(TIME)[:, None], RATE, [np.array([0])], piston(), BAND)[0, 0]
    error = np.abs(found - exact).max() / np.abs(exact).max()
    measured(
        "baffled piston on a spring struck by a half sine: largest error over the peak",
        error,
        at_most=0.01,
        source="Runge-Kutta and the closed form on the axis",
    )


def test_rigid_and_undamped_modes_do_not_come_around():
    """A free mass moves as F / m; an undamped one rings on to the end, and nothing of it is there before the blow."""
    modes = Modes(
        np.array([2.0, 1.0]), np.zeros(2), np.array([0.0, (2 * np.pi * 500.0) ** 2]), np.array([[1.0, 0.0], [0.0, 1.0]])
    )
    force = np.column_stack([means(TIME), means(TIME)])
    rows = pressure_rows(np.zeros((1, 3)), np.array([[1e-2, 1e-2]]), np.array([[0, 0, HEIGHT]]), RATE)
    free, rings = sound_of_forces(modes, force, RATE, [np.array([0]), np.array([1])], rows, BAND)[0]
    gain = AIR.density * 1e-2 / (2 * np.pi * HEIGHT)
    exact = in_band(gain * half_sine(TIME - HEIGHT / AIR.speed) / 2.0)
    np.testing.assert_allclose(free, exact, atol=2e-3 * np.abs(exact).max())
    # Amplitude at the end: omega times the Fourier transform of the blow at omega.
    t = np.linspace(0.01, 0.01 + LENGTH, 20_001)
    blow = trapezoid(half_sine(t) * np.exp(2j * np.pi * 500.0 * t), t)
    late = TIME > 0.2
    assert np.abs(rings[late]).max() == pytest.approx(gain * 2 * np.pi * 500.0 * abs(blow), rel=0.01)
    assert np.abs(rings[TIME < 0.005]).max() < 1e-3 * np.abs(rings).max()


def test_stiff_modes_by_their_series(monkeypatch):
    """Modes from four times the band on: the same within (1/4)^4 of their share."""
    rng = np.random.default_rng(2)
    omega = 2 * np.pi * np.array([300.0, 4.1 * BAND, 6 * BAND, 30 * BAND])
    modes = Modes(np.ones(4), 0.02 * omega, omega**2, rng.normal(size=(1, 4)))
    rows = pressure_rows(np.zeros((1, 3)), rng.normal(size=(1, 4)), np.array([[0, 0, HEIGHT]]), RATE)
    force = means(TIME)[:, None]
    short = sound_of_forces(modes, force, RATE, [np.array([0])], rows, BAND)
    monkeypatch.setattr(forced, "STIFF", np.inf)
    whole = sound_of_forces(modes, force, RATE, [np.array([0])], rows, BAND)
    np.testing.assert_allclose(short, whole, atol=1e-4 * np.abs(whole).max())
    assert np.abs(short - whole).max() > 0.0


def test_groups_add_up_and_no_force_is_silence():
    rng = np.random.default_rng(1)
    omega = 2 * np.pi * np.array([120.0, 700.0])
    modes = Modes(np.ones(2), 0.04 * omega, omega**2, rng.normal(size=(3, 2)))
    rows = pressure_rows(np.zeros((1, 3)), np.ones((1, 2)), np.array([[0, 0, 1.0]]), RATE)
    force = means(TIME)[:, None] * np.array([1.0, -2.0, 0.0])
    one, two, none, both = sound_of_forces(
        modes, force, RATE, [np.array([0]), np.array([1]), np.array([2]), np.array([0, 1, 2])], rows, BAND
    )[0]
    np.testing.assert_allclose(one + two, both, atol=1e-12 * np.abs(both).max())
    assert not none.any()


def test_nothing_is_left_outside_the_band():
    assert faded(np.array([5.0, 10.0, BAND, 2 * BAND]), BAND).tolist() == [0.0, 0.0, 0.0, 0.0]
    assert faded(np.array([20.0, 0.85 * BAND]), BAND) == pytest.approx(1.0)


@pytest.mark.parametrize("band", [15.0, 20_000.0, np.nan])
def test_a_band_that_cannot_be_computed_is_refused(band):
    modes = Modes(np.ones(1), np.ones(1), np.ones(1), np.ones((1, 1)))
    rows = pressure_rows(np.zeros((1, 3)), np.ones((1, 1)), np.array([[0, 0, 1.0]]), RATE)
    with pytest.raises(InputError, match="a band up to"):
        sound_of_forces(modes, np.zeros((100, 1)), RATE, [np.array([0])], rows, band)
