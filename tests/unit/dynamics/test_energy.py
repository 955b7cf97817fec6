"""The energy balance: nothing is created, dampers only take, the rest shrinks with the scheme's order."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import trapezoid

from creak.dynamics.history import ENERGIES, History
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from helpers_core import NO_CHANNELS, chain, channels, forces_on, free_run, system_of, time_axis

RECORDED = {"section": "energy", "source": "conservation"}

KINETIC, STRAIN, CONTACT, DAMPING, CONTACT_DAMPING, FRICTION, EXTERNAL, SCHEME = range(len(ENERGIES))
N = 12


@cache
def rattling(h: float, alpha: float = -0.05, *, stiffness: float = 2e5, damper: float = 0.0) -> History:
    """A chain pushed against four stops on both sides."""
    M, K = chain(N)
    system = system_of(M, K, alpha=0.4, beta=1e-5)
    G = np.zeros((4, N))
    G[0, 5], G[1, 8], G[2, 11], G[3, 11] = 1.0, -1.0, 1.0, -1.0
    gaps = channels(G, np.array([1e-3, 1.5e-3, 3e-3, 3e-3]), stiffness, damper)
    time = time_axis(1.0, h)
    push = 8.0 * np.sin(2 * np.pi * 1.9 * time) + 4.0 * np.sin(2 * np.pi * 7.0 * time)
    return simulate(system, gaps, forces_on(time, [N - 1], push), HHT(alpha), OutputRequest(np.arange(N)))


def test_columns_are_named_in_order():
    assert ENERGIES == ("kinetic", "strain", "contact", "damping", "contact_damping", "friction", "external", "scheme")


@pytest.mark.parametrize("alpha", [-0.05, 1.0 - np.sqrt(2.0)])
def test_contact_creates_no_energy(alpha, measured):
    """What is left over is never below -.5 % of the external work: a soft enough penalty with dissipation."""
    history = rattling(5e-4, alpha)
    assert history.contact_steps > 100
    assert (history.energy[:, SCHEME] >= -0.005 * history.energy_scale).all()
    measured(f"chain between stops, alpha {alpha:.3g}: share of energy created", history.energy_created, at_most=0.005)


def test_leftover_shrinks_with_the_step(measured):
    """An impact on a penalty is caught within (omega h)^2 of its energy: halving the step at least halves the rest."""
    left = [np.abs(rattling(h).energy[:, SCHEME]).max() for h in (1e-3, 5e-4, 2.5e-4)]
    measured(
        "chain between stops: what is left over, ratio of half the step",
        max(left[1] / left[0], left[2] / left[1]),
        at_most=0.5,
        source="second order",
    )


def test_dampers_only_take():
    history = rattling(5e-4, damper=30.0)
    for column in (DAMPING, CONTACT_DAMPING):
        taken = history.energy[:, column]
        # The trapezoidal rule of v C v over a step may dip by the scheme's error where v changes sign.
        assert np.diff(taken).min() >= -1e-4 * taken[-1]
        assert taken[-1] > 0.0
    assert history.energy_created <= 0.005


def test_balance_adds_up(measured):
    """stored + taken + scheme = external + initial, at every step, to round-off."""
    e = rattling(5e-4, damper=30.0).energy
    total = e[:, [KINETIC, STRAIN, CONTACT, DAMPING, CONTACT_DAMPING, SCHEME]].sum(axis=1)
    error = np.abs(total - e[:, EXTERNAL]).max() / np.abs(e).max()
    measured("chain between stops: sum of the energy table, relative error", error, at_most=1e-12, source="definition")


def test_external_work_of_a_force_is_force_times_way(measured):
    M, K = chain(3)
    time = time_axis(0.5, 1e-4)
    force = 3.0 * np.sin(40.0 * time)
    history = simulate(system_of(M, K), NO_CHANNELS, forces_on(time, [2], force), HHT(), OutputRequest(np.arange(3)))
    velocity = np.gradient(history.displacement[:, 2], 1e-4)
    # Trapezoidal rule in time: (omega h)^2 with omega up to 180 rad/s.
    expected = trapezoid(force * velocity, dx=1e-4)
    measured(
        "chain under a force: external work",
        history.energy[-1, EXTERNAL],
        expected,
        rel=1e-3,
        unit="J",
        source="force times way",
    )


def test_free_undamped_motion_loses_only_what_hht_takes():
    """Damping ratio -alpha (1+alpha)^2 Omega^3 / 8: the loss over a time t is 2 zeta omega t of the energy."""
    omega, h, alpha = 50.0, 2e-3, -0.05
    system = system_of(np.eye(1), np.array([[omega**2]]), velocity=np.ones(1))
    history = free_run(system, NO_CHANNELS, 2.0, h, alpha)
    zeta = -alpha * (1 + alpha) ** 2 * (omega * h) ** 3 / 8
    lost = history.energy[-1, SCHEME] / history.energy[0, KINETIC]
    # Leading order; the next is smaller by Omega = .1, and the energy itself swings by alpha Omega^2 / 4 over a period.
    assert lost == pytest.approx(2 * zeta * omega * 2.0, rel=0.15, abs=abs(alpha) * (omega * h) ** 2)


def test_average_acceleration_keeps_energy_exactly(measured):
    """alpha = 0 on a linear system: the trapezoidal works are exact, nothing is left over but round-off."""
    M, K = chain(N)
    system = system_of(M, K, alpha=0.4, beta=1e-4, velocity=np.linspace(0, 1, N))
    time = time_axis(0.5, 1e-3)
    loads = forces_on(time, [N - 1], np.sin(30 * time))
    history = simulate(system, NO_CHANNELS, loads, HHT(0.0), OutputRequest(np.arange(N)))
    np.testing.assert_allclose(history.energy[:, SCHEME], 0.0, atol=1e-3 * history.energy_scale)
    undamped = free_run(system_of(M, K, velocity=np.linspace(0, 1, N)), NO_CHANNELS, 0.5, 1e-3, 0.0)
    error = np.abs(undamped.energy[:, SCHEME]).max() / undamped.energy_scale
    measured("alpha = 0, free chain: energy not accounted for, relative", error, at_most=1e-10)


def test_leftover_of_a_smooth_linear_run_is_of_the_third_order():
    """HHT's own dissipation: Omega^3 per radian, Omega^2 per unit of time in the work's rule; observed 2 to 3."""
    M, K = chain(4, stiffness=400.0)
    left = []
    for h in (4e-3, 2e-3, 1e-3):
        time = time_axis(1.0, h)
        ramp = np.clip(time / 0.5, 0.0, 1.0)
        load = 5.0 * ramp**3 * (10 - 15 * ramp + 6 * ramp**2)
        history = simulate(system_of(M, K), NO_CHANNELS, forces_on(time, [3], load), HHT(), OutputRequest(np.arange(4)))
        left.append(np.abs(history.energy[:, SCHEME]).max())
    order = np.log2(np.array(left[:-1]) / left[1:])
    assert (order > 1.8).all()
    assert (order < 3.3).all()


def test_a_run_that_starts_closed_keeps_its_balance():
    """A preloaded stop (negative initial gap) accelerates the mass from the first instant."""
    m, k, depth, h = 1.0, 1e4, 1e-3, 1e-4
    gaps = channels([[1.0]], -depth, k)
    history = free_run(system_of(np.eye(1) * m, np.zeros((1, 1))), gaps, 0.05, h)
    assert history.energy[0, CONTACT] == pytest.approx(0.5 * k * depth**2)
    w = np.sqrt(k / m)
    u = history.displacement[:, 0]
    inside = history.time < 0.015
    # u = depth (1 - cos w t) while pressed; (w h)^2 / 12 = 1e-5 from the scheme.
    np.testing.assert_allclose(u[inside], depth * (1 - np.cos(w * history.time[inside])), atol=2e-4 * depth)
    leaving = (u[-1] - u[-2]) / h
    assert leaving == pytest.approx(depth * w, rel=1e-3)
    assert history.energy_created < 1e-3
