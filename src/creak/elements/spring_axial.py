"""Spring and dashpot along the line between two nodes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, require_sound
from creak.elements.truss2 import TRANSLATIONS
from creak.model.materials import AxialSpring
from creak.model.mesh import COMMON, Own


def stiffness(coords: FloatArray, section: AxialSpring, own: Own = COMMON) -> FloatArray:
    """K = k [t t', -t t'; -t t', t t'] on the translations, t the unit vector from node 1 to node 2.

    The line is that of the undeformed model: a preload adds nothing.

    Parameters
    ----------
    coords : (n, 2, 3) global coordinates, length.
    section : stiffness in force / length.

    Returns
    -------
    (n, 12, 12), node by node (ux, uy, uz, rx, ry, rz) in global axes.

    Raises
    ------
    DegenerateElement : coincident nodes.
    """
    return section.stiffness * _pattern(coords)


def damping(coords: FloatArray, section: AxialSpring, own: Own = COMMON) -> FloatArray:
    """C of the dashpot, as `stiffness` with the damping coefficient."""
    return section.damping * _pattern(coords)


def mass(coords: FloatArray, section: AxialSpring, own: Own = COMMON) -> FloatArray:
    """Zero (n, 12, 12): a spring has no mass."""
    return np.zeros((coords.shape[0], 12, 12))


def _pattern(coords: FloatArray) -> FloatArray:
    require_sound(~(np.linalg.norm(coords[:, 1] - coords[:, 0], axis=1) > 0.0), "the two nodes coincide")

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        line = piece[:, 1] - piece[:, 0]
        both = np.concatenate([-line, line], axis=1) / np.linalg.norm(line, axis=1)[:, None]
        out = np.zeros((piece.shape[0], 12, 12))
        out[:, TRANSLATIONS[:, None], TRANSLATIONS] = both[:, :, None] * both[:, None, :]
        return out

    return in_chunks(kernel, coords, 12)
