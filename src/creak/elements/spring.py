"""Spring and dashpot between two dofs, or from one dof to ground."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.model.materials import Spring
from creak.model.mesh import COMMON, Own


def stiffness(coords: FloatArray, section: Spring, own: Own = COMMON) -> FloatArray:
    """K = k g g', with g u = u2[dof2] - u1[dof1] for two nodes and u1[dof1] for one.

    The dofs are global axes and the nodes need not coincide: a two-node spring between nodes that are apart
    (or between different dofs) puts a moment on the model under rigid rotation.
    """
    return section.stiffness * _pattern(coords, section)


def damping(coords: FloatArray, section: Spring, own: Own = COMMON) -> FloatArray:
    """C = c g g' of the dashpot, same shape and same g as `stiffness`."""
    return section.damping * _pattern(coords, section)


def _pattern(coords: FloatArray, section: Spring) -> FloatArray:
    """g g' (n, d, d)."""
    n, n_node, _ = coords.shape
    gap = np.zeros(6 * n_node)
    if n_node == 1:
        gap[section.dof1 - 1] = 1.0
    else:
        gap[section.dof1 - 1] -= 1.0
        gap[6 + section.dof2 - 1] += 1.0
    return np.tile(np.outer(gap, gap), (n, 1, 1))
