"""Concentrated mass and rotary inertia at one node."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.model.materials import PointMass


def stiffness(coords: FloatArray, section: PointMass) -> FloatArray:
    """Zero (n, 6, 6): a mass has no stiffness."""
    return np.zeros((coords.shape[0], 6, 6))


def mass(coords: FloatArray, section: PointMass) -> FloatArray:
    """M = diag(m I, J) with J = [Ixx Ixy Ixz; Ixy Iyy Iyz; Ixz Iyz Izz].

    The six values are the entries of the inertia tensor itself, so Ixy = -(integral of x y dm).

    Parameters
    ----------
    coords : (n, 1, 3) global coordinates; only n is used.
    section : mass and inertia, each zero where the element has none.

    Returns
    -------
    (n, 6, 6) on (ux, uy, uz, rx, ry, rz) in global axes.
    """
    ixx, iyy, izz, ixy, ixz, iyz = section.inertia
    one = np.zeros((6, 6))
    one[:3, :3] = section.mass * np.eye(3)
    one[3:, 3:] = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return np.tile(one, (coords.shape[0], 1, 1))
