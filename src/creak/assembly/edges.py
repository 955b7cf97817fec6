"""Shells and the edges of their surfaces, as the whole model has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.drilling import held_directions
from creak.assembly.partition import shared_nodes
from creak.elements.free_sides import SHELLS, ending_sides, twisting_sides, with_free_sides
from creak.model.constraints import KinematicCoupling, RigidLink
from creak.model.dofs import ROTATIONS
from creak.model.mesh import ElementBlock, Model

BEAMS = ("beam2", "beam3")


def with_edges(model: Model, blocks: Sequence[ElementBlock], nodes: IntArray) -> list[ElementBlock]:
    """The blocks, whose nodes are `nodes`, with the free sides of their shells.

    Of quadrilaterals these are the sides that no other shell of the model has, of triangles those along which a
    twisting moment falls to nothing: see `elements.free_sides`. Ties and equations join the edges of shells as a fold
    does, and leave them that.
    """
    beside = _shells_beside(model, blocks, nodes)
    out = with_free_sides(blocks, beside)
    shells = [k for k, block in enumerate(out) if block.kind in SHELLS]
    if all(out[k].kind != "tri3" for k in shells):
        return out
    coords = model.nodes.coords
    at, held = _held_rotations(model)
    for k, ends in zip(shells, ending_sides(coords, [*(out[k].nodes_idx for k in shells), *beside]), strict=False):
        block = out[k]
        if block.kind == "tri3":
            free = twisting_sides(coords, block.nodes_idx, ends, at, held)
            out[k] = replace(block, own=replace(block.own, free_sides=free))
    return out


def _held_rotations(model: Model) -> tuple[IntArray, FloatArray]:
    """Nodes (k,), sorted, and the projection (k, 3, 3) on the rotations that supports, rigid bodies and beams hold."""
    rigid = [c.nodes for c in model.constraints if isinstance(c, KinematicCoupling | RigidLink)]
    beams = [block.nodes_idx.ravel() for block in model.blocks if block.kind in BEAMS]
    supported, held = held_directions(model, ROTATIONS)
    stiff = np.unique(np.concatenate([supported[:0], *rigid, *beams]))
    nodes = np.union1d(supported, stiff)
    out = np.zeros((nodes.size, 3, 3))
    out[np.searchsorted(nodes, supported)] = held
    out[np.searchsorted(nodes, stiff)] = np.eye(3)
    return nodes, out


def _shells_beside(model: Model, blocks: Sequence[ElementBlock], nodes: IntArray) -> list[IntArray]:
    """Corner nodes of the shells of other parts that may have a side in common with the blocks."""
    shared = np.zeros(model.nodes.count, dtype=bool)
    shared[np.intersect1d(shared_nodes(model), nodes)] = True
    if not shared.any():
        return []
    parts = {block.part for block in blocks}
    others = [block.nodes_idx for block in model.blocks if block.kind in SHELLS and block.part not in parts]
    return [corners[np.count_nonzero(shared[corners], axis=1) >= 2] for corners in others]
