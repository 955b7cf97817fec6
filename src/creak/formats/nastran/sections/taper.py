"""Tapered PBEAM and PBEAML: the section along the beam, as pieces that do not taper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from creak.arrays import FloatArray
from creak.formats.nastran.sections.bar_shapes import dimensions, shape_of
from creak.formats.nastran.text.bulk_data import Card
from creak.model.materials import BeamSection

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
