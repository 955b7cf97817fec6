"""Hard stops of every size and unit against closed forms: contact follows from the structure, not from the clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh, null_space

import creak
from creak.dynamics.flow.hard import HARD, LOADS, SHORT, hard_springs, held
from creak.dynamics.flow.march import SAMPLES, simulate_flow, with_springs
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.record.recorder import OutputRequest
from creak.verify.events import find_events
from helpers_core import bar

N = 200
STEEL = {"m-kg-s": (2.1e11, 7800.0), "mm-t-s": (2.1e5, 7.8e-9), "in-lbf-s": (30e6, 7.33e-4), "m-kg-us": (0.21, 7800.0)}
"""Young's modulus and density."""
BARS = [("m-kg-s", 10.0**k) for k in (-6, -3, 0, 3)] + [("mm-t-s", 1e-3), ("mm-t-s", 1e6), ("in-lbf-s", 10.0)]
BARS += [("in-lbf-s", 0.01), ("m-kg-us", 1.0), ("m-kg-us", 1e-3)]
MODELS = {"modes": creak.diagonalise, "unreduced": lambda system: system}


def thrown(
    units: str, length: float, model: str, steps: float
) -> tuple[creak.History, list[creak.Event], float, float]:
    """A free bar of N elements at speed 1 onto a hard stop: its history, events, 2 L / c and mass."""
    young, density = STEEL[units]
    area = (0.01 * length) ** 2
    M, K = bar(N, length, young * area, density * area)
    blow, mass = 2.0 * length * np.sqrt(density / young), density * area * length
    system = creak.system_from_matrices(sp.csr_matrix(K), sp.csr_matrix(M), velocity=-np.ones(N + 1))
    system = MODELS[model](system)
    stop = creak.gap_channels(np.eye(1, N + 1), 0.2 * blow, np.inf)
    time = blow / steps * np.arange(int(np.ceil(1.5 * steps)) + 1)
    history = creak.simulate(system, stop, creak.make_loads(system, time), observed=np.arange(N + 1))
    return history, find_events(history, stop, f_max=10.0 / blow), blow, mass


def held_to(units: str, length: float, model: str, steps: float = 20.0) -> tuple[float, float, float, float]:
    """Contact over 2 L / c, impulse over 2 m v, where contact begins, and the speed of the middle of mass after it."""
    history, (event,), blow, mass = thrown(units, length, model, steps)
    middle = 0.5 * (history.displacement[:, 1:] + history.displacement[:, :-1]).mean(axis=1)
    left = float(np.diff(middle[-2:])[0]) / float(np.diff(history.time[history.output_index][-2:])[0])
    return (event.t_end - event.t_start) / blow, event.impulse / (2.0 * mass), event.t_start / (0.2 * blow), left


@pytest.mark.parametrize(("units", "length"), BARS)
def test_a_bar_of_any_size_and_unit_stays_for_its_wave(units, length):
    """2 L / c, impulse 2 m v, speed v (de Saint-Venant): six decades of size, four systems of units."""
    stays, impulse, begins, leaves = held_to(units, length, "modes")
    assert stays == pytest.approx(1.0, abs=0.01)
    assert impulse == pytest.approx(1.0, abs=0.01)
    assert leaves == pytest.approx(1.0, abs=0.01)
    assert begins == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("units", "length"), [("m-kg-s", 1.0), ("in-lbf-s", 10.0), ("m-kg-us", 1e-3)])
def test_a_bar_that_is_not_reduced_stays_for_its_wave(units, length):
    stays, impulse, begins, leaves = held_to(units, length, "unreduced")
    assert stays == pytest.approx(1.0, abs=0.01)
    assert impulse == pytest.approx(1.0, abs=0.01)
    assert leaves == pytest.approx(1.0, abs=0.01)
    assert begins == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("model", MODELS)
def test_units_change_no_answer(model):
    """The same bar in us: figures are ratios; round-off may move a touch of the front of the bar by a step of contact."""
    first, other = held_to("m-kg-s", 1.0, model), held_to("m-kg-us", 1e-3, model)
    assert first == pytest.approx(other, rel=1e-3)


@pytest.mark.parametrize("steps", [0.5, 1.0])
@pytest.mark.parametrize("model", MODELS)
def test_loads_whose_steps_are_as_long_as_the_blow(model, steps):
    stays, impulse, _, _ = held_to("m-kg-s", 1.0, model, steps)
    assert stays == pytest.approx(1.0, abs=0.01)
    assert impulse == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e3])
@pytest.mark.parametrize("model", MODELS)
def test_a_mass_on_its_spring_rebounds_at_once(model, unit):
    """Stop at -.2 of the amplitude: it is back after (pi + 2 asin .2) / omega, at the speed that it came with."""
    omega = 2.0 * np.pi / unit
    system = creak.system_from_matrices(np.array([[omega**2]]), np.eye(1), velocity=-np.ones(1))
    if model == "unreduced":
        system = creak.system_from_matrices(sp.csr_matrix([[omega**2]]), sp.eye(1, format="csr"), velocity=-np.ones(1))
    system = MODELS[model](system)
    stop = creak.gap_channels(np.eye(1), 0.2 / omega, np.inf)
    history = creak.simulate(system, stop, creak.make_loads(system, unit / 20.0 * np.arange(21)))
    one, two, *_ = find_events(history, stop, f_max=10.0 / unit)
    assert one.t_end - one.t_start < 0.005 * unit
    assert two.t_start - one.t_start == pytest.approx((np.pi + 2.0 * np.arcsin(0.2)) / omega, rel=0.01)
    assert one.impulse == pytest.approx(2.0 * np.cos(np.arcsin(0.2)), rel=0.01)


def test_a_hard_spring_is_set_by_the_largest_mode_that_its_channel_holds():
    """A bar fixed at its far end: each held mode is a spring of 2 EA / L, half as stiff as the whole at its first."""
    share, omega2 = np.full(N, 2.0), ((np.arange(N) + 0.5) * np.pi) ** 2
    fine = hard_springs(omega2[:50], share[None, :50], 1e3)
    assert fine[0] == pytest.approx(2.0 * HARD, rel=0.1)


def test_a_small_stiff_mass_on_a_large_soft_one_is_met_by_its_own_spring():
    """1 kg on 1 N/m against 100 kg on .01 N/m: contact is short against the quick one."""
    spring = hard_springs(np.array([1.0, 1e-4]), np.array([[1.0, 0.01]]), 1e3)
    assert spring[0] == pytest.approx(SHORT**2 / 1.01, rel=0.2)


def test_what_cannot_move_has_no_spring():
    assert hard_springs(np.array([1.0]), np.zeros((1, 1)), 1.0)[0] == 0.0


def test_hard_contact_of_a_plate_is_hard_against_its_stiffest_held_mode():
    """A channel whose stiffest held mode is .39 of all that resists a blow is no mass on its spring: 100 k_b is enough.

    A mass on a spring that holds it is: there the contact's frequency is 200 times its own.
    """
    omega2 = np.array([1.0, 4.0, 9.0, 16.0, 25.0]) * 1e6
    share = np.full(5, 0.2)
    local, largest = held(omega2, share)
    M, K = np.diag(1.0 / share), np.diag(omega2 / share)  # modes that move the channel by 1 each
    one = np.ones(5)
    fixed = null_space(one[None, :])
    squares, shapes = eigh(fixed.T @ K @ fixed, fixed.T @ M @ fixed)
    pulls = (one @ np.linalg.solve(M, K @ fixed @ shapes)) ** 2 / squares
    assert largest == pytest.approx(max(pulls.max(), local - pulls.sum()) / local, rel=1e-9)
    assert 0.136 < largest < 0.5
    assert hard_springs(omega2, share[None, :], 1e-3)[0] == pytest.approx(HARD * largest * local)
    assert hard_springs(omega2[:1], np.ones((1, 1)), 1.0)[0] == pytest.approx(SHORT**2 * omega2[0])


@pytest.mark.parametrize("by", [0.25, 1.0, 4.0])
def test_a_hard_spring_times_a_factor_holds_a_mass_for_less(by):
    """A mass on a spring turns round in pi sqrt(m / k); impulse 2 m v whatever k is."""
    system = creak.system_from_matrices(sp.csr_matrix([[0.0]]), sp.csr_matrix([[3.0]]), velocity=[-2.0])
    system, stop = creak.diagonalise(system), creak.gap_channels([[1.0]], 1.0, np.inf)
    loads, times = creak.make_loads(system, np.linspace(0.0, 1.0, 301)), replace(SETTLED, hard=by)
    sprung = with_springs(system, stop, loads, times)
    history = simulate_flow(system, stop, loads, OutputRequest(np.zeros(0, dtype=np.int64)), resolution=times)
    (event,) = find_events(history, stop, f_max=30.0)
    lasts = np.pi * np.sqrt(3.0 / sprung.stiffness[0])
    assert sprung.stiffness[0] == pytest.approx(by * (LOADS / loads.step / SAMPLES) ** 2 * 3.0, rel=1e-9)
    assert event.t_end - event.t_start == pytest.approx(lasts, rel=0.01)
    assert event.impulse == pytest.approx(12.0, rel=2e-3)
