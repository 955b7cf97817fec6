"""Rectangular, cylindrical and spherical coordinate systems: where points in them are, and which way these move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray


@dataclass(frozen=True)
class CoordinateSystem:
    """A rectangular (R), cylindrical (C: r, theta, z) or spherical (S: r, theta, phi; degrees) system."""

    kind: str
    origin: FloatArray
    axes: FloatArray
    """(3, 3), columns are the x, y and z axis in the basic (global) frame."""


BASIC = CoordinateSystem("R", np.zeros(3), np.eye(3))


def point_in_basic(system: CoordinateSystem, coordinates: FloatArray) -> FloatArray:
    """Place (3,) in the basic frame of a point given in a system."""
    a, b, c = coordinates
    if system.kind == "C":
        local = np.array([a * np.cos(np.radians(b)), a * np.sin(np.radians(b)), c])
    elif system.kind == "S":
        theta, phi = np.radians(b), np.radians(c)
        local = a * np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    else:
        local = np.array(coordinates, dtype=float)
    return system.origin + system.axes @ local


def axes_at(system: CoordinateSystem, place: FloatArray) -> FloatArray:
    """(3, 3): columns are the displacement directions of a grid at this place: u_basic = axes u_local.

    On the axis of a cylindrical or spherical system the angles are undefined; theta (and phi) = 0 is taken there.
    """
    if system.kind == "R":
        return system.axes
    x, y, z = system.axes.T @ (place - system.origin)
    phi = np.arctan2(y, x)
    around = np.array([-np.sin(phi), np.cos(phi), 0.0])
    if system.kind == "C":
        local = [np.array([np.cos(phi), np.sin(phi), 0.0]), around, np.array([0.0, 0.0, 1.0])]
    else:
        theta = np.arctan2(np.hypot(x, y), z)
        outward = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        local = [outward, np.cross(around, outward), around]
    return system.axes @ np.stack(local, axis=1)
