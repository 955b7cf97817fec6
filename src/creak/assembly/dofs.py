"""Labels of physical degrees of freedom: 6 node + (dof - 1), node a row of the model, dof 1..6."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.model.mesh import Model

AXES = ("X", "Y", "Z", "RX", "RY", "RZ")


def dof_label(node_idx: int, dof: int) -> int:
    """Label of dof 1..6 at a node row."""
    return 6 * node_idx + dof - 1


def dof_labels(nodes_idx: IntArray, dofs: IntArray) -> IntArray:
    """Labels of dofs 1..6, each at its node row; arrays of any shape that fit each other."""
    return 6 * np.asarray(nodes_idx, dtype=np.int64) + dofs - 1


def node_dofs(nodes_idx: IntArray, dofs: tuple[int, ...] = (1, 2, 3, 4, 5, 6)) -> IntArray:
    """(n_node * n_dof,) labels, node by node."""
    return (6 * np.asarray(nodes_idx, dtype=np.int64)[:, None] + np.array(dofs, dtype=np.int64) - 1).ravel()


def dof_name(model: Model, label: int) -> str:
    """`node 17 RZ of part FRAME`, for messages."""
    node, axis = divmod(int(label), 6)
    parts = [p.name for p in model.parts if np.isin(node, p.nodes_idx)]
    of = f" of part {parts[0]}" if parts else ""
    return f"node {model.nodes.label(node)} {AXES[axis]}{of}"
