"""Modes of a deck: how many, which masses they carry, motion of every node."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.elimination import linear_equations
from creak.errors import InputError
from creak.studies.models.deck_modes import deck_modes
from helpers_decks import STEEL, strip

RECORDED = {"section": "models", "source": "closed form"}

STRIP = STEEL + "*SHELL SECTION, ELSET=A, MATERIAL=STEEL\n1.0,\n"
CLAMPED = "*BOUNDARY\nROOT_A, 1, 6\n"
MASS_ON_A_LINK = """\
*NODE
 1, 0., 0., 0.
 2, 0., 0., 0.
 3, 0., 3., 0.
*ELEMENT, TYPE=MASS, ELSET=M
 1, 3
*ELEMENT, TYPE=SPRING2, ELSET=S
 2, 1, 2
*MASS, ELSET=M
 2.
*SPRING, ELSET=S
 3, 3
 50.
*MPC
 BEAM, 3, 2
*BOUNDARY
 1, ENCASTRE
 2, 1, 2
 2, 4, 6
"""


def beam(n: int = 40, length: float = 1000.0) -> str:
    """A slender cantilever of cubic beams along x: shear and rotary inertia matter by (r/L)^2 = 1e-6."""
    nodes = "".join(f" {i + 1}, {length * i / n:.10g}, 0., 0.\n" for i in range(n + 1))
    elements = "".join(f" {i}, {i}, {i + 1}\n" for i in range(1, n + 1))
    return (
        f"*NODE\n{nodes}*ELEMENT, TYPE=B33, ELSET=B\n{elements}{STEEL}"
        "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=CIRC\n 1.\n 0., 1., 0.\n*BOUNDARY\n 1, 1, 6\n"
    )


@pytest.fixture
def deck(tmp_path):
    def write(text):
        path = tmp_path / "deck.inp"
        path.write_text(text)
        return path

    return write


def test_effective_masses_of_a_cantilever(deck, measured):
    """Closed form (2 sigma_n / beta_n L)^2 in deflection: 61.31, 18.83, 6.47, 3.31 %, in y and in z.

    About its root the rotation carries 4 / (beta_n L)^4 of m L^2, the beam has 1/3 of it.
    """
    found = deck_modes(deck(beam()), count=8)
    beta = np.array([1.875104069, 4.694091133, 7.854757438, 10.99554073])
    sigma = (np.sinh(beta) - np.sin(beta)) / (np.cosh(beta) + np.cos(beta))
    expected = (2.0 * sigma / beta) ** 2
    share = found.effective.share.reshape(4, 2, 6).sum(axis=1)  # planes of equal stiffness mix freely
    assert share[:, 2] == pytest.approx(expected, rel=1e-3)
    assert share[:, 0] == pytest.approx(np.zeros(4), abs=1e-12)
    mass = np.pi * 1000.0 * 7.85e-9
    assert found.mass == pytest.approx(mass, rel=1e-9)
    assert found.effective.total[4:] == pytest.approx([mass * 1000.0**2 / 3.0] * 2, rel=1e-4)
    measured("cantilever: effective mass in deflection, mode {}", share[:, 1], expected, rel=1e-3)
    measured("cantilever: effective mass about the root, mode {}", share[:, 5], 3.0 * 4.0 / beta**4, rel=1e-3)


def test_all_modes_carry_all_that_does_not_ride_on_the_supports(deck):
    """Sum of L^2 = p' M^-1 p with p = M R over the free dofs; more than there are modes may be asked for."""
    found = deck_modes(deck(strip(1, 1, "A", 0.0, n=8) + STRIP + CLAMPED), count=10**6, about=(3.0, -2.0, 5.0))
    n = found.system.n
    assert len(found.frequencies) == n == 6 * 24
    e = found.effective
    M = to_dense(found.system.M)
    p = M @ found.shapes @ e.participation  # Phi Phi' M = I
    assert e.effective.sum(axis=0) == pytest.approx(np.diag(p.T @ np.linalg.solve(M, p)), rel=1e-8)
    assert (e.cumulative[-1] < 1.0).all()
    assert (e.cumulative[-1] > 0.75).all()
    finer = deck_modes(deck(strip(1, 1, "A", 0.0, n=32) + STRIP + CLAMPED), count=10**6, about=(3.0, -2.0, 5.0))
    assert len(finer.frequencies) == finer.system.n > 500
    assert (finer.effective.cumulative[-1] > e.cumulative[-1]).all()
    assert finer.effective.total[:3] == pytest.approx(e.total[:3])


def test_rigid_modes_of_a_free_strip_carry_everything(deck):
    found = deck_modes(deck(strip(1, 1, "A", 0.0, n=60) + STRIP), count=10, about=(60.0, 10.0, 0.0))
    assert found.rigid == 6
    share = found.effective.share
    assert share[:6].sum(axis=0) == pytest.approx(np.ones(6), abs=1e-6)
    assert share[6:].max() < 1e-8
    mass = 120.0 * 20.0 * 7.85e-9
    # Thin rectangle about its centre: m b^2/12, m a^2/12 and their sum; the shell adds m t^2/12.
    inertia = mass / 12.0 * np.array([20.0**2 + 1.0, 120.0**2 + 1.0, 120.0**2 + 20.0**2])
    assert found.effective.total == pytest.approx([mass] * 3 + inertia.tolist(), rel=5e-3)


def test_mass_on_a_rigid_link_that_belongs_to_no_part(deck):
    """omega^2 = k/m; all of the mass in z, all of m y^2 about x, nothing in the other directions."""
    found = deck_modes(deck(MASS_ON_A_LINK))
    assert found.frequencies == pytest.approx([np.sqrt(50.0 / 2.0) / (2.0 * np.pi)])
    e = found.effective
    assert e.total == pytest.approx([2.0, 2.0, 2.0, 18.0, 0.0, 18.0])
    assert e.share[0] == pytest.approx([0.0, 0.0, 1.0, 1.0, 0.0, 0.0], abs=1e-12)
    about = deck_modes(deck(MASS_ON_A_LINK), about=(4.0, 3.0, 0.0)).effective
    assert about.effective[0] == pytest.approx([0.0, 0.0, 2.0, 0.0, 2.0 * 16.0, 0.0], abs=1e-12)
    shape = next(found.translations())
    assert shape == pytest.approx(np.array([[0, 0, 0], [0, 0, 1], [0, 0, 1]]) * shape[1, 2])
    assert abs(shape[1, 2]) == pytest.approx(1.0 / np.sqrt(2.0))


def test_every_node_moves_as_its_constraints_say(deck):
    coupled = (
        strip(1, 1, "A", 0.0, n=8)
        + "*NODE\n 900, 140., 5., 30.\n"
        + STRIP
        + CLAMPED
        + "*ELEMENT, TYPE=MASS, ELSET=M\n 900, 900\n*MASS, ELSET=M\n 1e-6\n"
        + "*SURFACE, NAME=TIP, TYPE=NODE\nTIP_A\n*COUPLING, CONSTRAINT NAME=C, REF NODE=900, SURFACE=TIP\n*KINEMATIC\n"
    )
    found = deck_modes(deck(coupled), count=5)
    u = found.system.recover(found.shapes)
    place = {label: i for i, label in enumerate(found.system.labels.tolist())}
    equations = [e for c in found.model.constraints for e in linear_equations(c, found.model.nodes.coords)]
    assert len(equations) == 18
    for equation in equations:
        terms = [c * u[place[label]] for label, c in zip(equation.labels, equation.coefficients, strict=True)]
        assert np.abs(np.sum(terms, axis=0)).max() < 1e-9 * np.abs(u).max()
    moved = np.array(list(found.translations()))
    assert moved.shape == (5, 28, 3)
    assert (np.abs(moved).max(axis=2)[:, found.model.nodes.ids == 900] > 0.0).all()
    assert not moved[:, found.model.node_sets["ROOT_A"]].any()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"count": 0}, "count = 0; expected a whole number, 1 or more"),
        ({"count": 2.5}, "count = 2.5; expected a whole number, 1 or more"),
        ({"f_max": -1.0}, "f_max = -1; expected a positive number"),
        ({"f_max": 10.0, "count": 3}, "both f_max and count"),
    ],
)
def test_wrong_arguments(deck, wrong, said):
    with pytest.raises(InputError, match=said):
        deck_modes(deck(beam(4)), **wrong)


def test_what_is_not_read_stops_it_unless_ignored(deck):
    path = deck(beam(4) + "*EMBEDDED ELEMENT\n B\n")
    with pytest.raises(InputError, match=r"EMBEDDED ELEMENT.*--ignore"):
        deck_modes(path)
    assert len(deck_modes(path, ignore=["Embedded Element"], count=3).frequencies) == 3
