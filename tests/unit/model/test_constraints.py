"""What every constraint knows of itself: its nodes, those that follow, and its equations."""

from __future__ import annotations

import numpy as np
import pytest

from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink, Tie

COORDS = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.5], [0.0, 3.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.25, -1.0]])
CORNERS = np.array([0, 1, 2])
CONSTRAINTS = {
    "kinematic": (KinematicCoupling("K", 3, CORNERS, (1, 2, 6)), {0, 1, 2, 3}, {0, 1, 2}),
    "distributing": (DistributingCoupling("D", 3, CORNERS, np.array([1.0, 2.0, 3.0])), {0, 1, 2, 3}, {3}),
    "beam": (RigidLink("beam", 4, 1), {1, 4}, {4}),
    "pin": (RigidLink("pin", 4, 1), {1, 4}, {4}),
    "equation": (Equation(np.array([2, 0, 1]), np.array([1, 2, 3]), np.array([2.0, -1.0, 1.0])), {0, 1, 2}, {2}),
    "tie": (Tie("T", 4, CORNERS, np.array([0.5, 0.25, 0.25]), np.array([0.0, 0.1, -0.2])), {0, 1, 2, 4}, {4}),
}


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_nodes_and_dependents_are_those_of_the_equations(kind):
    constraint, nodes, dependents = CONSTRAINTS[kind]
    equations = list(constraint.equations(COORDS))
    assert {n for e in equations for n in e.nodes_idx.tolist()} == set(constraint.nodes.tolist()) == nodes
    assert {int(e.nodes_idx[0]) for e in equations} == set(constraint.dependents.tolist()) == dependents
    assert all(e.nodes_idx.shape == e.dofs.shape == e.coefficients.shape for e in equations)
    assert all(e.coefficients[0] != 0.0 for e in equations)


def test_an_equation_is_its_own():
    equation = CONSTRAINTS["equation"][0]
    assert list(equation.equations(COORDS)) == [equation]
