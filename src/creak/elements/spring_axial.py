"""Spring and dashpot along the line between two nodes."""

from __future__ import annotations

from creak.arrays import FloatArray
from creak.elements.truss2 import along_line
from creak.model.materials import AxialSpring
from creak.model.mesh import COMMON, Own


def stiffness(coords: FloatArray, section: AxialSpring, own: Own = COMMON) -> FloatArray:
    """K = k [t t', -t t'; -t t', t t'] on the translations, t the unit vector from node 1 to node 2.

    The line is that of the undeformed model: a preload adds nothing.
    """
    return section.stiffness * along_line(coords)


def damping(coords: FloatArray, section: AxialSpring, own: Own = COMMON) -> FloatArray:
    """C of the dashpot, as `stiffness` with the damping coefficient."""
    return section.damping * along_line(coords)
