"""Elements without a body: springs and dashpots, concentrated masses, given matrices.

Where an element has several matrices, `of` names the field of its section that makes one.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.bushing import arm_matrix
from creak.elements.truss2 import along_line
from creak.model.materials import AxialSpring, NodalMatrices, PointMass, Spring
from creak.model.mesh import COMMON, Own


def spring(coords: FloatArray, section: Spring, own: Own = COMMON, *, of: str = "stiffness") -> FloatArray:
    """K = k g g', C = c g g' with g u = u2[dof2] - u1[dof1] for two nodes and u1[dof1] for one.

    The dofs are global axes and the nodes need not coincide: a two-node spring between nodes that are apart
    (or between different dofs) puts a moment on the model under rigid rotation.
    """
    n, n_node, _ = coords.shape
    gap = np.zeros(6 * n_node)
    if n_node == 1:
        gap[section.dof1 - 1] = 1.0
    else:
        gap[section.dof1 - 1] -= 1.0
        gap[6 + section.dof2 - 1] += 1.0
    return getattr(section, of) * np.tile(np.outer(gap, gap), (n, 1, 1))


def axial(coords: FloatArray, section: AxialSpring, own: Own = COMMON, *, of: str = "stiffness") -> FloatArray:
    """K = k [t t', -t t'; -t t', t t'] on the translations, t the unit vector from node 1 to node 2; C with c.

    The line is that of the undeformed model: a preload adds nothing.
    """
    return getattr(section, of) * along_line(coords)


def given(coords: FloatArray, section: NodalMatrices, own: Own = COMMON, *, of: str = "stiffness") -> FloatArray:
    """The section's matrix on the dofs of one or more nodes, for each element (n, d, d) with d = 6 n_node."""
    return np.tile(getattr(section, of), (coords.shape[0], 1, 1))


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
