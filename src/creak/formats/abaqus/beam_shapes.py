"""Cross-sections of *BEAM SECTION: area, second moments, torsion constant, shear factor."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Shape:
    """Properties about the origin of Abaqus's section axes and about the centroid."""

    area: float
    i11: float
    """About axis 1 through the centroid."""
    i22: float
    i12: float
    torsion: float
    centroid: tuple[float, float] = (0.0, 0.0)
    """From the node, along axes 1 and 2."""
    shear_centre: tuple[float, float] = (0.0, 0.0)
    shear_factor: float = 1.0
    radius: float = 0.0
    """From the axis to the surface, for contact; 0: not known."""


def rectangle_torsion(a: float, b: float) -> float:
    """St Venant torsion constant of an a x b rectangle.

    J = l s^3 (1/3 - (64/pi^5) (s/l) sum_{n odd} tanh(n pi l / 2 s) / n^5), l the long and s the short side
    (Timoshenko and Goodier, Theory of Elasticity, art. 109).
    """
    long, short = max(a, b), min(a, b)
    ratio = long / short
    series = sum(math.tanh(n * math.pi * ratio / 2.0) / n**5 for n in range(1, 60, 2))
    return long * short * short * short * (1.0 / 3.0 - 64.0 / math.pi**5 / ratio * series)


def _rect(size: Sequence[float]) -> Shape:
    a, b = size
    torsion = rectangle_torsion(a, b)
    return Shape(
        a * b, a * b * b * b / 12.0, b * a * a * a / 12.0, 0.0, torsion, shear_factor=0.85, radius=0.5 * min(a, b)
    )


def _tube(outer: float, inner: float, factor: float) -> Shape:
    area = math.pi * (outer * outer - inner * inner)
    second = math.pi * (outer * outer * outer * outer - inner * inner * inner * inner) / 4.0
    return Shape(area, second, second, 0.0, 2.0 * second, shear_factor=factor, radius=outer)


def _circ(size: Sequence[float]) -> Shape:
    return _tube(size[0], 0.0, 0.89)


def _pipe(size: Sequence[float]) -> Shape:
    outer, wall = size
    if wall > outer:
        raise ValueError(f"PIPE with wall {wall:g} thicker than its radius {outer:g}")
    return _tube(outer, outer - wall, 0.53)


def _box(size: Sequence[float]) -> Shape:
    """a along axis 1, b along axis 2; walls t1 = t3 at the sides, t2 = t4 above and below. Torsion of the thin closed
    cell (Bredt)."""
    a, b, right, top, left, bottom = size
    if right != left or top != bottom:
        raise ValueError("BOX with opposite walls of different thickness; give its properties with SECTION=GENERAL")
    if right + left >= a or top + bottom >= b:
        raise ValueError(f"BOX of {a:g} x {b:g} has walls that leave no hole")
    parts = [
        (0.5 * (a - right), 0.0, right, b),
        (-0.5 * (a - left), 0.0, left, b),
        (0.5 * (left - right), 0.5 * (b - top), a - left - right, top),
        (0.5 * (left - right), -0.5 * (b - bottom), a - left - right, bottom),
    ]
    w, h = a - 0.5 * (left + right), b - 0.5 * (top + bottom)
    torsion = 4.0 * (w * h) ** 2 / (h / right + h / left + w / top + w / bottom)
    return _of_rectangles(parts, torsion, 0.44)


def _i(size: Sequence[float]) -> Shape:
    """l from the bottom to the node, h, bottom width b1, top width b2, thickness t1, t2, web t3."""
    below, h, b1, b2, t1, t2, t3 = size
    if t1 + t2 >= h:
        raise ValueError(f"I of height {h:g} has flanges that leave no web")
    web = h - t1 - t2
    parts = [
        (0.0, 0.5 * t1 - below, b1, t1),
        (0.0, h - 0.5 * t2 - below, b2, t2),
        (0.0, t1 + 0.5 * web - below, t3, web),
    ]
    torsion = (b1 * t1**3 + b2 * t2**3 + web * t3**3) / 3.0
    low, high = t1 * b1**3, t2 * b2**3
    centre = 0.5 * t1 - below + (h - 0.5 * (t1 + t2)) * high / (low + high)
    return _of_rectangles(parts, torsion, 0.44, (0.0, centre))


def _of_rectangles(
    parts: Sequence[tuple[float, float, float, float]],
    torsion: float,
    factor: float,
    shear_centre: tuple[float, float] | None = None,
) -> Shape:
    """From rectangles (x, y of the centre, width, height); the shear centre is the centroid when not given."""
    area = sum(w * h for _, _, w, h in parts)
    x = sum(w * h * cx for cx, _, w, h in parts) / area
    y = sum(w * h * cy for _, cy, w, h in parts) / area
    i11 = sum(w * h**3 / 12.0 + w * h * (cy - y) ** 2 for _, cy, w, h in parts)
    i22 = sum(h * w**3 / 12.0 + w * h * (cx - x) ** 2 for cx, _, w, h in parts)
    i12 = sum(w * h * (cx - x) * (cy - y) for cx, cy, w, h in parts)
    return Shape(area, i11, i22, i12, torsion, (x, y), (x, y) if shear_centre is None else shear_centre, factor)


SHAPES: dict[str, tuple[int, Callable[[Sequence[float]], Shape]]] = {
    "RECT": (2, _rect),
    "CIRC": (1, _circ),
    "PIPE": (2, _pipe),
    "BOX": (6, _box),
    "I": (7, _i),
}
"""Name -> number of dimensions, properties from them."""
