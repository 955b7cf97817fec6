"""Exact flow where damping couples the modes: complex modes against closed forms, the exponential and Radau."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.dynamics.diagonal import is_modal
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.flow.coupled import can_couple
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import march
from creak.linalg.complex_modes import _eigenpairs
from creak.reduction.diagonal import diagonalise
from creak.studies.run.integrate import flowing
from creak.verify.events import find_events
from creak.verify.reliability import created_of_contact
from helpers_core import NO_CHANNELS, chain, channels, system_of

RECORDED = {"section": "time"}


def fly(system, gaps, end, step, forces=(), labels=()) -> History:
    time = step / SAMPLES * np.arange(SAMPLES * round(end / step) + 1)
    values = np.stack([f(time) for f in forces], axis=1) if forces else np.zeros((time.size, 0))
    loads = Loads(time, np.zeros((3, time.size, 0)), values, tuple(np.array([x]) for x in labels))
    modal = diagonalise(system)
    assert can_couple(modal)
    return simulate_flow(modal, gaps, loads, OutputRequest(np.arange(system.n)))


def exponential(M, C, K, u, v, t) -> np.ndarray:
    """(t, n) free motion by the matrix exponential of the first-order form."""
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    return np.array([(sla.expm(A * x) @ np.concatenate([u, v]))[:n] for x in t])


def test_two_masses_and_a_dashpot_on_one_of_them(measured):
    """m = 1, k = 1e4 to ground and between, c = 8 on the first alone: free motion by its four complex eigenvalues."""
    M, K, C = np.eye(2), np.array([[2e4, -1e4], [-1e4, 1e4]]), np.diag([8.0, 0.0])
    system = system_of(M, K, extra=C, velocity=np.array([0.0, 1.0]))
    assert not is_modal(diagonalise(system))
    history = fly(system, NO_CHANNELS, 0.5, 1e-2)
    t = history.time[history.output_index]
    # s^4 + 8 s^3 + 3e4 s^2 + 8e4 s + 1e8 = 0; the motion of mass 2 is (s^2 + 8 s + 2e4) / that polynomial.
    roots = np.roots([1.0, 8.0, 3e4, 8e4, 1e8])
    weight = (roots**2 + 8.0 * roots + 2e4) / np.polyval([4.0, 24.0, 6e4, 8e4], roots)
    exact = (weight * np.exp(np.outer(t, roots))).sum(axis=1).real
    off = np.abs(history.displacement[:, 1] - exact).max() / np.abs(exact).max()
    measured("exact flow, two masses, dashpot on one: worst instant", off, at_most=1e-10, source="closed form")


@pytest.mark.parametrize("ratio", [0.1, 0.999999, 1.0, 1.000001, 20.0])
def test_close_to_critical_damping(ratio):
    """A dashpot across one spring of a chain, of the damping that makes its mode critical: no special case."""
    M, K = np.eye(2), np.diag([1e4, 1e4])
    C = 2.0 * ratio * 100.0 * 0.5 * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([0.0, 3.0])
    u, v = np.zeros(2), np.array([1.0, -0.5])
    history = fly(system_of(M, K, extra=C, velocity=v), NO_CHANNELS, 0.1, 1e-3)
    exact = exponential(M, C, K, u, v, history.time[history.output_index])
    np.testing.assert_allclose(history.displacement, exact, atol=1e-9 * np.abs(exact).max())


def test_modes_a_million_times_faster_take_no_digits_of_the_others():
    """Some of 1e9 rad/s, damped 2,000 times critically, as rotations that move next to no mass: each mode is off by
    round-off of itself, not of the fastest one."""
    rng = np.random.default_rng(2)
    omega = np.concatenate([np.geomspace(1e2, 1e6, 30), [1e8, 1e9, 4.8e9]])
    shapes = rng.standard_normal((omega.size, 4)) * np.sqrt(1e-6) * omega[:, None] / 30.0
    C = np.diag(1e-6 * omega**2) + shapes @ shapes.T
    X, Y, B = _eigenpairs(omega, omega, C)
    A = np.block([[np.zeros_like(C), np.diag(omega)], [-np.diag(omega), -C]])
    p = omega.size
    moved = np.hstack([X[:, :p] * B[0] + X[:, p:] * B[2], X[:, :p] * B[1] + X[:, p:] * B[3]])
    assert np.all(np.abs(A @ X - moved).max(axis=1) <= 1e-9 * np.abs(A).max(axis=1))
    np.testing.assert_allclose(X @ Y, np.eye(2 * p), atol=1e-9)


def test_defective_system_is_nudged_apart():
    """Two equal masses side by side, critically damped and coupled by their dampers alone: one Jordan block of four."""
    C = np.array([[200.0, 1e-2], [1e-2, 200.0]])
    v = np.array([1.0, 0.0])
    history = fly(system_of(np.eye(2), 1e4 * np.eye(2), extra=C, velocity=v), NO_CHANNELS, 0.05, 1e-3)
    exact = exponential(np.eye(2), C, 1e4 * np.eye(2), np.zeros(2), v, history.time[history.output_index])
    np.testing.assert_allclose(history.displacement, exact, atol=1e-7 * np.abs(exact).max())


def test_free_body_keeps_its_rigid_motion():
    """Three masses in a row, a dashpot inside, none to ground: centre of mass at constant speed, to round-off."""
    K = 1e4 * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    C = 30.0 * np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    v = np.array([1.0, 0.0, 0.0])
    history = fly(system_of(np.eye(3), K, extra=C, velocity=v), NO_CHANNELS, 1.0, 1e-2)
    t = history.time[history.output_index]
    np.testing.assert_allclose(history.displacement.mean(axis=1), t / 3.0, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(
        history.displacement[:20], exponential(np.eye(3), C, K, np.zeros(3), v, t[:20]), atol=1e-10
    )


def test_forced_motion_keeps_its_energy_books():
    """A push off resonance: amplitude of the harmonic solution, and what the dampers took is what the push gave."""
    M, K = chain(4)
    C = np.diag([0.0, 60.0, 0.0, 12.0])
    f = 2.0 * np.pi * 9.0
    history = fly(system_of(M, K, extra=C), NO_CHANNELS, 4.0, 1.0 / 180.0, [lambda t: np.sin(f * t)], [3])
    t = history.time[history.output_index]
    X = np.linalg.solve(K - f * f * M + 1j * f * C, np.eye(4)[3])
    late = t > 3.0 - 1e-9
    exact = (np.exp(1j * f * t)[:, None] * X).imag
    np.testing.assert_allclose(history.displacement[late], exact[late], atol=2e-4 * np.abs(X).max())
    took = dict(
        zip(ENERGIES, history.energy[-1] - history.energy[np.searchsorted(history.time, 3.0 - 1e-9)], strict=True)
    )
    # Over one second, nine periods: the power of the push is F w |X| sin(phase) / 2.
    assert took["damping"] == pytest.approx(0.5 * f * -X[3].imag, rel=2e-3)
    assert abs(took["scheme"]) < 1e-9 * took["damping"]


@pytest.mark.slow
def test_contact_agrees_with_radau():
    """Eight masses, dashpots on two, thrown at a stop: events of the independent scheme for any System."""
    M, K = chain(8, 0.05, 2e4)
    C = np.zeros((8, 8))
    C[6:, 6:] = 3.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    C[0, 0] = 2.0
    system = system_of(M, K, extra=C, velocity=np.linspace(0.0, -1.0, 8))
    gaps = channels(np.eye(8)[[7, 4]], [1e-3, 2e-3], [1e6, 3e5])
    flown = fly(system, gaps, 0.1, 1e-3)
    time = 2e-6 * np.arange(50_001)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
    stepped = march(FlightStepper(system, gaps, loads, HHT(), 50), OutputRequest(np.arange(8)))
    a, b = (find_events(h, gaps, merge=1e-4, f_max=1e4) for h in (flown, stepped))
    assert len(a) == len(b) > 2
    for one, other in zip(a, b, strict=True):
        assert one.t_start == pytest.approx(other.t_start, abs=1e-6)
        assert one.impulse == pytest.approx(other.impulse, rel=5e-4)
    assert created_of_contact(flown) < 1e-4
    whole = np.isin(flown.time, flown.time[flown.output_index])
    for which in ("kinetic", "strain", "damping"):  # found where whole steps end, lines in between
        column = ENERGIES.index(which)
        off = np.abs(flown.energy[:, column] - np.interp(flown.time, stepped.time, stepped.energy[:, column]))
        assert off[whole].max() < 1e-4 * stepped.energy[0, 0]
        assert off.max() < 0.1 * stepped.energy[0, 0]
    assert np.diff(flown.energy[:, ENERGIES.index("damping")]).min() > -1e-9 * stepped.energy[0, 0]


def test_a_reduced_model_with_a_dashpot_is_flown():
    """Reduced coordinates or dense matrices take exact flow; an unreduced model keeps the scheme that verifies it."""
    M, K = chain(3)
    C = np.diag([0.0, 2.0, 0.0])
    flows, why_not = flowing(system_of(M, K, extra=C, sparse=False))
    assert flows is not None
    assert can_couple(flows)
    assert why_not == ""
    assert flowing(system_of(M, K, extra=C))[0] is None
    light, why_not = flowing(system_of(np.diag([1.0, 1.0, 0.0]), K, extra=C, sparse=False))
    assert light is None
    assert "no mass" in why_not
