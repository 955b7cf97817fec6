"""Matrices that are not positive: refused where modes are needed, moved unreduced as before."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.integrate import solve_ivp

import creak
from creak.reduction.diagonal import diagonalise
from helpers_core import (
    NO_DAMPING,
    bar,
    beam_section,
    block,
    model_of,
    part_system,
    straight_beam,
    system_of,
    time_axis,
)

K = np.array([[1500.0, -1000.0], [-1000.0, 600.0]])
"""A buckled structure: one eigenvalue is negative."""
LOWEST = 0.5 * (2100.0 - np.sqrt(900.0**2 + 4.0 * 1000.0**2))
M_WRONG = np.array([[1.0, -2.0], [-2.0, 1.0]])


@pytest.mark.parametrize("kind", [np.asarray, sp.csr_matrix])
def test_modes_of_a_negative_stiffness_are_refused_with_how_far(kind):
    with pytest.raises(creak.InputError, match=rf"K is not positive.*omega\^2 = {LOWEST:.4g} \(rad/s\)\^2"):
        creak.modes(kind(K), kind(np.eye(2)))


def test_so_are_reduced_systems():
    system = creak.system_from_matrices(K, np.eye(2))
    with pytest.raises(creak.InputError, match="K is not positive"):
        creak.diagonalise(system)
    with pytest.raises(creak.InputError, match="K is not positive"):
        creak.craig_bampton(system, [1], count=1)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_a_free_body_on_one_node_keeps_round_off_alone_and_is_taken(count):
    """All that Guyan leaves of a free beam's stiffness at one node is round-off."""
    coords, e = straight_beam(20, 1.0)
    beam = part_system(model_of(coords, [block("beam2", e, beam_section())]), 0, NO_DAMPING)
    reduced = creak.couple(creak.craig_bampton(beam, beam.coordinates[:6], count=count))
    assert np.count_nonzero(creak.diagonalise(reduced).K.d < 1e-3) == 6


def test_a_mass_that_is_not_positive_is_refused():
    with pytest.raises(creak.InputError, match=r"M is not positive.* = -0\.33"):
        creak.modes(np.eye(2), M_WRONG)
    with pytest.raises(creak.InputError, match="M is not positive"):
        diagonalise(system_of(M_WRONG, np.eye(2), sparse=False))


def test_a_free_bar_has_a_rigid_mode_and_is_taken():
    M, K_bar = bar(40, 1.0, 3e9, 0.1)
    assert creak.modes(K_bar, M).omega2[0] == 0.0
    diagonalise(system_of(M, K_bar, sparse=False))


def test_what_stops_alone_hold_is_moved_unreduced():
    system = creak.system_from_matrices(K, np.eye(2), alpha=0.5)
    gaps = creak.gap_channels([[0.0, 1.0], [0.0, -1.0]], 5e-3, 1e5)
    time = time_axis(0.3, 1e-3)
    loads = creak.make_loads(system, time, forces=[([1], creak.Sine(5.0, 2.0))])

    def rates(t, y):
        push = 1e5 * np.maximum(0.0, -(5e-3 + np.array([y[1], -y[1]])))
        force = np.array([0.0, 2.0 * np.sin(10.0 * np.pi * t) + push[0] - push[1]])
        return np.concatenate([y[2:], force - 0.5 * y[2:] - K @ y[:2]])

    exact = solve_ivp(rates, (0.0, 0.3), np.zeros(4), rtol=1e-8, atol=1e-11, max_step=2e-3, t_eval=time)
    found = creak.simulate(system, gaps, loads, observed=[0, 1]).displacement
    np.testing.assert_allclose(found, exact.y[:2].T, atol=2e-3 * np.abs(exact.y[:2]).max())
