"""Cross-sections of beams from their dimensions: area, second moments, torsion constant, radius.

Axes 1 and 2 are those of the section before it is turned; x runs along axis 1, y along axis 2. What a program takes for
shear, and how it numbers dimensions, stays with its format.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Rectangle = tuple[float, float, float, float]
"""x and y of the centre, width along axis 1, height along axis 2."""


@dataclass(frozen=True)
class CrossSection:
    """Properties about the centroid."""

    area: float
    i11: float
    """integral of y^2: bending about axis 1."""
    i22: float
    i12: float
    """integral of x y."""
    torsion: float
    centroid: tuple[float, float] = (0.0, 0.0)
    """From the node, along axes 1 and 2."""
    shear_centre: tuple[float, float] = (0.0, 0.0)
    shear_factors: tuple[float, float] = (0.0, 0.0)
    """Shear area over area, along axes 1 and 2; 0: rigid in shear."""
    radius: float = 0.0
    """From the axis to the surface, for contact; 0: not known."""

    @property
    def sound(self) -> bool:
        """Whether there is such a section: area and moments positive and finite."""
        return all(0.0 < v < math.inf for v in (self.area, self.i11, self.i22, self.torsion))


def rectangle_torsion(a: float, b: float) -> float:
    """St Venant torsion constant of an a x b rectangle.

    J = l s^3 (1/3 - (64/pi^5) (s/l) sum_{n odd} tanh(n pi l / 2 s) / n^5), l the long and s the short side
    (Timoshenko and Goodier, Theory of Elasticity, art. 109).
    """
    long, short = max(a, b), min(a, b)
    ratio = long / short
    series = sum(math.tanh(n * math.pi * ratio / 2.0) / n**5 for n in range(1, 60, 2))
    return long * short * short * short * (1.0 / 3.0 - 64.0 / math.pi**5 / ratio * series)


def rectangle(a: float, b: float, torsion: float, shear_factor: float) -> CrossSection:
    """a along axis 1, b along axis 2."""
    radius = 0.5 * min(a, b)
    i11, i22 = a * b * b * b / 12.0, b * a * a * a / 12.0
    return CrossSection(a * b, i11, i22, 0.0, torsion, shear_factors=2 * (shear_factor,), radius=radius)


def tube(outer: float, inner: float, shear_factor: float) -> CrossSection:
    """Between two radii; `inner` 0: a rod."""
    area = math.pi * (outer * outer - inner * inner)
    second = math.pi * (outer * outer * outer * outer - inner * inner * inner * inner) / 4.0
    return CrossSection(area, second, second, 0.0, 2.0 * second, shear_factors=2 * (shear_factor,), radius=outer)


def composed(
    parts: Sequence[Rectangle],
    torsion: float | None = None,
    shear_factor: float | None = None,
    shear_centre: tuple[float, float] | None = None,
    radius: float = 0.0,
) -> CrossSection:
    """From rectangles; if not given, torsion of the thin open section, sum l t^3 / 3, the shear centre at the
    centroid, shear areas 5/6 of the walls that lie along (20 % short in the web of a thin I)."""
    area = sum(w * h for _, _, w, h in parts)
    x = sum(w * h * cx for cx, _, w, h in parts) / area
    y = sum(w * h * cy for _, cy, w, h in parts) / area
    i11 = sum(w * h**3 / 12.0 + w * h * (cy - y) ** 2 for _, cy, w, h in parts)
    i22 = sum(h * w**3 / 12.0 + w * h * (cx - x) ** 2 for cx, _, w, h in parts)
    i12 = sum(w * h * (cx - x) * (cy - y) for cx, cy, w, h in parts)
    if torsion is None:
        torsion = sum(max(w, h) * min(w, h) ** 3 for _, _, w, h in parts) / 3.0
    at = (x, y) if shear_centre is None else shear_centre
    along = sum(w * h for _, _, w, h in parts if w > h) / area
    shear = (5.0 / 6.0 * along, 5.0 / 6.0 * (1.0 - along)) if shear_factor is None else 2 * (shear_factor,)
    return CrossSection(
        area=area,
        i11=i11,
        i22=i22,
        i12=i12,
        torsion=torsion,
        centroid=(x, y),
        shear_centre=at,
        shear_factors=shear,
        radius=radius,
    )


def box(
    a: float, b: float, walls: tuple[float, float, float, float], shear_factor: float | None = None, radius: float = 0.0
) -> CrossSection:
    """a along axis 1, b along axis 2; walls right, top, left, bottom. Torsion of the thin closed cell (Bredt):

    J = 4 A^2 / sum (l / t), A and l between the middles of the walls.
    """
    right, top, left, bottom = walls
    parts = [
        (0.5 * (a - right), 0.0, right, b),
        (-0.5 * (a - left), 0.0, left, b),
        (0.5 * (left - right), 0.5 * (b - top), a - left - right, top),
        (0.5 * (left - right), -0.5 * (b - bottom), a - left - right, bottom),
    ]
    w, h = a - 0.5 * (left + right), b - 0.5 * (top + bottom)
    torsion = 4.0 * (w * h) ** 2 / (h / right + h / left + w / top + w / bottom)
    return composed(parts, torsion, shear_factor, radius=radius)


def hexagon(radius: float, wall: float, shear_factor: float) -> CrossSection:
    """Regular hexagon, radius to its outer corners; torsion of the thin cell (Bredt): 4 A^2 t/l of the middle line.

    Of side s: area 3 sqrt(3)/2 s^2, I = 5 sqrt(3)/16 s^4 about every axis.
    """
    root = math.sqrt(3.0)
    inner, middle = radius - 2.0 * wall / root, radius - wall / root
    second = 5.0 * root / 16.0 * (radius**4 - inner**4)
    torsion = 4.0 * (1.5 * root * middle * middle) ** 2 * wall / (6.0 * middle)
    area = 1.5 * root * (radius * radius - inner * inner)
    return CrossSection(
        area, second, second, 0.0, torsion, shear_factors=2 * (shear_factor,), radius=0.5 * root * radius
    )


def trapezoid(bottom: float, height: float, top: float, below: float, shear_factor: float) -> CrossSection:
    """Widths along axis 1, symmetric; the node lies `below` above the bottom. Its shear centre is put at the
    centroid."""
    both = bottom + top
    i11 = height**3 * (bottom * bottom + 4.0 * bottom * top + top * top) / (36.0 * both)
    i22 = height * both * (bottom * bottom + top * top) / 48.0
    centre = (0.0, height * (bottom + 2.0 * top) / (3.0 * both) - below)
    torsion = trapezoid_torsion(bottom, height, top)
    radius = 0.5 * min(0.5 * both, height)
    return CrossSection(
        area=0.5 * both * height,
        i11=i11,
        i22=i22,
        i12=0.0,
        torsion=torsion,
        centroid=centre,
        shear_centre=centre,
        shear_factors=2 * (shear_factor,),
        radius=radius,
    )


TERMS = 7
"""Even powers across, in Ritz's stress function of a trapezoid; twice as many upwards."""


def trapezoid_torsion(bottom: float, height: float, top: float) -> float:
    """St Venant torsion constant, by Ritz: J = 2 integral of phi, where lap phi = -2 and phi vanishes at the sides.

    phi = (1 - s^2) (1 - r^2) sum c_ij r^2i s^j, r and s from -1 to 1 across and up. A lower bound, short by less than
    1e-5 of rectangles up to 10:1 and of the equilateral triangle. Source: Timoshenko and Goodier, Theory of Elasticity,
    art. 111.
    """
    at, weight = np.polynomial.legendre.leggauss(4 * TERMS)
    vanishing = np.polynomial.Legendre([2 / 3, 0, -2 / 3])
    basis = [vanishing * np.polynomial.Legendre.basis(k) for k in range(2 * TERMS)]
    up, up_s = np.array([f(at) for f in basis]), np.array([f.deriv()(at) for f in basis])
    across, across_r = up[::2], up_s[::2]
    half = 0.25 * (bottom + top + (top - bottom) * at)
    turned = 0.25 * (top - bottom) * at[:, None] / half
    area = 0.5 * height * half * np.outer(weight, weight)
    value, along_r, along_s = (
        f[:, None, :, None] * g[None, :, None, :] for f, g in ((across, up), (across_r, up), (across, up_s))
    )
    n = across.shape[0] * up.shape[0]
    slope_x, slope_y = along_r / half, (along_s - along_r * turned) * 2.0 / height
    energy = sum((slope * area).reshape(n, -1) @ slope.reshape(n, -1).T for slope in (slope_x, slope_y))
    load = 2.0 * value.reshape(n, -1) @ area.ravel()
    return float(load @ np.linalg.solve(energy, load))


def principal(i11: float, i22: float, i12: float) -> tuple[float, float, float]:
    """Second moments about principal axes 1 and 2, and the angle from axis 1 to principal axis 1.

    I1 = I11 c^2 + I22 s^2 - 2 I12 s c with tan 2 angle = 2 I12/(I22 - I11), I12 = integral of x y.
    """
    if i12 == 0.0:
        return i11, i22, 0.0
    angle = 0.5 * math.atan2(2.0 * i12, i22 - i11)
    c, s = math.cos(angle), math.sin(angle)
    return (
        i11 * c * c + i22 * s * s - 2.0 * i12 * s * c,
        i11 * s * s + i22 * c * c + 2.0 * i12 * s * c,
        angle,
    )
