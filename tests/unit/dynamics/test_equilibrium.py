"""Equilibrium of a mass on springs that is pressed against a floor with friction and pulled along it."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.dynamics.equilibrium import equilibrium
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.linalg.factor import factor

ALONG, DOWN, FLOOR, MU, PRESSED, CLEAR = 10.0, 5.0, 100.0, 0.5, 3.0, 0.2
NORMAL = FLOOR * (PRESSED - DOWN * CLEAR) / (DOWN + FLOOR)
"""Of the floor, at a distance CLEAR below the mass."""


def solved(pull: float, friction: float = MU):
    system = creak.system_from_matrices(np.diag([ALONG, DOWN]), np.eye(2), alpha=0.1)
    across = np.array([[1.0, 0.0]])
    rubs = {"tangents": [across, 0.0 * across], "friction": friction} if friction else {}
    gaps = creak.gap_channels(np.array([[0.0, 1.0]]), CLEAR, FLOOR, **rubs)
    state = equilibrium(system, factor(system.K), gaps, np.array([pull, -PRESSED]), np.zeros(0))
    return system, gaps, state


@pytest.mark.parametrize("pull", [1.0, 4.0])
def test_a_mass_sticks_or_slides_by_what_friction_bears(pull):
    """Loads that grow together: friction bears the pull up to mu p, at which the spring takes the rest.

    Before it touches the mass has been pulled by the share of the load at touch.
    """
    _, _, state = solved(pull)
    free = pull * DOWN * CLEAR / PRESSED / ALONG
    stuck = abs(pull - ALONG * free) <= MU * NORMAL
    assert state.force[0] == pytest.approx(NORMAL, rel=1e-9)
    moved = free if stuck else (pull - MU * NORMAL) / ALONG
    assert state.q[0] == pytest.approx(moved, rel=0.1 if stuck else 1e-9)
    assert np.hypot(*state.held[0]) == pytest.approx(pull - ALONG * state.q[0], rel=1e-9)
    assert state.residual < 1e-12
    assert state.energy_error < 1e-12


def test_without_friction_it_follows_the_pull():
    _, _, state = solved(4.0, 0.0)
    assert state.q[0] == pytest.approx(4.0 / ALONG)
    assert state.increments == 1


def test_what_friction_holds_stays_by_steps():
    """The motion about the state: nothing moves, and the friction force stays what it was."""
    system, gaps, state = solved(1.0)
    time = 0.01 * np.arange(101)
    none = Loads(time, np.zeros((3, 101, 0)), np.zeros((101, 0)))
    h = simulate(system, state.on(gaps), none, HHT(-0.05), OutputRequest(np.arange(2)))
    assert np.abs(h.displacement).max() <= 1e-9 * abs(state.q[0])
    assert h.tangential == pytest.approx(np.tile(state.held[0], (101, 1)), rel=1e-9)
    assert h.tangential[0, 0] != 0.0
    assert h.energy_created < 1e-9
