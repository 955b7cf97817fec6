"""Six-node wedge."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_triangle
from creak.elements.solids.common import Reference, consistent_mass, isoparametric_stiffness
from creak.model.materials import SolidSection
from creak.model.mesh import COMMON, Own


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """h = L_i (1 -+ t)/2 with the area coordinates L = (1 - r - s, r, s) at the points (n_point, 3)."""
    r, s, t = points.T
    area = np.stack([1.0 - r - s, r, s], axis=1)
    low, high = 0.5 * (1.0 - t)[:, None], 0.5 * (1.0 + t)[:, None]
    by_plane = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    in_plane = [np.concatenate([low * row, high * row], axis=1) for row in by_plane]
    slopes = np.stack([*in_plane, np.concatenate([-0.5 * area, 0.5 * area], axis=1)], axis=1)
    return Reference(points, weights, np.concatenate([low * area, high * area], axis=1), slopes)


def _rule() -> Reference:
    """Six points in the triangle times two along the axis."""
    plane, weight = gauss_triangle()
    t = np.repeat([-1.0, 1.0], len(plane)) / np.sqrt(3.0)
    return reference(np.column_stack([np.tile(plane, (2, 1)), t]), np.tile(0.5 * weight, 2))


GAUSS = _rule()


def stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = integral of B' D B of the displacements L_i (1 -+ t)/2.

    A fill-in element: like the tetrahedron it is too stiff in bending and in nearly incompressible material.
    Source: Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (2000), chapter 8.

    Nodes: the triangle 1-2-3, then the nodes opposite them. The rotations have no stiffness.
    """
    return isoparametric_stiffness(coords, section, GAUSS, own)


def mass(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass, see `consistent_mass`."""
    return consistent_mass(coords, section, GAUSS, own)
