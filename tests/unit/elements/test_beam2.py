"""Euler-Bernoulli beam: statics, local axes, frequencies."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from creak.elements import beam2
from creak.elements.geometry import DegenerateElement
from creak.model.materials import BeamSection, Material
from helpers_fem import Mesh, dof, random_rotation, rigid_modes

RECORDED = {"section": "beams and solids", "source": "Euler-Bernoulli"}

STEEL = Material("STEEL", 2e11, 0.3, 7800.0)
SECTION = BeamSection("B", STEEL, area=2e-3, i11=3e-7, i22=8e-7, torsion=5e-7, axis1=(0.0, 1.0, 0.0))


def line(n: int, length: float, direction=(1.0, 0.0, 0.0)) -> Mesh:
    coords = np.linspace(0, length, n + 1)[:, None] * np.array(direction)
    return Mesh(coords, np.column_stack([np.arange(n), np.arange(1, n + 1)]), beam2)


def tip_displacement(section: BeamSection, force_dof: int) -> np.ndarray:
    stiffness = line(1, 2.0).stiffness(section).toarray()
    force = np.zeros(6)
    force[force_dof - 1] = 1.0
    return np.linalg.solve(stiffness[6:, 6:], force)


def test_tip_load_bends_about_the_axis_of_its_second_moment(measured):
    """Axis 1 is y: i22 about n2 = z resists deflection along y, i11 about y deflection along z."""
    rigidity = 2e11
    along_y, along_z = tip_displacement(SECTION, 2), tip_displacement(SECTION, 3)
    assert along_z[2] == pytest.approx(8 / (3 * rigidity * 3e-7), rel=1e-10)
    assert along_z[4] == pytest.approx(-4 / (2 * rigidity * 3e-7), rel=1e-10)
    measured("beam: tip deflection", along_y[1], 8 / (3 * rigidity * 8e-7), rel=1e-10, unit="m")
    measured("beam: tip rotation", along_y[5], 4 / (2 * rigidity * 8e-7), rel=1e-10, unit="rad")


def test_extension_and_torsion_follow_their_rigidities():
    assert tip_displacement(SECTION, 1)[0] == pytest.approx(2 / (2e11 * 2e-3), rel=1e-12)
    assert tip_displacement(SECTION, 4)[3] == pytest.approx(2 / (STEEL.shear_modulus * 5e-7), rel=1e-12)


def test_axis_1_is_made_perpendicular_to_the_beam():
    skew = BeamSection("B", STEEL, 2e-3, 3e-7, 8e-7, 5e-7, axis1=(4.0, 2.0, 0.0))
    coords = line(1, 2.0).coords[None]
    expected = beam2.stiffness(coords, SECTION)
    assert beam2.stiffness(coords, skew) == pytest.approx(expected, abs=1e-12 * expected.max())


def test_rigid_body_motion_is_strain_free_and_six_modes_only():
    mesh = line(3, 2.0, random_rotation(2)[0])
    stiffness = mesh.stiffness(SECTION).toarray()
    assert abs(stiffness @ rigid_modes(mesh.coords)).max() < 1e-12 * stiffness.max()
    energy = np.linalg.eigvalsh(stiffness)
    assert abs(energy[:6]).max() < 1e-12 * energy[-1] < 1e-3 * energy[6]


@pytest.mark.parametrize("held", ["cantilever", "free"])
def test_bending_frequencies_follow_euler_bernoulli(held, measured):
    """beta L of the closed form; twenty Hermite elements are within (beta h)^4/1440 of it, below 1e-4."""
    mesh, length = line(20, 2.0), 2.0
    stiffness, mass = mesh.stiffness(SECTION).toarray(), mesh.mass(SECTION).toarray()
    in_plane = dof(np.arange(21), 3, 5)
    if held == "cantilever":
        in_plane, beta_l = in_plane[2:], np.array([1.875104, 4.694091, 7.854757])
    else:
        beta_l = np.array([4.730041, 7.853205, 10.995608])
    lam = scipy.linalg.eigvalsh(stiffness[np.ix_(in_plane, in_plane)], mass[np.ix_(in_plane, in_plane)])
    if held == "free":
        assert abs(lam[:2]).max() < 1e-6 * lam[2]
        lam = lam[2:]
    exact = (beta_l / length) ** 2 * np.sqrt(2e11 * 3e-7 / (7800 * 2e-3))
    measured(
        f"{held} beam of 20 elements: beta L, mode {{}}", beta_l * np.sqrt(np.sqrt(lam[:3]) / exact), beta_l, rel=0.5e-4
    )
    assert np.all(np.sqrt(lam[:3]) > exact * (1 - 1e-6))


def test_mass_matrix_carries_mass_and_inertia():
    mesh = line(4, 2.0)
    modes = rigid_modes(mesh.coords - np.array([1.0, 0, 0]))
    got = np.diag(modes.T @ (mesh.mass(SECTION) @ modes))
    total = 7800 * 2e-3 * 2.0
    expected = [total, total, total, 7800 * 11e-7 * 2.0, total * 4 / 12, total * 4 / 12]
    assert got == pytest.approx(expected, rel=1e-12)


def test_axis_1_parallel_to_the_beam_is_refused():
    coords = np.stack([line(1, 2.0).coords, line(1, 2.0, (0.0, 1.0, 0.0)).coords])
    with pytest.raises(DegenerateElement, match="axis 1") as caught:
        beam2.stiffness(coords, SECTION)
    assert caught.value.rows.tolist() == [1]


def test_coincident_nodes_are_refused():
    with pytest.raises(DegenerateElement, match="coincide"):
        beam2.mass(np.zeros((1, 2, 3)), SECTION)
