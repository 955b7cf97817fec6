"""Dofs that nothing but dampers hold follow the others; what would press on them, or on nothing, is refused."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

import creak
from helpers_core import NONE, assembled, block, model_of, point_mass, spring, time_axis

TIME = time_axis(0.4, 1e-3)
LOADED = r"acts at dof 1, but only dampers hold it"


def exact(k: float, m: float, c: float, v: float) -> np.ndarray:
    """Motion of one mass by the matrix exponential."""
    A = np.array([[0.0, 1.0], [-k / m, -c / m]])
    return np.array([(sla.expm(A * t) @ [0.0, v])[0] for t in TIME])


def three(ends: float):
    """A mass on a spring; from it a damper of 10 to dof 1, from there one of `ends` to ground."""
    K, M = np.diag([1e3, 0.0]), np.diag([1.0, 0.0])
    C = np.array([[10.0, -10.0], [-10.0, 10.0 + ends]])
    return creak.system_from_matrices(K, M, C, velocity=[1.0, 0.0])


def test_two_dampers_in_series_are_one():
    """1 / c = 1 / 10 + 1 / 10; the point between them moves half as far as the mass."""
    joined = creak.couple(three(10.0))
    u = creak.simulate(joined, [], creak.make_loads(joined, TIME), observed=[0, 1]).displacement
    expected = exact(1e3, 1.0, 5.0, 1.0)
    np.testing.assert_allclose(u[:, 0], expected, atol=1e-6 * np.abs(expected).max())  # of the time integration
    np.testing.assert_allclose(u[:, 1], 0.5 * u[:, 0], atol=1e-15)


def test_a_damper_to_a_free_end_takes_the_end_along():
    joined = creak.couple(three(0.0))
    assert joined.damping.is_rayleigh  # nothing is left of it
    u = creak.simulate(joined, [], creak.make_loads(joined, TIME), observed=[0, 1]).displacement
    expected = exact(1e3, 1.0, 0.0, 1.0)
    np.testing.assert_allclose(u[:, 0], expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_array_equal(u[:, 1], u[:, 0])


def test_a_driven_end_pulls_through_dampers_in_series():
    """m a = c/2 (s' - v): against the exact answer to s = A sin(w t) from rest, s' = A w at once."""
    C = np.array([[10.0, -10.0, 0.0], [-10.0, 20.0, -10.0], [0.0, -10.0, 10.0]])
    K, M = np.diag([1e3, 0.0, 0.0]), np.diag([1.0, 0.0, 0.0])
    joined = creak.couple(creak.system_from_matrices(K, M, C), driven={"end": [2]})
    assert joined.n == 1
    w = 20.0
    loads = creak.make_loads(joined, TIME, motion={"end": creak.Sine(w / (2.0 * np.pi), 1e-3)})
    u = creak.simulate(joined, [], loads, observed=[0, 1, 2]).displacement
    A = np.zeros((4, 4))  # u, v, sin, cos
    A[0, 1], A[1, 0], A[1, 1], A[1, 3], A[2, 3], A[3, 2] = 1.0, -1e3, -5.0, 5.0 * 1e-3 * w, w, -w
    expected = np.array([(sla.expm(A * t) @ [0.0, 0.0, 0.0, 1.0])[0] for t in TIME])
    np.testing.assert_allclose(u[:, 0], expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_allclose(u[:, 1], 0.5 * (u[:, 0] + u[:, 2]), atol=1e-15)


def test_dampers_between_points_that_nothing_else_holds_are_of_no_effect():
    C = np.array([[0.0, 0.0, 0.0], [0.0, 7.0, -7.0], [0.0, -7.0, 7.0]])
    joined = creak.couple(creak.system_from_matrices(np.diag([1e3, 0.0, 0.0]), np.diag([1.0, 0.0, 0.0]), C))
    assert (joined.n, joined.damping.is_rayleigh) == (1, True)
    assert np.asarray(joined.rows(np.arange(3))[0].toarray()).ravel().tolist() == [1.0, 0.0, 0.0]


def test_a_force_a_channel_or_a_system_at_a_damper_alone_is_refused():
    joined = creak.couple(three(10.0))
    with pytest.raises(creak.InputError, match=LOADED):
        creak.simulate(joined, [], creak.make_loads(joined, TIME, forces=[([1], creak.Step(1.0))]))
    stop = creak.gap_channels([[0.0, 1.0]], 1e-3, 1e5)
    for system in (joined, creak.craig_bampton(joined, [0], count=0)):
        with pytest.raises(creak.InputError, match=LOADED):
            creak.simulate(system, stop, creak.make_loads(system, TIME))
    with pytest.raises(creak.InputError, match=LOADED):
        creak.couple(joined, creak.system_from_matrices([[1.0]], [[1.0]], labels=[1]))
    only_mass = creak.gap_channels([[1.0, 0.0]], 1e-3, 1e5)
    assert creak.simulate(joined, only_mass, creak.make_loads(joined, TIME)).force.max() > 0.0


def test_a_force_on_a_dof_that_has_nothing_is_refused():
    joined = creak.couple(creak.system_from_matrices(np.diag([1e3, 0.0, 0.0]), np.diag([1.0, 0.0, 0.0])), fixed=[2])
    with pytest.raises(creak.InputError, match=r"dof 1, but it has neither stiffness nor mass, and nothing holds it"):
        creak.simulate(joined, [], creak.make_loads(joined, TIME, forces=[([1], creak.Step(1.0))]))
    creak.simulate(
        joined, [], creak.make_loads(joined, TIME, forces=[([0, 2], creak.Step(1.0))])
    )  # the support bears it


def test_the_free_end_of_a_dashpot_of_a_deck_follows_and_is_named():
    """node 1 --k-- node 2 (mass), node 2 --c-- node 3: nothing is held by the dashpot."""
    blocks = [
        block("spring2", [[0, 1]], spring(1e3, 1), 0),
        block("spring2", [[1, 2]], spring(0.0, 1, damping=12.0), 0, 5),
        block("mass", [[1]], point_mass(2.0), 0, 9),
    ]
    model = model_of(np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]), blocks)
    system = assembled(model, NONE)
    x = [0, 6, 12]
    R = np.asarray(system.rows(np.array(x))[0].toarray())
    np.testing.assert_array_equal(R[2], R[1])
    assert system.damping.is_rayleigh
    with pytest.raises(creak.InputError, match=r"acts at node 3 X, but only dampers hold it"):
        system.bear(np.array([12]))
    with pytest.raises(creak.InputError, match=r"acts at node 3 Y, but it has neither stiffness nor mass"):
        system.bear(np.array([13]))
    system.bear(np.array(x[:2]))
