"""Solids of anisotropic material, and the ten-node tetrahedron."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.block_matrices import lumped
from creak.errors import InputError
from creak.model.elasticity import hooke, lamina, orthotropic, sheet_matrices
from creak.model.materials import AnisotropicMaterial, Material, SolidSection
from creak.model.mesh import Own
from helpers_fem import dof, random_rotation, rigid_modes, solve
from helpers_solids import KINDS, block

RECORDED = {"section": "beams and solids"}

E, NU, G = (140e9, 10e9, 9e9), (0.3, 0.25, 0.4), (5e9, 4.5e9, 3.5e9)
WOOD = AnisotropicMaterial("W", orthotropic(E, NU, G), 1600.0)
STEEL = Material("S", 2e11, 0.3, 7800.0)
EVERY = pytest.mark.parametrize("kind", sorted(KINDS))


def test_orthotropic_constants_come_back_from_the_flexibility():
    S = np.linalg.inv(WOOD.elasticity)
    assert 1 / np.diag(S) == pytest.approx([*E, G[0], G[2], G[1]])
    assert (-S[0, 1] * E[0], -S[0, 2] * E[0], -S[1, 2] * E[1]) == pytest.approx(NU)


def test_isotropic_constants_give_hookes_law():
    g = STEEL.shear_modulus
    D = orthotropic((2e11,) * 3, (0.3,) * 3, (g,) * 3)
    assert pytest.approx(hooke(STEEL), abs=1e-3) == D
    in_plane, shear = sheet_matrices(AnisotropicMaterial("S", D, 1.0))
    assert in_plane == pytest.approx(sheet_matrices(STEEL)[0], rel=1e-12, abs=1e-3)
    assert np.diag(shear) == pytest.approx([g, g])


def test_constants_of_no_stable_material_are_refused():
    with pytest.raises(InputError, match="no stable material"):
        lamina(1e9, 100e9, 0.5, 1e9, 1e9, 1e9)


@EVERY
def test_bar_pulled_off_its_material_axes_has_the_young_modulus_of_that_direction(kind, measured):
    """Uniaxial stress along x, material turned by 30 degrees about z: 1/Ex = c^4/E1 + (1/G12 - 2 nu12/E1) c^2 s^2 + s^4/E2."""
    mesh = block((3, 2, 1), (3.0, 1.0, 1.0), kind)  # a straight row of hex20r keeps hourglass modes
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    own = Own(
        axis1=np.tile([c, s, 0.0], (len(mesh.elements), 1)), axis2=np.tile([0.0, 1.0, 0.1 * 0], (len(mesh.elements), 1))
    )
    K = mesh.assemble(mesh.module.stiffness(mesh.coords[mesh.elements], SolidSection("W", WOOD), own))
    strain = uniaxial_strain(own)
    exact = np.zeros((len(mesh.coords), 6))
    exact[:, :3] = mesh.coords @ strain
    ends = mesh.nodes(lambda x: np.isclose(x[:, 0], 0.0) | np.isclose(x[:, 0], 3.0))
    held = np.union1d(dof(ends, 1, 2, 3), dof(np.arange(len(mesh.coords)), 4, 5, 6))
    u = solve(K, np.zeros(mesh.n_dof), held, exact.ravel()[held])
    assert u == pytest.approx(exact.ravel(), abs=1e-9 * np.abs(exact).max())
    reaction = (K @ u).reshape(-1, 6)[mesh.nodes(lambda x: np.isclose(x[:, 0], 3.0)), 0].sum()
    modulus = 1 / (c**4 / E[0] + (1 / G[0] - 2 * NU[0] / E[0]) * c**2 * s**2 + s**4 / E[1])
    measured(
        f"bar off its material axes, {kind}: Young's modulus",
        reaction / 1e-3,
        modulus,
        rel=1e-9,
        unit="Pa",
        source="exact",
    )


def uniaxial_strain(own: Own) -> np.ndarray:
    """Strain tensor of a stress along x such that exx = 1e-3, from the rotated flexibility."""
    from creak.elements.solids.common import elasticity

    flexibility = np.linalg.inv(elasticity(WOOD, Own(own.axis1[:1], own.axis2[:1]))[0, 0])
    e = flexibility[:, 0] * 1e-3 / flexibility[0, 0]
    return np.array([[e[0], e[3] / 2, e[5] / 2], [e[3] / 2, e[1], e[4] / 2], [e[5] / 2, e[4] / 2, e[2]]])


@EVERY
def test_matrices_turn_with_element_and_material(kind):
    mesh = block((1, 1, 1), (1.0, 0.8, 0.6), kind)
    x, Q = mesh.coords[mesh.elements], random_rotation(4)
    axes = random_rotation(6)
    n = len(x)
    own = Own(axis1=np.tile(axes[0], (n, 1)), axis2=np.tile(axes[1], (n, 1)))
    turned = Own(axis1=own.axis1 @ Q.T, axis2=own.axis2 @ Q.T)
    T = np.kron(np.eye(2 * x.shape[1]), Q)
    expected = T @ mesh.module.stiffness(x, SolidSection("W", WOOD), own) @ T.T
    found = mesh.module.stiffness(x @ Q.T, SolidSection("W", WOOD), turned)
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
    for K, nodes in zip(found, x @ Q.T, strict=True):
        assert (
            np.abs(K @ rigid_modes(nodes)[:, :6] * np.tile([1, 1, 1, 0, 0, 0], len(nodes))[:, None]).max()
            < 1e-9 * K.max()
        )


def test_ten_node_tetrahedron_bends_one_element_through_the_thickness(measured):
    """Cantilever 10 x 1 x 1, unit end shear: P L^3/(3 E I) + P L/(5/6 G A); linear tetrahedra are half as flexible."""
    section = SolidSection("S", Material("S", 1e7, 0.3, 1.0))
    found = {}
    for kind in ("tet4", "tet10"):
        mesh = block((10, 1, 1), (10.0, 1.0, 1.0), kind)
        end = mesh.nodes(lambda x: np.isclose(x[:, 0], 10.0))
        force = np.zeros(mesh.n_dof)
        force[dof(end, 3)] = 1.0 / end.size
        clamped = dof(mesh.nodes(lambda x: np.isclose(x[:, 0], 0.0)), 1, 2, 3)
        held = np.union1d(clamped, dof(np.arange(len(mesh.coords)), 4, 5, 6))
        found[kind] = solve(mesh.stiffness(section), force, held)[dof(end, 3)].mean()
    exact = 1e3 * 12 / (3 * 1e7) + 10 / (5 / 6 * 1e7 / 2.6)
    measured(
        "cantilever of one layer of C3D10: tip deflection",
        found["tet10"],
        exact,
        rel=0.03,
        unit="m",
        source="Timoshenko",
    )
    assert found["tet4"] < 0.6 * exact


def test_ten_node_mass_is_exact_and_lumps_without_negative_masses():
    """Consistent mass of straight tetrahedra: V rho/420 (6 at corners, 32 between); HRZ gives positive shares."""
    mesh = block((1, 1, 1), (1.0, 0.8, 0.6), "tet10")
    M = mesh.module.mass(mesh.coords[mesh.elements], SolidSection("S", STEEL))
    weight = 7800.0 * 0.48 / 6
    assert M[:, 0, 0] == pytest.approx(weight * 6 / 420)
    assert M[:, 24, 24] == pytest.approx(weight * 32 / 420)
    assert M[:, ::6, ::6].sum(axis=(1, 2)) == pytest.approx(weight)
    diagonal = np.diagonal(lumped(M), axis1=1, axis2=2)[:, ::6]
    assert diagonal.min() > 0
    assert diagonal.sum(axis=1) == pytest.approx(weight)
