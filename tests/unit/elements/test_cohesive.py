"""Cohesive layers: rigid motion separates nothing, uniform separations have their energy, mass, bad elements."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements import cohesive
from creak.elements.geometry import DegenerateElement
from creak.model.materials import AnisotropicMaterial, SolidSection
from helpers_fem import random_rotation, rigid_modes

RECORDED = {"section": "beams and solids"}

K_N, K_S, K_T = 700.0, 300.0, 200.0
D = np.zeros((6, 6))
D[[2, 5, 4], [2, 5, 4]] = K_N, K_S, K_T
LAYER = SolidSection("L", AnisotropicMaterial("GLUE", D, 0.5))
FACES = {
    3: np.array([[0.0, 0.0, 0.0], [2.0, 0.2, 0.0], [0.5, 1.5, 0.0]]),
    4: np.array([[0.0, 0.0, 0.0], [2.0, 0.2, 0.0], [1.8, 1.5, 0.0], [-0.2, 1.0, 0.0]]),
}
sizes = pytest.mark.parametrize("k", [3, 4])


def layer(k: int, height: float, warp: float = 0.0) -> np.ndarray:
    bottom = FACES[k].copy()
    bottom[0, 2] += warp
    return np.concatenate([bottom, bottom + [0.1 * height, -0.2 * height, height]])[None]


def area(k: int) -> float:
    x = FACES[k]
    return 0.5 * float(np.linalg.norm(np.cross(x[2] - x[0], x[-1] - x[1])) if k == 4 else np.cross(*(x[1:] - x[0]))[2])


@sizes
@pytest.mark.parametrize("height", [0.0, 0.3])
def test_rigid_motion_separates_nothing(k, height):
    coords = layer(k, height, warp=0.2) @ random_rotation(2).T
    K = cohesive.stiffness(coords, LAYER)[0]
    assert np.abs(K @ rigid_modes(coords[0])).max() < 1e-12 * np.abs(K).max()
    assert np.linalg.eigvalsh(K)[0] > -1e-12 * np.abs(K).max()


@sizes
@pytest.mark.parametrize("height", [0.0, 0.3])
@pytest.mark.parametrize(("direction", "stiffness"), [(0, K_S), (1, K_T), (2, K_N)])
def test_uniform_separation_has_its_energy(k, height, direction, stiffness, measured):
    """k delta^2 A, along the face towards global x, across that, and along the normal."""
    coords = layer(k, height)
    u = np.zeros((2 * k, 6))
    u[k:, direction] = 1e-3
    found = u.ravel() @ cohesive.stiffness(coords, LAYER)[0] @ u.ravel()
    name = f"cohesive layer of {2 * k} nodes: energy of a uniform separation"
    source = "k delta^2 A"
    measured(name, found, stiffness * 1e-6 * area(k), rel=1e-12, unit="J", source=source)


@sizes
def test_a_layer_without_thickness_turns_with_its_faces(k):
    """One face turned against the other opens it linearly: the moment is that of k x over the area."""
    coords = layer(k, 0.0)
    u = np.zeros((2 * k, 6))
    u[k:, 2] = 1e-3 * coords[0, k:, 0]
    force = (cohesive.stiffness(coords, LAYER)[0] @ u.ravel()).reshape(-1, 6)
    x = FACES[k][:, 0]
    triangles = [(0, 1, 2)] if k == 3 else [(0, 1, 2), (0, 2, 3)]
    second = sum(
        0.5
        * np.cross(FACES[k][j] - FACES[k][i], FACES[k][m] - FACES[k][i])[2]
        * (x[i] ** 2 + x[j] ** 2 + x[m] ** 2 + (x[i] + x[j] + x[m]) ** 2)
        / 12.0
        for i, j, m in triangles
    )
    assert force[k:, 2] @ x == pytest.approx(K_N * 1e-3 * second, rel=1e-12 if k == 3 else 1e-3)
    assert force.sum(axis=0)[:3] == pytest.approx(0.0, abs=1e-12)


@sizes
def test_mass(k):
    M = cohesive.mass(layer(k, 0.3), LAYER)[0]
    for dof in range(3):
        one = np.zeros((2 * k, 6))
        one[:, dof] = 1.0
        assert one.ravel() @ M @ one.ravel() == pytest.approx(0.5 * area(k), rel=1e-12)


def test_a_face_without_area_is_named():
    coords = np.concatenate([layer(4, 0.1), np.zeros((1, 8, 3))])
    with pytest.raises(DegenerateElement, match=r"no area \(rows 1 of the block\)"):
        cohesive.stiffness(coords, LAYER)
