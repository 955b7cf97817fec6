"""Two-node Euler-Bernoulli beam in space."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, require_sound, rotate_to_global, unit
from creak.model.materials import BeamSection

AXIAL, TWIST = np.array([0, 6]), np.array([3, 9])
ALONG_1, ALONG_2 = np.array([1, 5, 7, 11]), np.array([2, 4, 8, 10])
"""(deflection, rotation) of both ends: deflection along n1 turns about n2, along n2 about -n1."""
SIGN_2 = np.array([1.0, -1.0, 1.0, -1.0])
PARALLEL = 1e-6


def stiffness(coords: FloatArray, section: BeamSection) -> FloatArray:
    """Stiffness of straight prismatic beams: EA/L, GJ/L and the cubic (Hermite) bending stiffness.

    Local axes are the tangent t from node 1 to node 2, n1 = the section's axis 1 made perpendicular to t,
    and n2 = t x n1. i11 resists bending about n1 (deflection along n2), i22 bending about n2.

    No transverse shear: use shells or solids below some ten depths of length. The section's centroid and
    shear centre lie on the line between the nodes. Source: Przemieniecki, Theory of Matrix Structural
    Analysis (1968), chapter 5, without the shear terms.

    Parameters
    ----------
    coords : (n, 2, 3) global coordinates, length.
    section : area, second moments, torsion constant, axis 1 and material.

    Returns
    -------
    (n, 12, 12), node by node (ux, uy, uz, rx, ry, rz) in global axes.

    Raises
    ------
    DegenerateElement : coincident nodes, or axis 1 parallel to the beam.
    """
    _require_sound(coords, section)
    young, shear = section.material.youngs_modulus, section.material.shear_modulus

    def kernel(piece: FloatArray) -> FloatArray:
        length, frame = _line(piece, section)
        local = np.zeros((piece.shape[0], 12, 12))
        pair = np.array([[1.0, -1.0], [-1.0, 1.0]]) / length[:, None, None]
        local[:, AXIAL[:, None], AXIAL] = young * section.area * pair
        local[:, TWIST[:, None], TWIST] = shear * section.torsion * pair
        bending = _hermite_stiffness(length)
        local[:, ALONG_1[:, None], ALONG_1] = young * section.i22 * bending
        local[:, ALONG_2[:, None], ALONG_2] = young * section.i11 * bending * np.outer(SIGN_2, SIGN_2)
        return rotate_to_global(local, frame)

    return in_chunks(kernel, coords, 12)


def mass(coords: FloatArray, section: BeamSection) -> FloatArray:
    """Consistent mass: linear along the axis, Hermite across it, polar inertia rho (i11 + i22) in twist.

    Rotary inertia of bending is left out, as the Euler-Bernoulli theory does.
    Source: Przemieniecki (1968), chapter 11, without the rotary terms.

    Parameters
    ----------
    coords : (n, 2, 3) global coordinates, length.
    section : area, second moments, axis 1 and material.

    Returns
    -------
    (n, 12, 12), node by node (ux, uy, uz, rx, ry, rz) in global axes.

    Raises
    ------
    DegenerateElement : coincident nodes, or axis 1 parallel to the beam.
    """
    _require_sound(coords, section)
    density = section.material.density

    def kernel(piece: FloatArray) -> FloatArray:
        length, frame = _line(piece, section)
        local = np.zeros((piece.shape[0], 12, 12))
        pair = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0 * length[:, None, None]
        local[:, AXIAL[:, None], AXIAL] = density * section.area * pair
        local[:, TWIST[:, None], TWIST] = density * (section.i11 + section.i22) * pair
        across = density * section.area * _hermite_mass(length)
        local[:, ALONG_1[:, None], ALONG_1] = across
        local[:, ALONG_2[:, None], ALONG_2] = across * np.outer(SIGN_2, SIGN_2)
        return rotate_to_global(local, frame)

    return in_chunks(kernel, coords, 12)


def _require_sound(coords: FloatArray, section: BeamSection) -> None:
    """Raise `DegenerateElement` for beams without length or without a direction of axis 1."""
    line = coords[:, 1] - coords[:, 0]
    length = np.linalg.norm(line, axis=1)
    require_sound(~(length > 0.0), "the two nodes coincide")
    axis = np.array(section.axis1, dtype=float)
    sine = np.linalg.norm(np.cross(line, axis), axis=1)
    parallel = ~(sine > PARALLEL * length * np.linalg.norm(axis))
    require_sound(parallel, f"axis 1 of the section, {section.axis1}, is parallel to the beam")


def _line(coords: FloatArray, section: BeamSection) -> tuple[FloatArray, FloatArray]:
    """Lengths (n,) and local axes (n, 3, 3) with rows t, n1, n2."""
    line = coords[:, 1] - coords[:, 0]
    length = np.linalg.norm(line, axis=1)
    tangent = line / length[:, None]
    second = unit(np.cross(tangent, np.array(section.axis1, dtype=float)))
    return length, np.stack([tangent, np.cross(second, tangent), second], axis=1)


def _hermite_stiffness(length: FloatArray) -> FloatArray:
    """(n, 4, 4) integral of N''N'' on (w1, w1', w2, w2'), 1 / length^3."""
    unit_length = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    return unit_length * _scale(length) / length[:, None, None] ** 3


def _hermite_mass(length: FloatArray) -> FloatArray:
    """(n, 4, 4) integral of N N on (w1, w1', w2, w2'), length."""
    unit_length = np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    return unit_length / 420.0 * _scale(length) * length[:, None, None]


def _scale(length: FloatArray) -> FloatArray:
    """(n, 4, 4): a factor L for each rotation."""
    one = np.ones_like(length)
    factors = np.stack([one, length, one, length], axis=1)
    return factors[:, :, None] * factors[:, None, :]
