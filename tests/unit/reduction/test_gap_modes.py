"""Modes plus residual flexibility of the gap channels: what the basis keeps."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import to_dense
from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.dynamics.history import History
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.errors import InputError, NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import factor, regular_factor
from creak.linalg.modes import modes, small_shift
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.diagonal import diagonalise
from creak.reduction.gap_modes import gap_modes
from creak.reduction.modal import modal_system, support_motion, with_modal_damping
from helpers_core import NO_DAMPING, bar, chain, forces_on, free_run, system_of, time_axis
from helpers_core import channels as channels_on
from helpers_gap import LABELS, cantilevers, gap_rows, gaps_between, multisine_base

RECORDED = {"section": "reduction", "source": "full model"}

EVERYWHERE = np.arange(LABELS)


def static_answer(system: System, forces: np.ndarray, s: np.ndarray) -> np.ndarray:
    """q of K q = G' p - K_qs s, on a diagonal System without its rigid-body modes."""
    f = forces - np.asarray(to_dense(system.supports.K_qs) @ s)
    k = to_dense(system.K).diagonal() if isinstance(system.K, Diagonal) else None
    if k is None:
        return np.linalg.solve(to_dense(system.K), f)
    return np.where(k > 0.0, f / np.where(k > 0.0, k, 1.0), 0.0)


# --- statics ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [0, 1, 6, 30])
def test_answer_to_channel_forces_and_support_motion_is_exact_everywhere(count, measured):
    full, gaps = cantilevers(NO_DAMPING), gaps_between()
    G, p, s = gap_rows(full, gaps), np.array([3.0, -7.0]), np.array([0.01])
    small = gap_modes(full, G, count=count)
    exact = full.recover(static_answer(full, G.T @ p, s), s)
    found = small.recover(static_answer(small, gap_rows(small, gaps).T @ p, s), s)
    # Round-off: eps x condition of K (1e7).
    error = np.abs(found - exact).max() / np.abs(exact).max()
    measured("gap modes: static answer to channel forces and supports, relative error", error, at_most=1e-9)
    assert small.stats.modes == count
    assert small.stats.retained == 2
    assert small.n == count + 2


def test_answer_of_a_free_structure_is_exact():
    """Forces in balance on two free beams tied by a spring: K u = G' p to round-off, from inertia relief."""
    full, gaps = cantilevers(NO_DAMPING, driven=False), gaps_between()
    G = gap_rows(full, gaps)
    small = gap_modes(full, G, count=25)
    q = static_answer(small, gap_rows(small, gaps).T @ np.array([1.0, 0.0]), np.zeros(0))
    R = small.rows(full.coordinates)[0]
    rigid = modes(full.K, full.M, count=25, free=True)
    rigid = rigid.shapes[:, rigid.omega2 == 0.0]
    f = G[0] - full.M @ (rigid @ (rigid.T @ G[0]))
    assert np.abs(f).max() > 0.01 * np.abs(G[0]).max()
    # The rigid-body modes themselves are K-null to 1e-8 of the stiffness.
    np.testing.assert_allclose(full.K @ (R @ q), f, rtol=0, atol=1e-6)


@pytest.mark.parametrize("extra_modes", [0, 3])
def test_free_bar_under_balanced_forces_equals_the_held_one(extra_modes):
    """A bar pulled at both ends stretches by F L / EA; large enough for the sparse route."""
    n, length, rigidity = 700, 10.0, 900.0
    M, K = bar(n, length, rigidity, 1.0)
    system, G = system_of(M, K), np.zeros((1, n + 1))
    G[0, 0], G[0, -1] = -1.0, 1.0
    assert regular_factor(system.K) is None
    small = gap_modes(system, sp.csr_matrix(G), count=1 + extra_modes)
    R = small.rows(np.array([0, n]))[0]
    u = R @ static_answer(small, R.T @ np.array([-5.0, 5.0]), np.zeros(0))
    # Refined three times; what is left is round-off x (n^2 = 5e5).
    assert u[1] - u[0] == pytest.approx(5.0 * length / rigidity, rel=1e-9)
    assert small.K.d[0] == 0.0


def test_answers_to_applied_forces_can_be_appended():
    full, gaps = cantilevers(NO_DAMPING), gaps_between()
    G, label = gap_rows(full, gaps), np.array([6 * 3 + 1])
    load = full.rows(label)[0].T.toarray()
    exact = np.linalg.solve(to_dense(full.K), load)
    with_it, without = (gap_modes(full, G, count=4, static=x) for x in (exact, None))
    assert with_it.stats.retained == 3
    errors = [
        np.abs(s.recover(static_answer(s, s.rows(label)[0][0], np.zeros(1))) - full.recover(exact)[:, 0]).max()
        for s in (with_it, without)
    ]
    assert errors[0] < 1e-9 * np.abs(exact).max()
    assert errors[1] > 1e-4 * np.abs(exact).max()


def test_dependent_channels_are_dropped_and_change_nothing():
    """A channel twice, their sum, and one that moves nothing."""
    full = cantilevers(NO_DAMPING)
    G = gap_rows(full, gaps_between())
    more = np.vstack([G, G[0], G[0] + G[1], 0.0 * G[0]])
    plain, small = gap_modes(full, G, count=5), gap_modes(full, more, count=5)
    assert (small.stats.retained, small.stats.dropped) == (2, 3)
    for channel_rows in (G, more):
        exact = channel_rows @ np.linalg.solve(to_dense(full.K), channel_rows.T)
        rows = channel_rows @ small.rows(full.coordinates)[0]
        np.testing.assert_allclose(rows @ (rows.T / small.K.d[:, None]), exact, atol=1e-9 * np.abs(exact).max())
    np.testing.assert_allclose(np.sort(small.K.d), np.sort(plain.K.d), rtol=1e-8)


# --- modes -----------------------------------------------------------------------------------------------


def test_frequencies_are_upper_bounds_and_exact_where_modes_are_kept():
    full = cantilevers(NO_DAMPING)
    exact = sla.eigh(to_dense(full.K), to_dense(full.M), eigvals_only=True)
    G = gap_rows(full, gaps_between())
    for count in (0, 3, 9):
        found = np.sort(gap_modes(full, G, count=count).K.d)
        assert (found >= exact[: found.size] * (1 - 1e-8)).all()  # Rayleigh-Ritz, to round-off
        np.testing.assert_allclose(found[:count], exact[:count], rtol=1e-8)


@pytest.mark.parametrize("driven", [True, False])
def test_reduced_matrices_are_the_projected_ones(driven):
    """M = I and K diagonal are what V' M V and V' K V are, to round-off."""
    full = cantilevers(NO_DAMPING, driven=driven)
    small = gap_modes(full, gap_rows(full, gaps_between()), count=15)
    V = small.rows(full.coordinates)[0]
    scale = np.sqrt(np.maximum(small.K.d, 1.0))
    np.testing.assert_allclose(V.T @ (full.M @ V), np.eye(small.n), atol=1e-8)
    found = V.T @ (full.K @ V) / scale / scale[:, None]
    np.testing.assert_allclose(found, np.diag(small.K.d) / scale / scale[:, None], atol=1e-6)


def test_limit_count_and_given_modes_are_one_choice():
    full = cantilevers(NO_DAMPING)
    G = gap_rows(full, gaps_between())
    found = modes(full.K, full.M, count=8)
    f = found.frequencies
    by_limit = gap_modes(full, G, f_max=0.5 * (f[4] + f[5]))
    assert by_limit.stats.modes == 5
    assert by_limit.stats.first_left_out == pytest.approx(f[5], rel=1e-8)
    by_count = gap_modes(full, G, count=5)
    given = modes(full.K, full.M, count=5)
    by_modes = gap_modes(full, G, modes=given, stiffness=factor(full.K))
    for other in (by_count, by_modes):
        np.testing.assert_allclose(np.sort(other.K.d), np.sort(by_limit.K.d), rtol=1e-9)


def test_free_structure_with_given_modes_and_factor():
    full = cantilevers(NO_DAMPING, driven=False)
    G = gap_rows(full, gaps_between())
    own = gap_modes(full, G, count=14)
    shifted = factor(full.K + small_shift(full.K, full.M) * full.M)
    given = gap_modes(full, G, modes=modes(full.K, full.M, count=14, free=True), stiffness=shifted)
    np.testing.assert_allclose(given.K.d[14:], own.K.d[14:], rtol=1e-7)
    assert np.count_nonzero(own.K.d == 0.0) == np.count_nonzero(given.K.d == 0.0) >= 6


def test_reduced_systems_can_be_reduced_again():
    """Craig-Bampton, dense or diagonal, as the System that the channels act on."""
    M, K = chain(40)
    full, G = system_of(M, K), np.zeros((1, 40))
    G[0, [11, 39]] = 1.0, -1.0
    parts = craig_bampton(full, np.array([11, 39]), count=12)
    direct = gap_modes(parts, G @ parts.rows(np.arange(40))[0], count=6)
    diagonal = diagonalise(parts)
    twice = gap_modes(diagonal, G @ diagonal.rows(np.arange(40))[0], count=6)
    np.testing.assert_allclose(twice.K.d, direct.K.d, rtol=1e-8)
    by_limit = gap_modes(
        diagonal, G @ diagonal.rows(np.arange(40))[0], f_max=1.001 * np.sqrt(direct.K.d[5]) / 2 / np.pi
    )
    assert by_limit.stats.modes == 6
    assert by_limit.stats.first_left_out == pytest.approx(np.sqrt(diagonal.K.d[6]) / 2 / np.pi)
    p = np.array([2.0])
    exact = np.linalg.solve(K, G.T @ p)
    for small in (direct, twice):
        rows = small.rows(np.arange(40))[0]
        found = rows @ ((G @ rows).T @ p / small.K.d)
        np.testing.assert_allclose(G @ found, G @ exact, rtol=1e-9)


def test_without_channels_it_is_the_modal_system():
    full = cantilevers(Rayleigh(2.0, 1e-6))
    found, R = modes(full.K, full.M, count=7), support_motion(full, factor(full.K))
    load = full.rows(np.array([6 * 3 + 1]))[0].T.toarray()
    static = np.linalg.solve(to_dense(full.K), load)
    a = modal_system(full, found, R, static)
    b = gap_modes(full, np.zeros((0, full.n)), modes=found, static=static)
    np.testing.assert_allclose(a.K.d, b.K.d, rtol=1e-9)
    np.testing.assert_allclose(abs(a.supports.M_qs), abs(b.supports.M_qs), atol=1e-9)


# --- transients ------------------------------------------------------------------------------------------


def agree(a: History, b: History, tolerance: float) -> None:
    for name in ("displacement", "gap", "force"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(y, x, rtol=0, atol=tolerance * np.abs(x).max(initial=1e-300), err_msg=name)


@pytest.mark.parametrize("dashpot", [0.0, 0.5])
@pytest.mark.parametrize("stiffness", [0.0, 1e5])
def test_all_modes_kept_is_the_full_model(dashpot, stiffness):
    """A change of basis: nothing is left over, every channel is dropped."""
    full, gaps = cantilevers(Rayleigh(2.0, 1e-6), dashpot=dashpot), gaps_between(1e-3, stiffness)
    small = gap_modes(full, gap_rows(full, gaps), count=full.n)
    assert small.n == full.n
    assert small.stats.dropped == 2
    assert isinstance(small.K, Diagonal) == (dashpot == 0.0)
    loads = multisine_base(time_axis(0.06, 2e-4), 20.0, 300.0, 2e-4)
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(EVERYWHERE)) for s in (full, small))
    assert bool(a.contact_steps) == bool(stiffness)
    agree(a, b, 1e-7)  # round-off x condition of K


@pytest.mark.parametrize("zeta", [None, 0.02])
def test_driven_assembly_without_contact_moves_as_the_full_model(zeta):
    """Band up to f_max / 3: higher modes answer by (f / f_k)^2 < 1/9 of their static share, a few parts in 1000."""
    full = cantilevers(NO_DAMPING if zeta else Rayleigh(2.0, 1e-6))
    if zeta:
        found = modes(full.K, full.M, count=30)
        full = with_modal_damping(full, found, support_motion(full, factor(full.K)), zeta)
    gaps = gaps_between()
    small = gap_modes(full, gap_rows(full, gaps), f_max=1200.0)
    loads = multisine_base(time_axis(0.12, 2e-4), 20.0, 400.0, 1e-4)
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(EVERYWHERE)) for s in (full, small))
    scale = np.abs(a.gap - 0.02).max()
    np.testing.assert_allclose(b.gap, a.gap, rtol=0, atol=0.02 * scale)
    error = b.displacement - a.displacement
    assert np.sqrt(np.mean(error**2) / np.mean(a.displacement**2)) < 0.01
    assert isinstance(small.K, Diagonal)


def test_contact_of_a_driven_assembly_has_the_impulse_of_the_full_model(measured):
    full, gaps = cantilevers(Rayleigh(2.0, 1e-5)), gaps_between(2e-3, 2e4)
    loads = multisine_base(time_axis(0.1, 2e-4), 20.0, 150.0, 5e-4)
    small = gap_modes(full, gap_rows(full, gaps), f_max=1200.0)
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(EVERYWHERE)) for s in (full, small))
    assert a.contact_steps > 20
    # modes to eight times the band
    measured("gap modes, driven assembly: impulse over full", b.force.sum() / a.force.sum(), 1.0, rel=0.005)
    assert b.energy_created < 2e-4


def test_support_that_starts_with_a_speed():
    """The inside is at rest at first: no division by the mass that coordinates without mass do not have."""
    full, gaps = cantilevers(Rayleigh(2.0, 1e-6)), gaps_between()
    time = time_axis(0.1, 2e-4)
    w = 2.0 * np.pi * 15.0
    motion = 1e-3 * np.stack([np.sin(w * time), w * np.cos(w * time), -w * w * np.sin(w * time)])
    loads = Loads(time, motion[:, :, None], np.zeros((time.size, 0)))
    small = gap_modes(full, gap_rows(full, gaps), count=24)
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(EVERYWHERE)) for s in (full, small))
    error = b.displacement - a.displacement
    # The jump in speed excites all modes; those left out hold a share of some 1 % of the amplitude.
    assert np.sqrt(np.mean(error**2) / np.mean(a.displacement**2)) < 0.02


def test_applied_force_and_initial_velocity():
    M, K = chain(30)
    v = np.sin(np.arange(30) / 9.0)
    full, G = system_of(M, K, alpha=1.0, velocity=v), np.eye(30)[[29]]
    time = time_axis(1.0, 1e-3)
    loads = forces_on(time, [29], 50.0 * np.sin(8.0 * time))
    small = gap_modes(full, G, count=12)
    V = small.rows(np.arange(30))[0]
    moving = to_dense(small.M).diagonal() > 0.0
    # Momentum along every basis vector with mass; none goes to the others.
    np.testing.assert_allclose((V.T @ (M @ (V @ small.velocity - v)))[moving], 0.0, atol=1e-10)
    np.testing.assert_array_equal(small.velocity[~moving], 0.0)
    a, b = (simulate(s, channels_on(G, 9.0, 0.0), loads, HHT(), OutputRequest(np.arange(30))) for s in (full, small))
    agree(a, replace(b, gap=a.gap), 0.01)  # v is smooth: twelve modes hold it to 1 %


# --- errors ----------------------------------------------------------------------------------------------


def test_rigid_body_modes_must_be_kept():
    full = cantilevers(NO_DAMPING, driven=False)
    with pytest.raises(NumericalError, match="can move freely, and the 3 modes kept"):
        gap_modes(full, gap_rows(full, gaps_between()), count=3)


def test_input_errors_name_what_is_wrong():
    full = system_of(*chain(5))
    with pytest.raises(InputError, match="0 of f_max, count and modes are given; expected one"):
        gap_modes(full, np.eye(1, 5))
    with pytest.raises(InputError, match="2 of f_max, count and modes"):
        gap_modes(full, np.eye(1, 5), f_max=3.0, count=2)
    with pytest.raises(InputError, match=r"gap rows have 4 columns; expected 5.*system\.rows"):
        gap_modes(full, np.eye(1, 4), count=2)
    with pytest.raises(InputError, match="static has 3 rows; expected 5"):
        gap_modes(full, np.eye(1, 5), count=2, static=np.zeros((3, 1)))


def test_progress_is_told():
    stages: list[tuple[str, int, int]] = []
    full = cantilevers(NO_DAMPING)
    gap_modes(full, gap_rows(full, gaps_between()), count=3, progress=lambda *x: stages.append(x))
    assert stages[-1] == ("assembly: residual flexibility", 2, 2)


def test_rayleigh_damping_of_the_kept_modes():
    """One mode of a chain alone decays by exp(-zeta w t), zeta = (alpha / w + beta w) / 2."""
    M, K = chain(12)
    omega2, Phi = np.linalg.eigh(K)
    alpha, beta, w = 0.8, 4e-4, np.sqrt(omega2[1])
    zeta = 0.5 * (alpha / w + beta * w)
    small = gap_modes(system_of(M, K, alpha=alpha, beta=beta, velocity=Phi[:, 1]), np.eye(12)[[11]], count=4)
    gaps = channels_on(np.eye(12)[[11]], 9.0, 0.0)
    h = 2.0 * np.pi / w / 400
    history = free_run(small, gaps, 1600 * h, h)  # the first dofs, as many as there are coordinates
    t, wd = history.time, w * np.sqrt(1.0 - zeta**2)
    exact = np.exp(-zeta * w * t) * np.sin(wd * t) / wd
    # Phase error (w h)^2 / 10 x 2 pi 4.
    np.testing.assert_allclose(history.displacement, np.outer(exact, Phi[: small.n, 1]), atol=1.5e-3 / w)


# --- the bar on a rigid wall: contact .5 to 1.16667, force 300, impulse 200 -------------------------------------------

BAR, PIECE = 100, 0.1
STEP = 0.5 * PIECE / 30.0


@cache
def on_wall(count: int | None) -> History:
    """The bar of 100 elements on a rigid wall, penalty 10 EA/dx, h = dx / 2c, HHT(-0.05)."""
    foot = np.eye(1, BAR + 1)
    system = system_of(*bar(BAR, 10.0, 900.0, 1.0), velocity=np.full(BAR + 1, -10.0))
    if count is not None:
        system = gap_modes(system, foot, count=count)
    loads = at_rest(time_axis(1.25, STEP))
    return simulate(
        system, channels_on(foot, 5.0, 10.0 * 900.0 / PIECE), loads, HHT(), OutputRequest(np.arange(BAR + 1))
    )


def duration_of(history: History) -> float:
    steps = np.flatnonzero(history.force[:, 0] > 0.0)
    return float((steps[-1] - steps[0] + 1) * STEP)


def test_bar_with_many_modes_is_the_full_bar(measured):
    """70 of 101 modes: what the time step does not resolve is left out."""
    full, small = on_wall(None), on_wall(70)
    assert duration_of(small) == pytest.approx(duration_of(full), abs=1.5 * STEP)
    measured("bar on a wall, 70 modes, gap: impulse over full", small.force.sum() / full.force.sum(), 1.0, rel=1e-4)
    changes = [h.energy[-1, :3].sum() / h.energy[0, :3].sum() - 1.0 for h in (small, full)]
    assert changes[0] == pytest.approx(changes[1], rel=0.02)


@pytest.mark.parametrize(("count", "impulse_error"), [(8, 0.02), (15, 0.01)])
def test_residual_shapes_chatter_but_keep_the_impulse(count, impulse_error):
    """The residual shape is an oscillator of its own on the penalty: false re-openings in a forced step."""
    history = on_wall(count)
    pressed = (history.force[:, 0] > 0.0).astype(int)
    assert np.count_nonzero(np.diff(pressed) == 1) - 1 > 10
    assert history.force.sum() * STEP == pytest.approx(200.0, rel=impulse_error)
    assert duration_of(history) == pytest.approx(2.0 / 3.0, rel=0.04)
