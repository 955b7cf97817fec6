"""Which file computes which kind of element, and what every element keeps to.

An element is functions `stiffness`, `mass` and, where it has dashpots, `damping` of a whole block at once:

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

A file gives the equations, their source, and where the method stops being valid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.elements import beam2, beam3, bushing, cohesive, discrete, truss2
from creak.elements.shells import quad4, quad8, tri3, tri6
from creak.elements.solids import hex8, hex20, pyramid5, tet4, tet10, wedge6, wedge15
from creak.model.mesh import COMMON, Own

Matrices = Callable[[FloatArray, Any, Own], FloatArray]


@dataclass(frozen=True)
class Formulation:
    """The functions of one kind of element."""

    stiffness: Matrices
    mass: Matrices
    damping: Matrices | None = None
    """Viscous damping that the element itself has (dashpots); None where it has none."""
    softened: Matrices | None = None
    """Stiffness for lumped or linear mass, None where it is the same."""


def zero(coords: FloatArray, section: Any, own: Own = COMMON) -> FloatArray:
    """(n, d, d): a mass has no stiffness, a spring and a bushing no mass."""
    d = 6 * coords.shape[1]
    return np.zeros((coords.shape[0], d, d))


MATRICES = ("stiffness", "mass", "damping")
FORMULATIONS: dict[str, Formulation] = {
    "quad4": Formulation(quad4.stiffness, quad4.mass, softened=quad4.softened_stiffness),
    "tri3": Formulation(tri3.stiffness, tri3.mass),
    "quad8": Formulation(quad8.stiffness, quad8.mass),
    "tri6": Formulation(tri6.stiffness, tri6.mass),
    "beam2": Formulation(beam2.stiffness, beam2.mass),
    "beam3": Formulation(beam3.stiffness, beam3.mass),
    "truss2": Formulation(truss2.stiffness, truss2.mass),
    "hex8": Formulation(hex8.stiffness, hex8.mass),
    "wedge6": Formulation(wedge6.stiffness, wedge6.mass),
    "pyramid5": Formulation(pyramid5.stiffness, pyramid5.mass),
    "coh6": Formulation(cohesive.stiffness, cohesive.mass),
    "coh8": Formulation(cohesive.stiffness, cohesive.mass),
    "tet4": Formulation(tet4.stiffness, tet4.mass),
    "tet10": Formulation(tet10.stiffness, tet10.mass),
    "hex20": Formulation(hex20.stiffness, hex20.mass),
    "hex20r": Formulation(hex20.reduced_stiffness, hex20.mass),
    "hex20s": Formulation(hex20.reduced_shear_stiffness, hex20.mass),
    "wedge15": Formulation(wedge15.stiffness, wedge15.mass),
    **dict.fromkeys(("mass", "rotary"), Formulation(zero, discrete.mass)),
    **dict.fromkeys(("spring1", "spring2"), Formulation(discrete.spring, zero, partial(discrete.spring, of="damping"))),
    "axial2": Formulation(discrete.axial, zero, partial(discrete.axial, of="damping")),
    "bush1": Formulation(bushing.stiffness, zero, bushing.damping),
    "bush2": Formulation(bushing.stiffness, zero, bushing.damping),
    **dict.fromkeys(("nodal1", "nodal2"), Formulation(*(partial(discrete.given, of=x) for x in MATRICES))),
}
