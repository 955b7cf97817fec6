"""Friction acts on the sides of shells and beams: their nodes' rotations move these along each other."""

from __future__ import annotations

import numpy as np
import pytest

from creak.model.dofs import ROTATIONS, dofs_of
from helpers_contact import METHODS, T_HIGH, T_LOW, both, pair, stacked
from helpers_fem import random_rotation, rigid_modes

RUBS = (0.3, 0.3)
TOUCHING = 0.5 * (T_LOW + T_HIGH)
"""Height at which the plates lie on each other."""


def slip(operator, u: np.ndarray) -> np.ndarray:
    """(m, 2) along both tangents under the nodal motion u (6 n_node,)."""
    return np.stack([t @ u[operator.labels] for t in operator.tangents], axis=1)


@both
@pytest.mark.parametrize("kinds", [("quad4", "quad4"), ("tri3", "quad4")])
def test_plates_that_lie_on_each_other_turn_together_without_slip(method, kinds):
    """All six rigid motions, however the stack lies in space."""
    model = stacked(kinds=kinds, height=TOUCHING, rotation=random_rotation(3))
    operator, _ = METHODS[method](model, pair(friction=RUBS))
    for u in rigid_modes(model.nodes.coords).T:
        np.testing.assert_allclose(slip(operator, u), 0.0, atol=1e-12 * np.abs(u).max())


@both
def test_two_strips_that_bend_alike_slip_by_their_rotation_times_the_distance_of_their_middles(method):
    """A leaf spring: theta (t_1 + t_2) / 2, all nodes turning by theta where they are."""
    model = stacked(height=TOUCHING)
    operator, _ = METHODS[method](model, pair(friction=RUBS))
    for axis in (0, 1):
        u = np.zeros(6 * model.nodes.count)
        u[3 + axis :: 6] = 0.01
        moved = np.linalg.norm(slip(operator, u), axis=1)
        np.testing.assert_allclose(moved, 0.01 * TOUCHING, rtol=1e-12)
    np.testing.assert_allclose(operator.G @ u[operator.labels], 0.0, atol=1e-15)


@both
def test_what_does_not_rub_takes_no_rotations(method):
    operator, _ = METHODS[method](stacked(height=TOUCHING), pair())
    assert not np.isin(dofs_of(operator.labels), ROTATIONS).any()


@pytest.mark.parametrize(("clearance", "moved"), [(0.0, TOUCHING), (None, 0.5 * T_LOW)])
def test_a_set_of_nodes_has_half_its_shells_thickness_where_its_gap_is_given(clearance, moved):
    """Without a given gap the nodes themselves touch the main side, as their gap says."""
    model = stacked(height=TOUCHING)
    given = pair(friction=RUBS, secondary="TOP_NODES", clearance=clearance)
    operator, _ = METHODS["node-to-surface"](model, given)
    u = np.zeros(6 * model.nodes.count)
    u[4::6] = 0.01
    np.testing.assert_allclose(np.linalg.norm(slip(operator, u), axis=1), 0.01 * moved, rtol=1e-12)
