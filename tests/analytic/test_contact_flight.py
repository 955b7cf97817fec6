"""Contact between flights of high order: closed forms of the mass on its stop and of the elastic bar."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import march
from creak.verify.events import find_events
from helpers_core import bar, channels, forces_on, system_of, time_axis

RECORDED = {"section": "contact", "source": "closed form"}

SCHEME = ENERGIES.index("scheme")


# --- m = 100, k = 1e4, stop 1e6, no gap, v0 = 1 (downward): steps of 10 ms, a third of the contact -------------------

OMEGA = np.sqrt(1.01e6 / 100.0)
STOP = channels([[1.0]], 0.0, 1e6)


def on_stop(parts: int) -> History:
    mass = system_of(np.array([[100.0]]), np.array([[1e4]]), velocity=np.array([-1.0]))
    loads = at_rest(time_axis(0.3, 1e-2 / parts))
    return march(FlightStepper(mass, STOP, loads, HHT(), parts), OutputRequest(np.array([0])))


def test_mass_on_a_penalty_stop(measured):
    history = on_stop(200)
    event = find_events(history, STOP, merge=0.0, f_max=1e6)[0]
    # Contact steps with omega h = .005: 2e-6 of the scheme, as much of the interpolated release.
    assert event.force_peak == pytest.approx(9950.3719, rel=5e-6)
    # Then it swings on its own spring, a half turn long, in 26 flights with omega h = .1.
    t = history.time[history.output_index] - np.pi / OMEGA
    away = (t > 0.0) & (t < 0.99 * np.pi / 10.0)
    np.testing.assert_allclose(history.displacement[away, 0], 0.1 * np.sin(10.0 * t[away]), atol=1e-6)
    assert history.time.size < 4 * 200 + 30
    measured("mass on a penalty stop, flights: impulse", event.impulse, 198.01980, rel=5e-6, unit="N s")
    measured("mass on a penalty stop, flights: duration", event.t_end - event.t_start, 0.0312600153, rel=5e-6, unit="s")


def test_error_on_a_stop_falls_with_the_square_of_the_parts():
    impulse = [find_events(on_stop(n), STOP, merge=0.0, f_max=1e6)[0].impulse for n in (25, 50, 100, 200)]
    errors = np.abs(np.array(impulse) / 198.01980 - 1.0)
    # The release falls between two parts: only on the whole of the second order.
    assert errors[0] > 6.0 * errors[2] > 0.0
    assert errors[1] > 6.0 * errors[3] > 0.0


# --- bar on a rigid wall: E = 900, rho = 1, A = 1, L = 10, speed 10 from height 5 ------------------------------------

E_A, RHO_A, LENGTH, SPEED, HEIGHT, C = 900.0, 1.0, 10.0, 10.0, 5.0, 30.0
STEP = 1.0 / 30.0
"""A tenth of the way of a wave through the bar."""


@cache
def on_wall(n: int, parts: int) -> History:
    M, K = bar(n, LENGTH, E_A, RHO_A)
    gaps = channels(np.eye(1, n + 1), HEIGHT, 10.0 * E_A * n / LENGTH)
    system = system_of(M, K, velocity=np.full(n + 1, -SPEED))
    loads = at_rest(time_axis(1.4, STEP / parts))
    return march(FlightStepper(system, gaps, loads, HHT(), parts), OutputRequest(np.arange(n + 1)))


def test_bar_on_a_rigid_wall(measured):
    """Contact .5 to 1.16667, impulse 200, leaves at +10."""
    n, parts = 200, 40
    history = on_wall(n, parts)
    weights = history.weights @ history.force
    pressed = history.time[history.force[:, 0] > 0.0]
    # The smeared front and the penalty's compliance of dx / 10, as with HHT throughout (test_contact_bar).
    assert pressed[0] == pytest.approx(0.5, abs=2 * STEP / parts)
    assert pressed[-1] - pressed[0] == pytest.approx(2.0 * LENGTH / C, rel=0.01)
    inside = (history.time > 0.55) & (history.time < 1.11)
    assert history.force[inside, 0].mean() == pytest.approx(300.0, rel=0.005)
    leaving = np.diff(history.displacement[-2:], axis=0) / STEP
    assert leaving.mean() == pytest.approx(SPEED, rel=0.01)
    assert history.energy_created < 1e-9
    # Undeformed on leaving but for the smeared front, which flights of a tenth of the bar damp.
    assert history.energy[-1, SCHEME] < 0.015 * history.energy[0, 0]
    measured("bar on a wall, flights: impulse", weights[0], 200.0, rel=0.005, unit="N s")


def test_flights_bring_the_bar_to_the_wall_in_seconds_of_steps():
    """15 flights before, 7 after, 21 divided steps between."""
    history = on_wall(200, 40)
    long = np.diff(history.time) > 0.5 * STEP
    assert long.sum() >= 20
    assert history.time.size <= 22 + 21 * 40


# --- bouncing bar (Doyen, Ern, Piperno 2011) -------------------------------------------------------------------------

POINTS = {0.5: 3.75, 1.8: 0.533333, 2.0: 1.666667, 2.5: 4.027778, 3.0: 4.444444, 3.5: 0.694444, 4.5: 1.527778}


@cache
def bouncing(n: int, step: float, parts: int) -> History:
    """The mean of consistent and lumped mass: phase errors of the fourth order."""
    M, K = bar(n, LENGTH, E_A, RHO_A)
    M = 0.5 * (M + np.diag(M.sum(axis=1)))
    gaps = channels(np.eye(1, n + 1), HEIGHT, 10.0 * E_A * n / LENGTH)
    time = time_axis(4.6, step / parts)
    weight = forces_on(time, list(range(n + 1)), np.outer(np.ones(time.size), -10.0 * M.sum(axis=1)))
    return march(FlightStepper(system_of(M, K), gaps, weight, HHT(), parts), OutputRequest(np.array([0])))


def bottom(history: History) -> np.ndarray:
    t = history.time[history.output_index]
    return np.interp(list(POINTS), t, HEIGHT + history.displacement[:, 0])


def test_bouncing_bar(measured):
    """Two contacts of 266.667 and the way of the bottom; both converge as step and mesh are refined together."""
    impulses, errors = [], []
    for n, step, parts in ((36, 0.028, 20), (72, 0.014, 20), (144, 0.007, 20)):
        history = bouncing(n, step, parts)
        first = history.time < 2.5
        force = history.weights * history.force[:, 0]
        impulses.append((force[first].sum(), force[~first].sum()))
        errors.append(np.abs(bottom(history) - list(POINTS.values())).max())
        assert history.energy_created < 1e-3
    missing = np.abs(np.array(impulses) / (800.0 / 3.0) - 1.0)
    assert (np.diff(missing[:, 1]) < 0.0).all()
    assert (np.diff(errors) < 0.0).all()
    # Weight for 4.6 s is 460; the wave fronts that a step smears are what is missing.
    assert errors[-1] < 0.1
    measured("bouncing bar, flights: impulse {}", np.array(impulses[-1]), np.full(2, 800.0 / 3.0), rel=0.01, unit="N s")
