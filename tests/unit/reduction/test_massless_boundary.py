"""The massless boundary: the equations of its source, and impacts of an elastic bar."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.linalg as sla

from creak.assembly.part import Rayleigh
from creak.assembly.system import System, to_dense
from creak.dynamics.history import History
from creak.dynamics.loads import at_rest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import modes
from creak.reduction.diagonal import diagonalise
from creak.reduction.gap_modes import gap_modes
from creak.reduction.massless_boundary import massless_boundary
from creak_thesis.plain_newton import simulate_plain_newton
from helpers_core import NO_DAMPING, bar, chain, channels, free_run, system_of, time_axis
from helpers_gap import cantilevers, gap_rows, gaps_between, multisine_base

E_A, RHO_A, LENGTH, SPEED, HEIGHT, C = 900.0, 1.0, 10.0, 10.0, 5.0, 30.0
N = 100
DX = LENGTH / N
STEP = 0.5 * DX / C
TOUCH, DURATION, FORCE = HEIGHT / SPEED, 2.0 * LENGTH / C, RHO_A * C * SPEED
FOOT = np.eye(1, N + 1)


def dropped_bar(beta: float = 0.0) -> System:
    M, K = bar(N, LENGTH, E_A, RHO_A)
    return system_of(M, K, velocity=np.full(N + 1, -SPEED), beta=beta)


@cache
def on_wall(basis: str, count: int, beta: float = 0.0, height: float = HEIGHT) -> History:
    """The bar of 100 elements on a rigid wall, penalty 10 EA/dx, h = dx / 2c, HHT(-0.05)."""
    system = dropped_bar(beta)
    if basis != "full":
        system = {"gap": gap_modes, "massless": massless_boundary}[basis](system, FOOT, count=count)
    gaps = channels(FOOT, height, 10.0 * E_A / DX)
    return simulate(system, gaps, at_rest(time_axis(1.25, STEP)), HHT(), observed=np.arange(N + 1))


def duration(history: History) -> float:
    steps = np.flatnonzero(history.force[:, 0] > 0.0)
    return float((steps[-1] - steps[0] + 1) * STEP)


def impulse(history: History) -> float:
    return float(history.force.sum() * STEP)


def reopenings(history: History) -> int:
    return int(np.count_nonzero(np.diff((history.force[:, 0] > 0.0).astype(int)) == 1)) - 1


def ringing(history: History) -> float:
    """Root mean square of F / 300 - 1 over the contact without its ends."""
    t = history.time - TOUCH
    inside = (t > 0.075 * DURATION) & (t < 0.925 * DURATION)
    return float(np.sqrt(np.mean((history.force[inside, 0] / FORCE - 1.0) ** 2)))


def energy_change(history: History) -> float:
    stored = history.energy[:, :3].sum(axis=1)
    return float(stored[-1] / stored[0] - 1.0)


# --- the equations of the source ---------------------------------------------------------------------------


def macneal(M: np.ndarray, K: np.ndarray, G: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, K and recovery matrix of a held structure in coordinates (g, eta), as the source has them."""
    found = modes(K, M, count=count)
    Phi, m = found.shapes, G.shape[0]
    X = np.linalg.solve(K, G.T) - Phi @ ((Phi.T @ G.T) / found.omega2[:, None])
    stiff = np.linalg.inv(G @ X)
    B = G @ Phi
    K_red = np.block([[stiff, -stiff @ B], [-B.T @ stiff, np.diag(found.omega2) + B.T @ stiff @ B]])
    T = np.hstack([X @ stiff, Phi - X @ stiff @ B])
    return sla.block_diag(np.zeros((m, m)), np.eye(count)), K_red, T


def test_diagonal_form_is_that_of_the_source(measured):
    """Same motion for the same coordinates, same energies: the two differ by a change of coordinates only."""
    M, K = chain(20)
    G = np.zeros((2, 20))
    G[0, 7], G[0, 12], G[1, 19] = 1.0, -1.0, 1.0
    M_red, K_red, T = macneal(M, K, G, 5)
    small = massless_boundary(system_of(M, K), G, count=5)
    V = small.rows(np.arange(20))[0]
    A = np.linalg.lstsq(V, T, rcond=None)[0]
    np.testing.assert_allclose(V @ A, T, atol=1e-10)
    error = np.abs(A.T @ (small.K.d[:, None] * A) - K_red).max() / np.abs(K_red).max()
    measured(
        "reduction",
        "massless boundary: stiffness, relative error",
        error,
        at_most=1e-9,
        source="equations of the source",
    )
    measured(
        "reduction",
        "massless boundary: mass, error",
        np.abs(A.T @ (small.M.d[:, None] * A) - M_red).max(),
        at_most=1e-10,
        source="equations of the source",
    )
    # The first coordinates of the source are the gaps.
    np.testing.assert_allclose(G @ T, np.eye(2, 7), atol=1e-10)


def test_diagonalised_source_is_the_massless_boundary():
    """`diagonalise` splits the massless channels off: same spectrum, same contact."""
    M, K = chain(20)
    G = np.eye(20)[[19]]
    M_red, K_red, _ = macneal(M, K, G, 5)
    start = np.array([0.0, 1.0, -0.5, 0.2, 0.1, 0.0])
    source = system_of(M_red, K_red, velocity=start, sparse=False)
    small = diagonalise(source)
    direct = massless_boundary(system_of(M, K), G, count=5)
    np.testing.assert_allclose(small.K.d, direct.K.d, rtol=1e-9)
    np.testing.assert_array_equal(small.M.d, direct.M.d)
    gaps = channels(np.eye(1, 6), 0.005, 1e6)
    a, b = (free_run(s, gaps, 1.0, 1e-3) for s in (source, small))
    assert 20 < a.contact_steps < 900
    np.testing.assert_allclose(b.force, a.force, atol=1e-8 * a.force.max())
    np.testing.assert_allclose(b.displacement, a.displacement, atol=1e-9)


def test_vibration_without_contact_keeps_the_modes_exact(measured):
    full = cantilevers(NO_DAMPING)
    small = massless_boundary(full, gap_rows(full, gaps_between()), count=9)
    exact = sla.eigh(to_dense(full.K), to_dense(full.M), eigvals_only=True)
    measured(
        "reduction",
        "massless boundary: omega^2 of the kept modes over full, worst",
        small.K.d[:9] / exact[:9],
        1.0,
        rel=1e-8,
        source="full model",
    )
    np.testing.assert_array_equal(small.K.d[9:], 1.0)
    np.testing.assert_array_equal(small.M.d, [1.0] * 9 + [0.0] * 2)
    np.testing.assert_array_equal(small.supports.M_qs[9:], 0.0)
    np.testing.assert_allclose(small.supports.K_qs, 0.0, atol=1e-6 * np.abs(full.supports.K_qs).max())


# --- steps with coordinates without mass -------------------------------------------------------------------


@pytest.mark.parametrize("beta", [0.0, 3e-4])
def test_touching_channel_presses_as_in_the_full_model(beta):
    """A chain thrown against a stop it touches already, in its slowest mode: impulse and motion of the full model."""
    M, K = chain(30)
    velocity = -np.linalg.eigh(K)[1][:, 0]
    full, G = system_of(M, K, beta=beta, velocity=velocity * np.sign(velocity[0])), np.eye(30)[[29]]
    gaps, loads = channels(-G, 0.0, 1e5), at_rest(time_axis(0.2, 1e-3))
    small = massless_boundary(full, G, count=27)
    a, b = (simulate(s, gaps, loads, HHT(), observed=np.arange(30)) for s in (full, small))
    assert a.contact_steps > 50
    assert b.force.sum() == pytest.approx(a.force.sum(), rel=0.005)  # three of thirty modes left out
    np.testing.assert_allclose(b.displacement, a.displacement, atol=0.01 * np.abs(a.displacement).max())
    assert b.energy_created < 2.0 * a.energy_created


def test_imbalance_at_the_start_dies_out_within_a_few_steps():
    """No modes at all: a static spring r + 1/k. HHT weighs an algebraic equation at both ends of a step, so that what
    is out of balance at t = 0 (a channel closed from the start) is left by alpha / (1 + alpha) a step."""
    M, K = chain(10)
    G, k, alpha = np.eye(10)[[9]], 1e5, -0.05
    r = 10.0 / 1e4
    small = massless_boundary(system_of(M, K), G, count=0)
    loads = at_rest(time_axis(0.1, 1e-3))
    history = simulate(small, channels(G, -1e-3, k), loads, HHT(alpha), observed=np.arange(10))
    error = history.force[:, 0] - 1e-3 / (r + 1.0 / k)
    np.testing.assert_allclose(error[3:7] / error[2:6], alpha / (1.0 + alpha), rtol=1e-6)
    np.testing.assert_allclose(error[20:], 0.0, atol=1e-12)
    np.testing.assert_allclose(history.energy[:, 0], 0.0, atol=1e-20)


def test_condensed_contact_equals_plain_newton():
    system = massless_boundary(dropped_bar(), FOOT, count=15)
    gaps, loads = channels(FOOT, 0.05, 10.0 * E_A / DX), at_rest(time_axis(0.1, STEP))
    a, b = (run(system, gaps, loads, HHT(), observed=np.arange(3)) for run in (simulate, simulate_plain_newton))
    assert a.contact_steps > 50
    np.testing.assert_allclose(b.force, a.force, atol=1e-9 * a.force.max())


def test_dashpots_keep_the_matrices_dense_and_the_motion_right():
    full, gaps = cantilevers(Rayleigh(2.0, 1e-6), dashpot=0.5), gaps_between()
    small = massless_boundary(full, gap_rows(full, gaps), f_max=1200.0)
    assert not isinstance(small.M, Diagonal)
    np.testing.assert_array_equal(small.M.diagonal()[-2:], 0.0)
    loads = multisine_base(time_axis(0.12, 2e-4), 20.0, 400.0, 1e-4)
    a, b = (simulate(s, gaps, loads, HHT(), observed=np.array([6 * 8 + 1])) for s in (full, small))
    np.testing.assert_allclose(b.gap, a.gap, atol=0.02 * np.abs(a.gap - 0.02).max())


# --- the bar on a rigid wall: contact .5 to 1.16667, force 300, impulse 200 -------------------------------------


@pytest.mark.parametrize(
    ("count", "time_error", "impulse_error"), [(8, 0.04, 0.02), (15, 0.015, 0.01), (40, 0.005, 0.005)]
)
def test_bar_on_a_rigid_wall(count, time_error, impulse_error):
    """One contact without chatter, hardly any energy lost or made. A contact ends within 1 / (2 f_k) = DURATION / k."""
    history = on_wall("massless", count)
    assert np.flatnonzero(history.force[:, 0])[0] * STEP == pytest.approx(TOUCH, abs=2.0 * STEP)
    assert reopenings(history) == 0
    assert duration(history) == pytest.approx(DURATION, rel=min(time_error, 1.0 / count))
    assert impulse(history) == pytest.approx(200.0, rel=impulse_error)
    # Less than of the full bar, whose shortest waves HHT damps.
    assert -abs(energy_change(on_wall("full", 0))) < energy_change(history) < 1e-5
    assert history.energy_created < 1e-4
    # Truncated modes ring: the force is right on average only, and its peak stays near twice the plateau.
    assert ringing(history) < 0.6
    assert history.force.max() < 2.1 * FORCE


@pytest.mark.parametrize("basis", ["gap", "massless"])
def test_bar_with_many_modes_is_the_full_bar(basis, measured):
    """70 of 101 modes: what the time step does not resolve is left out."""
    full, small = on_wall("full", 0), on_wall(basis, 70)
    assert duration(small) == pytest.approx(duration(full), abs=1.5 * STEP)
    measured(
        "reduction",
        f"bar on a wall, 70 modes, {basis}: impulse over full",
        impulse(small) / impulse(full),
        1.0,
        rel=1e-4,
        source="full model",
    )
    assert energy_change(small) == pytest.approx(energy_change(full), rel=0.02)


@pytest.mark.parametrize(("count", "impulse_error"), [(8, 0.02), (15, 0.01)])
def test_residual_shapes_with_mass_chatter_but_keep_the_impulse(count, impulse_error):
    """The residual shape is an oscillator of its own on the penalty: false re-openings, energy lost or made in them.

    Chatter is chaotic: round-off decides how much energy, so it is the median of five heights that hardly differ.
    """
    heavy, light = on_wall("gap", count), on_wall("massless", count)
    assert reopenings(heavy) > 10
    assert heavy.force.max() > 1.5 * light.force.max()
    changes = [energy_change(on_wall("gap", count, height=HEIGHT * (1.0 + 1e-9 * k))) for k in range(-2, 3)]
    assert np.median(np.abs(changes)) > 4.0 * abs(energy_change(light))
    assert impulse(heavy) == pytest.approx(200.0, rel=impulse_error)
    assert duration(heavy) == pytest.approx(DURATION, rel=0.04)


@pytest.mark.parametrize(("count", "most"), [(15, 0.15), (40, 0.01)])
def test_damping_calms_the_force_and_takes_the_energy_of_the_full_bar(count, most):
    """Stiffness-proportional damping, 4 % at the 15th mode, 11 % at the 40th; it acts on the massless shape too."""
    beta = 5e-4
    full, small = on_wall("full", 0, beta), on_wall("massless", count, beta)
    assert energy_change(small) == pytest.approx(energy_change(full), rel=0.005)
    assert impulse(small) == pytest.approx(impulse(full), rel=5e-4)
    assert duration(small) == pytest.approx(duration(full), abs=2.5 * STEP)
    assert ringing(small) < 0.5 * ringing(on_wall("massless", count))
    assert ringing(small) < most
