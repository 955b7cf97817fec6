"""Given matrices on the dofs of one or more nodes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.model.materials import NodalMatrices
from creak.model.mesh import COMMON, Own


def stiffness(coords: FloatArray, section: NodalMatrices, own: Own = COMMON) -> FloatArray:
    """The section's stiffness for each element, (n, d, d) with d = 6 n_node."""
    return np.tile(section.stiffness, (coords.shape[0], 1, 1))


def damping(coords: FloatArray, section: NodalMatrices, own: Own = COMMON) -> FloatArray:
    """The section's damping for each element, (n, d, d)."""
    return np.tile(section.damping, (coords.shape[0], 1, 1))


def mass(coords: FloatArray, section: NodalMatrices, own: Own = COMMON) -> FloatArray:
    """The section's mass for each element, (n, d, d)."""
    return np.tile(section.mass, (coords.shape[0], 1, 1))
