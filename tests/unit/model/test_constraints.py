"""What every constraint knows of itself: its nodes, those that follow, and its equations.

A contact law: what is none is refused where it is made.
Systems of units: labels and sizes agree with each other.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.laws.parameters import laid_over
from creak.errors import InputError
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink, Tie
from creak.model.contact_law import ContactLaw, Coulomb
from creak.model.units import METRES, UNITS
from creak.studies.file.config import ModelTable
from creak.studies.prepare.unit_check import SYSTEMS

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


CURVE = np.array([[0.0, 0.0], [1e-3, 2e6], [3e-3, 3e6]])


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"stiffness": -1.0}, r"study.toml:7 stiffness: stiffness = -1; expected zero or more"),
        ({"stiffness": np.nan}, r"stiffness = nan"),
        ({"damping": -2.0}, r"study.toml:7 damping: damping = -2"),
        ({"stiffness": 1.0, "preload": -5.0}, r"study.toml:7 preload: preload = -5"),
        ({"stiffness": np.inf, "preload": 5.0}, r"preload = 5 without a finite stiffness"),
        ({"stiffness": 5.0, "curve": CURVE}, r"overclosure: both stiffness = 5.0 and an overclosure curve"),
        ({"curve": CURVE[::-1]}, r"overclosure: the overclosure curve starts at \[0.003, 3000000.0\]"),
        ({"friction": Coulomb(0.2, 0.3)}, r"friction: friction with static = 0.2, kinetic = 0.3, decay = 0"),
        ({"friction": Coulomb(0.2, 0.1, np.inf)}, r"decay = inf; expected 0 <= kinetic <= static and decay >= 0"),
    ],
)
def test_what_is_no_law_is_refused(numbers, message):
    with pytest.raises(InputError, match=message):
        ContactLaw(**numbers, where="study.toml:7")


def test_a_law_on_channels_is_its_numbers_times_their_scale():
    law = ContactLaw(curve=CURVE, damping=3.0, friction=Coulomb(0.3, 0.2, 5.0))
    on = laid_over(law, np.array([2.0, 4.0]))
    np.testing.assert_allclose(on["stiffness"], [4e9, 8e9], rtol=1e-12)  # the steepest part of the curve
    np.testing.assert_array_equal(on["damping"], [6.0, 12.0])
    np.testing.assert_array_equal(on["curves"].scale, [2.0, 4.0])
    np.testing.assert_array_equal(on["friction"].decay, 5.0)
    assert not on["step_limited"].any()
    assert on["preload"] is None


def test_the_elements_say_what_the_law_leaves_open():
    on = laid_over(ContactLaw(), np.array([2.0, 4.0]), np.array([10.0, 20.0]))
    np.testing.assert_array_equal(on["stiffness"], [20.0, 80.0])
    assert on["step_limited"].all()
    assert on["friction"] is None
    with pytest.raises(ValueError, match="without stiffness on channels without elements"):
        laid_over(ContactLaw(), np.ones(2))


SIZES = {"mm": 1e-3, "m": 1.0, "t": 1000.0, "kg": 1.0, "mJ": 1e-3, "J": 1.0, "MPa": 1e6, "Pa": 1.0, "N": 1.0}
SIZES |= {"in": 0.0254, "lbf": 4.4482216152605, "lbf s^2/in": 175.126835246476, "in lbf": 0.1129848290276167}
SIZES |= {"psi": 6894.757293168361, "t/mm^3": 1e12, "kg/m^3": 1.0, "lbf s^2/in^4": 10686895.178}
"""In SI; the inch and the pound-force are exact."""


@pytest.mark.parametrize("name", UNITS)
def test_labels_are_those_of_the_sizes(name):
    """force = mass length / time^2; energy and stress follow from it."""
    u = UNITS[name]
    found = (METRES[name], u.to_kg, u.newton, u.newton * METRES[name], u.newton * u.per_metre**2)
    wanted = [SIZES[label] for label in (u.length, u.mass, u.force, u.energy, u.stress)]
    assert found == pytest.approx(wanted, rel=1e-13)


def test_a_study_can_name_each_and_no_other():
    assert ModelTable.model_json_schema()["properties"]["units"]["enum"] == [*UNITS] == [*SYSTEMS]


def test_checks_of_a_deck_use_the_same_sizes():
    for name, system in SYSTEMS.items():
        u = UNITS[name]
        wanted = [SIZES[label] for label in (u.length, u.stress, u.density, u.mass)]
        assert (system.length, system.stress, system.density, system.mass) == pytest.approx(wanted, rel=1e-9)
