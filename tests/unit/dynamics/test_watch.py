"""Extremes over every whole step: the same however the motion comes in, and in either march.

Channels that are only watched cost memory in proportion to their number.
"""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import scipy.sparse as sp

from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flow import march as flow_march
from creak.dynamics.flow.march import simulate_flow
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.watch import Watch, Watched
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import CondensedStepper, simulate
from creak.reduction.diagonal import diagonalise
from helpers_core import NO_CHANNELS, chain, channels, system_of, time_axis


def watched(silent, turns=((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))) -> Watched:
    return Watched(silent, sp.csr_matrix(np.array(turns)), np.array([0, 1]), ("part A",))


def swinging():
    """Two masses on springs of their own, 20 and 35 Hz, thrown against each other."""
    K = np.diag([(2.0 * np.pi * 20.0) ** 2, (2.0 * np.pi * 35.0) ** 2])
    return system_of(np.eye(2), K, velocity=[1.0, -0.7], sparse=False)


def test_the_smallest_gap_between_two_steps_is_that_of_the_motion():
    """A sine sampled ten times a period: its trough to 1 % of its amplitude, where the samples miss up to 5 %."""
    system = swinging()
    gaps = channels(np.array([[1.0, 0.0]]), gap0=0.01, stiffness=0.0)
    watch = Watch(system, NO_CHANNELS, channel_matrices(system, NO_CHANNELS), watched(gaps.without_force()))
    time = 0.005 * np.arange(30)
    u = 0.008 * np.sin(2.0 * np.pi * 20.0 * time)[None]
    still, none = np.zeros((3, 30)), np.zeros((0, 30))
    watch.see(time, np.zeros((30, 0), dtype=bool), [none, none, u, still])
    seen = watch.extremes
    assert u.min() > -0.96 * 0.008
    assert seen.gap[0] == pytest.approx(0.002, abs=0.01 * 0.008)
    assert abs(seen.gap_at[0] % 0.05 - 0.0375) <= 0.005


@pytest.mark.parametrize("size", [1, 2, 7, 400])
def test_blocks_of_any_size_show_the_same(size):
    system, rng = swinging(), np.random.default_rng(4)
    gaps = channels(np.array([[1.0, -1.0], [0.0, 1.0]]), gap0=3.0, stiffness=0.0)
    pressing = channels(np.array([[0.0, 1.0]]), gap0=1.0, stiffness=1.0)
    on = channel_matrices(system, pressing)
    time, pressed = np.linspace(0.0, 1.0, 400), rng.random((400, 1)) < 0.1
    motions = [rng.standard_normal((k, 400)).cumsum(axis=1) for k in (1, 1, 2, 3)]
    whole, parts = (Watch(system, pressing, on, watched(gaps.without_force())) for _ in range(2))
    whole.see(time, pressed, motions)
    for k in range(0, 400, size):
        here = slice(k, k + size)
        parts.see(time[here], pressed[here], [m[:, here] for m in motions])
    for name in ("slip", "slip_at", "gap", "gap_at", "turn", "turn_at"):
        np.testing.assert_array_equal(getattr(parts.extremes, name), getattr(whole.extremes, name))


@pytest.mark.parametrize("every", [1, 7])
def test_every_form_of_a_system_sees_the_same_whatever_is_kept(every):
    system = swinging()
    silent = channels(np.array([[1.0, -1.0]]), gap0=0.02, stiffness=0.0).without_force()
    contact = channels(np.array([[-1.0, 1.0]]), gap0=0.004, stiffness=1e5)
    loads = at_rest(time_axis(0.35, 1e-3))
    seen = [
        simulate(s, contact, loads, HHT(), OutputRequest(np.arange(2), every=every, watched=watched(silent))).extremes
        for s in (system, diagonalise(system))
    ]
    assert seen[0].gap[0] < 0.02
    assert seen[0].turn[0] > 0.003
    for other in seen[1:]:
        for name in ("slip", "gap", "gap_at", "turn", "turn_at"):
            np.testing.assert_allclose(getattr(other, name), getattr(seen[0], name), rtol=1e-9)


MANY = 5_000
"""Channels: a matrix of them would be 200 MB."""


@pytest.fixture(scope="module")
def system():
    return diagonalise(system_of(*chain(2)))


def row_of(m: int, stiffness: float) -> GapOperator:
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
        gaps = row_of(m, 0.0)
        arguments = [system, gaps, loads(), *how]
        tracemalloc.start()
        made = kind(*arguments)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert made.gaps.m == MANY
    assert peak < 0.1 * 8 * MANY**2


@pytest.mark.parametrize("march", [flown, stepped])
def test_gaps_are_those_of_channels_that_could_press_and_do_not(march, system):
    silent, open_ = (march(system, row_of(3, stiffness)) for stiffness in (0.0, 100.0))
    np.testing.assert_allclose(silent.gap[-1], open_.gap[-1], rtol=1e-10)
    assert not open_.force.any()
