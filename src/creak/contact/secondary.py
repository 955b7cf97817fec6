"""Nodes that may touch a main surface: thickness and stiffness of what they stand for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import Facets, bends, facets_of
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import BeamSection
from creak.model.mesh import Model


@dataclass(frozen=True)
class SecondaryNodes:
    """Nodes that may touch a main surface."""

    rows: IntArray
    thickness: FloatArray
    """(n,) twice the distance from the node to the surface it stands for."""
    normal_stiffness: FloatArray
    """(n,) of the parent elements, see `Facets`; inf where there is none to ask."""
    depth: FloatArray
    """(n,) see `Facets`."""
    width: FloatArray
    """(n,) of the facets around; inf for nodes without."""
    arm: FloatArray
    """(n,) see `Facets`; of nodes of shells without facets half the thickness, which their gap does not know of."""


def nodes_of(model: Model, name: str, *, where: str) -> SecondaryNodes:
    """Nodes of a secondary surface, element set or node set.

    Nodes of facets take the mean of the facets around them. Nodes of beams have the section's outer radius where
    it is known (CIRC, PIPE; RECT: half the smaller side), also in node sets and node-based surfaces; all other
    nodes of these have no thickness, as in Abaqus.

    Raises
    ------
    InputError : see `facets_of`.
    """
    surface = model.surfaces.get(name.upper())
    if surface is not None and surface.is_node_based:
        return _bare_nodes(model, np.unique(surface.nodes_idx))
    members = model.element_sets.get(name.upper()) if surface is None else None
    if surface is None and members is None and name.upper() in model.node_sets:
        return _bare_nodes(model, np.unique(model.node_set(name, where=where)))
    if members is not None:
        lines = np.array([model.blocks[row].kind in ("beam2", "beam3", "truss2") for row in members[:, 0]], dtype=bool)
        if lines.any() and lines.all():
            ends = [model.blocks[row].nodes_idx[element] for row, element in members]
            return _bare_nodes(model, np.unique(np.concatenate(ends)))
    facets = facets_of(model, name, where=where)
    values = (facets.thickness, facets.normal_stiffness, facets.depth, facets.width, facets.arm)
    return SecondaryNodes(facets.node_rows, *(nodal(facets, v) for v in values))


def _bare_nodes(model: Model, rows: IntArray) -> SecondaryNodes:
    """Nodes without facets: those of beams alone have the radius of the thickest."""
    n = model.nodes.count
    radius, arm, other = np.zeros(n), np.zeros(n), np.zeros(n, dtype=bool)
    for block in model.blocks:
        if isinstance(block.section, BeamSection):
            np.maximum.at(radius, block.nodes_idx, block.section.radius)
            np.maximum.at(arm, block.nodes_idx, block.section.radius * (block.kind != "truss2"))
        elif block.kind in SHELL_FACETS or block.kind in FACES:
            other[block.nodes_idx] = True
            if bends(block.section):
                np.maximum.at(arm, block.nodes_idx, 0.5 * block.section.thickness)
    endless = np.full(rows.size, np.inf)
    thickness = np.where(other, 0.0, 2.0 * radius)[rows]
    return SecondaryNodes(rows, thickness, endless, np.zeros(rows.size), endless, arm[rows])


def nodal(facets: Facets, values: FloatArray) -> FloatArray:
    """Mean of a facet quantity at the surface's nodes, in the order of `node_rows`."""
    rows = facets.node_rows
    at = np.searchsorted(rows, facets.nodes)
    total = np.zeros(rows.size)
    count = np.zeros(rows.size)
    np.add.at(total, at, values[:, None])
    np.add.at(count, at, 1.0)
    return total / count
