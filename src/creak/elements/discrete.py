"""Elements without a body: springs, dashpots and bushings, concentrated masses, given matrices.

Where an element has several matrices, `of` names the field of its section that makes one.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, material_frames
from creak.elements.truss2 import along_line
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, PointMass, Spring
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


def bushing(coords: FloatArray, section: Bushing, own: Own = COMMON, *, of: str = "stiffness") -> FloatArray:
    """K = G' k G, and C with c, G (u, theta) the relative motion of b and a at p = x_a + location (x_b - x_a).

    d = R (u_b + theta_b x (p - x_b) - u_a - theta_a x (p - x_a)),   r = R (theta_b - theta_a), rows of R the
    axes of the element. Rigid arms bridge what lies between the nodes and p, so rigid motion costs no energy
    wherever the nodes are. One node: a is ground, at the node.
    """
    matrix = getattr(section, of)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        frame = material_frames(mine, len(piece))
        point = piece[:, 0] + section.location * (piece[:, -1] - piece[:, 0])
        signs = (1.0,) if piece.shape[1] == 1 else (-1.0, 1.0)
        G = np.concatenate([s * arm_matrix(point - piece[:, i]) for i, s in enumerate(signs)], axis=2)
        turned = np.concatenate([frame @ G[:, :3], frame @ G[:, 3:]], axis=1)
        return np.asarray(turned.transpose(0, 2, 1) @ matrix @ turned, dtype=np.float64)

    return in_chunks(kernel, coords, 6 * coords.shape[1], own)


def arm_matrix(arm: FloatArray) -> FloatArray:
    """(n, 6, 6): motion at the end of rigid arms (n, 3), u + theta x arm and theta."""
    out = np.tile(np.eye(6), (len(arm), 1, 1))
    out[:, :3, 3:] = np.cross(np.eye(3), arm[:, None, :]).transpose(0, 2, 1)
    return out


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
