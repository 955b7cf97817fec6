"""Bushings, axial springs, given matrices and offset masses."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements import discrete
from creak.elements.geometry import DegenerateElement
from creak.elements.registry import FORMULATIONS
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, PointMass
from creak.model.mesh import COMMON, Own
from helpers_fem import random_rotation, rigid_modes

K6 = np.diag([1e3, 2e3, 3e3, 40.0, 50.0, 60.0])
SECTION = Bushing("B", K6, 0.01 * K6)


@pytest.mark.parametrize("location", [0.0, 0.5, 1.0])
def test_rigid_motion_costs_a_bushing_nothing_wherever_its_nodes_are(location):
    x = np.random.default_rng(0).standard_normal((3, 2, 3))
    axes = random_rotation(5)
    own = Own(axis1=np.tile(axes[0], (3, 1)), axis2=np.tile(axes[1], (3, 1)))
    for K, nodes in zip(discrete.bushing(x, Bushing("B", K6, K6, location), own), x, strict=True):
        assert np.abs(K @ rigid_modes(nodes)).max() < 1e-12 * np.abs(K).max()
        assert np.linalg.eigvalsh(K)[-6:].min() > 0


def test_bushing_acts_along_its_own_axes():
    x = np.zeros((1, 2, 3))
    own = Own(axis1=np.array([[0.0, 2.0, 0.0]]), axis2=np.array([[0.0, 1.0, 3.0]]))
    K = discrete.bushing(x, SECTION, own)[0]
    assert np.diag(K)[:6] == pytest.approx([3e3, 1e3, 2e3, 60.0, 40.0, 50.0])
    assert K[6:, :6] == pytest.approx(-K[:6, :6])
    assert discrete.bushing(x, SECTION, own, of="damping")[0] == pytest.approx(0.01 * K)
    assert not FORMULATIONS["bush2"].mass(x, SECTION, COMMON).any()


def test_arm_of_the_first_node_carries_the_moment():
    """Axes that turn with node a see the motion at b, at distance L along x: turning a by theta shears by L theta."""
    x = np.array([[[0.0, 0, 0], [0.5, 0, 0]]])
    K = discrete.bushing(x, SECTION)[0]
    u = np.zeros(12)
    u[5] = 1e-3
    assert u @ K @ u == pytest.approx((2e3 * 0.5**2 + 60.0) * 1e-6)


def test_grounded_bushing():
    assert discrete.bushing(np.zeros((2, 1, 3)), SECTION)[1] == pytest.approx(K6)


def test_parallel_axes_are_refused():
    own = Own(axis1=np.array([[1.0, 0.0, 0.0]]), axis2=np.array([[2.0, 0.0, 0.0]]))
    with pytest.raises(DegenerateElement, match="parallel"):
        discrete.bushing(np.zeros((1, 2, 3)), SECTION, own)


def test_axial_spring_resists_elongation_only():
    x = np.array([[[0.0, 0, 0], [3.0, 4.0, 0]]])
    K = discrete.axial(x, AxialSpring("A", 5.0, 2.0))[0]
    u = np.zeros(12)
    u[6:9] = [0.6, 0.8, 7.0]
    assert u @ K @ u == pytest.approx(5.0)
    assert u @ discrete.axial(x, AxialSpring("A", 5.0, 2.0), of="damping")[0] @ u == pytest.approx(2.0)
    assert np.abs(K @ rigid_modes(x[0])).max() < 1e-12
    with pytest.raises(DegenerateElement, match="coincide"):
        discrete.axial(np.zeros((1, 2, 3)), AxialSpring("A", 5.0))


def test_given_matrices_are_taken_as_they_are():
    A = np.arange(36.0).reshape(6, 6)
    section = NodalMatrices("N", A, 2 * A, 3 * A)
    x = np.zeros((2, 1, 3))
    assert discrete.given(x, section, of="stiffness")[1] == pytest.approx(A)
    assert discrete.given(x, section, of="mass")[0] == pytest.approx(2 * A)
    assert discrete.given(x, section, of="damping")[0] == pytest.approx(3 * A)


def test_mass_beside_its_node_has_its_static_moment_and_steiner_inertia():
    section = PointMass("M", 2.0, (0.1, 0.2, 0.3, 0.0, 0.0, 0.0), offset=(0.0, 0.0, 0.5))
    M = discrete.mass(np.zeros((1, 1, 3)), section)[0]
    assert np.diag(M) == pytest.approx([2, 2, 2, 0.1 + 0.5, 0.2 + 0.5, 0.3])
    assert (M[0, 4], M[1, 3]) == pytest.approx((1.0, -1.0))
