"""Truss, concentrated mass, spring and dashpot."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements import discrete, truss2
from creak.elements.geometry import DegenerateElement
from creak.elements.registry import FORMULATIONS
from creak.model.materials import Material, PointMass, Spring, TrussSection
from creak.model.mesh import COMMON

BAR = TrussSection("T", Material("M", 7e10, 0.3, 2700.0), area=1e-4)
COORDS = np.array([[[0.0, 0, 0], [1.0, 2.0, 2.0]]])


def test_truss_resists_stretching_only():
    stiffness = truss2.stiffness(COORDS, BAR)[0]
    axis = np.array([1, 2, 2]) / 3
    stretch = np.concatenate([-axis, np.zeros(3), axis, np.zeros(3)]) / 2
    assert stretch @ stiffness @ stretch == pytest.approx(7e10 * 1e-4 / 3, rel=1e-12)
    energy = np.linalg.eigvalsh(stiffness)
    assert np.count_nonzero(energy > 1e-9 * energy[-1]) == 1


def test_truss_mass_is_the_same_in_all_directions():
    matrix = truss2.mass(COORDS, BAR)[0]
    for direction in np.eye(3):
        move = np.tile(np.concatenate([direction, np.zeros(3)]), 2)
        assert move @ matrix @ move == pytest.approx(2700 * 1e-4 * 3.0, rel=1e-12)
    assert not matrix[3:6].any()


def test_truss_without_length_is_refused():
    with pytest.raises(DegenerateElement, match="coincide"):
        truss2.stiffness(0 * COORDS, BAR)


def test_point_mass_and_inertia_fill_their_dofs():
    section = PointMass("P", 2.0, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    matrix = discrete.mass(np.zeros((2, 1, 3)), section)
    assert matrix.shape == (2, 6, 6)
    assert np.diag(matrix[1]).tolist() == [2, 2, 2, 1, 2, 3]
    assert matrix[0, 3, 4] == matrix[0, 4, 3] == 0.1
    assert matrix[0, 3, 5] == matrix[0, 5, 3] == 0.2
    assert matrix[0, 4, 5] == matrix[0, 5, 4] == 0.3
    assert not FORMULATIONS["mass"].stiffness(np.zeros((2, 1, 3)), section, COMMON).any()


def test_grounded_spring_acts_on_its_dof():
    stiffness = discrete.spring(np.zeros((1, 1, 3)), Spring("S", dof1=3, stiffness=5.0))[0]
    assert stiffness[2, 2] == 5.0
    assert np.count_nonzero(stiffness) == 1


def test_two_node_spring_resists_relative_motion():
    section = Spring("S", dof1=2, dof2=4, stiffness=5.0, damping=0.5)
    u = np.zeros(12)
    u[1], u[9] = 1.0, 4.0
    coords = np.zeros((1, 2, 3))
    assert u @ discrete.spring(coords, section)[0] @ u == pytest.approx(5.0 * 9.0)
    assert u @ discrete.spring(coords, section, of="damping")[0] @ u == pytest.approx(0.5 * 9.0)
    assert not FORMULATIONS["spring2"].mass(coords, section, COMMON).any()


def test_every_kind_has_matrices_and_only_springs_have_dashpots():
    assert set(FORMULATIONS) == {
        *("quad4", "tri3", "quad8", "tri6", "beam3", "pyramid5", "coh6", "coh8", "hex8", "wedge6", "tet4"),
        *("tet10", "hex20", "hex20r", "hex20s", "wedge15", "beam2", "truss2", "mass", "rotary", "spring1"),
        *("spring2", "axial2", "bush1", "bush2", "nodal1", "nodal2"),
    }
    assert {kind for kind, f in FORMULATIONS.items() if f.damping} == {
        "spring1",
        "spring2",
        "axial2",
        "bush1",
        "bush2",
        "nodal1",
        "nodal2",
    }
