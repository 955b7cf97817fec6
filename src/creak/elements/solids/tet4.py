"""Four-node tetrahedron with constant strain."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.solids.common import Reference, consistent_mass, isoparametric_stiffness
from creak.model.materials import SolidSection
from creak.model.mesh import COMMON, Own

SLOPES = np.array([[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 1.0]])
CENTRE = Reference(np.full((1, 3), 0.25), np.array([1.0 / 6.0]), np.full((1, 4), 0.25), SLOPES[None])


def _four_points() -> Reference:
    """Rule of degree two: Hammer and Stroud (1956)."""
    a, b = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
    shapes = np.full((4, 4), a) + (b - a) * np.eye(4)
    return Reference(shapes[:, 1:], np.full(4, 1.0 / 24.0), shapes, np.tile(SLOPES, (4, 1, 1)))


FOUR = _four_points()


def stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = V B' D B with constant strain.

    Much too stiff in bending (some ten elements through the thickness are needed) and locked in nearly
    incompressible material; use hexahedra where the answer depends on it. Source: Zienkiewicz and Taylor, The
    Finite Element Method, vol. 1 (2000), chapter 6.

    Nodes: the fourth node lies on the side to which 1-2-3 turn right-handed. The rotations have no stiffness.
    """
    return isoparametric_stiffness(coords, section, CENTRE, own)


def mass(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass rho V/20 (1 + delta_ij) on each translation."""
    return consistent_mass(coords, section, FOUR, own)
