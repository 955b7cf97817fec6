"""Sections, materials, axes, connectors and constraints of production decks."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose

from creak.assembly.part import Rayleigh, part_system
from creak.contact.facets import facets_of
from creak.elements.block_matrices import block_matrices
from creak.errors import InputError
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, supported_nodes
from creak.model.laminates import Ply, laminate
from creak.model.materials import (
    AnisotropicMaterial,
    AxialSpring,
    BeamSection,
    Bushing,
    GeneralShell,
    NodalMatrices,
    PointMass,
    ShellSection,
    SolidSection,
)
from creak.model.mesh import Model

Reader = Callable[[str], Model]
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 7.85e-9\n"
CARBON = (
    "*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=LAMINA\n 140000., 10000., 0.3, 5000., 5000., 3500.\n*DENSITY\n 1.6e-9\n"
)
PLATE = "*NODE\n 5, 0.\n 2, 10.\n 9, 10., 8.\n 11, 0., 8.\n*ELEMENT, TYPE=S4R, ELSET=P\n 70, 5, 2, 9, 11\n"
ROD = "*NODE\n 1, 0.\n 2, 10.\n*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2\n"


def shell(read: Reader, text: str) -> GeneralShell:
    model = read(PLATE + text)
    assert not [u for u in model.unread if u.changes_answer]
    section = model.blocks[0].section
    assert isinstance(section, GeneralShell)
    return section


@pytest.mark.parametrize(("word", "height"), [("SPOS", -0.6), ("SNEG", 0.6), ("0.25", -0.3), ("-0.5", 0.6)])
def test_offset_is_where_the_nodes_are_above_the_middle(read: Reader, word: str, height: float) -> None:
    found = shell(read, f"*SHELL SECTION, ELSET=P, MATERIAL=STEEL, OFFSET={word}\n 1.2\n{STEEL}")
    assert found.offset == pytest.approx(height)
    assert_allclose(found.B, height * found.A, rtol=1e-12)


def test_contact_meets_an_offset_shell_at_its_outer_surface(read: Reader) -> None:
    """Nodes on the positive face (SPOS): nothing above them, the whole thickness below."""
    text = f"*SHELL SECTION, ELSET=P, MATERIAL=STEEL, OFFSET=SPOS\n 1.2\n{STEEL}"
    model = read(
        f"{PLATE}{text}*SURFACE, NAME=TOP\n P, SPOS\n*SURFACE, NAME=UNDER\n P, SNEG\n*SURFACE, NAME=BOTH\n P,\n"
    )
    assert_allclose(facets_of(model, "TOP", where="").thickness, 0.0, atol=1e-12)
    assert_allclose(facets_of(model, "UNDER", where="").thickness, 2 * 1.2)
    with pytest.raises(InputError, match="nodes lie off their middle"):
        facets_of(model, "BOTH", where="")


@pytest.mark.parametrize("word", ["MID", "0.", "0"])
def test_no_offset_is_the_plain_section(read: Reader, word: str) -> None:
    model = read(f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL, OFFSET={word}\n 1.2\n{STEEL}")
    assert isinstance(model.blocks[0].section, ShellSection)


def test_composite_of_plies(read: Reader) -> None:
    text = "*SHELL SECTION, ELSET=P, COMPOSITE, ORIENTATION=O\n 0.2, 3, CARBON, 0.\n 0.3, 3, STEEL, 45., Ply-2\n"
    text += f"*ORIENTATION, NAME=O\n 0., 1., 0., -1., 0., 0.\n 3, 0.\n{STEEL}{CARBON}"
    model = read(PLATE + text)
    block = model.blocks[0]
    assert isinstance(block.section, GeneralShell)
    assert block.section.thickness == pytest.approx(0.5)
    assert block.section.mass == pytest.approx(0.2 * 1.6e-9 + 0.3 * 7.85e-9)
    assert block.own.axis1 is not None
    assert_allclose(block.own.axis1, [[0.0, 1.0, 0.0]], atol=1e-15)


def test_symmetric_composite_has_no_coupling(read: Reader) -> None:
    text = f"*SHELL SECTION, ELSET=P, COMPOSITE, SYMMETRIC\n 0.2, 3, CARBON, 0.\n 0.3, 3, CARBON, 90.\n{CARBON}"
    found = shell(read, text)
    assert found.thickness == pytest.approx(1.0)
    assert np.abs(found.B).max() < 1e-12 * found.A.max()


def test_orientation_of_shells_projects_the_axis_after_the_one_named(read: Reader) -> None:
    """Abaqus: `about` is next to the normal and the following axis, cyclic, gives direction 1; then the angle."""
    text = f"*ORIENTATION, NAME=O\n 1., 0., 0., 0., 1., 0.\n {{}}\n{CARBON}*SHELL SECTION, ELSET=P, MATERIAL=CARBON, ORIENTATION=O\n 1.\n"
    for line, expected in (
        ("3, 30.", (math.cos(math.pi / 6), 0.5, 0.0)),
        ("1, 0.", (0.0, 1.0, 0.0)),
        ("2", (0.0, 0.0, 1.0)),
    ):
        model = read(PLATE + text.format(line))
        own = model.blocks[0].own
        assert own.axis1 is not None
        assert_allclose(own.axis1[0], expected, atol=1e-15)
        told = [u.why for u in model.unread if u.keyword == "*ORIENTATION, NAME=O"]
        assert len(told) == (line[0] != "3")  # CalculiX projects axis 1


def test_only_orientations_in_use_must_be_right(read: Reader) -> None:
    wrong = "*ORIENTATION, NAME=O, SYSTEM=USER\n"
    read(f"{PLATE}{wrong}*SHELL SECTION, ELSET=P, MATERIAL=STEEL, ORIENTATION=O\n 1.\n{STEEL}")
    with pytest.raises(InputError, match="SYSTEM=USER"):
        read(f"{PLATE}{wrong}*SHELL SECTION, ELSET=P, MATERIAL=CARBON, ORIENTATION=O\n 1.\n{CARBON}")


def test_cylindrical_orientation_follows_the_element(read: Reader) -> None:
    text = f"*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n 5., -3., 0., 5., -3., 1.\n 3, 0.\n{CARBON}*SHELL SECTION, ELSET=P, MATERIAL=CARBON, ORIENTATION=O\n 1.\n"
    own = read(PLATE + text).blocks[0].own  # the centre (5, 4) lies above the axis: radial is y
    assert own.axis1 is not None
    assert_allclose(own.axis1, [[0.0, 1.0, 0.0]], atol=1e-15)


def test_section_by_its_stiffness(read: Reader) -> None:
    made = laminate("X", [Ply(homogeneous_material(), 1.0)], bottom=0.2)
    full = np.block([[made.A, made.B], [made.B, made.D]])
    numbers = [f"{full[i, j]:.12g}" for j in range(6) for i in range(j + 1)]
    lines = [", ".join(numbers[k : k + 8]) for k in (0, 8, 16)]
    text = "*SHELL GENERAL SECTION, ELSET=P, DENSITY=7.85e-9\n" + "\n".join(lines)
    found = shell(read, text + "\n*TRANSVERSE SHEAR STIFFNESS\n 6.e4, 5.e4, 0.\n")
    assert_allclose(found.B, made.B, rtol=1e-10, atol=1e-6)
    assert_allclose(np.diag(found.S), [6e4, 5e4])
    assert found.mass == 7.85e-9
    with pytest.raises(InputError, match="transverse shear"):
        read(PLATE + text + "\n")


def homogeneous_material():
    from creak.model.materials import Material

    return Material("M", 210000.0, 0.3, 7.85e-9)


def test_nodal_thickness(read: Reader) -> None:
    text = f"*SHELL SECTION, ELSET=P, MATERIAL=STEEL, NODAL THICKNESS\n 2.\n{STEEL}*NSET, NSET=ALL\n 5, 2, 9, 11\n*NODAL THICKNESS\n ALL, 1.\n 9, 3.\n"
    model = read(PLATE + text)
    assert_allclose(model.blocks[0].own.thickness, [[0.5, 0.5, 1.5, 0.5]])
    mass = part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass
    assert mass == pytest.approx(7.85e-9 * 80.0 * 1.5)  # the mean of 1, 1, 3, 1
    with pytest.raises(InputError, match="have no thickness"):
        read(PLATE + text.replace("ALL, 1.", "2, 1."))


@pytest.mark.parametrize(
    ("units", "value", "mass"),
    [("TOTAL MASS", 1e-6, 1e-6), ("MASS PER AREA", 2e-9, 160e-9), ("MASS PER VOLUME", 1e-9, 96e-9)],
)
def test_nonstructural_mass(read: Reader, units: str, value: float, mass: float) -> None:
    section = f"*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.2\n{STEEL}"
    model = read(f"{PLATE}{section}*NONSTRUCTURAL MASS, ELSET=P, UNITS={units}\n {value}\n")
    plain = 7.85e-9 * 80.0 * 1.2
    assert part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass == pytest.approx(plain + mass)


@pytest.mark.parametrize(
    ("given", "thickness"),
    [
        ("NODAL THICKNESS\n 1.\n*NODAL THICKNESS\n 5, 1.\n 2, 3.\n 9, 3.\n 11, 1.", 2.0),
        (
            "SHELL THICKNESS=D\n 1.\n*DISTRIBUTION TABLE, NAME=T\n LENGTH\n"
            "*DISTRIBUTION, NAME=D, LOCATION=ELEMENT, TABLE=T\n , 1.\n 70, 2.5",
            2.5,
        ),
    ],
)
@pytest.mark.parametrize(
    ("units", "value", "per_thickness"),
    [("TOTAL MASS", 160e-9, 0.0), ("MASS PER AREA", 2e-9, 0.0), ("MASS PER VOLUME", 2e-9, 1.0)],
)
@pytest.mark.parametrize("material", ["STEEL", "STEEL, OFFSET=SPOS"])
def test_nonstructural_mass_of_shells_with_a_thickness_of_their_own(
    read: Reader, given: str, thickness: float, units: str, value: float, per_thickness: float, material: str
) -> None:
    """rho t A and the mass itself: 2e-9 on an area of 80."""
    section = f"*SHELL SECTION, ELSET=P, MATERIAL={material}, {given}\n{STEEL}"
    model = read(f"{PLATE}{section}*NONSTRUCTURAL MASS, ELSET=P, UNITS={units}\n {value}\n")
    added = 160e-9 * (thickness if per_thickness else 1.0)
    mass = 7.85e-9 * 80.0 * thickness + added
    assert part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass == pytest.approx(mass)


def test_nonstructural_mass_on_some_elements_keeps_their_directions(read: Reader) -> None:
    more = (
        "*NODE\n 21, 0., 16.\n 22, 10., 16.\n*ELEMENT, TYPE=S4, ELSET=P\n 71, 11, 9, 22, 21\n*ELSET, ELSET=ONE\n 71\n"
    )
    text = f"*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n 0., 0., 0., 0., 0., 1.\n 3\n{CARBON}*SHELL SECTION, ELSET=P, MATERIAL=CARBON, ORIENTATION=O\n 1.\n"
    model = read(f"{PLATE}{more}{text}*NONSTRUCTURAL MASS, ELSET=ONE, UNITS=TOTAL MASS\n 1e-7\n")
    assert [b.ids.tolist() for b in model.blocks] == [[70], [71]]
    assert_allclose(model.blocks[1].own.axis1, [np.array([5.0, 12.0, 0.0]) / 13.0])
    assert_allclose(model.blocks[0].own.axis1, [np.array([5.0, 4.0, 0.0]) / math.sqrt(41.0)])


def test_engineering_constants_over_two_lines(read: Reader) -> None:
    solid = "*NODE\n 1, 0.\n 2, 1.\n 3, 0., 1.\n 4, 0., 0., 1.\n*ELEMENT, TYPE=C3D4, ELSET=S\n 1, 1, 2, 3, 4\n"
    wood = "*MATERIAL, NAME=W\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n 12000., 900., 500., 0.3, 0.4, 0.5, 700., 600.\n 50.\n*DENSITY\n 5.e-10\n"
    axes = "*ORIENTATION, NAME=O\n 0., 1., 0., 0., 0., 1.\n"
    model = read(f"{solid}{wood}{axes}*SOLID SECTION, ELSET=S, MATERIAL=W, ORIENTATION=O\n")
    section = model.blocks[0].section
    assert isinstance(section, SolidSection)
    assert isinstance(section.material, AnisotropicMaterial)
    flexibility = np.linalg.inv(section.material.elasticity)
    assert_allclose(1 / np.diag(flexibility), [12000, 900, 500, 700, 50, 600], rtol=1e-10)
    assert_allclose(model.blocks[0].own.axis1, [[0.0, 1.0, 0.0]])
    held = solid.replace("*NODE", "*PART, NAME=P\n*NODE") + "*SOLID SECTION, ELSET=S, MATERIAL=W\n*END PART\n"
    turned = "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n 0., 0., 0.\n 0., 0., 0., 0., 0., 1., 30.\n"
    with pytest.raises(InputError, match="no axes, in the rotated instance"):
        read(f"{held}{turned}*END INSTANCE\n*END ASSEMBLY\n{wood}")


def test_solids_without_orientation_have_the_global_axes_of_calculix(read: Reader) -> None:
    solid = "*NODE\n 1, 0.\n 2, 1.\n 3, 0., 1.\n 4, 0., 0., 1.\n*ELEMENT, TYPE=C3D4, ELSET=S\n 1, 1, 2, 3, 4\n"
    wood = "*MATERIAL, NAME=W\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n 12000., 900., 500., 0.3, 0.4, 0.5, 700., 600.\n 50.\n*DENSITY\n 5.e-10\n"
    axes = "*ORIENTATION, NAME=O\n 1., 0., 0., 0., 1., 0.\n"
    bare = read(f"{solid}{wood}*SOLID SECTION, ELSET=S, MATERIAL=W\n")
    given = read(f"{solid}{wood}{axes}*SOLID SECTION, ELSET=S, MATERIAL=W, ORIENTATION=O\n")
    assert [(u.keyword, u.changes_answer) for u in bare.unread] == [("*SOLID SECTION, ELSET=S", False)]
    for one, other in zip(
        block_matrices(bare.blocks[0], slice(None), bare.nodes.coords)[:2],
        block_matrices(given.blocks[0], slice(None), given.nodes.coords)[:2],
        strict=True,
    ):
        assert_allclose(one, other, rtol=1e-12, atol=1e-12 * np.abs(other).max())


def test_orthotropic_terms_and_engineering_constants_agree(read: Reader) -> None:
    from creak.model.elasticity import orthotropic

    D = orthotropic((12000.0, 900.0, 500.0), (0.3, 0.4, 0.5), (700.0, 600.0, 50.0))
    terms = [D[0, 0], D[0, 1], D[1, 1], D[0, 2], D[1, 2], D[2, 2], 700.0, 600.0, 50.0]
    lines = ", ".join(f"{v:.15g}" for v in terms[:8]) + f"\n {terms[8]}"
    solid = "*NODE\n 1, 0.\n 2, 1.\n 3, 0., 1.\n 4, 0., 0., 1.\n*ELEMENT, TYPE=C3D4, ELSET=S\n 1, 1, 2, 3, 4\n"
    text = f"*MATERIAL, NAME=W\n*ELASTIC, TYPE=ORTHOTROPIC\n {lines}\n*DENSITY\n 5.e-10\n*ORIENTATION, NAME=O\n 1., 0., 0., 0., 1., 0.\n*SOLID SECTION, ELSET=S, MATERIAL=W, ORIENTATION=O\n"
    for kind in ("ORTHOTROPIC", "ORTHO"):
        section = read(solid + text.replace("ORTHOTROPIC", kind)).blocks[0].section
        assert isinstance(section, SolidSection)
        assert isinstance(section.material, AnisotropicMaterial)
        assert_allclose(section.material.elasticity, D, rtol=1e-9, atol=1e-9)


def beam(read: Reader, text: str) -> BeamSection:
    section = read(ROD + text + STEEL).blocks[0].section
    assert isinstance(section, BeamSection)
    return section


def test_b31_shears_and_b33_does_not(read: Reader) -> None:
    text = "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT\n 4., 2.\n 0., 1., 0.\n"
    assert beam(read, text).shear_area1 == pytest.approx(0.85 * 8.0)
    model = read(ROD.replace("B31", "B33") + text + STEEL)
    assert isinstance(model.blocks[0].section, BeamSection)
    assert model.blocks[0].section.shear_area1 == 0.0


def test_third_node_of_a_beam_gives_its_axis(read: Reader) -> None:
    nodes = "*NODE\n 1, 0.\n 2, 10.\n 3, 20.\n 4, 1., 0., 5.\n*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2, 4\n 2, 2, 3\n"
    section = "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT\n 4., 2.\n 0., 1., 0.\n"
    assert_allclose(read(nodes + section + STEEL).blocks[0].own.axis1, [[1.0, 0.0, 5.0], [0.0, 1.0, 0.0]])


def test_transverse_shear_stiffness_of_a_beam(read: Reader) -> None:
    text = "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=CIRC\n 1.\n\n*TRANSVERSE SHEAR STIFFNESS\n 2000., 1000.\n"
    found, shear = beam(read, text), 210000.0 / 2.6
    assert (found.shear_area1, found.shear_area2) == pytest.approx((1000.0 / shear, 2000.0 / shear))


def test_a_thick_pipe_is_a_hollow_cylinder_and_names_may_be_long(read: Reader) -> None:
    rect = "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION={}\n 4., 2.\n"
    assert beam(read, rect.format("RECTANGULAR")) == beam(read, rect.format("RECT"))
    found = beam(read, "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=THICK PIPE\n 3., 1.\n")
    assert (found.area, found.i11, found.torsion) == pytest.approx(math.pi * np.array([5.0, 65.0 / 4.0, 65.0 / 2.0]))


def test_box_and_i_sections(read: Reader) -> None:
    """Closed forms of hollow rectangle and doubly symmetric I; an I placed on its lower flange has its centroid above."""
    box = beam(read, "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=BOX\n 40., 60., 2., 3., 2., 3.\n")
    assert box.i11 == pytest.approx((40 * 60**3 - 36 * 54**3) / 12)
    assert box.i22 == pytest.approx((60 * 40**3 - 54 * 36**3) / 12)
    assert box.area == pytest.approx(40 * 60 - 36 * 54)
    assert box.torsion == pytest.approx(4 * (38 * 57) ** 2 / (2 * 57 / 2 + 2 * 38 / 3))
    i = beam(read, "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=I\n 0., 60., 40., 40., 3., 3., 2.\n")
    assert i.i11 == pytest.approx((40 * 60**3 - 38 * 54**3) / 12)
    assert i.centroid == pytest.approx((0.0, 30.0))
    assert i.shear_centre == pytest.approx((0.0, 30.0))


def test_general_section_with_product_of_inertia_and_offsets(read: Reader) -> None:
    text = "*BEAM GENERAL SECTION, ELSET=B, DENSITY=1.e-9, SECTION=GENERAL\n 10., 300., 100., 200., 50.\n 0., 1., 0.\n 2.e5, 8.e4\n*CENTROID\n 1., 2.\n*SHEAR CENTER\n 3., 4.\n"
    found = beam(read, text)
    assert (found.centroid, found.shear_centre) == ((1.0, 2.0), (3.0, 4.0))
    tensor = np.array([[300.0, -100.0], [-100.0, 200.0]])
    assert sorted([found.i11, found.i22]) == pytest.approx(sorted(np.linalg.eigvalsh(tensor)))
    axis = np.array([math.cos(found.angle), math.sin(found.angle)])
    assert axis @ tensor @ axis == pytest.approx(found.i11)


SPRINGS = "*NODE\n 1, 0.\n 2, 3., 4.\n*ELEMENT, TYPE=MASS, ELSET=M\n 1, 1\n 2, 2\n*MASS, ELSET=M\n 1.\n"


def test_axial_spring_and_dashpot(read: Reader) -> None:
    text = "*ELEMENT, TYPE=SPRINGA, ELSET=K\n 8, 1, 2\n*SPRING, ELSET=K\n\n 100.\n*ELEMENT, TYPE=DASHPOTA, ELSET=C\n 9, 1, 2\n*DASHPOT, ELSET=C\n\n 7.\n"
    model = read(SPRINGS + text)
    spring, dashpot = (b.section for b in model.blocks if b.kind == "axial2")
    assert spring == AxialSpring("K", 100.0, 0.0)
    assert dashpot == AxialSpring("C", 0.0, 7.0)


def test_spring_along_an_orientation(read: Reader) -> None:
    text = "*ORIENTATION, NAME=O\n 0.6, 0.8, 0., 0., 1., 0.\n*ELEMENT, TYPE=SPRING1, ELSET=K\n 8, 2\n*SPRING, ELSET=K, ORIENTATION=O\n 1\n 100.\n"
    block = read(SPRINGS + text).blocks[-1]
    assert block.kind == "nodal1"
    assert isinstance(block.section, NodalMatrices)
    assert_allclose(block.section.stiffness[:2, :2], [[36.0, 48.0], [48.0, 64.0]])


def test_mass_and_inertia_along_an_orientation(read: Reader) -> None:
    """Axis 1 of the orientation is y, axis 2 is -x."""
    text = "*NODE\n 1, 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n 1, 1\n*ELEMENT, TYPE=ROTARYI, ELSET=J\n 2, 1\n*ORIENTATION, NAME=O\n 0., 1., 0., -1., 0., 0.\n"
    text += "*MASS, ELSET=M, TYPE=ANISOTROPIC, ORIENTATION=O\n 1., 2., 3.\n*ROTARY INERTIA, ELSET=J, ORIENTATION=O\n 4., 5., 6., 0.5\n"
    mass, inertia = (b.section for b in read(text).blocks)
    assert isinstance(mass, NodalMatrices)
    assert_allclose(np.diag(mass.mass), [2.0, 1.0, 3.0, 0.0, 0.0, 0.0], atol=1e-15)
    assert isinstance(inertia, PointMass)
    assert_allclose(inertia.inertia, (5.0, 4.0, 6.0, -0.5, 0.0, 0.0), atol=1e-15)


CONNECTOR = "*ELEMENT, TYPE=CONN3D2, ELSET=C\n 8, 1, 2\n"


def test_bushing_with_its_behaviour_and_axes(read: Reader) -> None:
    text = f"{CONNECTOR}*CONNECTOR SECTION, ELSET=C, BEHAVIOR=RUBBER\n BUSHING,\n O,\n*ORIENTATION, NAME=O\n 0., 0., 1., 1., 0., 0.\n"
    text += "*CONNECTOR BEHAVIOR, NAME=RUBBER\n*CONNECTOR ELASTICITY, COMPONENT=1\n 100.\n*CONNECTOR ELASTICITY, COMPONENT=5\n 7.\n*CONNECTOR DAMPING, COMPONENT=1\n 0.5\n"
    model = read(SPRINGS + text)
    block = model.blocks[-1]
    assert isinstance(block.section, Bushing)
    assert np.diag(block.section.stiffness).tolist() == [100, 0, 0, 0, 7, 0]
    assert block.section.damping[0, 0] == 0.5
    assert block.section.location == 0.5
    assert_allclose(block.own.axis1, [[0.0, 0.0, 1.0]])
    assert not model.constraints
    assert not [u for u in model.unread if u.changes_answer]


def test_coupled_connector_stiffness_and_cartesian_location(read: Reader) -> None:
    terms = "1., 2., 3., 0., 0., 4., 0., 0.\n 0., 5."
    text = f"{CONNECTOR}*CONNECTOR SECTION, ELSET=C, BEHAVIOR=R\n CARTESIAN, CARDAN\n*CONNECTOR BEHAVIOR, NAME=R\n*CONNECTOR ELASTICITY\n {terms}\n"
    section = read(SPRINGS + text).blocks[-1].section
    assert isinstance(section, Bushing)
    assert section.location == 1.0
    assert section.stiffness[0, 1] == section.stiffness[1, 0] == 2.0
    assert np.diag(section.stiffness).tolist() == [1, 3, 4, 5, 0, 0]


@pytest.mark.parametrize(
    ("kind", "dofs"), [("WELD", (1, 2, 3, 4, 5, 6)), ("BEAM", (1, 2, 3, 4, 5, 6)), ("JOIN", (1, 2, 3))]
)
def test_rigid_connectors_are_couplings(read: Reader, kind: str, dofs: tuple[int, ...]) -> None:
    (coupling,) = read(f"{SPRINGS}{CONNECTOR}*CONNECTOR SECTION, ELSET=C\n {kind},\n").constraints
    assert isinstance(coupling, KinematicCoupling)
    assert (coupling.ref_idx, coupling.nodes_idx.tolist(), coupling.dofs) == (0, [1], dofs)


def test_hinge_turns_about_its_first_axis_only(read: Reader) -> None:
    text = f"{CONNECTOR}*CONNECTOR SECTION, ELSET=C\n HINGE,\n O,\n*ORIENTATION, NAME=O\n 0.6, 0.8, 0., 0., 1., 0.\n"
    join, *turns = read(SPRINGS + text).constraints
    assert isinstance(join, KinematicCoupling)
    relative = []
    for equation in turns:
        assert isinstance(equation, Equation)
        row = np.zeros((2, 6))
        row[equation.nodes_idx, equation.dofs - 1] = equation.coefficients
        assert_allclose(row[0], -row[1], atol=1e-15)
        relative.append(row[1, 3:])
    assert_allclose(np.array(relative) @ [0.6, 0.8, 0.0], 0.0, atol=1e-15)
    assert np.linalg.matrix_rank(np.array(relative)) == 2


def test_nonlinear_connector_gives_its_slope_and_stops_the_run(read: Reader) -> None:
    text = f"{CONNECTOR}*CONNECTOR SECTION, ELSET=C, BEHAVIOR=R\n CARTESIAN,\n*CONNECTOR BEHAVIOR, NAME=R\n*CONNECTOR ELASTICITY, COMPONENT=2, NONLINEAR\n -10., -1.\n 0., 0.\n 30., 1.\n"
    model = read(SPRINGS + text)
    section = model.blocks[-1].section
    assert isinstance(section, Bushing)
    assert section.stiffness[1, 1] == 30.0
    assert [u.changes_answer for u in model.unread] == [True]


def test_unknown_connector_is_explained(read: Reader) -> None:
    with pytest.raises(InputError, match="connection type 'RETRACTOR' is not supported"):
        read(f"{SPRINGS}{CONNECTOR}*CONNECTOR SECTION, ELSET=C\n RETRACTOR,\n")


def test_distributing_coupling_element(read: Reader) -> None:
    nodes = "*NODE\n 20, 5., 4., 3.\n*ELEMENT, TYPE=DCOUP3D, ELSET=D\n 99, 20\n*DISTRIBUTING COUPLING, ELSET=D\n 5, 2.\n 2, 1.\n 9\n 11, 1.\n"
    model = read(f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n{STEEL}{nodes}")
    (coupling,) = model.constraints
    assert isinstance(coupling, DistributingCoupling)
    assert coupling.ref_idx == 4
    assert coupling.weights.tolist() == [2.0, 1.0, 1.0, 1.0]
    assert part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass == pytest.approx(7.85e-9 * 80)


PLAIN = f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n{STEEL}"


def test_supports_along_a_transform(read: Reader) -> None:
    """Node 9 at (10, 8) from the axis: its radial direction; all three translations of node 2 need no equation."""
    text = "*NSET, NSET=T\n 9, 2\n*TRANSFORM, NSET=T, TYPE=C\n 0., 0., 0., 0., 0., 1.\n*BOUNDARY\n 9, 1\n 2, PINNED\n 5, 3\n"
    model = read(PLAIN + text)
    (equation,) = model.constraints
    assert isinstance(equation, Equation)
    row = np.zeros(6)
    row[equation.dofs - 1] = equation.coefficients
    assert_allclose(row[:3], np.array([10.0, 8.0, 0.0]) / math.sqrt(164.0))
    assert sorted((f.nodes_idx.tolist(), f.dofs) for f in model.fixed) == [([0], (3,)), ([1], (1, 2, 3))]
    assert supported_nodes(model.constraints, model.fixed).tolist() == [0, 1, 2]


def test_equation_in_the_axes_of_its_nodes(read: Reader) -> None:
    text = "*NSET, NSET=T\n 9\n*TRANSFORM, NSET=T\n 0., 1., 0., -1., 0., 0.\n*EQUATION\n 2\n 9, 1, 1., 2, 3, -2.\n"
    (equation,) = read(PLAIN + text).constraints
    assert isinstance(equation, Equation)
    assert equation.dofs.tolist() == [2, 3]
    assert_allclose(equation.coefficients, [1.0, -2.0])


def test_initial_velocity_at_a_transformed_node_stops_the_run(read: Reader) -> None:
    text = "*NSET, NSET=T\n 9\n*TRANSFORM, NSET=T\n 0., 1., 0., -1., 0., 0.\n*INITIAL CONDITIONS, TYPE=VELOCITY\n 9, 1, 5.\n"
    assert [u.keyword for u in read(PLAIN + text).unread if u.changes_answer] == [
        "*INITIAL CONDITIONS on transformed nodes"
    ]
    assert not [u for u in read(PLAIN + text.replace("9, 1, 5.", "2, 1, 5.")).unread if u.changes_answer]


def test_a_transformed_node_is_found_by_its_instance_too(read: Reader) -> None:
    """INSTANCE.LABEL, as Abaqus/CAE writes a single node."""
    deck = "*PART, NAME=P\n*NODE\n1, 0, 0, 0\n2, 9, 0, 0\n*ELEMENT, TYPE=B31, ELSET=E\n1, 1, 2\n"
    deck += "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=CIRC\n1.\n0, 0, 1\n*END PART\n*ASSEMBLY, NAME=A\n"
    deck += "*INSTANCE, NAME=P-1, PART=P\n*END INSTANCE\n*NSET, NSET=T, INSTANCE=P-1\n2\n"
    deck += "*TRANSFORM, NSET=T\n0., 1., 0., -1., 0., 0.\n*END ASSEMBLY\n*MATERIAL, NAME=M\n*ELASTIC\n2e5, .3\n"
    deck += "*DENSITY\n7.8e-9\n*INITIAL CONDITIONS, TYPE=VELOCITY\nP-1.2, 1, 5.\n"
    assert [u.keyword for u in read(deck).unread if u.changes_answer] == ["*INITIAL CONDITIONS on transformed nodes"]


def test_coupling_along_an_orientation(read: Reader) -> None:
    text = "*NODE\n 20, 5., 4., 3.\n*KINEMATIC COUPLING, REF NODE=20, ORIENTATION=O\n 9, 1, 1\n*ORIENTATION, NAME=O\n 0.6, 0.8, 0., 0., 1., 0.\n"
    (equation,) = read(PLAIN + text).constraints
    assert isinstance(equation, Equation)
    row = np.zeros((5, 6))
    row[equation.nodes_idx, equation.dofs - 1] = equation.coefficients
    e, r = np.array([0.6, 0.8, 0.0]), np.array([5.0, 4.0, -3.0])
    turn = np.array([0.1, -0.2, 0.3])
    assert_allclose(row[2, :3], e)
    assert_allclose(row[4, 3:] @ turn, -e @ np.cross(turn, r), atol=1e-14)


def test_influence_radius_leaves_out_far_nodes(read: Reader) -> None:
    text = "*NODE\n 20, 0., 0., 1.\n*SURFACE, NAME=S\n P, SPOS\n*COUPLING, CONSTRAINT NAME=C, REF NODE=20, SURFACE=S, INFLUENCE RADIUS=9.\n*KINEMATIC\n"
    (coupling,) = read(PLAIN + text).constraints
    assert isinstance(coupling, KinematicCoupling)
    assert coupling.nodes_idx.tolist() == [0, 3]


def test_mpc_link_keeps_the_distance(read: Reader) -> None:
    (equation,) = read(PLAIN + "*MPC\n LINK, 9, 5\n").constraints
    assert isinstance(equation, Equation)
    row = np.zeros((4, 6))
    row[equation.nodes_idx, equation.dofs - 1] = equation.coefficients
    t = np.array([10.0, 8.0, 0.0]) / math.sqrt(164.0)
    assert_allclose(row[2, :3] * np.sign(row[2, 0]), t)
    assert_allclose(row[0], -row[2])


def test_nodes_in_cylindrical_and_local_systems(read: Reader) -> None:
    nodes = "*NODE, SYSTEM=C\n 5, 0., 0.\n 2, 10., 0.\n*SYSTEM\n 10., 0., 0., 10., 1., 0.\n*NODE\n 9, 8., 0.\n*SYSTEM\n*NODE, SYSTEM=S\n 11, 8., 90., 0.\n"
    element = PLATE.split("*ELEMENT", 1)[1]
    model = read(f"{nodes}*ELEMENT{element}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n{STEEL}")
    assert_allclose(model.nodes.coords, [[0, 0, 0], [10, 0, 0], [10, 8, 0], [0, 8, 0]], atol=1e-12)


def test_ten_node_tetrahedron_with_a_face(read: Reader) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    points = np.concatenate([corners, [(corners[i] + corners[j]) / 2 for i, j in pairs]])
    lines = "".join(f" {k + 1}, {x}, {y}, {z}\n" for k, (x, y, z) in enumerate(points))
    text = f"*NODE\n{lines}*ELEMENT, TYPE=C3D10, ELSET=S\n 1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10\n*SOLID SECTION, ELSET=S, MATERIAL=STEEL\n{STEEL}"
    model = read(text + "*SURFACE, NAME=F\n S, S3\n*SURFACE, NAME=ALL\n S,\n")
    assert model.surfaces["F"].side.tolist() == [9, 10, 11, 12]
    assert sorted(model.surfaces["F"].nodes_idx.tolist()) == [1, 2, 3, 5, 8, 9]
    assert model.surfaces["ALL"].facets.shape[0] == 16
    assert part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass == pytest.approx(7.85e-9 / 6)
