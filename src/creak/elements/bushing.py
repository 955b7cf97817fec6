"""Springs and dashpots in all six relative motions of two nodes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, material_frames
from creak.model.materials import Bushing
from creak.model.mesh import COMMON, Own


def stiffness(coords: FloatArray, section: Bushing, own: Own = COMMON) -> FloatArray:
    """K = G' k G with G (u, theta) = the relative motion of b and a at the point p = x_a + location (x_b - x_a).

    d = R (u_b + theta_b x (p - x_b) - u_a - theta_a x (p - x_a)),   r = R (theta_b - theta_a), rows of R the
    axes of the element. Rigid arms bridge what lies between the nodes and p, so rigid motion costs no energy
    wherever the nodes are. One node: a is ground, at the node.
    """
    return _congruent(coords, section.stiffness, section.location, own)


def damping(coords: FloatArray, section: Bushing, own: Own = COMMON) -> FloatArray:
    """C = G' c G, as `stiffness`."""
    return _congruent(coords, section.damping, section.location, own)


def _congruent(coords: FloatArray, matrix: FloatArray, location: float, own: Own) -> FloatArray:
    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        frame = material_frames(mine, len(piece))
        point = piece[:, 0] + location * (piece[:, -1] - piece[:, 0])
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
