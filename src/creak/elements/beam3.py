"""Three-node beam: two straight ones in a row."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.elements import beam2
from creak.model.materials import BeamSection
from creak.model.mesh import COMMON, Own

HALVES = (([0, 1], slice(0, 12)), ([1, 2], slice(6, 18)))
"""Nodes of the two beams, and their dofs."""


def of_halves(coords: FloatArray, own: Own, made: Callable[[FloatArray, Own], FloatArray]) -> FloatArray:
    """(n, 18, 18): the sum of the (n, 12, 12) that `made` gives for nodes 1, 2 and for nodes 2, 3."""
    out = np.zeros((len(coords), 18, 18))
    for ends, both in HALVES:
        out[:, both, both] += made(coords[:, ends], own)
    return out


def stiffness(coords: FloatArray, section: BeamSection, own: Own = COMMON) -> FloatArray:
    """Stiffness of two beams from node 1 to 2 and from 2 to 3, each as `beam2.stiffness`, exact under end loads.

    A curved beam becomes two chords: an error of the order (angle it turns through)^2/96 of its size.
    """
    return of_halves(coords, own, lambda x, mine: beam2.stiffness(x, section, mine))


def mass(coords: FloatArray, section: BeamSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass of the halves, see `beam2.mass`."""
    return of_halves(coords, own, lambda x, mine: beam2.mass(x, section, mine))


def geometric_stiffness(coords: FloatArray, section: BeamSection, own: Own, u: FloatArray) -> FloatArray:
    """Of both halves, see `beam2.geometric_stiffness`."""
    out = np.zeros((len(coords), 18, 18))
    for ends, both in HALVES:
        out[:, both, both] += beam2.geometric_stiffness(coords[:, ends], section, own, u[:, ends])
    return out


def heat_load(coords: FloatArray, section: BeamSection, own: Own, rise: FloatArray) -> FloatArray:
    """Of both halves, see `beam2.heat_load`."""
    out = np.zeros((len(coords), 18))
    for ends, both in HALVES:
        out[:, both] += beam2.heat_load(coords[:, ends], section, own, rise[:, ends])
    return out
