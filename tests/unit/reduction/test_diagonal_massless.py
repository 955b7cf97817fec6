"""Diagonalisation of Systems in which some directions have no mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla

from creak.assembly.system import Stats
from creak.dynamics.loads import at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.errors import NumericalError
from creak.reduction.diagonal import all_modes, diagonalise
from helpers_core import chain, channels, forces_on, simulate_plain_newton, system_of, time_axis

ALL = np.arange(8)


def hinged_chain(light: tuple[int, ...], mix: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """A chain of eight, some links without mass, in coordinates that hide which (unless not `mix`)."""
    M, K = chain(8)
    M[light, light] = 0.0
    T = np.eye(8) + (0.3 * np.random.default_rng(5).standard_normal((8, 8)) if mix else 0.0)
    return T.T @ M @ T, T.T @ K @ T


@pytest.mark.parametrize("mix", [False, True])
@pytest.mark.parametrize("light", [(3,), (0, 4, 5, 7)])
def test_massless_directions_are_split_off(light, mix):
    M, K = hinged_chain(light, mix)
    small = diagonalise(system_of(M, K, sparse=False))
    Phi = small.rows(ALL)[0]
    heavy = 8 - len(light)
    np.testing.assert_array_equal(small.M.d, [1.0] * heavy + [0.0] * len(light))
    np.testing.assert_array_equal(small.K.d[heavy:], 1.0)
    # Round-off.
    np.testing.assert_allclose(Phi.T @ M @ Phi, np.diag(small.M.d), atol=1e-11)
    np.testing.assert_allclose(Phi.T @ K @ Phi, np.diag(small.K.d), atol=1e-10 * small.K.d.max())
    # Static condensation of the plain chain gives the finite frequencies.
    _, plain = hinged_chain(light, mix=False)
    o, i = np.setdiff1d(ALL, light), np.array(light)
    condensed = plain[np.ix_(o, o)] - plain[np.ix_(o, i)] @ np.linalg.solve(plain[np.ix_(i, i)], plain[np.ix_(i, o)])
    np.testing.assert_allclose(small.K.d[:heavy], np.linalg.eigvalsh(condensed), rtol=1e-9)


@pytest.mark.parametrize("damping", [(0.0, 0.0), (1.5, 2e-4)])
def test_transient_is_unchanged(damping):
    """All directions are kept: a change of basis, contact on a massless coordinate included."""
    M, K = hinged_chain((3, 7), mix=True)
    system = system_of(M, K, alpha=damping[0], beta=damping[1], velocity=np.cos(ALL), sparse=False)
    time = time_axis(0.6, 1e-3)
    loads = forces_on(time, [7], 300.0 * np.sin(40.0 * time))
    gaps = channels(np.eye(8)[[7]], 0.01, 1e5)
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(ALL)) for s in (system, diagonalise(system)))
    assert 0 < a.contact_steps < time.size
    np.testing.assert_allclose(b.displacement, a.displacement, atol=1e-9 * np.abs(a.displacement).max())
    np.testing.assert_allclose(b.force, a.force, atol=1e-8 * a.force.max())
    np.testing.assert_allclose(b.energy, a.energy, atol=1e-8 * np.abs(a.energy).max())


def test_initial_velocity_is_kept_in_massless_directions_too():
    M, K = hinged_chain((2, 6))
    v = np.sin(ALL + 1.0)
    small = diagonalise(system_of(M, K, velocity=v, sparse=False))
    np.testing.assert_allclose(small.rows(ALL)[0] @ small.velocity, v, atol=1e-11)


def test_little_mass_is_mass():
    """Coordinates in very different units (1e-12 against 1) are not taken for massless ones."""
    M, K = chain(8)
    scale = np.where(ALL % 2, 1e-6, 1.0)
    small = diagonalise(system_of(M * scale * scale[:, None], K * scale * scale[:, None], sparse=False))
    np.testing.assert_array_equal(small.M.d, 1.0)
    np.testing.assert_allclose(small.K.d, np.linalg.eigvalsh(K), rtol=1e-8)


def test_neither_mass_nor_stiffness_is_an_error():
    M, K = chain(8)
    M[3, 3] = 0.0
    K[3], K[:, 3] = 0.0, 0.0
    with pytest.raises(NumericalError, match="neither mass nor stiffness"):
        diagonalise(system_of(M, K, sparse=False))


def test_statistics_and_labels_stay():
    M, K = hinged_chain((1,))
    system = replace(system_of(M, K, sparse=False), stats=Stats(modes=4))
    small = diagonalise(system)
    assert small.stats == Stats(modes=4)
    np.testing.assert_array_equal(small.labels, ALL)
    np.testing.assert_allclose(small.recover(np.eye(8)), small.rows(ALL)[0])


def test_imbalance_at_the_start_dies_out_within_a_few_steps():
    """A spring without mass. HHT weighs an algebraic equation at both ends of a step, so that what is out of balance at
    t = 0 (a channel closed from the start) is left by alpha / (1 + alpha) a step."""
    flexibility, k, alpha = 1e-3, 1e5, -0.05
    system = diagonalise(system_of(np.zeros((1, 1)), np.array([[1.0 / flexibility]]), sparse=False))
    loads = at_rest(time_axis(0.1, 1e-3))
    history = simulate(system, channels(np.eye(1), -1e-3, k), loads, HHT(alpha), OutputRequest(np.zeros(1, dtype=int)))
    error = history.force[:, 0] - 1e-3 / (flexibility + 1.0 / k)
    np.testing.assert_allclose(error[3:7] / error[2:6], alpha / (1.0 + alpha), rtol=1e-6)
    np.testing.assert_allclose(error[20:], 0.0, atol=1e-12)
    np.testing.assert_allclose(history.energy[:, 0], 0.0, atol=1e-20)


def test_condensed_contact_without_mass_equals_plain_newton():
    M, K = chain(8)
    M[7, 7] = 0.0
    system = diagonalise(system_of(M, K, velocity=np.where(ALL < 7, 1.0, 0.0), sparse=False))
    gaps, loads = channels(-np.eye(8)[[7]], 0.005, 1e5), at_rest(time_axis(0.3, 1e-3))
    a, b = (run(system, gaps, loads, HHT(), OutputRequest(ALL)) for run in (simulate, simulate_plain_newton))
    assert a.contact_steps > 50
    np.testing.assert_allclose(b.force, a.force, atol=1e-9 * a.force.max())


def test_masses_of_round_off_are_none():
    """As of static shapes in which massless rotations alone move: each held against the stiffness of its coordinate.

    The modes are those without these masses, of the stiffness condensed to the rest (Guyan; exact without mass).
    """
    rng, n, none = np.random.default_rng(3), 40, 8
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, n - none))
    K = 1e5 * (A @ A.T + np.eye(n))
    M = np.zeros((n, n))
    M[none:, none:] = 1e-6 * (B[none:] @ B[none:].T + np.eye(n - none))
    noise = np.zeros((n, n))
    noise[:none] = 1e-22 * rng.uniform(-1.0, 1.0, (none, n))
    faint = np.append(np.logspace(-11, -9, none), np.zeros(n - none))
    M += np.outer(faint, faint) + 0.5 * (noise + noise.T)
    condensed = K[none:, none:] - K[none:, :none] @ np.linalg.solve(K[:none, :none], K[:none, none:])
    omega2, Phi, N = all_modes(K, M)
    known = sla.eigh(condensed, M[none:, none:], eigvals_only=True)
    assert N.shape == (n, none)
    assert omega2 == pytest.approx(known, rel=1e-6)
    assert np.abs(N.T @ K @ N - np.eye(none)).max() < 1e-9
    assert np.abs(Phi.T @ M @ Phi - np.eye(n - none)).max() < 1e-6
