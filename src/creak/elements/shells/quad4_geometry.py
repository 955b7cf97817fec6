"""Bilinear geometry of a four-node shell: shape functions, directors, local axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import DEGENERATE, require_sound, unit

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""(r, s) of the four nodes."""
CENTRE = np.zeros((1, 2))
Pair = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Surface:
    """The mid-surface of n elements at n_point points."""

    points: FloatArray
    """(n_point, 2) natural coordinates (r, s)."""
    x_r: FloatArray
    """(n, n_point, 3) covariant base vector dx/dr."""
    x_s: FloatArray
    """(n, n_point, 3) covariant base vector dx/ds."""
    axes: FloatArray
    """(n, n_point, 3, 3) rows are local unit vectors e1, e2 and the normal."""
    inverse: FloatArray
    """(n, n_point, 2, 2) d(r, s)/d(local 1, 2): rows 1, 2, columns r, s."""
    area: FloatArray
    """(n, n_point) |x_r x x_s|."""
    weights: FloatArray
    """(n, n_point) quadrature weight times area."""


def shape(points: FloatArray) -> FloatArray:
    """Values (n_point, 4) of h_i = (1 + r r_i)(1 + s s_i)/4."""
    r, s = points[:, :1], points[:, 1:]
    return 0.25 * (1 + r * CORNERS[:, 0]) * (1 + s * CORNERS[:, 1])


def shape_derivatives(points: FloatArray) -> FloatArray:
    """Derivatives (n_point, 2, 4) of h_i by r and by s."""
    r, s = points[:, :1], points[:, 1:]
    by_r = 0.25 * CORNERS[:, 0] * (1 + s * CORNERS[:, 1])
    by_s = 0.25 * CORNERS[:, 1] * (1 + r * CORNERS[:, 0])
    return np.stack([by_r, by_s], axis=1)


def tangents(coords: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariant base vectors dx/dr and dx/ds, each (n, n_point, 3): bilinear, so linear in s and in r."""
    x = [coords[:, None, i] for i in range(4)]
    r, s = points[:, 0, None], points[:, 1, None]
    along_r, along_s = x[1] - x[0] + (x[2] - x[3]), x[3] - x[0] + (x[2] - x[1])
    twist = x[0] - x[1] + (x[2] - x[3])
    return 0.25 * (along_r + s * twist), 0.25 * (along_s + r * twist)


def directors(coords: FloatArray) -> FloatArray:
    """Unit normals (n, 4, 3) of the element's own surface at its nodes."""
    return unit(np.cross(*tangents(coords, CORNERS)))


def require_convex(coords: FloatArray) -> None:
    """Check every element of coords (n, 4, 3).

    Raises
    ------
    DegenerateElement : no area, or a corner angle not between 0 and 180 degrees.
    """
    diagonals = np.stack([coords[:, 2] - coords[:, 0], coords[:, 3] - coords[:, 1]])
    smallest = DEGENERATE * (diagonals**2).sum(axis=(0, 2))
    middle = np.cross(*tangents(coords, CENTRE))[:, 0]
    size = np.linalg.norm(middle, axis=1)
    require_sound(~(size > smallest), "the element has no area")
    corner = np.cross(*tangents(coords, CORNERS))
    least = np.einsum("nic,nc->ni", corner, middle / size[:, None]).min(axis=1)
    require_sound(~(least > smallest), "a corner angle is not between 0 and 180 degrees")


def evaluate(coords: FloatArray, points: FloatArray, weights: FloatArray) -> Surface:
    """Base vectors, local axes and area at the points.

    Axis 1 bisects the diagonals in the mean plane, so another first node turns it by 90 degrees at most. The
    axes at a point are those of the mean plane after the smallest rotation that takes the mean normal N to
    the normal n there: e1 = E1 - (n . E1) (n + N)/(1 + n . N).
    """
    first, second = unit(coords[:, 2] - coords[:, 0]), unit(coords[:, 3] - coords[:, 1])
    return surface_of(points, weights, tangents(coords, points), (unit(first - second), unit(np.cross(first, second))))


def bending_strains(normals: FloatArray, slopes: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 6 k): the part of the strains that is linear in z, of directors (n, k, 3); slopes (n_point, 2, k)
    of the shape functions."""
    n, k, _ = normals.shape
    v_r, v_s = np.einsum("gai,nic->angc", slopes, normals)[:, :, :, None]
    x_r, x_s = surface.x_r[:, :, None], surface.x_s[:, :, None]
    h_r, h_s = slopes[:, 0, :, None], slopes[:, 1, :, None]
    turn_r, turn_s = np.cross(normals[:, None], x_r), np.cross(normals[:, None], x_s)
    operator = np.empty((n, len(slopes), 3, k, 6))
    operator[:, :, 0, :, :3], operator[:, :, 0, :, 3:] = h_r * v_r, h_r * turn_r
    operator[:, :, 1, :, :3], operator[:, :, 1, :, 3:] = h_s * v_s, h_s * turn_s
    operator[:, :, 2, :, :3] = h_s * v_r + h_r * v_s
    operator[:, :, 2, :, 3:] = h_s * turn_r + h_r * turn_s
    return np.asarray(strain_transform(surface.inverse) @ operator.reshape(n, -1, 3, 6 * k), dtype=np.float64)


def surface_of(points: FloatArray, weights: FloatArray, base: Pair, mean: Pair) -> Surface:
    """As `evaluate`, of base vectors (n, n_point, 3), the axis 1 and the normal (n, 3) of the mean plane."""
    x_r, x_s = base
    cross = np.cross(x_r, x_s)
    area = np.linalg.norm(cross, axis=2)
    normal = cross / area[:, :, None]
    mean_axis, mean_normal = (v[:, None] for v in mean)
    tilt = np.einsum("nqc,ngc->ng", mean_axis, normal) / (1.0 + np.einsum("nqc,ngc->ng", mean_normal, normal))
    e1 = mean_axis - tilt[:, :, None] * (normal + mean_normal)
    axes = np.stack([e1, np.cross(normal, e1), normal], axis=2)
    jacobian = np.stack([x_r, x_s], axis=2) @ axes[:, :, :2].transpose(0, 1, 3, 2)
    return Surface(points, x_r, x_s, axes, inverse_2x2(jacobian), area, area * weights)


def inverse_2x2(matrix: FloatArray) -> FloatArray:
    """Inverse of (..., 2, 2)."""
    a, b, c, d = matrix[..., 0, 0], matrix[..., 0, 1], matrix[..., 1, 0], matrix[..., 1, 1]
    adjugate = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    return adjugate / (a * d - b * c)[..., None, None]


def zero_mean(coords: FloatArray, surface: Surface, modes: FloatArray) -> FloatArray:
    """(n, n_point, 3, k) local strains (j0/j) T0 E of covariant modes E (n_point, 3, k) with zero mean over the square.

    Their mean over the element is zero too, whatever its shape (Simo, Rifai, Int. J. Numer. Meth. Eng. 29 (1990) 1595).
    """
    centre = evaluate(coords, CENTRE, np.array([4.0]))
    ratio = (centre.area / surface.area)[:, :, None, None]
    return ratio * (strain_transform(centre.inverse) @ modes)


def strain_transform(inverse: FloatArray) -> FloatArray:
    """(..., 3, 3): (e11, e22, 2 e12) local Cartesian from covariant (e_rr, e_ss, 2 e_rs)."""
    a, b, c, d = inverse[..., 0, 0], inverse[..., 0, 1], inverse[..., 1, 0], inverse[..., 1, 1]
    rows = [(a * a, b * b, a * b), (c * c, d * d, c * d), (2 * a * c, 2 * b * d, a * d + b * c)]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
