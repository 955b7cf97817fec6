"""The nodes whose motion a study keeps, and those of them that nothing moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.arrays import IntArray
from creak.assembly.coupling import Driven
from creak.assembly.system import System
from creak.model.constraints import held_labels, tied_nodes
from creak.model.dofs import nodes_of
from creak.model.mesh import Model
from creak.studies.file.places import Places
from creak.studies.warned import Warned


def output_nodes(
    model: Model, node_sets: Sequence[str], pairs: IntArray, measured: Sequence[IntArray], places: Places
) -> IntArray:
    """Rows of the nodes of pairs, of the node sets in [output] nodes and of tests, each once, in that order."""
    where = places.where("output", "nodes")
    sets = [model.node_set(name, where=where) for name in node_sets]
    return np.array(list(dict.fromkeys(np.concatenate([pairs.ravel(), *sets, *measured]).tolist())), dtype=np.int64)


def unmoved_warnings(model: Model, nodes: IntArray, driven: Driven, superelements: Sequence[System]) -> list[str]:
    """Nodes of the output without an element, a link, a support or a drive: their motion is written as zero."""
    moved = tied_nodes(model.constraints, model.nodes.count)
    for block in model.blocks:
        moved[block.nodes_idx] = True
    moved[driven.nodes_idx] = moved[nodes_of(held_labels(model.fixed))] = True
    for system in superelements:
        moved[nodes_of(system.labels)] = True
    bare = nodes[~moved[nodes]]
    if not bare.size:
        return []
    others, verb = (f" and {bare.size - 1} more", "have") if bare.size > 1 else ("", "has")
    return [
        Warned(
            f"node {model.nodes.label(int(bare[0]))}{others} of the output {verb} no element, link or support: nothing "
            "moves there, and zero is written; look at [output] nodes"
        )
    ]
