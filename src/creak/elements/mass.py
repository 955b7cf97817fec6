"""Concentrated mass and rotary inertia at one node."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.bushing import arm_matrix
from creak.model.materials import PointMass
from creak.model.mesh import COMMON, Own


def mass(coords: FloatArray, section: PointMass, own: Own = COMMON) -> FloatArray:
    """M = T' diag(m I, J) T with J = [Ixx Ixy Ixz; Ixy Iyy Iyz; Ixz Iyz Izz] and T the rigid arm to the mass.

    The six values are the entries of the inertia tensor itself, so Ixy = -(integral of x y dm).
    """
    ixx, iyy, izz, ixy, ixz, iyz = section.inertia
    one = np.zeros((6, 6))
    one[:3, :3] = section.mass * np.eye(3)
    one[3:, 3:] = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if any(section.offset):
        arm = arm_matrix(np.array([section.offset]))[0]
        one = arm.T @ one @ arm
    return np.tile(one, (coords.shape[0], 1, 1))
