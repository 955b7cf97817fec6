"""Pressure on facets as forces at their nodes: the same for every deck format."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.steps import PointLoad

_AT = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@dataclass(frozen=True)
class Pressed:
    """Facets under pressure."""

    corners: IntArray
    """(n, 4) node rows; a triangle repeats its third."""
    pressure: FloatArray
    """(n, 4) at the corners, force / length^2, along the normal of the facet."""
    along: FloatArray
    """(n, 3) direction in which it acts instead, unit vectors; NaN: the normal."""


def nodal_forces(pressed: Pressed, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sorted node rows (k,) and forces (k, 3): integral of h_i p n dA with linear shape functions of each facet.

    Resultant and moment are those of the pressure. A shell or face with middle nodes has several facets, which bend
    into one another as its parabolas do; where the pressure changes or ends, forces lie as on a mesh of twice as many
    linear elements.
    """
    forces = np.empty((len(pressed.corners), 4, 3))
    triangle = pressed.corners[:, 2] == pressed.corners[:, 3]
    forces[triangle] = _of_triangles(_part(pressed, triangle), coords)
    forces[~triangle] = _of_quads(_part(pressed, ~triangle), coords)
    rows, at = np.unique(pressed.corners, return_inverse=True)
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


def _part(pressed: Pressed, rows: np.ndarray) -> Pressed:
    return Pressed(pressed.corners[rows], pressed.pressure[rows], pressed.along[rows])


def _of_triangles(pressed: Pressed, coords: FloatArray) -> FloatArray:
    """(n, 4, 3), nothing at the fourth: A n (p_i + sum p) / 12."""
    x, p = coords[pressed.corners[:, :3]], pressed.pressure[:, :3]
    area = 0.5 * np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    share = (p + p.sum(axis=1, keepdims=True)) / 12.0
    return np.pad(share[:, :, None] * _along(area, pressed.along)[:, None], ((0, 0), (0, 1), (0, 0)))


def _of_quads(pressed: Pressed, coords: FloatArray) -> FloatArray:
    """(n, 4, 3), 2 x 2 points."""
    x, out = coords[pressed.corners], np.zeros((len(pressed.corners), 4, 3))
    for r, s in _AT / np.sqrt(3.0):
        h = 0.25 * (1 + r * _AT[:, 0]) * (1 + s * _AT[:, 1])
        x_r = np.einsum("i,nic->nc", 0.25 * _AT[:, 0] * (1 + s * _AT[:, 1]), x)
        x_s = np.einsum("i,nic->nc", 0.25 * _AT[:, 1] * (1 + r * _AT[:, 0]), x)
        acting = (pressed.pressure @ h)[:, None] * _along(np.cross(x_r, x_s), pressed.along)
        out += h[:, None] * acting[:, None]
    return out


def _along(area: FloatArray, direction: FloatArray) -> FloatArray:
    """Area vectors (n, 3), turned into the direction where there is one."""
    size = np.linalg.norm(area, axis=1, keepdims=True)
    return np.where(np.isnan(direction), area, size * np.nan_to_num(direction))
