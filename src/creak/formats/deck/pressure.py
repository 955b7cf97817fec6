"""Pressure on facets as forces at their nodes: the same for every deck format."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.faces import SQUARE as _AT
from creak.model.faces import FaceShapes
from creak.model.steps import PointLoad

_FEW, _MANY = 2, 6
"""Gauss points along each side of a facet: exact to degree 3, which bilinear faces reach, and 11 (with middle nodes: 3
of N, 2 of p, 4 of n dA, 1 of a triangle)."""


@dataclass(frozen=True)
class Pressed:
    """Facets under pressure."""

    faces: FaceShapes
    """Facets and the faces that they are parts of."""
    pressure: FloatArray
    """(n, w) at the nodes of the face, force / length^2, along the normal of the facet."""
    along: FloatArray
    """(n, 3) direction in which it acts instead, unit vectors; NaN: the normal."""


def nodal_forces(pressed: Pressed, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sorted node rows (k,) and forces (k, 3): integral of N_k p n dA with the shape functions of the whole face.

    p = sum N_k p_k. A uniform pressure on a square face with middle nodes gives -1/12 of its force to a corner and 1/3
    to a middle node, on a triangular one nothing and 1/3. The Gauss rule of each facet is exact, of triangles as
    quadrilaterals that repeat a corner; with a direction of its own, where the face is flat.
    """
    faces = pressed.faces
    facet, x = np.arange(len(faces.nodes)), coords[faces.nodes]
    forces = np.zeros(x.shape)
    places, weights = np.polynomial.legendre.leggauss(_MANY if faces.sides.any() else _FEW)
    for (r, of_r), (s, of_s) in product(zip(places, weights, strict=True), repeat=2):
        along_r, along_s = 1 + r * _AT[:, 0], 1 + s * _AT[:, 1]
        shape = 0.25 * along_r * along_s
        slope = 0.25 * np.column_stack([_AT[:, 0] * along_s, _AT[:, 1] * along_r])
        _, N = faces.at(facet, np.broadcast_to(shape, (facet.size, 4)))
        tangents = np.einsum("kwr,kwx->rkx", faces.slopes(shape, slope), x)
        pressure = of_r * of_s * np.einsum("kw,kw->k", N, pressed.pressure)
        acting = pressure[:, None] * _along(np.cross(tangents[0], tangents[1]), pressed.along)
        forces += N[:, :, None] * acting[:, None]
    rows, at = np.unique(faces.nodes, return_inverse=True)
    total = np.zeros((rows.size, 3))
    np.add.at(total, at.reshape(-1), forces.reshape(-1, 3))
    return rows, total


def point_loads(rows: IntArray, forces: FloatArray, name: str, where: str) -> list[PointLoad]:
    """Forces (k, 3) at nodes (k,) as loads; nodes of one value together."""
    found: list[PointLoad] = []
    scale = float(np.abs(forces).max(initial=0.0))
    for axis in range(3):
        values, group = np.unique(np.round(forces[:, axis] / (scale or 1.0), 12), return_inverse=True)
        order = np.argsort(group.reshape(-1), kind="stable")
        for mine in np.split(order, np.searchsorted(group.reshape(-1)[order], np.arange(1, values.size))):
            if mine.size and values[group.reshape(-1)[mine[0]]]:
                value = float(forces[mine, axis].mean())
                found.append(PointLoad(rows[mine], axis + 1, value, "", name, where, spread=True))
    return found


def _along(area: FloatArray, direction: FloatArray) -> FloatArray:
    """Area vectors (n, 3), turned into the direction where there is one."""
    size = np.linalg.norm(area, axis=1, keepdims=True)
    return np.where(np.isnan(direction), area, size * np.nan_to_num(direction))
