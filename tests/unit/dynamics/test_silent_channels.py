"""Channels that are only watched cost memory in proportion to their number."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from creak.contact.gap_operator import GapOperator
from creak.dynamics.flow import march as flow_march
from creak.dynamics.flow.march import simulate_flow
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import CondensedStepper, simulate
from creak.reduction.diagonal import diagonalise
from helpers_core import chain, channels, system_of

MANY = 5_000
"""Channels: a matrix of them would be 200 MB."""


@pytest.fixture(scope="module")
def system():
    return diagonalise(system_of(*chain(2)))


def watched(m: int, stiffness: float) -> GapOperator:
    G = np.zeros((m, 2))
    G[:, 0], G[:, 1] = np.linspace(-1.0, 1.0, m), 1.0
    return channels(G, 1.0, stiffness, 0.0)


def loads() -> Loads:
    time = np.linspace(0.0, 0.03, 31)
    return Loads(time, np.zeros((3, time.size, 0)), np.sin(200.0 * time)[:, None], (np.array([1.0, 0.0]),))


def flown(system, gaps):
    return simulate_flow(system, gaps, loads(), OutputRequest(np.arange(2)))


def stepped(system, gaps):
    return simulate(system, gaps, loads(), HHT(-0.05), OutputRequest(np.arange(2)))


@pytest.mark.parametrize(
    ("kind", "how"), [(flow_march.FlowRun, (OutputRequest(np.arange(2)), SETTLED)), (CondensedStepper, (HHT(-0.05),))]
)
def test_watching_many_channels_makes_no_matrix_of_them(kind, how, system):
    for m in (3, MANY):  # the first compiles
        gaps = watched(m, 0.0)
        arguments = [system, gaps, loads(), *how]
        tracemalloc.start()
        made = kind(*arguments)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert made.gaps.m == MANY
    assert peak < 0.1 * 8 * MANY**2


@pytest.mark.parametrize("march", [flown, stepped])
def test_gaps_are_those_of_channels_that_could_press_and_do_not(march, system):
    silent, open_ = (march(system, watched(3, stiffness)) for stiffness in (0.0, 100.0))
    np.testing.assert_allclose(silent.gap[-1], open_.gap[-1], rtol=1e-10)
    assert not open_.force.any()
