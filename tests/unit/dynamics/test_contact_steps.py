"""Steps in contact: passive where they resolve nothing, fine where a mass has to rebound; springs for hard contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from creak.dynamics.flight.contact_steps import FINEST, IN_CONTACT, REBOUND, RESOLVED, steps_in_contact
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.history import History
from creak.dynamics.loads import at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import Scheme
from creak.dynamics.simulate import march
from creak.verify.reliability import created_of_contact
from helpers_core import bar, channels, system_of, time_axis

PARTS, STEP = 50, 1e-3
LONGEST = replace(SETTLED, stepped=1.0 / PARTS)
"""Of a step."""
MASS = system_of(np.eye(1), np.zeros((1, 1)), velocity=-np.ones(1))


def thrown(stop, parts: int, scheme: Scheme = IN_CONTACT, end: float = 5e-3) -> History:
    """A mass of 1 with speed 1 onto a stop at 1.234 mm."""
    time = time_axis(STEP * np.ceil(end / STEP), STEP / parts)
    return march(FlightStepper(MASS, stop, at_rest(time), scheme, parts), OutputRequest(np.array([0])))


def leaving(history: History) -> float:
    return float(np.diff(history.displacement[-2:, 0])[0] / STEP)


@pytest.mark.parametrize("omega_h", [0.5, 1.0, 2.0, 4.0, 8.0, 30.0])
def test_unresolved_springs_throw_nothing_back_that_did_not_come(omega_h):
    stop = channels([[1.0]], 1.234e-3, (omega_h * PARTS / STEP) ** 2)
    history = thrown(stop, PARTS)
    assert 0.3 < leaving(history) < 1.0
    assert created_of_contact(history) < 1e-9


@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9, 1e11, 1e14, np.inf])
def test_a_mass_rebounds_from_its_spring(stiffness):
    """Contact of 10 ms to .3 us: a spring that no part of a step resolves is as stiff as the finest one carries."""
    parts, stop = steps_in_contact(MASS, channels([[1.0]], 1.234e-3, stiffness), STEP, LONGEST)
    assert PARTS <= parts <= PARTS * FINEST
    assert np.sqrt(float(stop.stiffness[0])) * STEP / parts <= RESOLVED * (1.0 + 1e-12)
    assert stop.stiffness[0] == pytest.approx(min(stiffness, (RESOLVED * parts / STEP) ** 2), rel=1e-12)
    history = thrown(stop, parts, end=5e-3 + np.pi / np.sqrt(stop.stiffness[0]))
    impulse = float(history.weights @ history.force[:, 0])
    assert impulse == pytest.approx(2.0, rel=0.002)
    assert created_of_contact(history) < 1e-9


@pytest.mark.parametrize("zeta", [0.1, 0.5, 0.8])
def test_a_mass_rebounds_from_spring_and_damper(zeta):
    """It leaves when k y + c y' = 0, with y = -exp(-zeta w t) sin(w_d t) / w_d (closed form, 18 to 74 % are left)."""
    w = 1500.0
    k, c, w_d = w**2, 2.0 * zeta * w, w * np.sqrt(1.0 - zeta**2)

    def speed(t: float) -> float:
        return float(-np.exp(-zeta * w * t) * (np.cos(w_d * t) - zeta * w / w_d * np.sin(w_d * t)))

    def force(t: float) -> float:
        return float(k * np.exp(-zeta * w * t) * np.sin(w_d * t) / w_d - c * speed(t))

    left = brentq(force, 0.0, np.pi / w_d)
    parts, stop = steps_in_contact(MASS, channels([[1.0]], 1.234e-3, k, damping=c), STEP, LONGEST)
    assert leaving(thrown(stop, parts, end=8e-3)) == pytest.approx(speed(left), rel=0.004)


def test_hard_contact_of_a_mass_is_short_against_a_step():
    """The mass turns round in pi / omega, and omega is as high as its steps resolve, whatever the unit of time."""
    for unit in (1.0, 1e-6, 1e3):
        parts, stop = steps_in_contact(MASS, channels([[1.0]], 1.0, np.inf), unit * STEP, LONGEST)
        assert parts == PARTS * REBOUND
        assert stop.stiffness[0] == pytest.approx((RESOLVED * parts / (unit * STEP)) ** 2, rel=1e-9)


def test_the_front_of_a_bar_needs_no_finer_steps():
    """Steel bar, 100 elements of 1 mm: its end moves six times as much in ten steps as a block would."""
    M, K = bar(100, 0.1, 2.1e11 * 1e-4, 7800.0 * 1e-4)
    blow = 0.2 / np.sqrt(2.1e11 / 7800.0)
    stop = channels(np.eye(1, 101), 1e-4, 10.0 * 2.1e11 * 1e-4 / 1e-3)
    parts, same = steps_in_contact(system_of(M, K), stop, blow / 40.0, LONGEST)
    assert parts == PARTS
    assert same is stop
    parts, same = steps_in_contact(system_of(M, K), stop, blow, LONGEST)
    assert 1000 <= parts <= PARTS * FINEST
    assert same is stop


def test_nothing_is_asked_where_nothing_presses():
    stop = channels([[1.0]], 1.0, 0.0)
    assert steps_in_contact(MASS, stop, STEP, LONGEST) == (PARTS, stop)
