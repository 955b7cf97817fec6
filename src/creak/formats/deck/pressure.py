"""Pressure on facets as forces at their nodes: the same for every deck format."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.face_shapes import FEW, SQUARE, FaceShapes
from creak.model.quadrature import gauss_square, gauss_triangle
from creak.model.steps import PointLoad


@dataclass(frozen=True)
class Pressed:
    """Facets under pressure."""

    corners: IntArray
    """(n, 4) node rows; a triangle repeats its third."""
    pressure: FloatArray
    """(n, 4) at the corners, force / length^2, along the normal of the facet."""
    along: FloatArray
    """(n, 3) direction in which it acts instead, unit vectors; NaN: the normal."""
    shapes: FaceShapes
    """Of the faces that they are parts of."""


def nodal_forces(pressed: Pressed, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sorted node rows (k,) and forces (k, 3): integral of h_i p n dA with the shape functions of each whole face.

    Pressure is linear on each facet. Where middle nodes lie amid straight sides of a plane face, these are the
    consistent loads: of a uniform pressure on a square face -1/12 at a corner and 1/3 in the middle of a side, on a
    triangle 0 and 1/3. Curved faces are as their facets lie.
    """
    nodes = pressed.shapes.nodes
    forces = np.zeros((*nodes.shape, 3))
    triangle = pressed.corners[:, 2] == pressed.corners[:, 3]
    for mine, (shapes, slopes, weights) in ((triangle, _triangle()), (~triangle, _square())):
        facet = np.flatnonzero(mine)
        x, p, direction = coords[pressed.corners[facet]], pressed.pressure[facet], pressed.along[facet]
        for h, dh, w in zip(shapes, slopes, weights, strict=True):
            area = _along(np.cross(*np.einsum("ai,nic->anc", dh, x)), direction)
            _, whole = pressed.shapes.at(facet, np.broadcast_to(h, (facet.size, FEW)))
            forces[facet] += whole[:, :, None] * (w * (p @ h)[:, None] * area)[:, None]
    rows, at = np.unique(nodes, return_inverse=True)
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


def _triangle() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shape functions (q, 4), slopes (q, 2, 4) and weights of six points: exact to degree four."""
    points, weights = gauss_triangle()
    shapes = np.column_stack([1.0 - points.sum(axis=1), points, np.zeros(len(points))])
    slopes = np.array([[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0]])
    return shapes, np.broadcast_to(slopes, (len(points), 2, 4)), 0.5 * weights


def _square() -> tuple[FloatArray, FloatArray, FloatArray]:
    """The same of 3 x 3 points: exact to degree five in each direction."""
    points, weights = gauss_square(3)
    ends = 1.0 + points[:, None, :] * SQUARE
    slopes = 0.25 * np.stack([SQUARE[:, 0] * ends[:, :, 1], SQUARE[:, 1] * ends[:, :, 0]], axis=1)
    return 0.25 * ends.prod(axis=2), slopes, weights


def _along(area: FloatArray, direction: FloatArray) -> FloatArray:
    """Area vectors (n, 3), turned into the direction where there is one."""
    size = np.linalg.norm(area, axis=1, keepdims=True)
    return np.where(np.isnan(direction), area, size * np.nan_to_num(direction))
