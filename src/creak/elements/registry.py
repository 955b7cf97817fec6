"""Which file computes which kind of element, and what every element keeps to.

An element is a file, and one `Formulation` here. Solids that plain rules integrate are these rules alone. The functions
`stiffness`, `mass` and, where it has dashpots, `damping` take a whole block at once:

Parameters
----------
coords : (n, n_node, 3) corners of n elements, global coordinates, length unit of the deck; nodes in Abaqus's order.
section : of all n elements, a record of `model.materials`.
own : what each element has of its own, n rows each (`model.mesh.Own`): axes, thickness; `COMMON`: nothing.

Returns
-------
(n, d, d) with d = 6 n_node, symmetric, node by node (ux, uy, uz, rx, ry, rz) in global axes, also where an element has
nothing on some of them. Rigid motion strains no element. Arms, lumping and linear mass are not theirs: see
`block_matrices`.

Raises
------
DegenerateElement : some elements, by row: nodes that coincide, no length, area or volume, corners that are not convex
    or run the wrong way round, an axis of the section along the beam, a material direction along the normal.

Two more functions take what happens at the nodes as a fourth argument: `geometric_stiffness` displacements (n, n_node,
6), `heat_load` the rise (n, n_node) of temperature; forces are (n, d).

A file gives the equations, their source, and where the method stops being valid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.elements import beam2, beam3, cohesive, discrete, truss2
from creak.elements.shells import quad4, quad8, tri3, tri6
from creak.elements.solids import hex8, hex20
from creak.elements.solids.common import (
    Reference,
    consistent_mass,
    geometric_stiffness,
    heat_load,
    isoparametric_stiffness,
)
from creak.elements.solids.pyramid5 import PYRAMID5
from creak.elements.solids.tetrahedra import TET4, TET10
from creak.elements.solids.wedges import WEDGE6, WEDGE15
from creak.model.mesh import COMMON, Own

Matrices = Callable[[FloatArray, Any, Own], FloatArray]
AtNodes = Callable[[FloatArray, Any, Own, FloatArray], FloatArray]


@dataclass(frozen=True)
class Formulation:
    """The functions of one kind of element."""

    stiffness: Matrices
    mass: Matrices
    damping: Matrices | None = None
    """Viscous damping that the element itself has (dashpots); None where it has none."""
    softened: Matrices | None = None
    """Stiffness for lumped or linear mass, None where it is the same."""
    geometric: AtNodes | None = None
    """What the stress of displacements adds to the stiffness, to first order: membrane forces of shells, axial forces
    of beams. `unstressed`: nothing; None: creak does not know."""
    heat_load: AtNodes | None = None
    """Integral of B' D alpha dT: the forces that hold it as it is against heat, reversed. dT is constant through
    thickness and section. None where it does not expand (springs, masses, given matrices, layers of glue)."""
    softened_heat_load: AtNodes | None = None
    """The same with the softened stiffness."""


def _stressed(element: Any) -> Formulation:
    """Of a file with all that a structural element has."""
    return Formulation(
        element.stiffness, element.mass, geometric=element.geometric_stiffness, heat_load=element.heat_load
    )


def _integrated(rule: Reference, of_mass: Reference) -> Formulation:
    """Of a solid whose stiffness is the integral of B' D B by one rule, its mass consistent by another."""
    return Formulation(
        partial(isoparametric_stiffness, reference=rule),
        partial(consistent_mass, reference=of_mass),
        geometric=partial(geometric_stiffness, reference=rule),
        heat_load=partial(heat_load, reference=rule),
    )


def unstressed(coords: FloatArray, section: Any, own: Own, u: FloatArray) -> FloatArray:
    """Points, and springs along fixed directions, are as stiff under load as without."""
    return zero(coords, section, own)


def zero(coords: FloatArray, section: Any, own: Own = COMMON) -> FloatArray:
    """(n, d, d): a mass has no stiffness, a spring and a bushing no mass."""
    d = 6 * coords.shape[1]
    return np.zeros((coords.shape[0], d, d))


_BUSHING = Formulation(discrete.bushing, zero, partial(discrete.bushing, of="damping"))
_GIVEN = Formulation(*(partial(discrete.given, of=x) for x in ("stiffness", "mass", "damping")))
_REDUCED = _integrated(hex20.EIGHT, hex20.TWENTY_SEVEN)
FORMULATIONS: dict[str, Formulation] = {
    "quad4": replace(_stressed(quad4), softened=quad4.softened_stiffness, softened_heat_load=quad4.softened_heat_load),
    "tri3": _stressed(tri3),
    "quad8": _stressed(quad8),
    "tri6": _stressed(tri6),
    "beam2": _stressed(beam2),
    "beam3": _stressed(beam3),
    "truss2": _stressed(truss2),
    "hex8": _stressed(hex8),
    "wedge6": _integrated(*WEDGE6),
    "pyramid5": _integrated(*PYRAMID5),
    "coh6": Formulation(cohesive.stiffness, cohesive.mass),
    "coh8": Formulation(cohesive.stiffness, cohesive.mass),
    "tet4": _integrated(*TET4),
    "tet10": _integrated(*TET10),
    "hex20": _integrated(hex20.TWENTY_SEVEN, hex20.TWENTY_SEVEN),
    "hex20r": replace(_REDUCED, stiffness=hex20.reduced_stiffness),
    "hex20s": replace(_REDUCED, stiffness=hex20.reduced_shear_stiffness, heat_load=hex20.reduced_shear_heat_load),
    "wedge15": _integrated(*WEDGE15),
    **dict.fromkeys(("mass", "rotary"), Formulation(zero, discrete.mass, geometric=unstressed)),
    **dict.fromkeys(
        ("spring1", "spring2"),
        Formulation(discrete.spring, zero, partial(discrete.spring, of="damping"), geometric=unstressed),
    ),
    "axial2": Formulation(discrete.axial, zero, partial(discrete.axial, of="damping")),
    "bush1": replace(_BUSHING, geometric=unstressed),
    "bush2": _BUSHING,
    "nodal1": replace(_GIVEN, geometric=unstressed),
    "nodal2": _GIVEN,
}
