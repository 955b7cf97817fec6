"""Flights by collocation: order, period and damping, loads, supports, dampers, massless coordinates, energy, touches."""

from __future__ import annotations

from dataclasses import replace
from math import factorial

import numpy as np
import pytest
import scipy.linalg as sla

from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh
from creak.dynamics.flight.step import choose
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.history import ENERGIES, History, Interrupted
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import march, simulate
from creak.errors import NumericalError
from creak.linalg.modes import modes
from creak.reduction.modal import with_modal_damping
from helpers_core import NO_CHANNELS, chain, channels, forces_on, system_of, time_axis
from helpers_gap import cantilevers, gaps_between, multisine_base

RECORDED = {"section": "time", "source": "closed form"}

PI2 = 2.0 * np.pi
EXTERNAL, SCHEME = ENERGIES.index("external"), ENERGIES.index("scheme")
N = 6
PUSHED = [2, 5]
FORCE = np.array([-3.0, 7.0])
W = 9.0
"""Of the force, rad/s."""


def dashpot() -> np.ndarray:
    extra = np.zeros((N, N))
    extra[3:5, 3:5] = [[2.0, -2.0], [-2.0, 2.0]]
    return extra


def closed_form(M: np.ndarray, C: np.ndarray, K: np.ndarray, v0: np.ndarray, t: float) -> np.ndarray:
    """Displacement under FORCE cos(W t) on PUSHED from u = 0: steady state and exp(A t) of the rest."""
    F = np.zeros(N)
    F[PUSHED] = FORCE
    q = np.linalg.solve(K - W * W * M + 1j * W * C, F)
    A = np.block([[np.zeros((N, N)), np.eye(N)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    start = np.concatenate([-q.real, v0 - (1j * W * q).real])
    return (sla.expm(A * t) @ start)[:N] + (q * np.exp(1j * W * t)).real


def run(system, loads: Loads, substeps: int = 1, gaps=NO_CHANNELS, flight: int | None = None, **others) -> History:
    """Flights of one output step unless said."""
    asked = OutputRequest(np.arange(system.n))
    return march(FlightStepper(system, gaps, loads, HHT(), substeps, flight or substeps), asked, **others)


def pushed(steps: int, substeps: int, end: float = 2.0) -> Loads:
    time = time_axis(end, end / steps / substeps)
    return forces_on(time, PUSHED, np.cos(W * time)[:, None] * FORCE)


KINDS = {
    "rayleigh": lambda v: system_of(*chain(N, stiffness=400.0), alpha=0.3, beta=2e-3, velocity=v),
    "dashpot": lambda v: system_of(*chain(N, stiffness=400.0), alpha=0.3, beta=2e-3, extra=dashpot(), velocity=v),
    "dense": lambda v: system_of(
        *chain(N, stiffness=400.0), alpha=0.3, beta=2e-3, extra=dashpot(), velocity=v, sparse=False
    ),
    "modal": lambda v: modal_damped(v),
}


def modal_damped(v: np.ndarray):
    """Four modes with 3 %, the others undamped: a low rank."""
    M, K = chain(N, stiffness=400.0)
    system = system_of(M, K, velocity=v)
    return with_modal_damping(system, modes(system.K, system.M, count=4), np.zeros((N, 0)), 0.03)


def damping_matrix(system) -> np.ndarray:
    d: Damping = system.damping
    M, K = (A.toarray() if hasattr(A, "toarray") else A for A in (system.M, system.K))
    return d.alpha * M + d.beta * K + np.asarray(d.other(np.eye(N)))


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_ninth_order_on_a_forced_damped_chain(kind, measured):
    M, K = chain(N, stiffness=400.0)
    v0 = np.random.default_rng(0).standard_normal(N)
    system = KINDS[kind](v0)
    exact = closed_form(M, damping_matrix(system), K, v0, 2.0)
    errors = [np.abs(run(system, pushed(n, 40), 40).displacement[-1] - exact).max() for n in (64, 96)]
    order = np.log(errors[0] / errors[1]) / np.log(1.5)
    # (omega h)^9 / 4.6e8 omega t: what the highest mode loses of its amplitude where nothing else damps it.
    assert errors[-1] < 1e-7 * np.abs(exact).max()
    # Highest frequency 39 rad/s: omega h = 1.2 and .81, the next term bends the order.
    measured("collocation, forced damped chain: order", order, 9.0, abs=0.5)


def swing(per_period: float, periods: int = 40) -> tuple[float, float]:
    """Relative period error and damping ratio of a free oscillator, from the root of its difference equation."""
    h = 1.0 / per_period
    system = system_of(np.eye(1), np.array([[PI2**2]]), velocity=np.ones(1))
    u = run(system, at_rest(time_axis(periods, h))).displacement[:, 0]
    (a, minus_b), *_ = np.linalg.lstsq(np.column_stack([u[1:-1], u[:-2]]), u[2:], rcond=None)
    root = np.roots([1.0, -a, -minus_b])[0]
    decay, turn = -np.log(abs(root)), abs(np.angle(root))
    return PI2 * h / turn - 1.0, decay / turn


def pade(j: int, k: int, z: complex) -> complex:
    """The Pade approximation (j, k) of exp z."""

    def part(a: int, b: int, x: complex) -> complex:
        terms = [factorial(a + b - i) * factorial(a) / factorial(a - i) / factorial(i) * x**i for i in range(a + 1)]
        return sum(terms) / factorial(a + b)

    return part(j, k, z) / part(k, j, -z)


def test_period_and_damping_at_three_and_at_five_steps_a_period(measured):
    """Twenty output steps in ten periods, flights of two. HHT with alpha = -.05 has 24 and 12 %, 1e-2 and 4e-3."""
    for per_period, at_most in ((3, (2e-5, 4e-5)), (5, (3e-9, 2e-8))):
        period, damping = swing(per_period)
        R = pade(4, 5, 1j * PI2 / per_period)
        assert period == pytest.approx(PI2 / per_period / np.angle(R) - 1.0, rel=1e-3)
        assert damping == pytest.approx(-np.log(abs(R)) * per_period / PI2, rel=1e-3)
        name = f"collocation, {per_period} steps a period"
        measured(f"{name}: period error", abs(period), at_most=at_most[0])
        measured(f"{name}: damping ratio", damping, at_most=at_most[1])


def test_the_course_of_a_flight_is_right_between_its_ends(measured):
    """Output at every tenth of a flight with 3.3 flights a period."""
    w = PI2
    system = system_of(np.eye(1), np.array([[w * w]]), velocity=np.array([w]))
    time = time_axis(6.0, 0.03)
    history = run(system, at_rest(time), 1, flight=10)
    off = np.abs(history.displacement[:, 0] - np.sin(w * time))
    assert off.max() < 3.0 * off[::10].max()
    measured("collocation, within flights of .3 of a period", off.max(), at_most=5e-5)
    # Energies between the ends belong to the motion there.
    np.testing.assert_allclose(history.energy[:, :2].sum(axis=1), 0.5 * w * w, rtol=1e-4)
    kinetic = 0.5 * w * w * np.cos(w * time) ** 2
    np.testing.assert_allclose(history.energy[:, 0], kinetic, atol=1e-4 * w * w)


def test_flights_across_output_steps_end_where_others_do():
    """Of two output steps and a half, with the loads of a chain and a last flight that is cut short."""
    v0 = np.random.default_rng(0).standard_normal(N)
    loads = pushed(128, 20)
    fine = run(KINDS["dashpot"](v0), loads, 20)
    for kind in ("dashpot", "dense"):
        across = run(KINDS[kind](v0), loads, 20, flight=50)
        # Every second flight ends between two output steps.
        assert across.time.size == 129 + 26
        rows, scale = across.output_index, np.abs(fine.displacement).max()
        # omega h = 1.5 of the highest mode.
        np.testing.assert_allclose(across.displacement, fine.displacement, atol=1e-4 * scale)
        np.testing.assert_allclose(across.energy[rows, :-1], fine.energy[:, :-1], atol=1e-4 * fine.energy_scale)


def test_what_the_step_cannot_resolve_is_gone_after_a_few_steps():
    """A thousand radians a step, set ringing: no alternating noise stays (HHT keeps nine tenths a step)."""
    system = system_of(
        np.diag([1.0, 1e-6]), np.array([[200.0, -100.0], [-100.0, 100.0]]), velocity=np.array([0.0, 1.0])
    )
    quiet = run(replace(system, velocity=np.array([1e-6, 0.0])), at_rest(time_axis(1.0, 0.1)))
    history = run(system, at_rest(time_axis(1.0, 0.1)))
    # The fast mass brings the momentum 1e-6 of the slow one and .5e-6 of energy.
    assert history.energy[0, 0] == pytest.approx(5e-7)
    np.testing.assert_allclose(history.displacement[6:, 0], quiet.displacement[6:, 0], atol=3e-9)
    assert history.energy[-1, :2].sum() < 1e-11


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10])
def test_ringing_does_not_swing_out_between_the_stages(stiffness):
    """Chain set ringing up to 320 Hz, 3.2 and 32 kHz, flights of 2.5 ms with two output steps in them."""
    M, K = chain(20, stiffness=stiffness)
    v = np.random.default_rng(2).standard_normal(20)
    history = run(system_of(M, K, beta=1e-7, velocity=v), at_rest(time_axis(0.05, 1e-5)), 100, flight=250)
    assert history.energy_created < 1e-3
    assert np.abs(history.displacement).max() < 0.05 * np.sqrt(1e6 / stiffness) + 20.0 * 0.05 * abs(v.mean())


@pytest.mark.parametrize("substeps", [1, 10])
def test_energy_balance_holds_to_the_dissipation_of_the_scheme(substeps, measured):
    """What is left over never falls, and falls with the ninth power of the step."""
    v0 = np.random.default_rng(0).standard_normal(N)
    left = []
    for n in (40, 60, 90):
        history = run(KINDS["dashpot"](v0), pushed(n, substeps), substeps)
        assert np.diff(history.energy[:, SCHEME]).min() >= -1e-13
        assert history.energy[-1, ENERGIES.index("damping")] > 0.5
        left.append(history.energy[-1, SCHEME])
    order = np.log(np.array(left[:-1]) / left[1:]) / np.log(1.5)
    assert (order > 8.0).all()
    assert left[-1] < 1e-6 * history.energy[:, EXTERNAL].max()
    measured(
        "collocation, forced damped chain: energy lost by the scheme",
        left[-1] / history.energy_scale,
        at_most=1e-6,
        source="conservation",
        section="energy",
    )


def test_external_work_is_force_times_way():
    system, loads = KINDS["dashpot"](np.zeros(N)), pushed(100, 10, 1.0)
    reference = simulate(system, NO_CHANNELS, pushed(2000, 1, 1.0), HHT(), OutputRequest(np.arange(N)))
    history = run(system, loads, 10)
    # HHT at omega h = .02, (omega h)^2 = 4e-4 of .7.
    np.testing.assert_allclose(history.energy[:, EXTERNAL], reference.energy[::20, EXTERNAL], atol=3e-4)


def test_flights_are_long_under_smooth_loads_and_short_under_rough_ones():
    """A multisine up to a tenth of the sampling rate; noise whose straight pieces meet at the output steps."""
    system = KINDS["rayleigh"](np.zeros(N))
    time = time_axis(1.0, 1e-3)
    noise = np.random.default_rng(3).standard_normal(101)
    smooth = forces_on(time, PUSHED, np.cos(PI2 * 10.0 * time)[:, None] * FORCE)
    rough = forces_on(time, PUSHED, np.interp(time, np.arange(101) * 0.01, noise)[:, None] * FORCE)
    for loads, stages, stride in ((smooth, 5, 22), (rough, 3, 10)):
        rule, samples, said = choose(loads, 10)
        assert (rule.stages, samples, said) == (stages, stride, "")
    fine = run(system, rough, 1)
    history = march(FlightStepper(system, NO_CHANNELS, rough, HHT(), 10), OutputRequest(np.arange(N)))
    across = run(system, rough, 10, flight=25)
    off = [np.abs(h.displacement - fine.displacement[::10]).max() for h in (history, across)]
    # Stages between samples round the kinks.
    assert off[0] < 1e-3 * np.abs(fine.displacement).max()
    assert off[1] > 5.0 * off[0]
    assert history.energy_created < 1e-9


def test_fewer_factors_are_taken_where_memory_holds_no_more(monkeypatch):
    """Order 9 takes what five real factors do, 5 three; where not even that fits the factors themselves refuse."""
    time = time_axis(2.0, 1e-3)
    smooth = forces_on(time, PUSHED, np.cos(PI2 * 10.0 * time)[:, None] * FORCE)
    for gigabytes, stages in ((5.1, 5), (4.9, 3), (1.0, 3)):
        monkeypatch.setenv("CREAK_MEMORY_GB", str(gigabytes))
        rule, _, said = choose(smooth, 10, 1e9)
        assert rule.stages == stages
        assert ("memory" in said) == (stages < 5)
    monkeypatch.setenv("CREAK_MEMORY_GB", "1e-9")
    with pytest.raises(NumericalError, match="memory does not hold the factor"):
        run(KINDS["rayleigh"](np.zeros(N)), pushed(10, 1))


# --- prescribed motion -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rayleigh", [Rayleigh(2.0, 1e-5), Rayleigh(0.0, 0.0)])
def test_prescribed_motion_equals_a_fine_run(rayleigh):
    """Two cantilevers on a base that follows 24 lines up to 60 Hz; dashpot between their tips."""
    system = cantilevers(rayleigh, dashpot=0.4)
    gaps = gaps_between(1.0)
    fine = multisine_base(time_axis(0.2, 4e-5), 5.0, 60.0, 1e-3)
    coarse = multisine_base(time_axis(0.2, 2e-4), 5.0, 60.0, 1e-3)
    a = simulate(system, gaps, fine, HHT(), OutputRequest(np.zeros(0, dtype=np.int64)))
    b = march(FlightStepper(system, gaps, coarse, HHT(), 5), OutputRequest(np.zeros(0, dtype=np.int64)))
    motion, rows = np.abs(a.gap - 1.0).max(), b.output_index
    # HHT at 40 us: a phase of (omega h)^2 / 10 omega t = 3e-3 of what swings at 60 Hz.
    np.testing.assert_allclose(b.gap[rows], a.gap[::25], atol=5e-3 * motion)
    scale = np.abs(a.energy[:, EXTERNAL]).max()
    np.testing.assert_allclose(b.energy[rows, EXTERNAL], a.energy[::25, EXTERNAL], atol=5e-3 * scale)
    np.testing.assert_allclose(b.energy[:, SCHEME], 0.0, atol=5e-3 * scale)
    assert b.residual < 1e-9


# --- coordinates without mass --------------------------------------------------------------------------------------


def test_coordinates_without_mass_follow_statically():
    """Mass, spring, massless node, spring, ground: the node halves the motion of the mass, at every step."""
    M, K = np.diag([1.0, 0.0]), np.array([[100.0, -100.0], [-100.0, 200.0]])
    history = run(system_of(M, K, velocity=np.array([1.0, 0.0])), at_rest(time_axis(2.0, 0.05)))
    u = history.displacement
    np.testing.assert_allclose(u[:, 1], 0.5 * u[:, 0], atol=1e-14)
    w = np.sqrt(50.0)
    # Damping ratio (w h)^5 / 7200 = 8e-7 over w t = 14 rad.
    np.testing.assert_allclose(u[:, 0], np.sin(w * history.time) / w, atol=1.5e-5 / w)
    assert history.energy_created < 1e-12


def test_a_coordinate_with_neither_mass_nor_stiffness_is_named():
    M, K = np.diag([1.0, 0.0]), np.diag([100.0, 0.0])
    with pytest.raises(NumericalError, match=r"row 1|singular"):
        run(system_of(M, K), at_rest(time_axis(1.0, 0.1)))


# --- backends ------------------------------------------------------------------------------------------------------


def test_same_motion_without_pardiso(monkeypatch):
    """SuperLU and LAPACK give what PARDISO gives."""
    import creak.linalg.complex_factor as complex_factor
    import creak.linalg.factor as factor

    v0 = np.random.default_rng(0).standard_normal(N)
    here = run(KINDS["modal"](v0), pushed(40, 4), 4).displacement
    for module in (complex_factor, factor):
        monkeypatch.setattr(module, "has_pardiso", lambda: False)
    there = run(KINDS["modal"](v0), pushed(40, 4), 4).displacement
    np.testing.assert_allclose(there, here, atol=1e-12 * np.abs(here).max())


# --- touches ---------------------------------------------------------------------------------------------------------


def thrown(depth: float, substeps: int) -> History:
    """A mass on a soft spring that would swing `depth` past a stop and back within one flight of ten a period."""
    w, top = PI2, 1.0
    gaps = channels([[-1.0]], top - depth, 1e3)
    system = system_of(np.eye(1), np.array([[w * w]]), velocity=np.array([w * top]))
    loads = at_rest(time_axis(0.55, 0.1 / substeps))
    return run(system, loads, substeps, gaps)


@pytest.mark.parametrize("depth", [1e-2, 1e-3, 1e-4])
def test_a_touch_in_the_middle_of_a_flight_is_found(depth):
    """sin(2 pi t) peaks at .25 s; the steps end at .2 and .3, with gaps of 5 % of the way.

    The smallest touch is a tenth of a flight long.
    """
    history = thrown(depth, 1000)
    pressed = history.time[history.force[:, 0] > 0.0]
    assert pressed.size >= 30
    swings = np.arcsin(1.0 - depth) / PI2
    assert pressed[0] == pytest.approx(swings, abs=2e-4)
    # Short steps from the twentieth of the flight before contact to the one behind it, flights elsewhere.
    short = history.time[1:][np.diff(history.time) < 2e-4]
    assert short[0] > swings - 0.01
    assert short[-1] < pressed[-1] + 0.01
    assert history.time.size < short.size + 12


def test_a_flight_ends_before_contact_and_its_motion_there_is_right():
    """The step in which a mass swings into a stop: place and speed at the last instant before it, and the impulse."""
    history = thrown(0.1, 1000)
    first = int(np.argmax(history.force[:, 0] > 0.0))
    last = np.flatnonzero(np.diff(history.time[:first]) > 2e-4)[-1] + 1
    t = history.time[last]
    assert t < np.arcsin(0.9) / PI2 < t + 0.012
    assert history.gap[last, 0] == pytest.approx(0.9 - np.sin(PI2 * t), abs=1e-5)
    assert history.energy[last, 0] == pytest.approx(0.5 * (PI2 * np.cos(PI2 * t)) ** 2, rel=1e-4)
    # There and back on the stop, about its place of rest: w2^2 = w^2 + k, with the pull of the soft spring.
    W = np.sqrt(PI2**2 + 1e3)
    rest, v = -(PI2**2) * 0.9 / W**2, PI2 * np.sqrt(1.0 - 0.9**2)
    amplitude, phase = np.hypot(rest, v / W), np.arctan2(-rest, v / W)
    long = (np.pi + 2.0 * phase) / W if rest > 0 else (np.pi - 2.0 * np.arctan2(-rest, v / W)) / W
    impulse = 1e3 * (rest * long + 2.0 * amplitude / W * np.cos(np.arcsin(-rest / amplitude)))
    assert history.weights @ history.force[:, 0] == pytest.approx(impulse, rel=1e-3)


def test_the_closing_test_divides_no_flight_that_passes_at_a_thousandth():
    history = thrown(-1e-3, 200)
    assert history.time.size == 6
    assert not history.contact_steps


def test_division_without_a_touch_changes_nothing():
    """To the end of a divided step and on from there: no energy comes or goes, no acceleration is out of place."""
    v0 = np.random.default_rng(0).standard_normal(N)
    loads = pushed(320, 20)
    plain = run(KINDS["dashpot"](v0), loads, 20)

    class Nervous(FlightStepper):
        def _begin(self, now):
            if now.row in (1000, 1020, 3000):
                self._closed = now.row + 20
            else:
                super()._begin(now)

    gaps = channels(np.eye(1, N), 1e3, 1.0)
    stepper = Nervous(KINDS["dashpot"](v0), gaps, loads, HHT(), 20, 20)
    history = march(stepper, OutputRequest(np.arange(N)))
    assert history.time.size == 321 + 3 * 19
    # HHT at omega h = .012: a phase of (omega h)^2 / 10 of 40 rad/s over .0125 s three times, 2e-5.
    scale = np.abs(plain.displacement).max()
    np.testing.assert_allclose(history.displacement, plain.displacement, atol=2e-5 * scale)
    rows = history.output_index
    np.testing.assert_allclose(history.energy[rows, SCHEME], plain.energy[:, SCHEME], atol=2e-5 * plain.energy_scale)


def test_a_run_that_starts_closed_presses_from_the_first_instant():
    m, k, depth = 1.0, 1e4, 1e-3
    history = run(
        system_of(np.eye(1) * m, np.zeros((1, 1))), at_rest(time_axis(0.05, 1e-5)), 100, channels([[1.0]], -depth, k)
    )
    w = np.sqrt(k / m)
    rows = history.output_index
    t = history.time[rows]
    exact = depth * np.where(t < 0.5 * np.pi / w, 1 - np.cos(w * t), 1 + w * t - 0.5 * np.pi)
    np.testing.assert_allclose(history.displacement[:, 0], exact, atol=1e-5 * depth)
    assert history.energy_created < 1e-5


# --- the end of a run --------------------------------------------------------------------------------------------------


def test_ctrl_c_keeps_what_was_computed():
    def interrupt(done: int, total: int) -> None:
        if done >= 20:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="stopped at t = ") as stop:
        run(KINDS["rayleigh"](np.ones(N)), pushed(40, 1), progress=interrupt)
    assert stop.value.history.time.size == 21
