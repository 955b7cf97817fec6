"""Cross-sections by their dimensions, PBARL and PBEAML; tapered PBEAM and PBEAML as pieces that do not taper.

Axis 1 is y, in plane 1 (the orientation vector); axis 2 is z, in plane 2. Nastran's I1 is bending in plane 1, so i22.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.cross_section import CrossSection, Rectangle, box, composed, rectangle, tube
from creak.formats.nastran.text.bulk_data import Card
from creak.model.materials import BeamSection


def _bar(width: float, height: float) -> CrossSection:
    """Width along z, height along y; torsion by Roark's series, shear factor 5/6."""
    a, b = max(width, height), min(width, height)
    torsion = a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))
    return rectangle(height, width, torsion, 5.0 / 6.0)


def _rod(r: float) -> CrossSection:
    return tube(r, 0.0, 0.9)


def _tube(outer: float, inner: float) -> CrossSection:
    return tube(outer, inner, 0.5)


def _box(width: float, height: float, flange: float, web: float) -> CrossSection:
    """Width along z, height along y."""
    return _box1(width, height, flange, flange, web, web)


def _thin(parts: list[Rectangle]) -> CrossSection:
    """Open section of rectangles (y, z of the centre, height along y, width along z)."""
    return composed(parts, radius=0.5 * max(min(h, w) for _, _, h, w in parts))


def _i(h: float, a: float, b: float, tw: float, ta: float, tb: float) -> CrossSection:
    """Height, bottom and top flange widths, web, bottom and top flange thickness."""
    web = h - ta - tb
    return _thin([(0.5 * ta, 0.0, ta, a), (ta + 0.5 * web, 0.0, web, tw), (h - 0.5 * tb, 0.0, tb, b)])


def _i1(flange: float, web: float, inner: float, height: float) -> CrossSection:
    """DIM1 both flange overhangs together, DIM2 web, DIM3 height between the flanges, DIM4 total height."""
    t = 0.5 * (height - inner)
    return _i(height, flange + web, flange + web, web, t, t)


def _channel(width: float, height: float, web: float, flange: float) -> CrossSection:
    """CHAN: flange width, height, web and flange thickness; the web along y."""
    mid = height - 2.0 * flange
    return _thin(
        [
            (0.5 * flange, 0.5 * width, flange, width),
            (0.5 * height, 0.5 * web, mid, web),
            (height - 0.5 * flange, 0.5 * width, flange, width),
        ]
    )


def _tee(width: float, height: float, flange: float, web: float) -> CrossSection:
    stem = height - flange
    return _thin([(0.5 * stem, 0.0, stem, web), (height - 0.5 * flange, 0.0, flange, width)])


def _angle(width: float, height: float, flange: float, web: float) -> CrossSection:
    """L: horizontal leg along z, vertical along y, their thicknesses."""
    return _thin(
        [
            (0.5 * flange, 0.5 * width, flange, width),
            (flange + 0.5 * (height - flange), 0.5 * web, height - flange, web),
        ]
    )


def _tube2(outer: float, wall: float) -> CrossSection:
    return _tube(outer, outer - wall)


def _box1(width: float, height: float, top: float, bottom: float, left: float, right: float) -> CrossSection:
    """Closed box with four walls of their own."""
    return box(height, width, (top, right, bottom, left), radius=0.5 * min(width, height))


def _chan1(flange: float, web: float, inner: float, height: float) -> CrossSection:
    """CHAN1: overhang of the flanges, web, height between the flanges, total height."""
    return _channel(flange + web, height, web, 0.5 * (height - inner))


def _chan2(side: float, bottom: float, height: float, width: float) -> CrossSection:
    """CHAN2: thickness of the sides and of the bottom, height of the sides, total width; the bottom along z."""
    leg = height - bottom
    return _thin(
        [
            (0.5 * bottom, 0.5 * width, bottom, width),
            (bottom + 0.5 * leg, 0.5 * side, leg, side),
            (bottom + 0.5 * leg, width - 0.5 * side, leg, side),
        ]
    )


def _tee1(flange: float, web: float, flange_wall: float, web_wall: float) -> CrossSection:
    """T1, a T on its side: height and thickness of the flange (along y), length and thickness of the web (along z)."""
    return _thin([(0.0, 0.5 * flange_wall, flange, flange_wall), (0.0, flange_wall + 0.5 * web, web_wall, web)])


def _tee2(width: float, height: float, flange: float, web: float) -> CrossSection:
    """T2, a T upside down."""
    stem = height - flange
    return _thin([(0.5 * flange, 0.0, flange, width), (flange + 0.5 * stem, 0.0, stem, web)])


def _aitch(inner: float, flanges: float, height: float, web: float) -> CrossSection:
    """H: width between the flanges, both flanges together, their height, thickness of the web (along z)."""
    t = 0.5 * flanges
    at = 0.5 * (inner + t)
    return _thin([(0.0, -at, height, t), (0.0, 0.0, web, inner), (0.0, at, height, t)])


def _zed(flange: float, web: float, inner: float, height: float) -> CrossSection:
    """Z: overhang of a flange, web, height between the flanges, total height; the upper flange towards -z."""
    t = 0.5 * (height - inner)
    at = 0.5 * (web + flange)
    return _thin([(height - 0.5 * t, -at, t, flange), (0.5 * height, 0.0, height, web), (0.5 * t, at, t, flange)])


def _hat(height: float, wall: float, top: float, brim: float) -> CrossSection:
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


def _cross(width: float, web: float, height: float, wall: float) -> CrossSection:
    """CROSS: both arms together, upright, its height, thickness of the arms."""
    at = 0.5 * web + 0.25 * width
    return _thin([(0.0, 0.0, height, web), (0.0, -at, wall, 0.5 * width), (0.0, at, wall, 0.5 * width)])


SHAPES: dict[str, tuple[int, Callable[..., CrossSection]]] = {
    "ROD": (1, _rod),
    "TUBE": (2, _tube),
    "BAR": (2, _bar),
    "BOX": (4, _box),
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


def is_off_centre(kind: str, dims: Sequence[float]) -> bool:
    """Is the shear centre of this section beside the centroid? That of an I is where its flanges differ."""
    if kind == "I":
        _, bottom, top, _, t_bottom, t_top = dims
        return not (math.isclose(bottom, top, rel_tol=1e-6) and math.isclose(t_bottom, t_top, rel_tol=1e-6))
    return kind in OFF_CENTRE


def read_shape(card: Card, first: int) -> tuple[CrossSection, float]:
    """The section of a PBARL or PBEAML card whose type stands in field 3, and the non-structural mass after it.

    Raises
    ------
    InputError : an unknown type, a dimension that is missing or not positive.
    """
    dims = dimensions(card, first)
    return shape_of(card, dims), card.real(first + len(dims), 0.0)


def dimensions(card: Card, first: int) -> list[float]:
    """DIM1, DIM2, ... from a field on.

    Raises
    ------
    InputError : an unknown type, a dimension that is missing.
    """
    kind = card.text(3).upper()
    if kind not in SHAPES:
        raise card.wrong(3, f"one of {', '.join(SHAPES)}", "Give the area and the moments on PBAR or PBEAM.")
    return [card.real(first + i) for i in range(SHAPES[kind][0])]


def shape_of(card: Card, dims: list[float]) -> CrossSection:
    """The section of the type of a card with some dimensions.

    Raises
    ------
    InputError : a dimension that is not positive, dimensions that make no section.
    """
    kind = card.text(3).upper()
    n, make = SHAPES[kind]
    if any(not d > 0.0 for d in dims[: 1 if kind == "TUBE" else n]):
        raise card.error(f"{card.title} has dimensions {dims}", expected="> 0")
    try:
        shape = make(*dims)
        right = shape.sound
    except ArithmeticError:  # no wall, or too large to compute with
        right = False
    if not right:
        raise card.error(f"{card.title}: dimensions {dims} make no {kind}", expected="walls thinner than the section")
    return shape


TAPERED = 1e-3
"""Share by which sections of a beam may differ before it tapers."""
PIECES = 12
"""Pieces between two stations: a cantilever whose I falls to an eighth is then .5 % off at most."""
AREA, MASS = 0, 5
"""Places in A, I1, I2, I12, J, NSM."""


@dataclass(frozen=True)
class Profile:
    """Sections along a beam, from end A."""

    ends: tuple[float, ...]
    """Where each piece ends, 0 to 1; the last one at 1."""
    sections: tuple[BeamSection, ...]


def uniform(section: BeamSection) -> Profile:
    """The same section all along."""
    return Profile((1.0,), (section,))


def tapered(
    stations: Sequence[tuple[float, Sequence[float]]], make: Callable[[Sequence[float]], BeamSection]
) -> Profile:
    """Pieces of a beam whose A, I1, I2, I12, J and NSM are linear between stations, as Nastran takes them.

    A piece has the stiffness whose reciprocal is the mean of the reciprocals along it, and the mean mass.

    Parameters
    ----------
    stations : (x / L, values), ascending from 0 to 1. make : the section of some values.
    """
    first = np.array(stations[0][1])
    table = np.array([values for _, values in stations])
    if np.allclose(table, first, rtol=TAPERED, atol=TAPERED * float(np.abs(first).max()) * 1e-6):
        return uniform(make(first.tolist()))
    ends: list[float] = []
    sections: list[BeamSection] = []
    for (x0, a), (x1, b) in pairwise(stations):
        for k in range(PIECES):
            low, high = (np.array(a) + (np.array(b) - np.array(a)) * s for s in (k / PIECES, (k + 1) / PIECES))
            stiff = _harmonic(low, high)
            section = make(stiff.tolist())
            lost = 0.5 * (low[AREA] + high[AREA]) - stiff[AREA]
            mass = section.line_mass + section.material.density * lost
            sections.append(replace(section, line_mass=float(mass)))
            ends.append(x0 + (x1 - x0) * (k + 1) / PIECES)
    return Profile((*ends[:-1], 1.0), tuple(sections))


def _harmonic(a: FloatArray, b: FloatArray) -> FloatArray:
    """One over the mean of 1/f of what is linear from a to b, (b - a) / ln(b / a); the mean where f has no sign; of the
    mass and the product of inertia the mean."""
    mean = 0.5 * (a + b)
    with np.errstate(all="ignore"):
        found = np.where((a * b > 0.0) & (np.abs(b - a) > 1e-6 * np.abs(mean)), (b - a) / np.log(b / a), mean)
    found[[3, MASS]] = mean[[3, MASS]]
    return np.asarray(found, dtype=np.float64)


def pbeam_stations(card: Card) -> tuple[list[tuple[float, list[float]]], int]:
    """x / L and A, I1, I2, I12, J, NSM at the stations of a PBEAM, and the field of K1.

    Raises
    ------
    InputError : stations that are not between the ends.
    """
    at, places = 8, list[tuple[float, int]]()
    if card.text(at).upper() not in _WORDS:
        at += 8
    while card.text(at).upper() in _WORDS:
        places.append((card.real(at + 1, 1.0), at + 2))
        at += 16 if card.text(at).upper() == "YES" else 8
    return _values(card, [card.real(i, 0.0) for i in range(2, 8)], places), at


def pbeaml_dimensions(card: Card) -> list[tuple[float, list[float]]]:
    """x / L and DIM1, DIM2, ..., NSM at the stations of a PBEAML.

    Raises
    ------
    InputError : an unknown type, a dimension that end A lacks, stations that are not between the ends.
    """
    dims = dimensions(card, 8)
    n = len(dims)
    at, places = 8 + n + 1, list[tuple[float, int]]()
    while card.text(at).upper() in _WORDS:
        places.append((card.real(at + 1, 1.0), at + 2))
        at += n + 3
    return _values(card, [*dims, card.real(8 + n, 0.0)], places)


def pbeaml_stations(card: Card, along: Sequence[tuple[float, Sequence[float]]]) -> list[tuple[float, list[float]]]:
    """x / L and A, I1, I2, I12, J, NSM of `pbeaml_dimensions`.

    Raises
    ------
    InputError : dimensions that make no section.
    """
    found = []
    for x, (*dims, mass) in along:
        shape = shape_of(card, dims)
        found.append((x, [shape.area, shape.i22, shape.i11, shape.i12, shape.torsion, mass]))
    return found


def _values(card: Card, start: Sequence[float], places: Sequence[tuple[float, int]]) -> list[tuple[float, list[float]]]:
    """The values at end A, at the stations (x / L, first field) and at end B.

    Blank values of end B are those of end A, blank ones in between are linear between the ends.
    """
    _check(card, [x for x, _ in places])
    end = next((i for x, i in places if x == 1.0), None)
    last = list(start) if end is None else [card.real(end + i, a) for i, a in enumerate(start)]
    found = [(0.0, list(start))]
    for x, i in sorted(places):
        if x < 1.0:
            line = [a + (b - a) * x for a, b in zip(start, last, strict=True)]
            found.append((x, [card.real(i + j, value) for j, value in enumerate(line)]))
    return [*found, (1.0, last)]


_WORDS = ("YES", "YESA", "NO")


def _check(card: Card, places: Sequence[float]) -> None:
    if any(not 0.0 < x <= 1.0 for x in places) or len(set(places)) < len(places):
        raise card.error(
            f"{card.title} has stations at {', '.join(f'{x:g}' for x in places)}",
            expected="X/XB between 0 and 1, each once",
            fix="Correct them.",
        )
