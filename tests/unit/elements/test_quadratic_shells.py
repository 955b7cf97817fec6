"""Shells with middle nodes: exact states, no spurious modes, thin plates, and the roof."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks_shell import ROOF, THIN_PLATES, scordelis_lo, thick_plate, thin_plate
from creak.elements import beam3
from creak.elements.block_matrices import lumped
from creak.elements.geometry import DegenerateElement
from creak.elements.registry import FORMULATIONS
from creak.elements.shells import quad8 as shell_quad8
from creak.elements.shells.common import SPIN
from creak.model.expansion import Expansion
from creak.model.laminates import homogeneous_shell
from creak.model.materials import BeamSection, Material, ShellSection
from creak.model.mesh import COMMON, Own
from helpers_fem import QUADRATIC as SHAPES
from helpers_fem import Mesh, dof, grid, macneal_patch, random_rotation, rectangle, rigid_modes, shell_section, solve
from helpers_solids import with_middle_nodes

RECORDED = {"section": "shell statics", "source": "MacNeal, Harder 1985"}

KINDS = ["quad8", "tri6"]
SIDES = {"quad8": ("quad", ((0, 1), (1, 2), (2, 3), (3, 0))), "tri6": ("tri", ((0, 1), (1, 2), (2, 0)))}


def curved(kind: str) -> Mesh:
    """Doubly curved, skew, of two by two cells."""
    return grid(
        2,
        2,
        lambda x, y: np.column_stack([x + 0.1 * y * y, 1.3 * y + 0.2 * x, 0.3 * x * x - 0.2 * y * y + 0.3 * x * y]),
        kind,
    )


def patch(kind: str) -> Mesh:
    """MacNeal and Harder's patch with middle nodes on straight sides."""
    corners, sides = SIDES[kind]
    linear = macneal_patch(corners)
    return Mesh(*with_middle_nodes(linear.coords, linear.elements, sides), SHAPES[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_shape_functions_are_one_at_their_node_and_slopes_are_theirs(kind):
    at = SHAPES[kind].NODES
    found = SHAPES[kind].reference(at, np.zeros(len(at)))
    assert np.allclose(found.shapes, np.eye(len(at)), atol=1e-14)
    step = 1e-6
    for axis in range(2):
        moved = [
            SHAPES[kind].reference(0.3 * at + sign * step * np.eye(2)[axis], np.zeros(len(at))) for sign in (1, -1)
        ]
        slope = (moved[0].shapes - moved[1].shapes) / (2 * step)
        assert np.allclose(SHAPES[kind].reference(0.3 * at, np.zeros(len(at))).slopes[:, axis], slope, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motion_strains_no_curved_element_and_nothing_else_is_free(kind):
    mesh = curved(kind)
    section = shell_section(0.1, 1e3, 0.3)
    for piece in (mesh, Mesh(mesh.coords, mesh.elements[:1], mesh.module)):
        used = dof(np.unique(piece.elements), 1, 2, 3, 4, 5, 6)
        K = piece.stiffness(section).toarray()[np.ix_(used, used)]
        assert np.abs(K @ rigid_modes(mesh.coords)[used]).max() < 1e-14 * np.abs(K).max()
        values = np.linalg.eigvalsh(K)
        assert (values < 1e-12 * values[-1]).sum() == 6
        assert values[6] > 1e-9 * values[-1]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("state", ["membrane", "bending"])
def test_constant_states_of_a_distorted_patch_are_exact(kind, state, measured):
    mesh = patch(kind)
    x, y = mesh.coords[:, 0], mesh.coords[:, 1]
    exact = np.zeros((len(x), 6))
    if state == "membrane":
        exact[:, 0], exact[:, 1] = 1e-3 * (x + y / 2), 1e-3 * (y + x / 2)
    else:
        exact[:, 2] = 1e-3 * (x * x + x * y + y * y) / 2
        exact[:, 3], exact[:, 4] = 1e-3 * (x / 2 + y), -1e-3 * (x + y / 2)
    outer = mesh.nodes(
        lambda c: (c[:, 0] < 1e-9) | (c[:, 0] > 0.24 - 1e-9) | (c[:, 1] < 1e-9) | (c[:, 1] > 0.12 - 1e-9)
    )
    held = dof(outer, 1, 2, 3, 4, 5, 6)
    u = solve(mesh.stiffness(shell_section(1e-3, 1e6, 0.25)), np.zeros(mesh.n_dof), held, exact.ravel()[held])
    measured(
        f"patch test, {state}, {kind}: largest error over largest displacement or rotation",
        float(np.abs(u - exact.ravel()).max() / np.abs(exact).max()),
        at_most=1e-7,
    )


@pytest.mark.parametrize(("kind", "limit"), [("quad8", 0.01), ("tri6", 0.035)])
@pytest.mark.parametrize("edges", ["SSSS", "FFFF", "CFFF"])
def test_thin_plates_of_few_elements(kind, limit, edges, measured):
    """Thickness a / 1000: elements that lock are wrong by tens of per cent here."""
    ratio = thin_plate(edges, 6, kind)
    assert THIN_PLATES[edges]
    measured(
        f"thin square plate {edges}, first modes, {kind} 6 x 6: largest error",
        float(np.abs(ratio - 1.0).max()),
        at_most=limit,
        source="exact or Ritz",
        section="shell modes",
    )


@pytest.mark.parametrize(("kind", "limit"), [("quad8", 0.002), ("tri6", 0.007)])
@pytest.mark.parametrize("edges", ["SSSS", "CFFF"])
def test_thin_plates_of_distorted_elements(kind, limit, edges):
    """Corners moved by up to a quarter of an element, thickness a / 1000: 8 x 8 S8 of CalculiX are 20 to 71 % off."""
    assert np.abs(thin_plate(edges, 8, kind, moved=0.25) - 1.0).max() < limit


@pytest.mark.parametrize(("kind", "limit"), [("quad8", 0.012), ("tri6", 0.04)])
def test_clamped_thin_plates_and_thick_ones_of_few_elements(kind, limit):
    assert np.abs(thin_plate("CCCC", 6, kind) - 1.0).max() < limit
    assert np.abs(thick_plate(6, kind) - 1.0).max() < limit


@pytest.mark.parametrize(("kind", "n", "limit"), [("quad8", 4, 0.01), ("tri6", 4, 0.01)])
def test_scordelis_lo_roof(kind, n, limit, measured):
    measured(f"Scordelis-Lo roof, {kind} {n} x {n}", scordelis_lo(n, kind) * ROOF, ROOF, rel=limit, unit="ft")


@pytest.mark.parametrize("kind", KINDS)
def test_mass_is_that_of_the_plate_and_lumped_masses_are_positive(kind):
    mesh = rectangle(1, 1, 2.0, 3.0, kind)
    section = shell_section(0.1, 1.0, 0.3, 5.0)
    M = mesh.mass(section).toarray()
    rigid = rigid_modes(mesh.coords - [1.0, 1.5, 0.0])
    inertia = np.diag(rigid.T @ M @ rigid)
    mass, t = 2.0 * 3.0 * 0.1 * 5.0, 0.1
    assert np.allclose(inertia[:3], mass, rtol=1e-12)
    about_z = mass * (4.0 + 9.0 + SPIN * t * t) / 12.0
    assert np.allclose(inertia[3:], [mass * (9.0 + t * t) / 12.0, mass * (4.0 + t * t) / 12.0, about_z], rtol=1e-10)
    assert np.linalg.eigvalsh(M).min() > 0.0
    corners = mesh.coords[mesh.elements]
    each = lumped(mesh.module.mass(corners, section))
    share = np.diagonal(each, axis1=1, axis2=2)[:, ::6]
    assert (share > 0.0).all()
    assert share.sum() == pytest.approx(mass)


@pytest.mark.parametrize("kind", KINDS)
def test_offset_section_bends_about_the_middle_of_its_sheet(kind):
    """Nodes half a thickness off the sheet: bending free of membrane force is that of the sheet about its own middle."""
    material = Material("M", 1e6, 0.0, 1.0)
    t, offset = 0.02, 0.01
    mesh = rectangle(8, 1, 1.0, 0.1, kind)
    root, tip = mesh.nodes(lambda x: x[:, 0] < 1e-9), mesh.nodes(lambda x: x[:, 0] > 1 - 1e-9)
    force = np.zeros(mesh.n_dof)
    force[dof(tip, 3)] = np.array([1.0, 4.0, 1.0]) / 6.0 * 1e-3
    u = solve(mesh.stiffness(homogeneous_shell("S", material, t, offset)), force, dof(root, 1, 2, 3, 4, 5, 6))
    exact = 1e-3 / (3 * 1e6 * 0.1 * t**3 / 12)
    assert u[dof(tip, 3)].mean() == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_free_curved_shells_expand_without_stress(kind):
    mesh = curved(kind)
    material = Material("M", 1e3, 0.3, 1.0, expansion=Expansion((1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0)))
    section = ShellSection("S", material, 0.05)
    x = mesh.coords[mesh.elements]
    load = FORMULATIONS[kind].heat_load(x, section, COMMON, np.full(mesh.elements.shape, 20.0))
    f = np.zeros(mesh.n_dof)
    np.add.at(f, (6 * mesh.elements[:, :, None] + np.arange(6)).reshape(len(x), -1), load)
    grown = np.zeros((len(mesh.coords), 6))
    grown[:, :3] = 0.02 * mesh.coords
    K = mesh.stiffness(section)
    assert np.abs(K @ grown.ravel() - f).max() < 1e-10 * np.abs(f).max()


@pytest.mark.parametrize("kind", KINDS)
def test_tension_stiffens_a_string_of_shells(kind):
    """u' K_g u of the deflection w = x (1 - x) under N: N b integral of w'^2 = N b / 3."""
    mesh = rectangle(3, 2, 1.0, 0.2, kind)
    section = shell_section(0.01, 1e4, 0.0)
    stretched = np.zeros((len(mesh.coords), 6))
    stretched[:, 0] = 1e-3 * mesh.coords[:, 0]
    w = np.zeros_like(stretched)
    w[:, 2] = mesh.coords[:, 0] * (1.0 - mesh.coords[:, 0])
    Kg = mesh.assemble(
        FORMULATIONS[kind].geometric(mesh.coords[mesh.elements], section, COMMON, stretched[mesh.elements])
    )
    assert w.ravel() @ Kg @ w.ravel() == pytest.approx(1e4 * 0.01 * 1e-3 * 0.2 / 3.0, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_numbering_and_axes_do_not_matter(kind):
    mesh = curved(kind)
    x, section = mesh.coords[mesh.elements[:1]], shell_section(0.1, 1e3, 0.3)
    values = np.linalg.eigvalsh(mesh.module.stiffness(x, section)[0])
    k = x.shape[1] // 2
    first = np.concatenate([np.roll(np.arange(k), 1), k + np.roll(np.arange(k), 1)])
    for other in (x[:, first], x @ random_rotation(3).T):
        assert np.allclose(np.linalg.eigvalsh(mesh.module.stiffness(other, section)[0]), values, atol=1e-9 * values[-1])


@pytest.mark.parametrize("kind", KINDS)
def test_folded_elements_are_named_by_row(kind):
    flat = rectangle(1, 1, 1.0, 1.0, kind)
    x = np.repeat(flat.coords[flat.elements[:1]], 3, axis=0)
    x[1, x.shape[1] // 2] = x[1, 0] + 0.05 * (x[1, 1] - x[1, 0])
    x[2] = x[2, :1]
    with pytest.raises(DegenerateElement, match="no area") as raised:
        flat.module.stiffness(x, shell_section(0.1, 1.0, 0.3))
    assert raised.value.rows.tolist() == [2]
    with pytest.raises(DegenerateElement, match="middle nodes") as raised:
        flat.module.mass(x[:2], shell_section(0.1, 1.0, 0.3))
    assert raised.value.rows.tolist() == [1]


def test_thickness_at_the_nodes_scales_the_section():
    mesh = rectangle(1, 1, 1.0, 1.0, "quad8")
    x, section = mesh.coords[mesh.elements], shell_section(0.1, 1e3, 0.3)
    twice = Own(thickness=np.full((1, 8), 2.0))
    assert np.allclose(
        shell_quad8.stiffness(x, section, twice), shell_quad8.stiffness(x, shell_section(0.2, 1e3, 0.3)), rtol=1e-12
    )


def test_few_elements_bend_as_many_small_quads():
    """A strip of 4 x 1 against 32 x 6 four-node shells, loaded in the middle of its end."""

    def tip(mesh: Mesh) -> float:
        root, end = mesh.nodes(lambda x: x[:, 0] < 1e-9), mesh.nodes(lambda x: x[:, 0] > 1 - 1e-9)
        middle = end[np.argmin(np.abs(mesh.coords[end, 1] - 0.1))]
        force = np.zeros(mesh.n_dof)
        force[dof(middle, 3)] = 1.0
        u = solve(mesh.stiffness(shell_section(0.02, 1e6, 0.3)), force, dof(root, 1, 2, 3, 4, 5, 6))
        return float(u[dof(middle, 3)][0])

    reference = tip(rectangle(32, 6, 1.0, 0.2))
    for kind in KINDS:
        assert tip(rectangle(4, 1, 1.0, 0.2, kind)) == pytest.approx(reference, rel=0.01)


def test_three_node_beams_are_two_beams_and_expand_freely():
    material = Material("M", 1e5, 0.3, 1e-3, expansion=Expansion((1e-5, 1e-5, 1e-5, 0.0, 0.0, 0.0)))
    section = BeamSection("B", material, 4.0, 2.0, 1.0, 1.5, (0.0, 0.0, 1.0))
    x = np.array([[[0.0, 0.0, 0.0], [1.0, 0.5, 0.0], [2.0, 1.0, 0.0]]])
    K, M = beam3.stiffness(x, section)[0], beam3.mass(x, section)[0]
    assert np.abs(K @ rigid_modes(x[0])).max() < 1e-9 * np.abs(K).max()
    along = np.zeros((3, 6))
    along[:, 0] = 1.0
    assert along.ravel() @ M @ along.ravel() == pytest.approx(1e-3 * 4.0 * np.sqrt(5.0))
    grown = np.zeros((3, 6))
    grown[:, :3] = 2e-4 * x[0]
    assert beam3.heat_load(x, section, COMMON, np.full((1, 3), 20.0))[0] == pytest.approx(K @ grown.ravel(), abs=1e-9)
