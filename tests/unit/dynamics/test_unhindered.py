"""Gaps without contact by whole flight steps: against SciPy's integrator, and against the march."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from creak.assembly.part import Rayleigh
from creak.dynamics.flow import unhindered
from creak.dynamics.flow.lowest import CLOSE, LITTLE
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.flow.unhindered import gaps_without_contact
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from helpers_core import chain, channels, system_of
from helpers_gap import cantilevers, gaps_between, multisine_base

H, STEPS = 4e-3, 50
GAPS = channels(np.array([[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, 0.0]]), np.array([0.3, 0.1]), 0.0)


def force(t):
    """N, a cubic of time: no step of it is approximated."""
    return 3.0 + 20.0 * t - 500.0 * t**2 + 2000.0 * t**3


@pytest.mark.parametrize("extra", [None, np.diag([8.0, 0.0, 0.0, 30.0])], ids=["single modes", "coupled"])
def test_gaps_are_those_of_scipys_integrator(extra, monkeypatch):
    monkeypatch.setattr(unhindered, "CHUNK", 7)
    M, K = chain(4)
    M[1, 1] = 2.5
    velocity = np.array([0.0, 0.4, -0.2, 1.0])
    system = system_of(M, K, alpha=0.5, beta=1e-4, extra=extra, velocity=velocity)
    C = 0.5 * M + 1e-4 * K + (0.0 if extra is None else extra)
    time = H / SAMPLES * np.arange(SAMPLES * STEPS + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), force(time)[:, None], (np.array([2]),))
    found = gaps_without_contact(diagonalise(system), GAPS, loads)

    def rate(t, y):
        push = np.zeros(4)
        push[2] = force(t)
        return np.concatenate([y[4:], np.linalg.solve(M, push - C @ y[4:] - K @ y[:4])])

    exact = solve_ivp(
        rate,
        (0.0, H * STEPS),
        np.concatenate([np.zeros(4), velocity]),
        "DOP853",
        time[::SAMPLES],
        rtol=1e-11,
        atol=1e-13,
    ).y[:4]
    expected = np.array([0.3 + exact[0] - exact[3], 0.1 + exact[1]]).T
    np.testing.assert_allclose(found.at, expected, atol=1e-9)


@pytest.mark.parametrize("extra", [None, np.diag([2e3, 0.0, 0.0, 5e3])], ids=["single modes", "coupled"])
def test_a_gap_that_rings_shut_between_two_steps_is_found(extra, monkeypatch):
    """Modes up to 4 kHz and flight steps of 1 ms: a push that is there at once, and a throw, by SciPy's integrator."""
    monkeypatch.setattr(unhindered, "CHUNK", 7)
    M, K = chain(4, stiffness=2e8)
    K[3, 3] = 3e4
    K[2, 3] = K[3, 2] = -1e4
    velocity = np.array([0.0, 0.0, 0.3, 0.0])
    system = system_of(M, K, beta=2e-6, extra=extra, velocity=velocity)
    C = 2e-6 * K + (0.0 if extra is None else extra)
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 40 + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.full((time.size, 1), -5e3), (np.array([1]),))
    gaps = channels(GAPS.G.toarray(), np.full(2, 6e-5), 0.0)
    silent = gaps_without_contact(diagonalise(system), gaps, loads)

    def rate(t, y):
        push = np.array([0.0, -5e3, 0.0, 0.0])
        return np.concatenate([y[4:], np.linalg.solve(M, push - C @ y[4:] - K @ y[:4])])

    y0, fine = np.concatenate([np.zeros(4), velocity]), np.linspace(0.0, 0.04, 40_001)
    u = solve_ivp(rate, (0.0, 0.04), y0, "DOP853", fine, rtol=1e-9, atol=1e-13).y[:4]
    lowest = 6e-5 + np.array([u[0] - u[3], u[1]]).min(axis=1)
    room = CLOSE * (gaps.gap0 - lowest)
    assert (np.abs(silent.lowest - lowest) <= np.maximum(room, CLOSE * LITTLE * gaps.gap0)).all()
    assert (silent.at.min(axis=0) > lowest + 3.0 * room).any()


@pytest.mark.parametrize("dashpot", [0.0, 40.0])
def test_gaps_on_moving_supports_are_those_of_the_march(dashpot):
    system = cantilevers(Rayleigh(2.0, 1e-6), dashpot=dashpot)
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 400 + 1)
    loads, gaps = multisine_base(time, 5.0, 60.0, 1e-3), gaps_between()
    modal = diagonalise(system)
    told = []
    found = gaps_without_contact(modal, gaps, loads, lambda done, total: told.append((done, total)))
    history = simulate_flow(modal, gaps, loads, OutputRequest(gaps.labels))
    expected = gaps.gap0 + history.displacement @ gaps.G.T  # its own gaps are seen through a filter
    np.testing.assert_allclose(found.at, expected, atol=1e-10 * np.ptp(found.at))
    assert (found.lowest <= found.at.min(axis=0)).all()
    assert told[-1] == (800, 800)
