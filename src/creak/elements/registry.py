"""Which file computes which kind of element."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from creak.arrays import FloatArray
from creak.elements import (
    beam2,
    mass,
    shell_quad4,
    shell_tri3,
    solid_hex8,
    solid_tet4,
    solid_wedge6,
    spring,
    truss2,
)

Matrices = Callable[[FloatArray, Any], FloatArray]


@dataclass(frozen=True)
class Formulation:
    """Element matrices of a whole block: `coords` (n, n_node, 3) and the section in, (n, d, d) out,
    d = 6 n_node, node by node (ux, uy, uz, rx, ry, rz) in global axes."""

    stiffness: Matrices
    mass: Matrices
    damping: Matrices | None = None
    """Viscous damping that the element itself has (dashpots); None where it has none."""


FORMULATIONS: dict[str, Formulation] = {
    "quad4": Formulation(shell_quad4.stiffness, shell_quad4.mass),
    "tri3": Formulation(shell_tri3.stiffness, shell_tri3.mass),
    "beam2": Formulation(beam2.stiffness, beam2.mass),
    "truss2": Formulation(truss2.stiffness, truss2.mass),
    "hex8": Formulation(solid_hex8.stiffness, solid_hex8.mass),
    "wedge6": Formulation(solid_wedge6.stiffness, solid_wedge6.mass),
    "tet4": Formulation(solid_tet4.stiffness, solid_tet4.mass),
    "mass": Formulation(mass.stiffness, mass.mass),
    "rotary": Formulation(mass.stiffness, mass.mass),
    "spring1": Formulation(spring.stiffness, spring.mass, spring.damping),
    "spring2": Formulation(spring.stiffness, spring.mass, spring.damping),
}
