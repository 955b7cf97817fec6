"""Lasting contact: longer steps while the same channels press, and a history as long as its course asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.integrate import solve_ivp

from creak.assembly.system import Supports
from creak.contact.gap_operator import Curves, Friction, GapOperator
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.flow.propagator import Q0, UU, UV, VU, VV, in_kicks, propagator
from creak.dynamics.flow.resolution import SETTLED, finer
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.verify.events import find_events
from creak.verify.reliability import created_of_contact
from helpers_core import chain, channels, system_of

N, PENALTY = 12, 1e10
"""Masses of .01 kg in a row; springs of the contact turn them round in 3 us, so that steps of the kicks are .2 us."""
GAPS = channels(np.eye(N)[[3, 7, 11]], [1e-4, 2e-4, 3e-4], PENALTY)


def pressed(resolution=SETTLED, stiffness=1e5, gaps=GAPS, beta=0.0) -> History:
    """A row of masses in thick oil, pushed onto three stops within 10 ms and held there for 80 ms, 20 Hz on top."""
    M, K = chain(N, 0.01, stiffness)
    system = diagonalise(system_of(M, K, alpha=4000.0, beta=beta))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 100 + 1)
    push = -np.clip(time / 0.01, 0.0, 1.0) * (200.0 + 20.0 * np.sin(2.0 * np.pi * 20.0 * time))
    loads = Loads(
        time, np.zeros((3, time.size, 0)), np.outer(push, np.ones(3)), tuple(np.array([x]) for x in (2, 6, 10))
    )
    return simulate_flow(system, gaps, loads, OutputRequest(np.arange(N)), resolution=resolution)


@pytest.fixture(scope="module")
def history() -> History:
    return pressed()


def test_steps_grow_while_contact_lasts_and_few_are_kept(history):
    """Kicks alone take half a million steps of .2 us here, and kept each of them."""
    step = np.diff(history.time)
    assert step.min() < 5e-7
    assert history.contact_steps < 30_000
    assert history.time.size < 30_000


def test_force_of_lasting_contact_is_that_of_statics(history):
    """Quasi-static: what the stops carry is the push, less what the springs between them and the ground take."""
    at = np.searchsorted(history.time, 0.0905)
    K = chain(N, 0.01, 1e5)[1]
    G, t = GAPS.G.toarray()[:, :N], history.time[at]
    push = np.zeros(N)
    push[[2, 6, 10]] = -(200.0 + 20.0 * np.sin(2.0 * np.pi * 20.0 * t))
    u = np.linalg.solve(K + PENALTY * G.T @ G, push - PENALTY * G.T @ GAPS.gap0)
    exact = -PENALTY * (GAPS.gap0 + G @ u)
    np.testing.assert_allclose(history.force[at], exact, rtol=0.02)


def test_no_energy_comes_of_it(history):
    assert created_of_contact(history) < 1e-3
    assert abs(history.energy[-1, ENERGIES.index("scheme")]) < 2e-3 * history.energy_scale


def test_finer_steps_change_neither_times_nor_impulses(history):
    fine = pressed(finer(SETTLED, 2.0))
    found, exact = (find_events(h, GAPS, merge=5e-3, f_max=500.0) for h in (history, fine))
    assert len(found) == len(exact) > 0
    for a, b in zip(found, exact, strict=True):
        assert a.t_start == pytest.approx(b.t_start, abs=1e-4)
        assert a.impulse == pytest.approx(b.impulse, rel=1e-3)


def test_modes_that_are_damped_within_a_kick_press_in_long_steps():
    """Kicks throw them up by h p / (2 m) and they fall back at once: a long step begins without that, and the motion is
    that of statics, of which velocities at 20 Hz are known."""
    K, gaps = chain(N, 0.01, 1e9)[1], replace(GAPS, gap0=1e-4 * GAPS.gap0)
    history = pressed(stiffness=1e9, gaps=gaps, beta=1e-4)
    G, t = gaps.G.toarray()[:, :N], history.time[-1]
    push = np.zeros(N)
    push[[2, 6, 10]] = -20.0 * 40.0 * np.pi * np.cos(40.0 * np.pi * t)
    v = np.linalg.solve(K + PENALTY * G.T @ G, push)
    assert history.energy[-1, ENERGIES.index("kinetic")] == pytest.approx(0.005 * v @ v, rel=0.02)


@pytest.mark.parametrize("damp", [0.0, 1e2, 1e8])
@pytest.mark.parametrize("stiff", [0.0, 1e4, 1e12])
def test_modes_in_kicks_that_do_not_change(damp, stiff):
    """In the middle of each kick of a row that is long enough for the mode to come to where the next leaves it."""
    h = 1e-6
    P, half = propagator(*(np.array([x]) for x in (1.0, damp, stiff)), h)[:, 0], np.array([0.0, 0.5 * h])
    step, mean = P[[UU, UV, VU, VV]].reshape(2, 2), np.array([P[Q0 + 1], P[Q0]])
    u, v = (x[0] for x in in_kicks(np.array([damp]), np.array([stiff]), h))
    # Beside the motion under a force u of which k u is the force that goes on.
    at = np.array([0.0, v])
    np.testing.assert_allclose(step @ (at + half) + half - at, u * mean, rtol=1e-9, atol=1e-12 * np.abs(mean).max())


@pytest.mark.parametrize(
    ("alpha", "beta", "damper"),
    [pytest.param(20.0, 0.0, 0.0, marks=pytest.mark.slow), (20.0, 1e-4, 0.0), (20.0, 1e-5, 30.0)],
)
def test_energy_books_of_damped_modes_that_press(alpha, beta, damper):
    """Against an ODE solver: what modes that are damped within a step take, and no energy out of nothing."""
    n, k, stop = 4, 1e7, 1e-7
    M, K = chain(n, 0.01, 1e8)
    system, C = diagonalise(system_of(M, K, alpha=alpha, beta=beta)), alpha * M + beta * K
    end, push = 0.03, lambda t: -200.0 * np.clip(t / 0.01, 0.0, 1.0) * (1.0 + 0.5 * np.sin(2.0 * np.pi * 60.0 * t))
    time = np.linspace(0.0, end, 120 * SAMPLES + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), push(time)[:, None], (np.array([1]),))
    gaps = channels(np.eye(n)[[3]], stop, k, damping=damper)
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(n)))

    def slope(t, x):
        u, v = x[:n], x[n : 2 * n]
        gap, rate = stop + u[3], v[3]
        spring = max(-k * gap, 0.0)
        force = max(spring - damper * rate, 0.0) if gap < 0.0 else 0.0
        f = -K @ u - C @ v
        f[1] += push(t)
        f[3] += force
        return np.concatenate([v, f / np.diag(M), [v @ C @ v, -(force - spring) * rate, push(t) * v[1]]])

    found = solve_ivp(slope, (0.0, end), np.zeros(2 * n + 3), "LSODA", rtol=1e-6, atol=1e-12, max_step=1e-5)
    damping, contact_damping, external = found.y[-3:, -1]
    energy = dict(zip(ENERGIES, history.energy[-1], strict=True))
    assert energy["external"] == pytest.approx(external, rel=0.02)
    assert energy["damping"] == pytest.approx(damping, rel=0.05, abs=1e-3 * external)
    assert energy["contact_damping"] == pytest.approx(contact_damping, rel=0.05, abs=1e-4 * external)
    assert abs(energy["scheme"]) < 5e-3 * external


# --- long steps against an ODE solver -------------------------------------------------------------------------------

NORMAL, STATIC, KINETIC = 20.0, 0.3, 0.2
SPRINGS = np.diag([1e4, 2e4, 3e4])


def rubbing(decay: float, damping: float) -> GapOperator:
    """Dof 1 is pressed by 20 N on a spring of 1e5 N/m, dofs 0 and 2 rub along and across."""
    gaps = channels([[0.0, 1.0, 0.0]], -NORMAL / 1e5, 1e5, damping=damping)
    along, across = (channels([row], 0.0, 0.0).G for row in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    friction = Friction(*(np.array([x]) for x in (STATIC, KINETIC, decay)))
    return replace(gaps, tangents=(along, across), friction=friction, preload=np.array([NORMAL]))


@pytest.mark.parametrize(("decay", "damping"), [(0.0, 0.0), (0.05, 0.0), (0.0, 40.0)])
def test_sliding_that_turns_under_a_force_that_swings(decay, damping):
    """It slides in curves while the pressure swings: place, heat, and what the damper took."""
    end, start = 0.08, np.array([1.5, 0.0, -0.9])
    system = diagonalise(system_of(np.eye(3), SPRINGS, velocity=start))
    time = np.linspace(0.0, end, 240 * SAMPLES + 1)
    push = 10.0 * np.sin(2.0 * np.pi * 20.0 * time)
    loads = Loads(time, np.zeros((3, time.size, 0)), push[:, None], (np.array([1]),))
    history = simulate_flow(system, rubbing(decay, damping), loads, OutputRequest(np.arange(3)))
    assert (history.force[:, 0] > 0.0).all()
    assert np.all(np.hypot(*history.sliding[1:].T) > 0.0)

    def slope(t, x):
        u, v = x[:3], x[3:6]
        press = NORMAL - 1e5 * u[1] - damping * v[1]
        speed = np.hypot(v[0], v[2])
        mu = KINETIC + (STATIC - KINETIC) * np.exp(-speed / decay) if decay else KINETIC
        force = -SPRINGS @ u - mu * press / speed * np.array([v[0], 0.0, v[2]])
        force[1] += press - NORMAL + 10.0 * np.sin(2.0 * np.pi * 20.0 * t)
        return np.concatenate([v, force, [mu * press * speed, damping * v[1] ** 2]])

    exact = solve_ivp(
        slope, (0.0, end), np.concatenate([np.zeros(3), start, [0.0, 0.0]]), "DOP853", rtol=1e-11, atol=1e-12
    )
    energy = dict(zip(ENERGIES, history.energy[-1], strict=True))
    np.testing.assert_allclose(history.displacement[-1], exact.y[:3, -1], rtol=0, atol=2e-6)
    assert energy["friction"] == pytest.approx(exact.y[6, -1], rel=1e-4)
    assert energy["contact_damping"] == pytest.approx(exact.y[7, -1], rel=2e-3, abs=1e-9)
    assert abs(energy["scheme"]) < 1e-5 * energy["friction"]
    assert history.contact_steps < 240 * 128 / 10


def test_friction_never_pushes_along_beside_a_part_that_is_pressed_hard():
    """A block of 10 mg on a belt that swings, beside a part pressed by 1000 N, which sets what may jump in a step.

    The share of time that it slides is that of the same block alone, whatever its mass: it scales with nothing.
    """
    end, m, swing = 0.5, 1e-5, 2.0 * np.pi * 9.0
    M, K = np.diag([1.0, m, m]), np.diag([1e4, m * (2.0 * np.pi * 11.0) ** 2, m * (2.0 * np.pi * 17.0) ** 2])
    wall = Supports(("belt",), *(np.zeros((3, 1)),) * 3, *(np.zeros((1, 1)),) * 3, np.zeros((3, 1)))

    def rows(labels):
        pick = sp.csr_matrix((np.ones(labels.size), (np.arange(labels.size), np.minimum(labels, 2))), (labels.size, 3))
        return sp.csr_matrix(pick.multiply((labels < 3)[:, None])), (labels == 3).astype(float)[:, None]

    system = replace(system_of(M, K, alpha=100.0), rows=rows, supports=wall, labels=np.arange(4))
    load = np.array([1000.0, 10.0 * m])
    gaps = channels([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]], -load / 1e5, 1e5)
    along, across = (
        channels([row, other], 0.0, 0.0).G
        for row, other in (((0, 0, 0, 0), (0, 1, 0, -1)), ((0, 0, 0, 0), (0, 0, 1, 0)))
    )
    gaps = replace(gaps, tangents=(along, across), friction=Friction(*(np.full(2, x) for x in (0.2, 0.2, 0.0))))
    time = np.linspace(0.0, end, 1000 * SAMPLES + 1)
    c, s = np.cos(swing * time), np.sin(swing * time)
    belt = 1e-3 * np.array([1.0 - c, swing * s, swing**2 * c])[:, :, None]
    push = 800.0 * np.sin(2.0 * np.pi * 3.0 * time)
    loads = Loads(time, belt, push[:, None], (np.array([0]),))
    history = simulate_flow(diagonalise(system), replace(gaps, preload=load), loads, OutputRequest(np.arange(3)))
    work = (history.tangential * history.sliding)[:, 2:].sum(axis=1)
    assert work.min() < 0.0
    assert work.max() <= 1e-9 * -work.min()


def test_what_creeps_follows_the_pull_in_long_steps():
    """A light mass at its limit of friction: where it creeps to hangs on its own force. A pull that turns leads it on
    a pursuit curve, x' = (e . F' / k) e / |e|^2 with e = F / k - x of length mu N / k."""
    end, k, mass, r = 0.06, 1e5, 1e-3, KINETIC * NORMAL / 1e5

    def pull(t):
        size = 6.0 * np.clip(t / 0.02, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(t / 0.02, 0.0, 1.0))
        turn = 2.0 * np.pi * 10.0 * np.clip(t - 0.02, 0.0, None) ** 2 / 0.04
        return np.array([size * np.cos(turn), size * np.sin(turn)])

    system = diagonalise(system_of(mass * np.eye(3), k * np.eye(3), alpha=400.0))
    time = np.linspace(0.0, end, 180 * SAMPLES + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), pull(time).T, (np.array([0]), np.array([2])))
    gaps = replace(rubbing(0.0, 0.0), friction=Friction(*(np.array([x]) for x in (KINETIC, KINETIC, 0.0))))
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(3)))

    def slope(t, x):
        e, rate = pull(t) / k - x, (pull(t + 1e-7) - pull(t - 1e-7)) / (2e-7 * k)
        return max(e @ rate, 0.0) * e / (e @ e) if e @ e >= (r * (1.0 - 1e-6)) ** 2 else np.zeros(2)

    exact = solve_ivp(slope, (0.0, end), np.zeros(2), "RK45", rtol=1e-6, atol=1e-11, max_step=5e-4).y[:, -1]
    assert np.linalg.norm(exact) > r
    np.testing.assert_allclose(history.displacement[-1, [0, 2]], exact, rtol=0, atol=2e-3 * np.linalg.norm(exact))
    assert history.contact_steps < 180 * 128 / 5


def test_a_wall_that_moves_smoothly_shakes_nothing_that_rests_on_it():
    """The force is m (g + a). A wall whose speed jumped by 3 mm/s between flight steps let it ring by 5 %."""
    mass, gravity, k = 1.0, 10.0, 2e9
    zero, side = np.zeros((1, 1)), np.zeros((1, 1))

    def rows(labels):
        pick = sp.csr_matrix((labels == 0).astype(float)[:, None])
        return pick, (labels == 1).astype(float)[:, None]

    wall = Supports(("wall",), side, side, side, zero, zero, zero, side)
    alone = system_of(np.array([[mass]]), np.array([[10.0]]))
    system = replace(alone, rows=rows, supports=wall, labels=np.arange(2))
    gaps = replace(channels([[1.0, -1.0]], -mass * gravity / k, k), preload=np.array([mass * gravity]))
    omega, end = 2.0 * np.pi * 18.0, 0.1
    time = np.linspace(0.0, end, 100 * SAMPLES + 1)
    c, s = np.cos(omega * time), np.sin(omega * time)
    move = 6e-5 * np.array([(1 - c) ** 2, 2 * omega * (1 - c) * s, 2 * omega**2 * (s**2 + (1 - c) * c)])
    loads = Loads(time, move[:, :, None], np.zeros((time.size, 0)))
    history = simulate_flow(diagonalise(system), gaps, loads, OutputRequest(np.arange(1)))
    at = omega * history.time
    pull = 2 * 6e-5 * omega**2 * (np.sin(at) ** 2 + (1 - np.cos(at)) * np.cos(at))
    swing = np.ptp(mass * pull)
    assert swing > 0.3 * mass * gravity
    np.testing.assert_allclose(history.force[:, 0], mass * (gravity + pull), rtol=0, atol=2e-3 * swing)
    assert history.contact_steps < 100 * 128 / 5


def test_what_sticks_holds_against_a_pull_that_grows():
    """No way and no heat: friction is the pull."""
    M, K = np.eye(3), SPRINGS
    system = diagonalise(system_of(M, K))
    time = np.linspace(0.0, 0.05, 150 * SAMPLES + 1)
    pull = 4.0 * (time / 0.05) ** 2  # below .3 x 20 N
    loads = Loads(time, np.zeros((3, time.size, 0)), pull[:, None], (np.array([0]),))
    history = simulate_flow(system, rubbing(0.0, 0.0), loads, OutputRequest(np.arange(3)))
    assert not history.sliding.any()
    assert history.energy[-1, ENERGIES.index("friction")] == 0.0
    assert np.abs(history.displacement[:, 0]).max() < 1e-2 * 4.0 / 1e4  # the spring would give way by 4 N / 1e4
    assert history.contact_steps < 2_000


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_a_foam_that_is_squeezed_all_the_time(damping):
    """A mass on a curve of three pieces, among which it swings: place, impulse, energies."""
    curve = np.array([[0.0, 0.0], [1e-4, 2.0], [3e-4, 12.0], [1e-3, 80.0]])
    gaps = channels([[1.0]], 0.0, 0.0, damping=damping)
    gaps = replace(gaps, curves=Curves(np.zeros(1, dtype=np.int64), np.ones(1), (curve,)))
    end, push = 0.3, lambda t: -15.0 * np.clip(t / 0.05, 0.0, 1.0) ** 2 * (1.0 + 0.6 * np.sin(2.0 * np.pi * 12.0 * t))
    time = np.linspace(0.0, end, 600 * SAMPLES + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), push(time)[:, None], (np.array([0]),))
    system = diagonalise(system_of(np.eye(1), 1e3 * np.eye(1), alpha=20.0))
    history = simulate_flow(system, gaps, loads, OutputRequest(np.array([0])))

    def slope(t, x):
        deep = -x[0]
        force = max(0.0, np.interp(deep, *curve.T) - damping * x[1]) if deep > 0.0 else 0.0
        return [x[1], push(t) - 1e3 * x[0] - 20.0 * x[1] + force, force]

    exact = solve_ivp(slope, (0.0, end), [0.0, 0.0, 0.0], "DOP853", rtol=1e-9, atol=1e-12, max_step=1e-4)
    pressed = history.force[history.time > 0.05]
    assert (pressed > 0.0).all()
    assert np.ptp(-history.gap[history.time > 0.05]) > 2e-4  # over more than one piece
    assert history.displacement[-1, 0] == pytest.approx(exact.y[0, -1], rel=2e-4)
    assert np.sum(history.weights * history.force[:, 0]) == pytest.approx(exact.y[2, -1], rel=2e-5)
    energy = dict(zip(ENERGIES, history.energy[-1], strict=True))
    assert abs(energy["scheme"]) < 1e-4 * energy["external"]
    assert history.contact_steps < 600 * 128 / 5
