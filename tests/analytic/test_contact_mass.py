"""One mass and its stop: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from creak.dynamics.history import ENERGIES, History
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.verify.events import find_events
from helpers_core import channels, forces_on, free_run, system_of, time_axis

RECORDED = {"section": "contact", "source": "closed form"}

PI = np.pi


def one_mass(m: float, k: float, v0: float):
    return system_of(np.array([[m]]), np.array([[k]]), velocity=np.array([v0]))


def velocity(history: History) -> np.ndarray:
    """Central differences of the first observed dof."""
    return np.gradient(history.displacement[:, 0], history.time[history.output_index])


# --- m = 100, k = 1e4, stop 1e6, no gap, v0 = 1 (downward) -------------------------------------------------

OMEGA = np.sqrt(1.01e6 / 100.0)
STOP = channels([[1.0]], 0.0, 1e6)


def on_stop(h: float, alpha: float = -0.05) -> History:
    return free_run(one_mass(100.0, 1e4, -1.0), STOP, 0.036, h, alpha)


@pytest.fixture(scope="module")
def fine() -> History:
    return on_stop(2e-5)


def test_numbers_of_the_case_are_its_closed_form():
    assert pytest.approx(9950.3719, abs=5e-5) == 1e6 / OMEGA
    assert pytest.approx(0.0312600153, abs=5e-11) == PI / OMEGA
    assert pytest.approx(198.01980, abs=5e-6) == 2e6 / OMEGA**2


def test_mass_on_a_penalty_stop_force_duration_and_impulse(fine, measured):
    # (omega h)^2 / 12 = 3e-7 is the scheme's error; the interpolated release adds up to (omega h)^2 = 4e-6.
    event = find_events(fine, STOP, merge=0.0, f_max=1e6)[0]
    measured("mass on a penalty stop: peak force", event.force_peak, 9950.3719, rel=4e-6, unit="N")
    measured("mass on a penalty stop: duration", event.t_end - event.t_start, 0.0312600153, rel=4e-6, unit="s")
    # The first touch at t = 0 to the release; the sum of forces is a rectangle rule, exact to (omega h)^2.
    measured("mass on a penalty stop: impulse", event.impulse, 198.01980, rel=4e-6, unit="N s")


def test_mass_leaves_a_penalty_stop_with_the_speed_it_came(fine, measured):
    after = fine.time > 0.0313
    w = np.sqrt(1e4 / 100.0)
    t = fine.time[after] - PI / OMEGA
    # Free again it swings on its own spring: v = cos(w t).
    measured(
        "mass on a penalty stop: speed after it left, worst instant",
        velocity(fine)[after][1:-1],
        np.cos(w * t)[1:-1],
        abs=1e-5,
        unit="m/s",
    )


def test_error_on_a_stop_falls_with_the_square_of_the_step(measured):
    # Only while the contact lasts: the release falls between two steps.
    errors = []
    for h in (4e-4, 2e-4, 1e-4):
        history = on_stop(h)
        inside = history.time < 0.03
        exact = 1e6 / OMEGA * np.sin(OMEGA * history.time[inside])
        errors.append(np.abs(history.force[inside, 0] - exact).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    # HHT is of second order; .1 is what the next term may bend it.
    measured("mass on a penalty stop: order in the step", order, 2.0, abs=0.1, source="HHT")


def test_energy_on_a_stop_is_kept_to_the_scheme_dissipation(fine, measured):
    stored = fine.energy[:, :3].sum(axis=1)
    # Damping ratio -alpha (1+alpha)^2 Omega^3 / 8 = 6e-12 per radian is far below the impact's own O((omega h)^2).
    measured("mass on a penalty stop: energy, worst instant", stored, 50.0, rel=4e-6, unit="J", source="conservation")
    assert fine.energy_created < 4e-6
    assert fine.energy[:, ENERGIES.index("contact")].max() == pytest.approx(0.5 * 9950.3719**2 / 1e6, rel=1e-5)


# --- gravity ----------------------------------------------------------------------------------------------


def test_mass_with_gravity_on_a_spring_stop(measured):
    """m = 1, k = 1e4, g = 9.81, v0 = 1: contact .0333717 s, force 110.290."""
    h = 1e-5
    time = time_axis(0.036, h)
    gaps = channels([[1.0]], 0.0, 1e4)
    loads = forces_on(time, [0], np.full(time.size, -9.81))
    history = simulate(one_mass(1.0, 0.0, -1.0), gaps, loads, HHT(), OutputRequest(np.array([0])))
    event = find_events(history, gaps, merge=0.0, f_max=1e6)[0]
    w, static = 100.0, 9.81 / 1e4
    amplitude = np.hypot(1.0 / w, static)
    assert 1e4 * (amplitude + static) == pytest.approx(110.290, abs=5e-4)
    # The printed digits; the scheme is good to (omega h)^2 = 1e-6.
    leaving = velocity(history)[np.searchsorted(history.time, event.t_end)]
    measured("mass with gravity on a spring stop: peak force", event.force_peak, 110.290, abs=5e-4, unit="N")
    measured("mass with gravity on a spring stop: duration", event.t_end, 0.0333717, abs=1e-7, unit="s")
    # one step of gravity
    measured("mass with gravity on a spring stop: speed on leaving", leaving, 1.0, abs=2e-4, unit="m/s")


def test_mass_bounces_back_to_its_height(measured):
    """Dropped on a stiff stop it comes back: period 2 sqrt(2 H / g) + contact."""
    m, g, H, k = 1.0, 10.0, 0.05, 1e5
    h = 1e-4
    time = time_axis(0.34, h)
    gaps = channels([[1.0]], H, k)
    loads = forces_on(time, [0], np.full(time.size, -m * g))
    history = simulate(one_mass(m, 0.0, 0.0), gaps, loads, HHT(), OutputRequest(np.array([0])))
    events = find_events(history, gaps, merge=0.0, f_max=1e6)
    speed, w = np.sqrt(2 * g * H), np.sqrt(k / m)
    # Contact on a spring under gravity: w t / 2 = pi - atan(v w / g).
    contact = 2.0 * (PI - np.arctan(speed * w / g)) / w
    period = 2.0 * speed / g + contact
    first = speed / g
    for i, event in enumerate(events[:2]):
        assert event.t_start == pytest.approx(first + i * period, abs=2 * h)
        # Speed from a backward difference one step before: g h of the fall is missing.
        assert event.closing_speed == pytest.approx(speed, abs=2 * g * h + 1e-3)
        measured(
            f"mass that bounces: duration of contact {i + 1}", event.t_end - event.t_start, contact, rel=2e-3, unit="s"
        )
        measured(
            f"mass that bounces: impulse {i + 1}", event.impulse, 2 * m * speed + m * g * contact, rel=2e-3, unit="N s"
        )


# --- bilinear oscillator ------------------------------------------------------------------------------------


def test_bilinear_oscillator_period(measured):
    """T = pi (1/w1 + 1/w2), whatever the amplitude."""
    m, k, stop = 2.0, 800.0, 7200.0
    w1, w2 = np.sqrt(k / m), np.sqrt((k + stop) / m)
    period = PI * (1.0 / w1 + 1.0 / w2)
    h = period / 1000
    gaps = channels([[1.0]], 0.0, stop)
    for v0 in (1.0, 20.0):
        history = free_run(one_mass(m, k, v0), gaps, 3.2 * period, h)
        starts = np.array([e.t_start for e in find_events(history, gaps, merge=0.0, f_max=1e6)])
        assert starts.size == 3
        assert starts[0] == pytest.approx(PI / w1, rel=7e-5)
        # Period error Omega^2 (1/12 - alpha/4) = 6e-6 while pressed; interpolated crossings add (omega h)^2 = 6e-5.
        measured(f"bilinear oscillator from {v0:g} m/s: period", np.diff(starts), period, rel=7e-5, unit="s")


def test_play_between_two_stops_keeps_the_mass_inside(measured):
    """A free mass rattles between two stops: one round 2 d / v + 2 pi / omega."""
    m, k, d, v = 0.5, 5e5, 2e-3, 0.5
    w = np.sqrt(k / m)
    gaps = channels([[-1.0], [1.0]], d / 2, k)
    h = 1e-5
    history = free_run(one_mass(m, 0.0, v), gaps, 0.04, h)
    events = find_events(history, gaps, merge=0.0, f_max=1e9)
    upper = [e.t_start for e in events if e.channel == "stop:0"]
    # (omega h)^2 = 1e-4 at each of 4 crossings.
    assert -history.gap.min() == pytest.approx(v / w, rel=1e-4)
    measured("mass between two stops: time of a round", np.diff(upper), 2 * d / v + 2 * PI / w, rel=4e-4, unit="s")


# --- dampers of channels ------------------------------------------------------------------------------------


def test_closing_damper_takes_energy_and_never_pulls(measured):
    """On a spring and dashpot the force jumps to c v at first touch and never becomes a pull."""
    m, k, c, v = 1.0, 1e4, 20.0, 1.0
    gaps = channels([[1.0]], 1e-3, k, c)
    history = free_run(one_mass(m, 0.0, -v), gaps, 0.035, 1e-5)
    assert (history.force >= 0.0).all()
    assert (history.gap[history.force == 0.0] >= -1e-9).mean() > 0.5
    first = np.flatnonzero(history.force[:, 0] > 0.0)[0]
    assert history.force[first + 1, 0] == pytest.approx(c * v, rel=0.03)
    # m x'' + c x' + k x = 0 from x = 0 until the force returns to zero.
    w, zeta = np.sqrt(k / m), c / (2 * np.sqrt(k * m))
    wd = w * np.sqrt(1 - zeta**2)
    t = np.linspace(0.0, PI / wd, 20_001)
    x = v / wd * np.exp(-zeta * w * t) * np.sin(wd * t)
    dx = np.gradient(x, t)
    end = np.flatnonzero(k * x + c * dx < 0.0)[0]
    loss = 0.5 * m * (v**2 - dx[end] ** 2) - 0.5 * k * x[end] ** 2
    lost = history.energy[-1, ENERGIES.index("contact_damping")]
    assert history.energy[:, ENERGIES.index("contact_damping")].min() >= 0.0
    # The rest of the spring's energy goes too: it unloads against its own damper, away from the mass.
    # The backward rule in the closing step is off by half a step of the jump, c v h / 2 of some c v w.
    measured("stop with spring and dashpot: energy lost", lost, loss + 0.5 * k * x[end] ** 2, rel=5e-3, unit="J")
    scheme = history.energy[-1, ENERGIES.index("scheme")]
    assert abs(scheme) < 5e-3 * lost
    assert velocity(history)[-2] == pytest.approx(-dx[end], rel=5e-3)
