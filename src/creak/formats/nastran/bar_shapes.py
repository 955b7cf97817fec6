"""PBARL and PBEAML: cross-sections by their dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from creak.errors import InputError
from creak.formats.nastran.bulk_data import Card


@dataclass(frozen=True)
class Shape:
    """A cross-section about its centroid; axis y is plane 1 (the orientation vector), z plane 2."""

    area: float
    i1: float
    """integral of y^2: bending in plane 1."""
    i2: float
    torsion: float
    k1: float = 0.0
    """Shear factor in plane 1; 0: rigid."""
    k2: float = 0.0
    radius: float = 0.0
    i12: float = 0.0


def _box_shape(width: float, height: float, flange: float, web: float) -> Shape:
    """Closed box: width along z, height along y; torsion by Bredt."""
    inner_w, inner_h = width - 2.0 * web, height - 2.0 * flange
    mean = (width - web) * (height - flange)
    around = 2.0 * ((width - web) / flange + (height - flange) / web)
    return Shape(
        width * height - inner_w * inner_h,
        (width * height**3 - inner_w * inner_h**3) / 12.0,
        (height * width**3 - inner_h * inner_w**3) / 12.0,
        4.0 * mean**2 / around,
        radius=0.5 * min(width, height),
    )


def rectangle(width: float, height: float) -> Shape:
    """Width along z (plane 2), height along y; torsion by Roark's series, shear factor 5/6."""
    a, b = max(width, height), min(width, height)
    torsion = a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))
    return Shape(
        width * height, width * height**3 / 12.0, height * width**3 / 12.0, torsion, 5.0 / 6.0, 5.0 / 6.0, 0.5 * b
    )


def _thin(rectangles: list[tuple[float, float, float, float]]) -> Shape:
    """Open section of rectangles (y, z of the centre, height along y, width along z); torsion sum of l t^3/3."""
    r = np.array(rectangles)
    area = r[:, 2] * r[:, 3]
    y, z = r[:, 0] - area @ r[:, 0] / area.sum(), r[:, 1] - area @ r[:, 1] / area.sum()
    i1 = float(area @ (y**2 + r[:, 2] ** 2 / 12.0))
    i2 = float(area @ (z**2 + r[:, 3] ** 2 / 12.0))
    long, short = np.maximum(r[:, 2], r[:, 3]), np.minimum(r[:, 2], r[:, 3])
    torsion = float((long * short**3).sum()) / 3.0
    return Shape(float(area.sum()), i1, i2, torsion, radius=0.5 * float(short.max()), i12=float(area @ (y * z)))


def _rod(r: float) -> Shape:
    quarter = math.pi * r**4 / 4.0
    return Shape(math.pi * r * r, quarter, quarter, 2.0 * quarter, 0.9, 0.9, r)


def _tube(outer: float, inner: float) -> Shape:
    quarter = math.pi * (outer**4 - inner**4) / 4.0
    return Shape(math.pi * (outer**2 - inner**2), quarter, quarter, 2.0 * quarter, 0.5, 0.5, outer)


def _i(h: float, a: float, b: float, tw: float, ta: float, tb: float) -> Shape:
    """Height, bottom and top flange widths, web, bottom and top flange thickness."""
    web = h - ta - tb
    return _thin([(0.5 * ta, 0.0, ta, a), (ta + 0.5 * web, 0.0, web, tw), (h - 0.5 * tb, 0.0, tb, b)])


def _i1(flange: float, web: float, inner: float, height: float) -> Shape:
    """DIM1 both flange overhangs together, DIM2 web, DIM3 height between the flanges, DIM4 total height."""
    t = 0.5 * (height - inner)
    return _i(height, flange + web, flange + web, web, t, t)


def _channel(width: float, height: float, web: float, flange: float) -> Shape:
    """CHAN: flange width, height, web and flange thickness; the web along y."""
    mid = height - 2.0 * flange
    return _thin(
        [
            (0.5 * flange, 0.5 * width, flange, width),
            (0.5 * height, 0.5 * web, mid, web),
            (height - 0.5 * flange, 0.5 * width, flange, width),
        ]
    )


def _tee(width: float, height: float, flange: float, web: float) -> Shape:
    stem = height - flange
    return _thin([(0.5 * stem, 0.0, stem, web), (height - 0.5 * flange, 0.0, flange, width)])


def _angle(width: float, height: float, flange: float, web: float) -> Shape:
    """L: horizontal leg along z, vertical along y, their thicknesses."""
    return _thin(
        [
            (0.5 * flange, 0.5 * width, flange, width),
            (flange + 0.5 * (height - flange), 0.5 * web, height - flange, web),
        ]
    )


def _tube2(outer: float, wall: float) -> Shape:
    return _tube(outer, outer - wall)


def _box1(width: float, height: float, top: float, bottom: float, left: float, right: float) -> Shape:
    """Closed box with four walls of their own; torsion by Bredt."""
    mid = height - top - bottom
    walls = _thin(
        [
            (0.5 * bottom, 0.5 * width, bottom, width),
            (height - 0.5 * top, 0.5 * width, top, width),
            (bottom + 0.5 * mid, 0.5 * left, mid, left),
            (bottom + 0.5 * mid, width - 0.5 * right, mid, right),
        ]
    )
    b, h = width - 0.5 * (left + right), height - 0.5 * (top + bottom)
    around = b / top + b / bottom + h / left + h / right
    return replace(walls, torsion=4.0 * (b * h) ** 2 / around, radius=0.5 * min(width, height))


def _chan1(flange: float, web: float, inner: float, height: float) -> Shape:
    """CHAN1: overhang of the flanges, web, height between the flanges, total height."""
    return _channel(flange + web, height, web, 0.5 * (height - inner))


def _chan2(side: float, bottom: float, height: float, width: float) -> Shape:
    """CHAN2: thickness of the sides and of the bottom, height of the sides, total width; the bottom along z."""
    leg = height - bottom
    return _thin(
        [
            (0.5 * bottom, 0.5 * width, bottom, width),
            (bottom + 0.5 * leg, 0.5 * side, leg, side),
            (bottom + 0.5 * leg, width - 0.5 * side, leg, side),
        ]
    )


def _tee1(flange: float, web: float, flange_wall: float, web_wall: float) -> Shape:
    """T1, a T on its side: height and thickness of the flange (along y), length and thickness of the web (along z)."""
    return _thin([(0.0, 0.5 * flange_wall, flange, flange_wall), (0.0, flange_wall + 0.5 * web, web_wall, web)])


def _tee2(width: float, height: float, flange: float, web: float) -> Shape:
    """T2, a T upside down."""
    stem = height - flange
    return _thin([(0.5 * flange, 0.0, flange, width), (flange + 0.5 * stem, 0.0, stem, web)])


def _aitch(inner: float, flanges: float, height: float, web: float) -> Shape:
    """H: width between the flanges, both flanges together, their height, thickness of the web (along z)."""
    t = 0.5 * flanges
    at = 0.5 * (inner + t)
    return _thin([(0.0, -at, height, t), (0.0, 0.0, web, inner), (0.0, at, height, t)])


def _zed(flange: float, web: float, inner: float, height: float) -> Shape:
    """Z: overhang of a flange, web, height between the flanges, total height; the upper flange towards -z."""
    t = 0.5 * (height - inner)
    at = 0.5 * (web + flange)
    return _thin([(height - 0.5 * t, -at, t, flange), (0.5 * height, 0.0, height, web), (0.5 * t, at, t, flange)])


def _hat(height: float, wall: float, top: float, brim: float) -> Shape:
    """HAT: total height, wall, width of the top, overhang of each brim."""
    side, at = height - 2.0 * wall, 0.5 * (top - wall)
    foot = at - 0.5 * wall + 0.5 * (brim + wall)
    return _thin(
        [
            (height - 0.5 * wall, 0.0, wall, top),
            (0.5 * height, -at, side, wall),
            (0.5 * height, at, side, wall),
            (0.5 * wall, -foot, wall, brim + wall),
            (0.5 * wall, foot, wall, brim + wall),
        ]
    )


def _cross(width: float, web: float, height: float, wall: float) -> Shape:
    """CROSS: both arms together, upright, its height, thickness of the arms."""
    at = 0.5 * web + 0.25 * width
    return _thin([(0.0, 0.0, height, web), (0.0, -at, wall, 0.5 * width), (0.0, at, wall, 0.5 * width)])


SHAPES: dict[str, tuple[int, Callable[..., Shape]]] = {
    "ROD": (1, _rod),
    "TUBE": (2, _tube),
    "BAR": (2, rectangle),
    "BOX": (4, _box_shape),
    "I": (6, _i),
    "I1": (4, _i1),
    "T": (4, _tee),
    "CHAN": (4, _channel),
    "L": (4, _angle),
    "TUBE2": (2, _tube2),
    "BOX1": (6, _box1),
    "CHAN1": (4, _chan1),
    "CHAN2": (4, _chan2),
    "T1": (4, _tee1),
    "T2": (4, _tee2),
    "H": (4, _aitch),
    "Z": (4, _zed),
    "HAT": (4, _hat),
    "CROSS": (4, _cross),
}
"""Number of dimensions and the section of each type."""
OFF_CENTRE = {"T", "CHAN", "L", "CHAN1", "CHAN2", "T1", "T2", "HAT", "BOX1"}
"""The shear centre is not the centroid; where Nastran puts it is not followed for bars, which have none."""


def read_shape(card: Card, first: int) -> tuple[Shape, float]:
    """The section of a PBARL or PBEAML card whose type stands in field 3, and the non-structural mass after it.

    Raises
    ------
    InputError : an unknown type, a dimension that is missing or not positive.
    """
    kind = card.text(3).upper()
    if kind not in SHAPES:
        raise card.wrong(3, f"one of {', '.join(SHAPES)}", "Give the area and the moments on PBAR or PBEAM.")
    n, make = SHAPES[kind]
    dims = [card.real(first + i) for i in range(n)]
    if any(not d > 0.0 for d in dims[: 1 if kind == "TUBE" else n]):
        raise InputError(f"{card.name} {card.text(0)} has dimensions {dims}", where=card.where, expected="> 0")
    try:
        shape = make(*dims)
        right = all(0.0 < v < math.inf for v in (shape.area, shape.i1, shape.i2, shape.torsion))
    except ArithmeticError:  # no wall, or too large to compute with
        right = False
    if not right:
        raise InputError(
            f"{card.name} {card.text(0)}: dimensions {dims} make no {kind}",
            where=card.where,
            expected="walls thinner than the section",
        )
    return shape, card.real(first + n, 0.0)
