"""Steps in contact: passive where they resolve nothing, fine where a mass has to rebound; springs for hard contact."""

from __future__ import annotations

import numpy as np
import pytest

from creak.dynamics.flight.contact_steps import FINEST, IN_CONTACT, RESOLVED, steps_in_contact
from creak.dynamics.flight.stepper import simulate_high_order
from creak.dynamics.history import History
from creak.dynamics.loads import at_rest
from creak.dynamics.scheme import Scheme
from creak.verify.reliability import created_of_contact
from helpers_core import bar, channels, system_of, time_axis

LONGEST, STEP = 2e-5, 1e-3
MASS = system_of(np.eye(1), np.zeros((1, 1)), velocity=-np.ones(1))


def thrown(stop, parts: int, scheme: Scheme = IN_CONTACT) -> History:
    """A mass of 1 with speed 1 onto a stop at 1.234 mm."""
    time = time_axis(5e-3, STEP / parts)
    return simulate_high_order(MASS, stop, at_rest(time), scheme, observed=np.array([0]), substeps=parts)


def leaving(history: History) -> float:
    return float(np.diff(history.displacement[-2:, 0])[0] / STEP)


@pytest.mark.parametrize("omega_h", [0.5, 1.0, 2.0, 4.0, 8.0, 30.0])
def test_unresolved_springs_throw_nothing_back_that_did_not_come(omega_h):
    stop = channels([[1.0]], 1.234e-3, (omega_h / LONGEST) ** 2)
    history = thrown(stop, round(STEP / LONGEST))
    assert 0.3 < leaving(history) < 1.0
    assert created_of_contact(history) < 1e-9


@pytest.mark.parametrize("stiffness", [1e7, 1e9, 1e11, np.inf])
def test_a_mass_rebounds_from_its_spring(stiffness):
    """Contact of 1 ms to 10 us: 12 % to all of its own steps."""
    parts, stop = steps_in_contact(MASS, channels([[1.0]], 1.234e-3, stiffness), STEP, LONGEST)
    assert parts == pytest.approx(STEP / LONGEST, abs=1) or parts * LONGEST / STEP <= FINEST
    omega = np.sqrt(float(stop.stiffness[0]))
    resolved = omega * STEP / parts <= RESOLVED
    history = thrown(stop, parts)
    impulse = float(history.weights @ history.force[:, 0])
    assert impulse == pytest.approx(2.0, rel=0.01 if resolved else 0.05)
    assert created_of_contact(history) < 1e-9


def test_hard_contact_turns_the_own_mass_of_a_channel_round_in_20_us():
    _, stop = steps_in_contact(MASS, channels([[1.0]], 1.0, np.inf), STEP, LONGEST)
    assert stop.stiffness[0] == pytest.approx((np.pi / 2e-5) ** 2, rel=1e-9)


def test_the_front_of_a_bar_needs_no_finer_steps():
    """Steel bar, 100 elements of 1 mm: its end moves six times as much in ten steps as a block would."""
    M, K = bar(100, 0.1, 2.1e11 * 1e-4, 7800.0 * 1e-4)
    stop = channels(np.eye(1, 101), 1e-4, 10.0 * 2.1e11 * 1e-4 / 1e-3)
    parts, same = steps_in_contact(system_of(M, K), stop, STEP, LONGEST)
    assert parts == round(STEP / LONGEST)
    assert same is stop


def test_nothing_is_asked_where_nothing_presses():
    stop = channels([[1.0]], 1.0, 0.0)
    assert steps_in_contact(MASS, stop, STEP, LONGEST) == (50, stop)
