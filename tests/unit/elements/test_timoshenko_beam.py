"""Timoshenko beam, sections off the line of the nodes, rigid arms, lumped mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

from creak.elements import beam2
from creak.elements.block_matrices import block_matrices, lumped
from creak.model.materials import BeamSection, Material
from creak.model.mesh import ElementBlock, Own
from helpers_fem import Mesh, dof, random_rotation, rigid_modes

RECORDED = {"section": "beams and solids"}

STEEL = Material("STEEL", 2e11, 0.3, 7800.0)
PLAIN = BeamSection("B", STEEL, 2e-3, 3e-7, 8e-7, 5e-7, (0.0, 1.0, 0.0))
THICK = BeamSection(
    "T",
    STEEL,
    0.02,
    0.2 * 0.1**3 / 12,
    0.1 * 0.2**3 / 12,
    4e-5,
    (0.0, 1.0, 0.0),
    shear_area1=0.02 * 5 / 6,
    shear_area2=0.02 * 5 / 6,
)
ODD = replace(THICK, centroid=(0.03, -0.02), shear_centre=(-0.01, 0.04), angle=0.4)


def line(n: int, length: float, direction=(1.0, 0.0, 0.0)) -> Mesh:
    coords = np.linspace(0, length, n + 1)[:, None] * np.array(direction)
    return Mesh(coords, np.column_stack([np.arange(n), np.arange(1, n + 1)]), beam2)


def modes(mesh: Mesh, section: BeamSection, held: np.ndarray) -> np.ndarray:
    """Angular frequencies."""
    free = np.setdiff1d(np.arange(mesh.n_dof), held)
    K, M = (A.toarray()[np.ix_(free, free)] for A in (mesh.stiffness(section), mesh.mass(section)))
    return np.sqrt(np.maximum(scipy.linalg.eigh(K, M, eigvals_only=True), 0.0))


def test_tip_load_bends_and_shears(measured):
    """P L^3/(3 E I) + P L/(G A_s), exact with one element."""
    K = line(1, 0.5).stiffness(THICK).toarray()[6:, 6:]
    G = STEEL.shear_modulus
    for axis, second in ((1, THICK.i22), (2, THICK.i11)):
        force = np.zeros(6)
        force[axis] = 1.0
        expected = 0.5**3 / (3 * 2e11 * second) + 0.5 / (G * 0.02 * 5 / 6)
        measured(
            f"short beam: tip deflection along axis {axis}",
            np.linalg.solve(K, force)[axis],
            expected,
            rel=1e-10,
            unit="m",
            source="Timoshenko",
        )


def timoshenko_cantilever(section: BeamSection, length: float, guess: float) -> float:
    """Root near `guess` of the frequency equation (Huang, J. Appl. Mech. 28 (1961) 579) via the state matrix."""
    E, G, rho = 2e11, STEEL.shear_modulus, 7800.0
    EI, GA = E * section.i22, G * section.shear_area1

    def closed(w: float) -> float:
        # state (w, theta, M, V): w' = theta + V/GA, theta' = M/EI, M' = -V - rho I w^2 theta, V' = -rho A w^2 w
        S = np.array(
            [
                [0, 1, 0, 1 / GA],
                [0, 0, 1 / EI, 0],
                [0, -rho * section.i22 * w * w, 0, -1],
                [-rho * 0.02 * w * w, 0, 0, 0],
            ]
        )
        end = scipy.linalg.expm(S * length)
        return float(np.linalg.det(end[2:, 2:]))

    return float(scipy.optimize.brentq(closed, 0.9 * guess, 1.1 * guess, xtol=1e-9 * guess))


def test_short_cantilever_vibrates_as_timoshenko_says(measured):
    """Second mode, L/h = 5; static shapes lack the shear of the inertia inside an element: error 0.14/n^2, here 9e-5."""
    found = modes(line(40, 1.0), THICK, np.arange(6))
    mode_in_1 = min(found, key=lambda w: abs(w - 6350.0))
    exact = timoshenko_cantilever(THICK, 1.0, mode_in_1)
    measured(
        "short cantilever, L/h = 5: second mode",
        mode_in_1,
        exact,
        rel=1.5e-4,
        unit="rad/s",
        source="Timoshenko; Huang 1961",
    )
    euler = 4.694091**2 * np.sqrt(2e11 * THICK.i22 / (7800 * 0.02))
    assert exact < 0.9 * euler


def test_no_shear_area_is_the_euler_bernoulli_beam():
    stiff = replace(THICK, shear_area1=1e9, shear_area2=1e9)
    rigid = replace(THICK, shear_area1=0.0, shear_area2=0.0)
    x = line(1, 0.7).coords[None]
    expected = beam2.stiffness(x, rigid)
    assert beam2.stiffness(x, stiff) == pytest.approx(expected, abs=1e-9 * expected.max())


def test_odd_section_is_strain_free_in_rigid_motion():
    mesh = line(2, 2.0, random_rotation(2)[0])
    K = mesh.stiffness(ODD).toarray()
    assert np.abs(K @ rigid_modes(mesh.coords)).max() < 1e-11 * np.abs(K).max()
    energy = np.linalg.eigvalsh(K)
    assert np.abs(energy[:6]).max() < 1e-11 * energy[-1] < 1e-3 * energy[6]


def test_mass_of_an_off_centre_section_is_that_of_the_body():
    mesh = line(5, 2.0)
    R, M = rigid_modes(mesh.coords), mesh.mass(ODD).toarray()
    body, m = R.T @ M @ R, 7800.0 * 0.02 * 2.0
    assert body[:3, :3] == pytest.approx(m * np.eye(3), abs=1e-10 * m)
    y, z = 0.03, -0.02  # axis 1 is y, axis 2 is z
    assert (body[0, 4], body[0, 5]) == pytest.approx((m * z, -m * y), rel=1e-9)
    polar = 7800.0 * (ODD.i11 + ODD.i22) * 2.0
    assert body[3, 3] == pytest.approx(polar + m * (y * y + z * z), rel=1e-9)


def test_offset_centroid_and_rigid_arms_agree():
    """Centroid and shear centre moved by (c1, c2), or the nodes' ends moved there by arms."""
    c = (0.03, -0.02)
    x = np.array([[[0.1, 0, 0], [0.9, 0.2, -0.3]]])
    section = replace(THICK, axis1=(0.3, 1.0, 0.2))
    line = x[0, 1] - x[0, 0]
    t = line / np.linalg.norm(line)
    n2 = np.cross(t, section.axis1)
    n2 /= np.linalg.norm(n2)
    arm = c[0] * np.cross(n2, t) + c[1] * n2
    own = Own(arms=np.tile(arm, (1, 2, 1)))
    block = ElementBlock("beam2", np.array([1]), np.array([[0, 1]]), section, 0, own=own)
    moved = block_matrices(block, slice(None), x[0])
    shifted = replace(section, centroid=c, shear_centre=c)
    for found, made in zip(moved, (beam2.stiffness, beam2.mass), strict=False):
        expected = made(x, shifted)
        assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def test_offset_cantilever_bends_about_its_own_centroid():
    """Clamping the whole section: where the nodes lie does not change the bending modes of the beam."""
    middle = modes(line(20, 2.0), replace(PLAIN, angle=0.0), np.arange(6))[:2]
    off = modes(line(20, 2.0), replace(PLAIN, centroid=(0.0, 0.05), shear_centre=(0.0, 0.05)), np.arange(6))[:2]
    assert off == pytest.approx(middle, rel=1e-6)


def test_axis_of_each_element_replaces_that_of_the_section():
    x = np.tile(line(1, 1.0).coords, (2, 1, 1))
    own = Own(axis1=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    K = beam2.stiffness(x, replace(PLAIN, axis1=(0.0, 1.0, 1.0)), own)
    assert K[0, 1, 1] == pytest.approx(12 * 2e11 * PLAIN.i22)
    assert K[1, 2, 2] == pytest.approx(12 * 2e11 * PLAIN.i22)
    assert K[1, 1, 1] == pytest.approx(12 * 2e11 * PLAIN.i11)


def test_principal_angle_turns_the_section():
    x = line(1, 1.0).coords[None]
    turned = replace(PLAIN, angle=0.5)
    same = replace(PLAIN, axis1=(0.0, float(np.cos(0.5)), float(np.sin(0.5))))
    expected = beam2.stiffness(x, same)
    assert beam2.stiffness(x, turned) == pytest.approx(expected, abs=1e-12 * expected.max())


def test_lumped_mass_keeps_mass_and_centre_and_converges(measured):
    x = line(1, 2.0).coords[None]
    M = lumped(beam2.mass(x, PLAIN))[0]
    m = 7800.0 * 2e-3 * 2.0
    assert np.diag(M)[:6] == pytest.approx([m / 2] * 3 + [0] * 3)
    mesh = line(40, 2.0)
    K, M = (
        mesh.stiffness(PLAIN).toarray(),
        mesh.assemble(lumped(beam2.mass(mesh.coords[mesh.elements], PLAIN))).toarray(),
    )
    free = np.setdiff1d(np.arange(mesh.n_dof), dof(0, 1, 2, 3, 4, 5, 6))
    flexibility = np.linalg.inv(K[np.ix_(free, free)])
    w2 = 1 / np.linalg.eigvals(flexibility @ M[np.ix_(free, free)]).real.max()
    exact = 1.875104**4 * 2e11 * 3e-7 / (7800 * 2e-3 * 16)
    measured(
        "cantilever of 40 elements, lumped mass: omega^2", w2, exact, rel=2e-3, unit="rad2/s2", source="Euler-Bernoulli"
    )
