"""Local axes at points: rectangular, cylindrical and spherical systems."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError

TINY = 1e-9


@dataclass(frozen=True, eq=False)
class LocalSystem:
    """A rectangular, cylindrical or spherical system, placed in global coordinates."""

    kind: str
    """R, C or S"""
    a: FloatArray
    """(3,) R: direction of axis 1. C: a point of the polar axis. S: the centre."""
    b: FloatArray
    """(3,) R: a direction in the 1-2 plane. C: another point of the axis. S: a point of the polar axis."""
    where: str = ""

    def axes(self, points: FloatArray) -> FloatArray:
        """(n, 3, 3): rows are axes 1, 2, 3 at the points (n, 3).

        R: x', y', z'. C: radial, tangential, axial. S: radial, tangential (circumferential), meridional. On the
        axis, where the radial direction is not defined, it is any one.

        Raises
        ------
        InputError : the two points or directions define no system.
        """
        if self.kind == "R":
            return np.broadcast_to(_frame(self.a, self.b, self.where), (len(points), 3, 3))
        polar = _unit(self.b - self.a, self.where)
        r = points - self.a
        radial = r - (r @ polar)[:, None] * polar
        size = np.linalg.norm(radial, axis=1)
        extent = max(float(np.linalg.norm(r, axis=1).max(initial=0.0)), float(np.linalg.norm(self.b - self.a)))
        spare = np.cross(polar, np.eye(3)[int(np.argmin(np.abs(polar)))])
        spare /= np.linalg.norm(spare)
        on_axis = size <= TINY * extent
        radial = np.where(on_axis[:, None], spare, radial / np.maximum(size, 1e-300)[:, None])
        tangential = np.cross(polar, radial)
        if self.kind == "C":
            return np.stack([radial, tangential, np.broadcast_to(polar, radial.shape)], axis=1)
        distance = np.linalg.norm(r, axis=1)
        outward = np.where((distance > TINY * extent)[:, None], r / np.maximum(distance, 1e-300)[:, None], radial)
        return np.stack([outward, tangential, np.cross(outward, tangential)], axis=1)

    def moved(self, rotation: FloatArray, origin: FloatArray) -> LocalSystem:
        """The system of an instance: x_global = rotation x + origin; directions only turn."""
        shift = 0.0 if self.kind == "R" else origin
        return LocalSystem(self.kind, rotation @ self.a + shift, rotation @ self.b + shift, self.where)


def _unit(vector: FloatArray, where: str) -> FloatArray:
    size = float(np.linalg.norm(vector))
    if not 0.0 < size < np.inf:
        raise InputError(
            "the points of a local system coincide",
            expected="two different points",
            where=where,
            fix="Correct the coordinates.",
        )
    return vector / size


def _frame(a: FloatArray, b: FloatArray, where: str) -> FloatArray:
    first = _unit(a, where)
    third = np.cross(first, b)
    if not float(np.linalg.norm(third)) > TINY * float(np.linalg.norm(b)):
        raise InputError(
            "the two directions of a local system are parallel or zero",
            expected="a point on axis 1 and another in the 1-2 plane",
            where=where,
            fix="Correct the coordinates.",
        )
    third = _unit(third, where)
    return np.stack([first, np.cross(third, first), third])


def turned_about(frames: FloatArray, axis: int, degrees: float) -> FloatArray:
    """The two other axes of frames (n, 3, 3) turned about axis 1, 2 or 3 by an angle in degrees."""
    if not degrees:
        return frames
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = axis % 3, (axis + 1) % 3
    out = np.array(frames)
    out[:, i] = c * frames[:, i] + s * frames[:, j]
    out[:, j] = c * frames[:, j] - s * frames[:, i]
    return out
