"""Solid elements: rigid modes, patch test, bending, nearly incompressible material, mass, frequencies, bad elements."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import roots_jacobi

from creak.elements.geometry import DegenerateElement
from creak.elements.solids import pyramid5
from creak.model.materials import Material, SolidSection
from creak.model.mesh import COMMON
from helpers_fem import dof, frequencies, random_rotation, rigid_modes, solve
from helpers_solids import KINDS, block, in_place, solid_mesh

RECORDED = {"section": "beams and solids", "source": "exact"}

EXACT = 1e-10
STEEL = SolidSection("S", Material("STEEL", 2e11, 0.3, 7800.0))
kinds = pytest.mark.parametrize("kind", sorted(KINDS))


def held_in_place(mesh) -> np.ndarray:
    """Rotations have no stiffness."""
    return dof(np.arange(len(mesh.coords)), 4, 5, 6)


@kinds
def test_rigid_body_motion_is_strain_free_and_six_modes_only(kind):
    mesh = block((2, 2, 1), (2.0, 1.0, 1.0), kind, distortion=0.15)
    mesh.coords = mesh.coords @ random_rotation(3).T
    keep = dof(np.arange(len(mesh.coords)), 1, 2, 3)
    K = mesh.stiffness(STEEL).toarray()
    assert np.abs(K @ rigid_modes(mesh.coords)).max() < 1e-12 * K.max() * 10
    energy = np.linalg.eigvalsh(K[np.ix_(keep, keep)])
    assert np.abs(energy[:6]).max() < 1e-12 * energy[-1] < 1e-6 * energy[6]


@kinds
def test_constant_strain_on_a_distorted_mesh_is_exact(kind, measured):
    """Patch test: linear displacements on the border; inner nodes follow and stresses are Hooke's."""
    mesh = block((2, 2, 2), (0.24, 0.2, 0.16), kind, distortion=0.2)
    gradient = 1e-3 * np.array([[1.0, 0.5, -0.3], [0.2, -0.7, 0.4], [0.6, 0.1, 0.8]])
    exact = np.zeros((len(mesh.coords), 6))
    exact[:, :3] = mesh.coords @ gradient.T
    border = mesh.nodes(lambda x: (np.isclose(x, 0.0) | np.isclose(x, [0.24, 0.2, 0.16])).any(axis=1))
    assert border.size == {"tet10": 98, "hex20": 74, "hex20r": 74, "hex20s": 74, "wedge15": 82}.get(kind, 26)
    held = np.union1d(dof(border, 1, 2, 3), held_in_place(mesh))
    K = mesh.stiffness(STEEL)
    u = solve(K, np.zeros(mesh.n_dof), held, exact.ravel()[held])
    assert u == pytest.approx(exact.ravel(), abs=EXACT * np.abs(exact).max())
    lame = 2e11 * 0.3 / (1.3 * 0.4)
    strain = 0.5 * (gradient + gradient.T)
    energy = (2 * STEEL.material.shear_modulus * (strain**2).sum() + lame * np.trace(strain) ** 2) * 0.24 * 0.2 * 0.16
    measured(f"patch of distorted {kind}: energy", u @ (K @ u), energy, rel=EXACT, unit="J", source="Hooke")


@pytest.mark.parametrize("aspect", [0.25, 1.0, 10.0])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
def test_pure_bending_of_one_rectangular_hexahedron_is_exact(aspect, nu, measured):
    """Energy E I kappa^2 L: u = -x y, v = x^2/2 + nu (y^2 - z^2)/2, w = nu y z at the corners."""
    mesh = block((1, 1, 1), (aspect, 1.0, 1.0), "hex8")
    x, y, z = (mesh.coords - 0.5 * mesh.coords.max(axis=0)).T
    u = np.zeros((8, 6))
    u[:, 0], u[:, 1], u[:, 2] = -x * y, x * x / 2 + nu * (y * y - z * z) / 2, nu * y * z
    K = mesh.stiffness(SolidSection("S", Material("M", 1e6, nu, 1.0)))
    # Equilibrium states take the least energy of all with these corner displacements.
    ratio = u.ravel() @ (K @ u.ravel()) / (1e6 / 12 * aspect)
    measured("one hexahedron in pure bending, aspect to 10, nu to .4999: energy ratio", ratio, 1.0, rel=1e-9)


def cantilever(mesh, section: SolidSection, length: float) -> float:
    """Tip deflection under a unit force spread over the end, root held as a beam's: free to contract sideways."""
    x = mesh.coords
    root, tip = np.flatnonzero(np.isclose(x[:, 0], 0.0)), np.flatnonzero(np.isclose(x[:, 0], length))
    foot = root[np.argmin(np.linalg.norm(x[root], axis=1))]
    other = root[np.argmin(np.linalg.norm(x[root] - np.array([0.0, 0.0, x[:, 2].max()]), axis=1))]
    held = np.unique(np.concatenate([dof(root, 1), dof(foot, 2, 3), dof(other, 2), held_in_place(mesh)]))
    force = np.zeros(mesh.n_dof)
    force[dof(tip, 2)] = 1.0 / tip.size
    return float(solve(mesh.stiffness(section), force, held)[dof(tip, 2)].mean())


def test_slender_cantilever_of_one_layer_follows_beam_theory(measured):
    """P L^3/(3 E I) + P L/(kappa G A) with one hexahedron through the depth; the cubic deflection takes 10 elements."""
    section = SolidSection("S", Material("M", 1e6, 0.25, 1.0))
    mesh = block((10, 1, 1), (10.0, 1.0, 1.0), "hex8")
    exact = 1e3 / (3 * 1e6 / 12) + 10.0 / (5 / 6 * section.material.shear_modulus)
    # Linear curvature by element-wise constants: error 1/(4 n^2) of the deflection, .25 %; the rest is St Venant's.
    found = cantilever(mesh, section, 10.0)
    measured("cantilever of 10 hexahedra: tip deflection", found, exact, rel=1e-2, unit="m", source="Timoshenko")


def test_tetrahedra_and_wedges_bend_too_stiffly_and_converge():
    section = SolidSection("S", Material("M", 1e6, 0.25, 1.0))
    exact = 64.0 / (3 * 1e6 / 12) + 4.0 / (5 / 6 * section.material.shear_modulus)
    for kind in ("tet4", "wedge6"):
        coarse, fine = (cantilever(block((4 * n, n, n), (4.0, 1.0, 1.0), kind), section, 4.0) / exact for n in (1, 4))
        assert coarse < fine < 1.0, kind
        assert 1.0 - fine < 0.35 * (1.0 - coarse), kind  # second order would be 1/16


def punched_cube(n: int, distortion: float) -> float:
    """Deflection of a unit force on a quarter of the top of a cube between smooth walls, E = 1, nu = 0.4999."""
    mesh, x = block((n, n, n), (1.0, 1.0, 1.0), "hex8", distortion), solid_mesh((n, n, n), (1.0, 1.0, 1.0))[0]
    outer = (np.isclose(x, 0.0) | np.isclose(x, 1.0)).any(axis=1)
    mesh.coords[outer] = x[outer]
    held = [dof(np.flatnonzero(np.isclose(x[:, axis], 0.0)), axis + 1) for axis in range(3)]
    held += [dof(np.flatnonzero(np.isclose(x[:, axis], 1.0)), axis + 1) for axis in range(2)]
    top = np.flatnonzero(np.isclose(x[:, 2], 1.0) & (x[:, :2] < 0.51).all(axis=1))
    rim = np.isclose(x[top, :2], 0.0) | np.isclose(x[top, :2], 0.5)
    share = np.where(rim, 0.5, 1.0).prod(axis=1)
    share /= share.sum()
    force = np.zeros(mesh.n_dof)
    force[dof(top, 3)] = -share
    section = SolidSection("S", Material("M", 1.0, 0.4999, 1.0))
    u = solve(mesh.stiffness(section), force, np.unique(np.concatenate([*held, held_in_place(mesh)])))
    return float(-share @ u[dof(top, 3)])


@pytest.mark.parametrize("distortion", [0.0, 0.2])
def test_nearly_incompressible_hexahedra_do_not_lock(distortion, measured):
    """4^3 elements are within 10 % of 8^3 (second order: 4/3 x 7 %); trilinear ones alone give 3 % of the answer."""
    coarse, fine = punched_cube(4, distortion), punched_cube(8, 0.0)
    measured("punched cube, nu = .4999, 4^3: over 8^3", coarse / fine, 1.0, rel=0.10, source="finer mesh")


def test_hexahedra_lock_neither_in_volume_nor_in_bending_together(measured):
    """Slender cantilever, nu = 0.4999, one layer: still the beam's answer."""
    section = SolidSection("S", Material("M", 1e6, 0.4999, 1.0))
    exact = 1e3 / (3 * 1e6 / 12) + 10.0 / (5 / 6 * section.material.shear_modulus)
    mesh = block((20, 1, 1), (10.0, 1.0, 1.0), "hex8")
    found = cantilever(mesh, section, 10.0)
    measured(
        "cantilever of 20 hexahedra, nu = .4999: tip deflection", found, exact, rel=2e-2, unit="m", source="Timoshenko"
    )


@kinds
def test_mass_has_the_right_sum_centre_and_inertia(kind, measured):
    mesh = block((2, 2, 2), (0.3, 0.2, 0.1), kind, distortion=0.1)
    M = mesh.mass(STEEL)
    modes = rigid_modes(mesh.coords)
    inertia = modes.T @ (M @ modes)
    mass = 7800 * 0.3 * 0.2 * 0.1
    assert np.diag(inertia)[:3] == pytest.approx(mass, rel=1e-12)
    # Products of linear fields are integrated exactly on rectangular elements only; the distorted ones to 1e-3.
    measured(f"block of {kind}: moment of inertia", inertia[5, 5], mass * (0.3**2 + 0.2**2) / 3, rel=1e-3, unit="kg m2")
    assert inertia[1, 5] == pytest.approx(mass * 0.15, rel=1e-12)


def test_bending_frequencies_of_a_free_bar_follow_beam_theory(measured):
    mesh = block((20, 1, 1), (2.0, 0.05, 0.05), "hex8")
    keep = dof(np.arange(len(mesh.coords)), 1, 2, 3)
    K, M = (A[keep][:, keep].tocsc() for A in (mesh.stiffness(STEEL), mesh.mass(STEEL)))
    found = frequencies(K, M, np.zeros(0, dtype=int), 8, -1e4)
    beam = 4.730041**2 / (2 * np.pi * 2.0**2) * np.sqrt(2e11 * 0.05**2 / 12 / 7800)
    assert np.abs(found[:6]).max() < 1e-2 * beam
    # Shear and rotary inertia lower it by some (pi r/L)^2 of 1e-2/2, the mesh raises it by (k h)^2/24.
    measured(
        "free bar of 20 hexahedra: first bending frequency",
        found[6:8],
        beam,
        rel=1e-2,
        unit="Hz",
        source="Euler-Bernoulli",
    )


@kinds
def test_turned_elements_have_the_turned_matrices(kind):
    mesh = block((1, 1, 1), (1.0, 0.7, 0.6), kind, distortion=0.1)
    R = random_rotation(1)
    turned = in_place(mesh, mesh.coords @ R.T + 3.0)
    T = np.kron(np.eye(2 * len(mesh.coords)), R)
    for matrix in ("stiffness", "mass"):
        K, K_turned = (getattr(m, matrix)(STEEL).toarray() for m in (mesh, turned))
        assert pytest.approx(K_turned, abs=1e-10 * K.max()) == T @ K @ T.T


@kinds
def test_inverted_and_flat_elements_are_refused(kind):
    mesh = block((1, 1, 1), (1.0, 1.0, 1.0), kind)
    coords = np.repeat(mesh.coords[mesh.elements[:1]], 3, axis=0)
    coords[1, :, 2] *= -1.0
    coords[2, :, 2] = 0.0
    for matrix in (mesh.module.stiffness, mesh.module.mass):
        with pytest.raises(DegenerateElement, match="Jacobian not positive") as error:
            matrix(coords, STEEL, COMMON)
        assert error.value.rows.tolist() == [1, 2]


@pytest.mark.parametrize("n", [2, 3])
def test_gauss_jacobi_of_pyramids(n):
    x, w = (np.array(row) for row in pyramid5.GAUSS_JACOBI[n])
    np.testing.assert_allclose(np.array([x, w]), roots_jacobi(n, 2.0, 0.0), rtol=1e-14)
    for power in range(2 * n):  # exact up to degree 2 n - 1; the integral of (1 - x)^2 (1 - x)^k is 2^(k + 3) / (k + 3)
        assert w @ (1.0 - x) ** power == pytest.approx(2.0 ** (power + 3) / (power + 3), rel=1e-13)
