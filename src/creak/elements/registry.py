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
from typing import Any

from creak.arrays import FloatArray
from creak.elements import (
    beam2,
    beam3,
    bushing,
    cohesive,
    mass,
    nodal,
    shell_quad4,
    shell_quad8,
    shell_tri3,
    shell_tri6,
    solid_hex8,
    solid_hex20,
    solid_pyramid5,
    solid_tet4,
    solid_tet10,
    solid_wedge6,
    solid_wedge15,
    spring,
    spring_axial,
    truss2,
)
from creak.model.mesh import Own

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


FORMULATIONS: dict[str, Formulation] = {
    "quad4": Formulation(shell_quad4.stiffness, shell_quad4.mass, softened=shell_quad4.softened_stiffness),
    "tri3": Formulation(shell_tri3.stiffness, shell_tri3.mass),
    "quad8": Formulation(shell_quad8.stiffness, shell_quad8.mass),
    "tri6": Formulation(shell_tri6.stiffness, shell_tri6.mass),
    "beam2": Formulation(beam2.stiffness, beam2.mass),
    "beam3": Formulation(beam3.stiffness, beam3.mass),
    "truss2": Formulation(truss2.stiffness, truss2.mass),
    "hex8": Formulation(solid_hex8.stiffness, solid_hex8.mass),
    "wedge6": Formulation(solid_wedge6.stiffness, solid_wedge6.mass),
    "pyramid5": Formulation(solid_pyramid5.stiffness, solid_pyramid5.mass),
    "coh6": Formulation(cohesive.stiffness, cohesive.mass),
    "coh8": Formulation(cohesive.stiffness, cohesive.mass),
    "tet4": Formulation(solid_tet4.stiffness, solid_tet4.mass),
    "tet10": Formulation(solid_tet10.stiffness, solid_tet10.mass),
    "hex20": Formulation(solid_hex20.stiffness, solid_hex20.mass),
    "hex20r": Formulation(solid_hex20.reduced_stiffness, solid_hex20.mass),
    "hex20s": Formulation(solid_hex20.reduced_shear_stiffness, solid_hex20.mass),
    "wedge15": Formulation(solid_wedge15.stiffness, solid_wedge15.mass),
    "mass": Formulation(mass.stiffness, mass.mass),
    "rotary": Formulation(mass.stiffness, mass.mass),
    "spring1": Formulation(spring.stiffness, spring.mass, spring.damping),
    "spring2": Formulation(spring.stiffness, spring.mass, spring.damping),
    "axial2": Formulation(spring_axial.stiffness, spring_axial.mass, spring_axial.damping),
    "bush1": Formulation(bushing.stiffness, bushing.mass, bushing.damping),
    "bush2": Formulation(bushing.stiffness, bushing.mass, bushing.damping),
    "nodal1": Formulation(nodal.stiffness, nodal.mass, nodal.damping),
    "nodal2": Formulation(nodal.stiffness, nodal.mass, nodal.damping),
}
