"""Exact flow: single modes against the matrix exponential, loads, bounds between samples, levels of contact."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product
from typing import NamedTuple

import numba
import numpy as np
import pytest
import scipy.linalg as sla
from benchmarks.random_contact import LIMIT, random_run
from scipy.integrate import solve_ivp

import creak
from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh
from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import law_arrays
from creak.dynamics.channels import channel_matrices
from creak.dynamics.closing import closes_between
from creak.dynamics.flow.kicks import share_out
from creak.dynamics.flow.march import SAMPLES, form_of, simulate_flow
from creak.dynamics.flow.model import filtered, resting
from creak.dynamics.flow.motion import band_energies
from creak.dynamics.flow.propagator import propagator
from creak.dynamics.flow.resolution import FINE, QUICK, SETTLED, Resolution, flow_steps, straight
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.dynamics.state import LinearTerms
from creak.errors import InputError
from creak.reduction.diagonal import diagonalise
from creak.verify.events import find_events
from creak.verify.reliability import created_of_contact
from helpers_core import NO_CHANNELS, chain, channels, system_of
from helpers_gap import cantilevers, gaps_between, multisine_base

RECORDED = {"section": "time"}


def fly(system, gaps, end, step, forces=(), labels=(), resolution=SETTLED, every=1) -> History:
    """A System diagonalised and flown; `forces` are functions of time."""
    time = step / SAMPLES * np.arange(SAMPLES * round(end / step) + 1)
    values = np.stack([f(time) for f in forces], axis=1) if forces else np.zeros((time.size, 0))
    loads = Loads(time, np.zeros((3, time.size, 0)), values, tuple(np.array([x]) for x in labels))
    return simulate_flow(
        diagonalise(system), gaps, loads, OutputRequest(np.arange(system.n), every=every), resolution=resolution
    )


def energies(history: History) -> dict[str, np.ndarray]:
    return dict(zip(ENERGIES, history.energy.T, strict=True))


# --- single modes ---------------------------------------------------------------------------------------------------

MODES = [
    (1.0, 0.0, 0.0),
    (2.0, 3.0, 1e4),
    (1.0, 1e3, 1e10),
    (1.0, 50.0, 0.0),
    (3.0, 0.0, 5e2),
    (1.0, 3e3, 1e6),
    (1.0, 2e3, 1e6),
    (1.0, 1e5, 1e3),
]


@pytest.mark.parametrize("h", [1e-5, 1e-3])
@pytest.mark.parametrize("mode", MODES)
def test_propagator_is_the_exponential_of_the_equation(mode, h):
    m, c, k = mode
    A = np.zeros((6, 6))  # u, h v, then the derivatives of the load times powers of h: time in steps
    A[[0, 2, 3, 4], [1, 3, 4, 5]] = 1.0
    A[1, :3] = -h * h * k / m, -h * c / m, 1.0 / m
    E = sla.expm(A)
    P = propagator(*(np.array([x]) for x in mode), h)[:, 0]
    powers = h ** np.arange(2, 6)
    found = np.array([[P[0], P[1] / h, *(P[5:9] / powers)], [P[2] * h, P[3], *(P[4:8] * h / powers)]])
    # Round-off of the exponential itself, which squares its way up to h omega = 100.
    np.testing.assert_allclose(found, E[:2], rtol=1e-9, atol=1e-11 * np.abs(E[:2]).max())


@pytest.mark.parametrize("h", [1e-5, 1e-3])
@pytest.mark.parametrize("mode", MODES)
def test_mean_of_a_step_is_that_of_its_instants(mode, h):
    """Gauss's rule over the instants; up to h omega = 100 it needs its points."""
    mode = tuple(np.array([x]) for x in mode)
    places, weights = np.polynomial.legendre.leggauss(80)
    exact = np.zeros(6)
    for x, w in zip(places, weights, strict=True):
        P = propagator(*mode, 0.5 * h * (1.0 + x))[:, 0]
        exact += 0.5 * w * np.array([P[0], P[1], *P[5:9]])
    found = propagator(*mode, h)[9:, 0]
    scale = np.array([1.0, h, *(h ** np.arange(2, 6) / mode[0])])
    np.testing.assert_allclose(found / scale, exact / scale, rtol=1e-9, atol=1e-11)


def test_two_half_steps_are_one_step():
    rng = np.random.default_rng(3)
    m, c, k = rng.uniform(0.5, 2.0, 40), rng.uniform(0.0, 10.0, 40), 10.0 ** rng.uniform(0.0, 12.0, 40)
    whole, half = propagator(m, c, k, 1e-3), propagator(m, c, k, 5e-4)
    u = half[0] * half[0] + half[1] * half[2], half[0] * half[1] + half[1] * half[3]
    np.testing.assert_allclose(u[0], whole[0], atol=1e-12)
    np.testing.assert_allclose(u[1], whole[1], atol=1e-12 * np.abs(whole[1]).max())


def test_massless_coordinates_follow_their_load():
    P = propagator(np.array([0.0]), np.array([0.0]), np.array([4.0]), 0.5)[:, 0]
    np.testing.assert_allclose(P[:9], [0, 0, 0, 0, 0, 0.25, 0.125, 0.03125, 0.5**3 / 24.0])
    np.testing.assert_allclose(P[9:], [0, 0, 0.25, 0.0625, 0.5**2 / 24.0, 0.5**3 / 96.0])


# --- flight ---------------------------------------------------------------------------------------------------------


def test_forced_motion_is_that_of_the_closed_form(measured):
    """m = 1, k = (2 pi 20)^2, zeta = 2 %, pushed at 33 Hz from rest, ten flight steps a period of the push."""
    w, f, zeta = 2 * np.pi * 20.0, 2 * np.pi * 33.0, 0.02
    system = system_of(np.eye(1), np.array([[w * w]]), alpha=2 * zeta * w)
    history = fly(system, NO_CHANNELS, 0.6, 1.0 / 330.0, [lambda t: np.sin(f * t)], [0])
    t = history.time[history.output_index]
    X = 1.0 / (w * w - f * f + 2j * zeta * w * f)
    steady = (X * np.exp(1j * f * t)).imag
    wd = w * np.sqrt(1 - zeta**2)
    a = -X.imag
    b = (-(X * 1j * f).imag + zeta * w * a) / wd
    exact = steady + np.exp(-zeta * w * t) * (a * np.cos(wd * t) + b * np.sin(wd * t))
    # The cubic through the load is off by 5.1e-4 (Omega H)^4 = 8e-5.
    measured(
        "exact flow, damped mode pushed off resonance: worst instant",
        np.abs(history.displacement[:, 0] - exact).max() / np.abs(exact).max(),
        at_most=2e-4,
        source="closed form",
    )


def test_load_error_falls_with_the_fourth_power_of_the_flight_step():
    w, f = 2 * np.pi * 20.0, 2 * np.pi * 33.0
    system = system_of(np.eye(1), np.array([[w * w]]))
    errors = []
    for n in (5, 10, 20):
        history = fly(system, NO_CHANNELS, 0.3, 1.0 / (33.0 * n), [lambda t: np.sin(f * t)], [0], every=n)
        t = history.time[history.output_index]
        exact = (np.sin(f * t) - f / w * np.sin(w * t)) / (w * w - f * f)
        errors.append(np.abs(history.displacement[:, 0] - exact).max())
    assert np.log2(errors[0] / errors[1]) > 3.5
    assert np.log2(errors[1] / errors[2]) > 3.5


def test_flight_needs_no_short_steps():
    """A mode at 2 MHz is flown with steps of a millisecond: period and energy stay."""
    w = 2 * np.pi * 2e6
    system = system_of(np.eye(1), np.array([[w * w]]), velocity=np.ones(1))
    history = fly(system, NO_CHANNELS, 0.05, 1e-3)
    t = history.time[history.output_index]
    # 6e5 radians: the phase keeps what 16 digits of it leave.
    np.testing.assert_allclose(history.displacement[:, 0], np.sin(w * t) / w, atol=1e-8 / w)


# --- what happens between the samples -------------------------------------------------------------------------------


def dipping(at: float, step: float, gap0: float, stiffness: float) -> tuple[History, GapOperator]:
    """Modes at 5 and 400 Hz, both at their lowest at once at the time `at` where nothing is in their way."""
    K = np.diag([(2 * np.pi * 5.0) ** 2, (2 * np.pi * 400.0) ** 2])
    u = np.array([1e-3, 2e-4])
    w = np.sqrt(np.diag(K))
    start = [np.cos(x * at) for x in w], [-np.sin(x * at) * x for x in w]
    system = system_of(np.eye(2), K, velocity=-u * -np.array(start[1]))
    push = [lambda t, k=k, a=a: 0.0 * t + k * a for k, a in zip(np.diag(K), u * np.array(start[0]), strict=True)]
    gaps = channels([[1.0, 1.0]], gap0, stiffness)
    return fly(system, gaps, 0.2, step, push, [0, 1], every=round(1e-3 / step)), gaps


@cache
def lowest(at: float) -> tuple[float, float]:
    """Of the free motion: how far down, when."""
    free, _ = dipping(at, 1e-6, 1.0, 0.0)
    return 1.0 - float(free.gap.min()), float(free.time[np.argmin(free.gap[:, 0])])


@pytest.mark.parametrize("depth", [1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("at", [0.1037, 0.1052, 0.10999])
def test_a_touch_between_two_samples_is_found(depth, at):
    """A mode at 400 Hz on a slow one: its dip of `depth` m lasts a fraction of the flight step of 1 ms."""
    down, fine = lowest(at)
    history, gaps = dipping(at, 1e-3, down - depth, 1e5)
    events = find_events(history, gaps, merge=0.0, f_max=1e5)
    assert events
    assert min(abs(0.5 * (e.t_start + e.t_end) - fine) for e in events) < 2e-4


def test_a_touch_of_what_begins_to_ring_as_its_load_begins_to_rise_is_found():
    """u = V t - V / w sin(w t) from rest under the force k V t, against V t: a gap of half of V / w closes at once."""
    w, V = 2.0 * np.pi * 8e3, 0.3
    system = system_of(np.eye(2), np.diag([w * w, 0.0]), velocity=np.array([0.0, V]))
    gaps = channels([[1.0, -1.0]], 0.5 * V / w, 1e6)
    (first, *_) = find_events(fly(system, gaps, 2e-3, 1e-4, [lambda t: w * w * V * t], [0]), gaps, f_max=5e3)
    assert first.t_start == pytest.approx(np.arcsin(0.5) / w, rel=0.01)


def test_a_cubic_that_dips_is_told_whatever_its_slopes_are():
    """Its lowest value of 2,001 in the step, for slopes of either sign at either end."""
    x, rng, told = np.linspace(0.0, 1.0, 2001), np.random.default_rng(3), []
    for g0, d0, g1, d1 in rng.standard_normal((4000, 4)) * [0.3, 3.0, 0.3, 3.0]:
        g = (
            abs(g0) * (1 + 2 * x) * (1 - x) ** 2
            + d0 * x * (1 - x) ** 2
            + g1 * x * x * (3 - 2 * x)
            + d1 * x * x * (x - 1)
        )
        found = closes_between(*(np.array([v]) for v in (abs(g0), d0, g1, d1)), 1.0)
        if abs(g.min()) > 1e-5:
            assert found == (g.min() < 0.0)
            told.append((found, g1 > 0.0, d0 > 0.0, d1 > 0.0))
    assert {x[2:] for x in told if x[0] and x[1]} == {(False, False), (False, True), (True, True)}


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_bound_holds_between_samples(damping):
    """Random motion of forty modes under loads that are cubics: no gap that contact sees leaves the band about the cubic
    through its ends, from rest either."""
    rng = np.random.default_rng(5)
    n, H = 40, 1e-3
    omega = 10.0 ** rng.uniform(1.0, 5.5, n)
    rows = rng.standard_normal((3, n))
    diagonal = diagonalise(system_of(np.eye(n), np.diag(omega**2)))
    diagonal = replace(
        diagonal, damping=Damping(0.0, 0.0, None, np.eye(n), 2.0 * damping * np.sqrt(diagonal.K.diagonal()))
    )
    gaps = channels(rows, 0.0, 1.0)
    loads = Loads(H / 3 * np.arange(7), np.zeros((3, 7, 0)), np.zeros((7, 0)))
    form = form_of(diagonal, channel_matrices(diagonal, gaps), LinearTerms(diagonal, loads), gaps)
    steps = flow_steps(form, gaps.laws, H, Resolution(0.5, 0.1, 0.01))
    model = filtered(form, steps.mollifier, steps.h, np.zeros(3))
    assert steps.mollifier.min() < 1e-9
    w = np.sqrt(model.k)
    state, x = resting(model, loads), np.linspace(1e-12, 1.0, 151)
    for level, start, loaded in product(range(steps.levels + 1), (0.0, 1.0), range(5)):
        if (start, loaded) == (0.0, 0):
            P = np.stack([propagator(model.m, model.c, model.k, H / 2**level * part) for part in x], axis=-1)
        h, D, energy = H / 2**level, np.zeros((4, n)), np.zeros(steps.reach.shape[1])
        D[:loaded] = rng.standard_normal((loaded, n)) * w * H ** -np.arange(float(loaded))[:, None]
        state.x[:] = start * rng.standard_normal((2, n)) / [w, np.ones(n)]
        told_energies(model, steps.band, D, 0.0, state, energy)
        U = np.einsum("dnx,dn->nx", P[[0, 1, 5, 6, 7, 8]], np.vstack([state.x, D]))
        V = np.einsum("dnx,dn->nx", P[[2, 3, 4, 5, 6, 7]], np.vstack([state.x, D]))
        g, r = model.rows @ U, h * (model.rates @ V)
        cubic = np.outer(g[:, 0], (1 + 2 * x) * (1 - x) ** 2) + np.outer(r[:, 0], x * (1 - x) ** 2)
        cubic += np.outer(g[:, -1], x * x * (3 - 2 * x)) + np.outer(r[:, -1], x * x * (x - 1))
        off = energy @ steps.reach[level] + 1e-9 * np.abs(g).max()
        assert (np.abs(g - cubic).max(axis=1) <= off).all()
        assert steps.reach[level].max() <= steps.reach[0].max()
        T = 0.5 * h
        told_energies(model, steps.band, D, h, state, energy)
        line = g[:, :1] + np.outer(r[:, 0], x)
        off = energy @ straight(form, steps, T) + 1e-9 * np.abs(g).max()
        assert (np.abs(g - line)[:, x <= 0.5].max(axis=1) <= off).all()


@numba.njit
def told_energies(model, band, D, T, state, out):
    """`band_energies` as other compiled code calls it."""
    band_energies(model, band, D, T, state, out)


# --- choice of steps ------------------------------------------------------------------------------------------------


def test_steps_near_contact_follow_its_own_time_scale():
    M, K = chain(3)
    system = diagonalise(system_of(M, K))
    loads = Loads(1e-3 / 3 * np.arange(7), np.zeros((3, 7, 0)), np.zeros((7, 0)))

    def step(stiffness, resolution=SETTLED):
        gaps = channels([[0.0, 0.0, 1.0]], 0.0, stiffness)
        form = form_of(system, channel_matrices(system, gaps), LinearTerms(system, loads), gaps)
        return flow_steps(form, gaps.laws, 1e-3, resolution).h

    assert step(1e10) * 1e5 <= 0.25 < 2.0 * step(1e10) * 1e5
    assert step(4e10) == pytest.approx(0.5 * step(1e10))
    assert step(1e10, QUICK) == pytest.approx(2.0 * step(1e10))
    assert step(1e10, FINE) == pytest.approx(0.25 * step(1e10))
    assert step(1.0) <= 1e-3 * SETTLED.longest


def test_stiffness_that_nothing_can_have_is_refused():
    M, K = chain(2)
    with pytest.raises(InputError, match="contact that can be resolved"):
        fly(system_of(M, K), channels([[0.0, 1.0]], 0.0, 1e32), 0.01, 1e-3)


def test_a_damper_without_a_spring_is_refused():
    """It would never act: a channel presses by its spring."""
    M, K = chain(2)
    with pytest.raises(InputError, match="damper of 10 and no spring"):
        fly(system_of(M, K), channels([[0.0, 1.0]], 0.0, 0.0, 10.0), 0.01, 1e-3)


def test_friction_without_mass_is_refused():
    system = system_of(np.diag([1.0, 0.0]), np.diag([1e4, 1e4]))
    gaps = channels([[0.0, 1.0]], 0.0, 1e5, 10.0)
    with pytest.raises(InputError, match="without mass"):
        fly(system, gaps, 0.01, 1e-3)


# --- Systems --------------------------------------------------------------------------------------------------------


def rattle(resolution: Resolution, step: float) -> History:
    """Two cantilevers side by side on a shaken base, .5 mm apart."""
    system = diagonalise(cantilevers(Rayleigh(20.0, 1e-6)))
    time = step / SAMPLES * np.arange(SAMPLES * round(0.4 / step) + 1)
    loads = multisine_base(time, 10.0, 120.0, 2e-4)
    return simulate_flow(
        system, gaps_between(5e-4, 1e6), loads, OutputRequest(np.zeros(0, dtype=int)), resolution=resolution
    )


def test_two_beams_under_base_motion_converge():
    """Prescribed motion, several channels: halving everything changes nothing that counts, nor does HHT at 20 us."""
    found = {}
    for name, resolution, step in (("settled", SETTLED, 8e-4), ("fine", FINE, 4e-4)):
        history = rattle(resolution, step)
        found[name] = find_events(history, gaps_between(5e-4, 1e6), merge=2e-3, f_max=500.0)
        assert created_of_contact(history) < 1e-3
    time = 2e-5 * np.arange(20_001)
    loads = multisine_base(time, 10.0, 120.0, 2e-4)
    stepped = simulate(
        diagonalise(cantilevers(Rayleigh(20.0, 1e-6))),
        gaps_between(5e-4, 1e6),
        loads,
        HHT(),
        OutputRequest(np.zeros(0, dtype=int)),
    )
    found["HHT"] = find_events(stepped, gaps_between(5e-4, 1e6), merge=2e-3, f_max=500.0)
    assert len(found["fine"]) > 5
    for name, bar in (("settled", 0.02), ("HHT", 0.05)):
        assert len(found[name]) == len(found["fine"])
        for a, b in zip(found[name], found["fine"], strict=True):
            assert a.t_start == pytest.approx(b.t_start, abs=1e-4)
            assert a.impulse == pytest.approx(b.impulse, rel=bar, abs=bar * max(e.impulse for e in found["fine"]))


def test_output_and_whole_coordinates_are_those_of_the_instants():
    M, K = chain(4)
    system = diagonalise(system_of(M, K, velocity=np.array([0.0, 0.0, 0.0, 1.0])))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 60 + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
    gaps = channels([[0.0, 0.0, 0.0, -1.0]], 1e-3, 1e6)
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(4), every=2, whole_at=np.array([0, 4, 60])))
    np.testing.assert_allclose(history.time[history.output_index], 2e-3 * np.arange(31), atol=1e-15)
    rows = system.rows(np.arange(4))[0]
    np.testing.assert_allclose(np.asarray(rows @ history.coordinates)[:, 1], history.displacement[2], atol=1e-15)
    assert history.force.max() > 0.0


def test_the_last_step_is_kept_whatever_its_time_rounds_to():
    """n times a step of three samples may end a round-off before the last of the 3 n samples."""
    M, K = chain(4)
    system = diagonalise(system_of(M, K, velocity=np.array([0.0, 0.0, 0.0, 1.0])))
    gaps, late = channels([[0.0, 0.0, 0.0, -1.0]], 1e-3, 1e6), 0
    for end in np.linspace(0.05, 0.06, 20):
        time = end / (49 * SAMPLES) * np.arange(49 * SAMPLES + 1)
        loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
        history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(4), whole_at=np.array([1, 49])))
        late += history.time[-1] < time[-1]
        assert history.whole_at.tolist() == [1, 49]
        np.testing.assert_allclose(
            np.asarray(system.rows(np.arange(4))[0] @ history.coordinates[:, 1]), history.displacement[-1]
        )
    assert late


@pytest.mark.parametrize("seed", [*range(24), 156, 192, 371, 406, 656])
def test_random_systems_create_no_energy_in_contact(seed):
    """Any law, with or without friction, dampers and damping that couples modes: what comes out is what went in."""
    history = random_run(seed)
    assert (history.force >= 0.0).all()
    assert created_of_contact(history) < 0.25 * LIMIT


@pytest.mark.parametrize("damping", [0.0, 4e4])
@pytest.mark.parametrize("at", [1.0, 1.003, 1.007, 1.013])
def test_the_impulse_of_a_blow_is_what_it_changes_of_the_momentum(damping, at):
    """Two free masses on a spring, thrown at a stop: whatever part of a step they touch and leave in."""
    mass, k = np.array([2.0, 1.0]), 1e4
    system = creak.system_from_matrices(k * np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag(mass), velocity=[-1.0, -1.0])
    stop = channels([[1.0, 0.0]], 0.1 * at, 1e10, damping)
    history = fly(system, stop, 0.3, 1e-3)
    momentum = np.diff(history.displacement @ mass) / np.diff(history.time[history.output_index])
    assert float(history.weights @ history.force[:, 0]) == pytest.approx(momentum[-1] - momentum[0], rel=2e-5)


class Pressed(NamedTuple):
    """What the shares of a kick are found from."""

    force: np.ndarray
    gap: np.ndarray
    rate: np.ndarray
    drift: np.ndarray


@numba.njit
def shared(laws, W, h, x, other, sign, share):
    """`share_out` as other compiled code calls it: it counts no references."""
    share_out(laws, W, h, x, other, sign, share)


def test_a_spring_that_is_not_pressed_yet_keeps_its_whole_share_of_a_kick():
    """Its gap is zero in a step in which friction's solver has a force for it: there is no work to share out."""
    laws = law_arrays(np.array([1e3, 1e3]), np.zeros(2), None, None)
    x = Pressed(np.array([1.0, 1.0]), np.array([0.0, -1e-3]), np.array([2.0, 2.0]), np.zeros(2))
    share = np.ones(2)
    shared(laws, 1e-3 * np.eye(2), 1e-3, x, np.array([1e-3, 1e-3]), 1.0, share)
    assert np.isfinite(share).all()
    assert share[0] == 1.0
    assert share[1] == pytest.approx(0.5 * 1e3 * 1e-6 / (0.5 * 1e-3 * 1.0 * 2.0), rel=0.01)


# --- work of the loads ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gap", [1e3, -1e-3])
def test_work_of_loads_on_what_rings_far_faster_than_the_flight_step(gap):
    """Two masses, one rings at 20 kHz after a blow, eight times in a flight step; nothing is lost, so a force of 30 Hz
    works what the energy rises by. A stop is out of reach, or presses lightly on the slow one for good."""
    slow, fast = 2.0 * np.pi * np.array([20.0, 20e3])
    K = np.diag([slow**2, fast**2])
    K[0, 1] = K[1, 0] = 0.05 * slow * fast
    system = diagonalise(system_of(np.eye(2), K, velocity=np.array([0.0, 20.0])))
    time = np.linspace(0.0, 0.08, 200 * SAMPLES + 1)
    push = 20.0 * np.sin(2.0 * np.pi * 30.0 * time)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.stack([push, push], axis=1), (np.array([0, 1]),))
    preload = 5.0 if gap < 0.0 else 0.0
    stop = channels([[1.0, 0.0]], gap, preload / 1e-3 or 1.0)
    history = simulate_flow(system, stop, loads, OutputRequest(np.arange(2)))
    assert history.force.any() == (gap < 0.0)
    stored = history.energy[:, :3].sum(axis=1)
    external, damping = (history.energy[:, ENERGIES.index(name)] for name in ("external", "damping"))
    allowed = 2e-3 * np.ptp(stored)
    np.testing.assert_allclose(external, stored - stored[0], rtol=0, atol=allowed)
    np.testing.assert_allclose(damping, 0.0, rtol=0, atol=allowed)


def test_what_dampers_take_where_the_base_goes_far():
    """A mass of 160 Hz on a damped spring whose base goes 100 in .1 s: c times the square of their relative speed."""
    m, k, c, way, T = 1e-3, 1e3, 0.05, 100.0, 0.1
    time = np.linspace(0.0, 0.14, 350 * SAMPLES + 1)
    x = np.clip(time / T, 0.0, 1.0)
    rows = x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2 / T, 60 * x * (1 - x) * (1 - 2 * x) / T**2
    K, M = np.array([[k, -k], [-k, k]]), np.diag([1e-6, m])
    free = creak.system_from_matrices(K, M, beta=c / k)
    system = diagonalise(creak.couple(free, driven={"base": [0]}))
    loads = creak.make_loads(system, time, motion={"base": creak.Motion(*(way * row for row in rows))})
    history = simulate_flow(system, creak.gap_channels([[0.0, 1.0]], 1e6, 1.0), loads, OutputRequest(np.array([1])))

    def slope(t, y):
        z = min(t / T, 1.0)
        off = y[0] - way * z**3 * (10 - 15 * z + 6 * z**2)
        fast = y[1] - way * 30 * z**2 * (1 - z) ** 2 / T
        return [y[1], -(k * off + c * fast) / m, c * fast**2]

    exact = solve_ivp(slope, (0.0, time[-1]), [0.0, 0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-13, t_eval=history.time)
    damping = history.energy[:, ENERGIES.index("damping")]
    np.testing.assert_allclose(damping, exact.y[2], rtol=0, atol=1e-3 * exact.y[2, -1])
    assert np.diff(damping).min() > -1e-6 * damping[-1]
