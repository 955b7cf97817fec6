"""Loads of heat: the forces at the nodes that hold an element as it is against a rise in temperature, reversed.

f = integral of B' D alpha dT, with the strains B of the element's own stiffness, so that an element that is free to
expand ends without stress (Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (2000), section 2.2). dT is given
at the nodes and constant through thickness and section.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.elements import beam2, beam3, truss2
from creak.elements.bushing import arm_matrix
from creak.elements.geometry import CHUNK
from creak.elements.shells import quad4, quad8, tri3, tri6
from creak.elements.solids import hex8, hex20
from creak.elements.solids.common import Reference, heat_load
from creak.elements.solids.rules import SOLID_RULES
from creak.model.materials import GeneralShell, Section, SolidSection
from creak.model.mesh import ElementBlock, Own

Heated = Callable[[FloatArray, Any, Own, FloatArray], FloatArray]
"""(coords, section, own, rise) -> (n, d), as `stiffness` of an element; rise (n, n_node) of temperature."""


def _solid(reference: Reference) -> Heated:
    """Of solids whose stiffness is the integral of B' D B."""

    def made(coords: FloatArray, section: SolidSection, own: Own, rise: FloatArray) -> FloatArray:
        return heat_load(coords, section, own, reference, rise)

    return made


HEATED: dict[str, Heated] = {
    "quad4": quad4.heat_load,
    "tri3": tri3.heat_load,
    "quad8": quad8.heat_load,
    "tri6": tri6.heat_load,
    "beam2": beam2.heat_load,
    "beam3": beam3.heat_load,
    "truss2": truss2.heat_load,
    "hex8": hex8.heat_load,
    "hex20s": hex20.reduced_shear_heat_load,
    **{kind: _solid(rule) for kind, rule in SOLID_RULES.items()},
}
"""Kinds of elements that expand; layers of glue, springs, masses and given matrices do not."""


SOFTENED: dict[str, Heated] = {"quad4": quad4.softened_heat_load}
"""Of kinds that have another stiffness with lumped or linear mass."""


def block_heat_load(
    block: ElementBlock, coords: FloatArray, rise: FloatArray, *, form: str = "consistent"
) -> FloatArray:
    """(n_elem, d) forces of a block on its nodes, rigid arms (which do not expand) included.

    Parameters
    ----------
    coords : (n_node, 3) of all nodes of the model. rise : (n_elem, n_node_per_element) above what strains nothing.
    form : of the mass, as of `block_matrices`.
    """
    heated = HEATED[block.kind] if form == "consistent" else SOFTENED.get(block.kind, HEATED[block.kind])
    out = np.zeros((block.ids.size, 6 * block.nodes_idx.shape[1]))
    for start in range(0, block.ids.size, CHUNK):
        rows = slice(start, start + CHUNK)
        own, x = block.own.take(rows), coords[block.nodes_idx[rows]]
        x = x if own.arms is None else x + own.arms
        forces = heated(x, block.section, own, rise[rows])
        if own.arms is not None:
            each = arm_matrix(own.arms.reshape(-1, 3)).transpose(0, 2, 1) @ forces.reshape(-1, 6, 1)
            forces = each.reshape(forces.shape)
        out[rows] = forces
    return out


def expands(kind: str, section: Section) -> bool:
    """Whether heat strains elements of a kind with that section."""
    if kind not in HEATED or (isinstance(section, GeneralShell) and section.rigid):
        return False
    return expansion_of(section) is not None


def expansion_of(section: Section) -> Any:
    """`Expansion` of the section's material, `ShellExpansion` of a shell, None without."""
    source = section if isinstance(section, GeneralShell) else getattr(section, "material", None)
    return getattr(source, "expansion", None)
