"""Shells by their resultants: offset, laminates, material directions, thickness at the nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from creak.elements.geometry import DegenerateElement
from creak.elements.shells import quad4 as shell_quad4
from creak.model.elasticity import lamina, turned_shear
from creak.model.laminates import Ply, homogeneous_shell, laminate, shifted
from creak.model.materials import GeneralShell, Material, SheetMaterial, ShellSection
from creak.model.mesh import Own
from helpers_fem import KINDS, QUADRATIC, Mesh, dof, frequencies, random_rotation, rectangle, rigid_modes

RECORDED = {"section": "beams and solids"}

STEEL = Material("STEEL", 2e11, 0.3, 7800.0)
CARBON = SheetMaterial("CARBON", *lamina(140e9, 10e9, 0.3, 5e9, 5e9, 3.5e9), 1600.0)
CROSS = laminate("C", [Ply(CARBON, 1e-3), Ply(CARBON, 1e-3, np.pi / 2)], bottom=3e-4)
BOTH = pytest.mark.parametrize("kind", ["quad", "tri"])


def warped(kind: str) -> np.ndarray:
    """Coordinates (3, n, 3) of crooked elements, warped where they can be."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    x = square + 0.15 * np.random.default_rng(1).standard_normal((3, 4, 3))
    return x if kind == "quad" else x[:, :3]


@BOTH
def test_isotropic_resultants_give_the_matrices_of_the_homogeneous_section(kind):
    module, x = KINDS[kind], warped(kind)
    plain, general = ShellSection("S", STEEL, 0.01), homogeneous_shell("S", STEEL, 0.01)
    for made in (module.stiffness, module.mass):
        expected = made(x, plain)
        assert made(x, general) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


@BOTH
@pytest.mark.parametrize("section", [ShellSection("S", STEEL, 0.02), CROSS], ids=["isotropic", "laminate"])
def test_thickness_at_the_nodes_scales_the_section(kind, section, measured):
    """Twice the thickness everywhere is the section of twice the thickness."""
    module, x = KINDS[kind], warped(kind)
    if isinstance(section, ShellSection):
        thick = ShellSection("S", STEEL, 0.04)
    else:
        thick = laminate("C", [Ply(CARBON, 2e-3), Ply(CARBON, 2e-3, np.pi / 2)], bottom=6e-4)
    own = Own(thickness=np.full(x.shape[:2], 2.0))
    for made in (module.stiffness, module.mass):
        expected = made(x, thick)
        error = np.abs(made(x, section, own) - expected).max() / np.abs(expected).max()
        measured(
            "twice the thickness at the nodes: K and M, relative error",
            error,
            at_most=1e-12,
            source="section twice as thick",
        )


@BOTH
def test_offset_laminate_is_free_of_strain_in_rigid_motion_only(kind):
    x = warped(kind)
    own = Own(axis1=np.array([[1.0, 0.2, 0.3]] * 3))
    for matrix, coords in zip(KINDS[kind].stiffness(x, CROSS, own), x, strict=True):
        motion = rigid_modes(coords)
        assert np.abs(matrix @ motion).max() < 1e-10 * np.abs(matrix).max()
        energy = np.linalg.eigvalsh(matrix)
        assert energy[0] > -1e-9 * energy[-1]
        assert np.linalg.matrix_rank(matrix, tol=1e-12 * energy[-1]) == len(matrix) - 6


@BOTH
def test_mass_of_an_offset_shell_moves_like_the_body_it_is(kind, measured):
    """Rigid motion: m, the static moment m c n and the inertia m c^2 of the shifted sheet about the nodes' plane."""
    mesh = rectangle(4, 3, 2.0, 1.5, kind)
    t, c = 0.1, 0.3
    M = mesh.mass(homogeneous_shell("S", STEEL, t, c)).toarray()
    R = rigid_modes(mesh.coords)
    body = R.T @ M @ R
    m = 7800.0 * t * 3.0
    assert body[:3, :3] == pytest.approx(m * np.eye(3), abs=1e-9 * m)
    # centre of mass (1, 0.75, c): momentum of rotation about x and y
    assert (body[0, 4], body[1, 3], body[2, 3]) == pytest.approx((m * c, -m * c, m * 0.75), rel=1e-9)
    inertia_x = m * (1.5**2 / 3 + c**2 + t**2 / 12)
    measured(
        f"shell off its nodes, {kind}: moment of inertia", body[3, 3], inertia_x, rel=1e-9, unit="kg m2", source="exact"
    )


@BOTH
@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_a_mass_per_area_moves_with_the_middle_of_a_shell_and_stays_as_it_is_where_the_shell_is_thicker(kind, ratio):
    """A sheet of m = rho t A and inertia m t^2/12 at height c, and a film of M = a A in its middle; t and c with the
    thickness of the elements."""
    mesh = rectangle(4, 3, 2.0, 1.5, kind)
    t, c, a = 0.1 * ratio, 0.3 * ratio, 500.0
    section = replace(homogeneous_shell("S", STEEL, 0.1, 0.3), area_mass=a)
    own = Own(thickness=np.full(mesh.elements.shape, ratio))
    M = mesh.assemble(KINDS[kind].mass(mesh.coords[mesh.elements], section, own)).toarray()
    R = rigid_modes(mesh.coords)
    body = R.T @ M @ R
    m, film = 7800.0 * t * 3.0, a * 3.0
    assert body[:3, :3] == pytest.approx((m + film) * np.eye(3), abs=1e-9 * m)
    assert (body[0, 4], body[1, 3]) == pytest.approx(((m + film) * c, -(m + film) * c), rel=1e-9)
    assert body[3, 3] == pytest.approx((m + film) * (1.5**2 / 3 + c**2) + m * t**2 / 12, rel=1e-9)


@BOTH
def test_material_direction_turns_the_section(kind):
    """A ply at 30 degrees from x is a ply at 0 degrees from the direction at 30 degrees."""
    x = rectangle(1, 1, 1.0, 0.7, kind)
    coords = x.coords[x.elements]
    a = np.pi / 6
    at_angle = laminate("A", [Ply(CARBON, 1e-3, a), Ply(CARBON, 2e-3, a + 0.4)])
    along = laminate("B", [Ply(CARBON, 1e-3), Ply(CARBON, 2e-3, 0.4)])
    at_angle = replace(at_angle, S=turned_shear(along.S, a))
    own = Own(axis1=np.tile([np.cos(a), np.sin(a), 0.5], (len(coords), 1)))
    expected = KINDS[kind].stiffness(coords, at_angle)
    assert KINDS[kind].stiffness(coords, along, own) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


@BOTH
def test_matrices_turn_with_element_and_direction(kind):
    x, Q = warped(kind), random_rotation(3)
    own, turned = (Own(axis1=np.tile(d, (3, 1))) for d in (np.array([1.0, 0.3, 0]), Q @ np.array([1.0, 0.3, 0])))
    T = np.kron(np.eye(2 * x.shape[1]), Q)
    for made in (KINDS[kind].stiffness, KINDS[kind].mass):
        expected = T @ made(x, CROSS, own) @ T.T
        assert made(x @ Q.T, CROSS, turned) == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


def test_direction_along_the_normal_is_refused():
    x = rectangle(1, 1, 1.0, 1.0).coords[None, [0, 2, 3, 1]]
    with pytest.raises(DegenerateElement, match="normal"):
        shell_quad4.stiffness(x, CROSS, Own(axis1=np.array([[0.0, 0.0, 1.0]])))


@BOTH
def test_constant_strain_and_curvature_store_the_energy_of_the_resultants(kind, measured):
    """Patch: u = e x + z-linear field of constant curvature; energy = area/2 [e; k]' [A B; B D] [e; k]."""
    mesh = rectangle(3, 2, 0.6, 0.4, kind)
    inner = np.isclose(mesh.coords[:, 0] % 0.6, 0.2) & np.isclose(mesh.coords[:, 1], 0.2)
    mesh = Mesh(mesh.coords + np.where(inner[:, None], [0.03, -0.02, 0.0], 0.0), mesh.elements, mesh.module)
    rng = np.random.default_rng(5)
    strain, bend = 1e-3 * rng.standard_normal(3), rng.standard_normal(3)
    x, y, _ = mesh.coords.T
    u = np.zeros((len(x), 6))
    u[:, 0], u[:, 1] = strain[0] * x + 0.5 * strain[2] * y, strain[1] * y + 0.5 * strain[2] * x
    u[:, 2] = -0.5 * (bend[0] * x * x + bend[1] * y * y + bend[2] * x * y)
    u[:, 3], u[:, 4] = -(bend[1] * y + 0.5 * bend[2] * x), bend[0] * x + 0.5 * bend[2] * y
    both = np.concatenate([strain, bend])
    section = np.block([[CROSS.A, CROSS.B], [CROSS.B, CROSS.D]])
    K = mesh.stiffness(CROSS, np.arange(mesh.n_dof))
    energy = u.ravel() @ (K @ u.ravel())
    measured(
        f"laminate with offset, {kind}: energy of constant strain and curvature",
        energy,
        0.24 * both @ section @ both,
        rel=1e-9,
        unit="J",
        source="exact resultants",
    )
    border = mesh.nodes(lambda p: np.isclose(p[:, 0] % 0.6, 0) | np.isclose(p[:, 1] % 0.4, 0))
    free = np.setdiff1d(np.arange(mesh.n_dof), dof(border, 1, 2, 3, 4, 5, 6))
    assert np.abs((K @ u.ravel())[free]).max() < 1e-8 * np.abs(K @ u.ravel()).max()


def test_resultants_of_a_shifted_sheet():
    shell = shifted(homogeneous_shell("S", STEEL, 0.01), 0.02)
    A = 2e11 * 0.01 / 0.91
    assert shell.A[0, 0] == pytest.approx(A)
    assert shell.B[0, 0] == pytest.approx(0.02 * A)
    assert shell.D[0, 0] == pytest.approx(A * (0.01**2 / 12 + 0.02**2))
    assert np.diag(shell.S) == pytest.approx(5 / 6 * STEEL.shear_modulus * 0.01)
    assert (shell.mass, shell.first_moment) == pytest.approx((78.0, 1.56))
    assert shell.rotary_inertia == pytest.approx(78.0 * (0.01**2 / 12 + 0.02**2))


def test_shear_stiffness_of_a_sandwich_is_that_of_its_core(measured):
    """Thin stiff skins, soft core: S = G_core (h + t)^2/h (Allen 1969), exact as the skins' share vanishes."""
    skin, core = Material("A", 70e9, 0.3, 2700.0), Material("B", 1e8, 0.3, 100.0)
    t, h = 1e-4, 0.02
    section = laminate("S", [Ply(skin, t), Ply(core, h), Ply(skin, t)])
    measured(
        "sandwich: shear stiffness",
        section.S[0, 0],
        core.shear_modulus * (h + t) ** 2 / h,
        rel=3e-3,
        unit="N/m",
        source="Allen 1969",
    )


def simply_supported(mesh: Mesh, section: GeneralShell, tangential: tuple[int, int]) -> np.ndarray:
    """The lowest three frequencies; `tangential` are the in-plane dofs held on the edges x = const and y = const."""
    size = mesh.coords.max(axis=0)
    on_x = mesh.nodes(lambda p: np.isclose(p[:, 0], 0) | np.isclose(p[:, 0], size[0]))
    on_y = mesh.nodes(lambda p: np.isclose(p[:, 1], 0) | np.isclose(p[:, 1], size[1]))
    held = np.concatenate([dof(on_x, 3, 4, tangential[0]), dof(on_y, 3, 5, tangential[1])])
    return frequencies(mesh.stiffness(section, held), mesh.mass(section), np.unique(held), 3, -1.0)


@BOTH
def test_specially_orthotropic_plate_vibrates_as_navier_says(kind, measured):
    """[0 90 0]: w^2 = pi^4/(rho h a^4) [D11 m^4 + 2 (D12 + 2 D66) m^2 n^2 r^2 + D22 n^4 r^4] (Jones, 5.72).

    a/h = 1000, so that shear lowers it by less than 1e-4; both elements err by O(1/n^2), 0.1 % and 0.35 % here.
    """
    a, b, t = 1.0, 0.8, 1e-3 / 3
    section = laminate("C", [Ply(CARBON, t), Ply(CARBON, t, np.pi / 2), Ply(CARBON, t)])
    found = simply_supported(rectangle(24, 20, a, b, kind), section, (2, 1))
    D, r = section.D, a / b
    squares = [
        np.pi**4
        / section.mass
        / a**4
        * (D[0, 0] * m**4 + 2 * (D[0, 1] + 2 * D[2, 2]) * m**2 * n**2 * r**2 + D[1, 1] * n**4 * r**4)
        for m in (1, 2, 3)
        for n in (1, 2, 3)
    ]
    expected = np.sqrt(np.sort(squares))[:3] / (2 * np.pi)
    measured(
        f"laminate [0 90 0] supported at its edges, {kind}: frequency {{}}",
        found,
        expected,
        rel=2e-3 if kind == "quad" else 8e-3,
        unit="Hz",
        source="Navier; Jones, 5.72",
    )


def test_antisymmetric_cross_ply_couples_bending_and_stretching(measured):
    """[0 90], edges free to move normally (S2): the determinant of Jones, eq. 5.83-5.85, in-plane inertia left out."""
    a, t = 1.0, 5e-4
    section = laminate("C", [Ply(CARBON, t), Ply(CARBON, t, np.pi / 2)])
    A, B, D, k = section.A, section.B, section.D, np.pi / a
    T = np.array(
        [
            [(A[0, 0] + A[2, 2]) * k**2, (A[0, 1] + A[2, 2]) * k**2, -B[0, 0] * k**3],
            [(A[0, 1] + A[2, 2]) * k**2, (A[1, 1] + A[2, 2]) * k**2, B[0, 0] * k**3],
            [-B[0, 0] * k**3, B[0, 0] * k**3, (D[0, 0] + 2 * (D[0, 1] + 2 * D[2, 2]) + D[1, 1]) * k**4],
        ]
    )
    stiffness = T[2, 2] - T[2, :2] @ np.linalg.solve(T[:2, :2], T[:2, 2])
    expected = np.sqrt(stiffness / section.mass) / (2 * np.pi)
    without = np.sqrt(T[2, 2] / section.mass) / (2 * np.pi)
    found = simply_supported(rectangle(20, 20, a, a), section, (2, 1))[0]
    measured(
        "laminate [0 90] supported at its edges: frequency 1",
        found,
        expected,
        rel=5e-3,
        unit="Hz",
        source="Jones, 5.83-5.85",
    )
    assert expected < 0.8 * without


@pytest.mark.parametrize("kind", [*KINDS, *QUADRATIC])
def test_a_sandwich_has_no_modes_of_drilling_rotations(kind):
    """Soft in its plane and of much inertia: the rotations about the normal stay out of its modes."""
    face, core = Material("FACE", 5e9, 0.3, 1500.0), Material("CORE", 2e7, 0.3, 80.0)
    section = laminate("S", [Ply(face, 5e-4), Ply(core, 15e-3), Ply(face, 5e-4)])
    mesh = rectangle(4, 3, 0.8, 0.5, kind)
    K, M = mesh.stiffness(section).toarray(), mesh.mass(section).toarray()
    values, shapes = scipy.linalg.eigh(K, M, subset_by_value=(-np.inf, (2 * np.pi * 2000.0) ** 2))
    drilling = shapes[5::6]
    share = np.einsum("ik,ij,jk->k", drilling, M[5::6, 5::6], drilling)
    assert values.size > 20
    assert share[6:].max() < 0.01


@BOTH
def test_free_plate_does_not_know_where_its_nodes_are(kind):
    """Nodes one thickness off the middle: the frequencies are those of nodes at the middle, to the mesh's error."""
    mesh = rectangle(16, 8, 1.0, 0.5, kind)
    t = 0.01
    none = np.zeros(0, dtype=int)
    middle, off = (
        frequencies(mesh.stiffness(s), mesh.mass(s), none, 10, -1e4)[6:]
        for s in (homogeneous_shell("S", STEEL, t), homogeneous_shell("S", STEEL, t, t))
    )
    assert off == pytest.approx(middle, rel=2e-2 if kind == "tri" else 1e-5)


def test_triangle_and_quadrilateral_agree_on_an_offset_cantilever():
    sections = homogeneous_shell("S", STEEL, 0.02, 0.01)
    found = []
    for kind in ("quad", "tri"):
        mesh = rectangle(20, 4, 1.0, 0.2, kind)
        clamped = dof(mesh.nodes(lambda p: np.isclose(p[:, 0], 0)), 1, 2, 3, 4, 5, 6)
        found.append(frequencies(mesh.stiffness(sections), mesh.mass(sections), clamped, 3, -1.0))
    assert found[0] == pytest.approx(found[1], rel=2e-2)
