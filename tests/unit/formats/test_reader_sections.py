"""Beams, trusses, point elements, links and equations on a small frame."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from numpy.testing import assert_allclose

from creak.formats.deck.cross_section import rectangle_torsion
from creak.model.constraints import Equation, KinematicCoupling, RigidLink
from creak.model.materials import BeamSection, PointMass, Spring, TrussSection
from creak.model.mesh import Model

Reader = Callable[[str], Model]

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 7.85e-9\n"
BEAMS = "*NODE\n 1, 0.\n 2, 10.\n 3, 20.\n*ELEMENT, TYPE=B33, ELSET=B\n 1, 1, 2\n 2, 2, 3\n"


@pytest.mark.parametrize(
    ("shape", "sizes", "expected"),
    [
        ("RECT", "4., 2.", (8.0, 4.0 * 8.0 / 12.0, 2.0 * 64.0 / 12.0, rectangle_torsion(4.0, 2.0))),
        ("CIRC", "2.", (4.0 * math.pi, 4.0 * math.pi, 4.0 * math.pi, 8.0 * math.pi)),
        ("PIPE", "2., 1.", (3.0 * math.pi, 3.75 * math.pi, 3.75 * math.pi, 7.5 * math.pi)),
    ],
)
def test_beam_shapes(read: Reader, shape: str, sizes: str, expected: tuple[float, ...]) -> None:
    text = f"{BEAMS}*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION={shape}\n {sizes}\n 0., 1., 0.\n{STEEL}"
    section = read(text).blocks[0].section
    assert isinstance(section, BeamSection)
    assert_allclose((section.area, section.i11, section.i22, section.torsion), expected, rtol=1e-14)
    assert section.axis1 == (0.0, 1.0, 0.0)


def test_rectangle_torsion_of_a_square_and_of_a_strip() -> None:
    assert rectangle_torsion(1.0, 1.0) == pytest.approx(0.140577, abs=5e-7)  # Timoshenko, table of k1
    assert rectangle_torsion(0.01, 10.0) == pytest.approx(10.0 * 0.01**3 / 3.0, rel=1e-3)


def test_general_beam_section(read: Reader) -> None:
    keyword = "*BEAM GENERAL SECTION, ELSET=B, SECTION=GENERAL, DENSITY=2.e-9"
    text = f"{BEAMS}{keyword}\n 1., 2., 0., 3., 4.\n\n 260., 100.\n"
    section = read(text).blocks[0].section
    assert isinstance(section, BeamSection)
    assert (section.area, section.i11, section.i22, section.torsion) == (1.0, 2.0, 3.0, 4.0)
    assert section.axis1 == (0.0, 0.0, -1.0)
    assert section.material.density == 2e-9
    assert section.material.shear_modulus == pytest.approx(100.0)


def test_general_beam_section_with_a_material_is_that_of_calculix(read: Reader) -> None:
    """Dimensions and axis as of *BEAM SECTION, and no line of moduli."""
    lines = f"ELSET=B, MATERIAL=STEEL, SECTION=PIPE\n .11, .01\n 0., 1., 0.\n{STEEL}"
    general, plain = (read(f"{BEAMS}*BEAM {name}SECTION, {lines}").blocks[0].section for name in ("GENERAL ", ""))
    assert general == plain


def test_truss(read: Reader) -> None:
    text = BEAMS.replace("B33", "T3D2") + f"*SOLID SECTION, ELSET=B, MATERIAL=STEEL\n 2.5\n{STEEL}"
    block = read(text).blocks[0]
    assert block.kind == "truss2"
    assert isinstance(block.section, TrussSection)
    assert block.section.area == 2.5


SDOF = """\
*NODE
 1, 0.
 2, 1.
*ELEMENT, TYPE=MASS, ELSET=M
 1, 1
*ELEMENT, TYPE=ROTARYI, ELSET=R
 2, 1
*ELEMENT, TYPE=SPRING1, ELSET=K
 3, 1
*ELEMENT, TYPE=DASHPOT2, ELSET=C
 4, 1, 2
*ELSET, ELSET=OSCILLATOR
 M, R, K, C
*MASS, ELSET=M, ALPHA=0.5
 100.
*ROTARY INERTIA, ELSET=R
 1., 2., 3., 0.1
*SPRING, ELSET=K
 1
 1.e4
*DASHPOT, ELSET=C
 1, 1
 7.
"""


def test_oscillator_is_one_part_named_after_its_set(read: Reader) -> None:
    model = read(SDOF)
    assert [p.name for p in model.parts] == ["OSCILLATOR"]
    assert model.parts[0].nodes_idx.tolist() == [0, 1]
    assert [(b.kind, b.part) for b in model.blocks] == [
        ("mass", 0),
        ("rotary", 0),
        ("spring1", 0),
        ("spring2", 0),
    ]
    mass, rotary, spring, dashpot = (b.section for b in model.blocks)
    assert mass == PointMass("M", mass=100.0, alpha=0.5)
    assert rotary == PointMass("R", inertia=(1.0, 2.0, 3.0, 0.1, 0.0, 0.0))
    assert spring == Spring("K", 1, 1, stiffness=1e4)
    assert dashpot == Spring("C", 1, 1, damping=7.0)


def test_rotary_inertia_turns_with_its_instance(read: Reader) -> None:
    text = (
        "*PART, NAME=P\n*NODE\n 1, 0.\n*ELEMENT, TYPE=ROTARYI, ELSET=R\n 1, 1\n"
        "*ROTARY INERTIA, ELSET=R\n 1., 2., 3.\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n"
        " 0., 0., 0.\n 0., 0., 0., 0., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n"
    )
    section = read(text).blocks[0].section
    assert isinstance(section, PointMass)
    assert_allclose(section.inertia, (2.0, 1.0, 3.0, 0.0, 0.0, 0.0), atol=1e-15)


def _with_beams(extra: str) -> str:
    return f"{BEAMS}*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=CIRC\n 1.\n{STEEL}{extra}"


def test_mpc_between_sets_pairs_their_nodes(read: Reader) -> None:
    sets = "*NSET, NSET=A\n 1, 2\n*NODE\n 4, 0., 1.\n 5, 1., 1.\n*NSET, NSET=D\n 5, 4\n"
    extra = f"{sets}*MPC\n TIE, D, A\n PIN, 3, 4\n"
    model = read(_with_beams(extra))
    links = [c for c in model.constraints if isinstance(c, RigidLink)]
    ids = model.nodes.ids
    assert [(c.kind, int(ids[c.dependent_idx]), int(ids[c.independent_idx])) for c in links] == [
        ("tie", 5, 1),
        ("tie", 4, 2),
        ("pin", 3, 4),
    ]


def test_other_mpc_types_are_listed(read: Reader) -> None:
    unread = read(_with_beams("*MPC\n SLIDER, 1, 3\n")).unread
    assert [u.changes_answer for u in unread] == [True]
    assert "*MPC, SLIDER" in unread[0].keyword


def test_equation_over_two_lines(read: Reader) -> None:
    (equation,) = read(_with_beams("*EQUATION\n 3\n 1, 2, 1., 2, 2, -0.5\n 3, 2, -0.5\n")).constraints
    assert isinstance(equation, Equation)
    assert equation.nodes_idx.tolist() == [0, 1, 2]
    assert equation.dofs.tolist() == [2, 2, 2]
    assert equation.coefficients.tolist() == [1.0, -0.5, -0.5]


def test_kinematic_coupling_groups_lines_by_dofs(read: Reader) -> None:
    model = read(_with_beams("*KINEMATIC COUPLING, REF NODE=1\n 2, 1, 3\n 3\n"))
    assert [(c.nodes_idx.tolist(), c.dofs) for c in model.constraints if isinstance(c, KinematicCoupling)] == [
        ([1], (1, 2, 3)),
        ([2], (1, 2, 3, 4, 5, 6)),
    ]


def test_rigid_body_of_a_node_set_as_calculix_writes_it(read: Reader) -> None:
    model = read(_with_beams("*NODE\n 9, 5., 5.\n*NSET, NSET=SOME\n 2, 3\n*RIGID BODY, REFNODE=9, NSET=SOME\n"))
    (c,) = (c for c in model.constraints if isinstance(c, KinematicCoupling))
    assert (c.nodes_idx.tolist(), c.dofs) == ([1, 2], (1, 2, 3, 4, 5, 6))


def test_rigid_body_of_elements_and_pinned_nodes(read: Reader) -> None:
    extra = "*NODE\n 9, 5., 5.\n*NSET, NSET=PINS\n 3\n*RIGID BODY, REF NODE=9, ELSET=B, PIN NSET=PINS\n"
    model = read(_with_beams(extra))
    assert [(c.nodes_idx.tolist(), c.dofs) for c in model.constraints if isinstance(c, KinematicCoupling)] == [
        ([2], (1, 2, 3)),
        ([0, 1], (1, 2, 3, 4, 5, 6)),
    ]
    assert model.parts[0].nodes_idx.tolist() == [0, 1, 2, 3]
