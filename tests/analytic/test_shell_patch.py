"""Patch tests of MacNeal and Harder, Finite Elem. Anal. Des. 1 (1985) 3: constant states are exact."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_fem import Mesh, dof, macneal_patch, random_rotation, rectangle, shell_section, solve

RECORDED = {"section": "shell statics", "source": "MacNeal, Harder 1985"}

EXACT = 1e-9
DRILLING_ERROR = 2e-2
"""The drilling penalty of the quad adds some gamma G L^2/(E h^2): 6e-3 at an aspect ratio of four."""
T, E, NU = 0.001, 1e6, 0.25
SECTION = shell_section(T, E, NU)
AREA = 0.24 * 0.12
BOUNDARY = np.arange(4)
kinds = pytest.mark.parametrize("kind", ["quad", "tri"])


def membrane_state(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    u = np.zeros((len(x), 6))
    u[:, 0], u[:, 1] = 1e-3 * (x + y / 2), 1e-3 * (y + x / 2)
    return u.ravel()


def bending_state(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    u = np.zeros((len(x), 6))
    u[:, 2] = 1e-3 * (x * x + x * y + y * y) / 2
    u[:, 3], u[:, 4] = 1e-3 * (x / 2 + y), -1e-3 * (x + y / 2)
    return u.ravel()


def interior_answer(mesh: Mesh, exact: np.ndarray) -> np.ndarray:
    held = dof(BOUNDARY, 1, 2, 3, 4, 5, 6)
    return solve(mesh.stiffness(SECTION, held), np.zeros(mesh.n_dof), held, exact[held])


def reactions_in(mesh: Mesh, u: np.ndarray, mode: np.ndarray) -> float:
    held = dof(BOUNDARY, 1, 2, 3, 4, 5, 6)
    return float(mode @ (mesh.stiffness(SECTION, held) @ u))


@kinds
@pytest.mark.parametrize("state", [membrane_state, bending_state])
def test_constant_strain_on_distorted_mesh_is_exact(kind, state, measured):
    mesh = macneal_patch(kind)
    exact = state(mesh.coords[:, 0], mesh.coords[:, 1])
    found = interior_answer(mesh, exact)
    error = np.abs(found - exact).max() / np.abs(exact).max()
    measured(
        f"{state.__name__.replace('_state', ' patch')}, {kind}: displacements inside, relative error",
        error,
        at_most=EXACT,
    )


@kinds
@pytest.mark.parametrize("state", [membrane_state, bending_state])
def test_patch_in_an_arbitrary_plane_is_exact(kind, state, measured):
    mesh = macneal_patch(kind)
    exact = state(mesh.coords[:, 0], mesh.coords[:, 1])
    turn = random_rotation(7)
    mesh.coords = mesh.coords @ turn.T
    exact = (exact.reshape(-1, 3) @ turn.T).ravel()
    found = interior_answer(mesh, exact)
    error = np.abs(found - exact).max() / np.abs(exact).max()
    measured(f"{state.__name__.replace('_state', ' patch')} in any plane, {kind}: relative error", error, at_most=EXACT)


@kinds
def test_membrane_stresses_of_the_patch(kind, measured):
    """Virtual work of each unit strain: stresses 1333, 1333 and 400."""
    mesh = macneal_patch(kind)
    x, y, _ = mesh.coords.T
    u = interior_answer(mesh, membrane_state(x, y))
    for unit, stress in (((x, 0 * x), 4000 / 3), ((0 * x, y), 4000 / 3), ((y / 2, x / 2), 400.0)):
        mode = np.zeros((8, 6))
        mode[:, 0], mode[:, 1] = unit
        found = reactions_in(mesh, u, mode.ravel()) / (T * AREA)
        measured(f"membrane patch: stress {stress:.0f}", found, stress, rel=EXACT, unit="Pa")


@kinds
def test_bending_moments_of_the_patch(kind, measured):
    """Virtual work of each unit curvature: Mx = My = 1.111e-7, Mxy = 3.333e-8."""
    mesh = macneal_patch(kind)
    x, y, _ = mesh.coords.T
    u = interior_answer(mesh, bending_state(x, y))
    modes = [
        (x * x / 2, 0 * x, -x, 1e-6 / 9),
        (y * y / 2, y, 0 * x, 1e-6 / 9),
        (x * y / 2, x / 2, -y / 2, 1e-7 / 3),
    ]
    for w, r_x, r_y, moment in modes:
        mode = np.zeros((8, 6))
        mode[:, 2], mode[:, 3], mode[:, 4] = w, r_x, r_y
        found = reactions_in(mesh, u, mode.ravel()) / AREA
        measured(f"bending patch: moment {moment:.3e}", found, moment, rel=EXACT, unit="N")


@pytest.mark.parametrize(("kind", "thickness"), [("quad", 1e4), ("tri", 1e4)])
def test_constant_transverse_shear_on_distorted_mesh_is_exact(kind, thickness, measured):
    """Rotations held, the edge deflected linearly: inner nodes follow, energy kappa G t gamma^2 A/2.

    Thin elements give way through their inner rotations, by (element size / t)^2; thick ones are exact.
    """
    mesh, section = macneal_patch(kind), shell_section(thickness, E, NU)
    x, y, _ = mesh.coords.T
    exact = np.zeros((8, 6))
    exact[:, 2] = 1e-3 * (x + 2 * y)
    held = np.union1d(dof(BOUNDARY, 1, 2, 3), dof(np.arange(8), 4, 5, 6))
    stiffness = mesh.stiffness(section)
    u = solve(stiffness, np.zeros(48), held, exact.ravel()[held])
    assert u == pytest.approx(exact.ravel(), abs=EXACT * np.abs(exact).max())
    expected = 5 / 6 * section.material.shear_modulus * thickness * 5e-6 * AREA
    measured(
        f"transverse shear patch, {kind}: energy over exact",
        u @ (stiffness @ u) / expected,
        1.0,
        rel=EXACT,
        source="exact",
    )


@kinds
def test_in_plane_bending_of_a_slender_rectangle_is_exact(kind, measured):
    """Energy ratio of Felippa (2003): one, whatever the aspect ratio."""
    for length in (0.5, 1.0, 4.0):
        mesh = rectangle(1, 1, length, 1.0, kind)
        x, y = mesh.coords[:, 0] - length / 2, mesh.coords[:, 1] - 0.5
        u = np.zeros((4, 6))
        u[:, 0], u[:, 1], u[:, 5] = -x * y, x * x / 2 + NU * y * y / 2, x
        energy = reactions_in(mesh, u.ravel(), u.ravel())
        ratio = energy / (E * T * length / 12)
        measured(
            f"one element bent in its plane, {kind}: energy ratio",
            ratio,
            1.0,
            rel=EXACT if kind == "tri" else DRILLING_ERROR,
            source="Felippa 2003",
        )
