"""Loads of heat: the forces at the nodes that hold an element as it is against a rise in temperature, reversed.

f = integral of B' D alpha dT, with the strains B of the element's own stiffness, so that an element that is free to
expand ends without stress (Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (2000), section 2.2). dT is given
at the nodes and constant through thickness and section.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.elements.bushing import arm_matrix
from creak.elements.geometry import CHUNK
from creak.elements.registry import FORMULATIONS
from creak.model.materials import GeneralShell, Section
from creak.model.mesh import ElementBlock


def block_heat_load(
    block: ElementBlock, coords: FloatArray, rise: FloatArray, *, form: str = "consistent"
) -> FloatArray:
    """(n_elem, d) forces of a block on its nodes, rigid arms (which do not expand) included.

    Parameters
    ----------
    block : of a kind with a `Formulation.heat_load`.
    coords : (n_node, 3) of all nodes of the model. rise : (n_elem, n_node_per_element) above what strains nothing.
    form : of the mass, as of `block_matrices`.
    """
    formulation = FORMULATIONS[block.kind]
    heated = None if form == "consistent" else formulation.softened_heat_load
    heated = heated or formulation.heat_load
    assert heated is not None
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
    if FORMULATIONS[kind].heat_load is None or (isinstance(section, GeneralShell) and section.rigid):
        return False
    return expansion_of(section) is not None


def expansion_of(section: Section) -> Any:
    """`Expansion` of the section's material, `ShellExpansion` of a shell, None without."""
    source = section if isinstance(section, GeneralShell) else getattr(section, "material", None)
    return getattr(source, "expansion", None)
