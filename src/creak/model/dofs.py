"""Labels of physical degrees of freedom: 6 node + (dof - 1), node a row of the model, dof 1..6.

This is the one place that knows how a label is made; a generalised coordinate has a label below 0, and no node.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray

PER_NODE = 6
ALL = (1, 2, 3, 4, 5, 6)
TRANSLATIONS = (1, 2, 3)
ROTATIONS = (4, 5, 6)
AXES = ("X", "Y", "Z", "RX", "RY", "RZ")


def dof_label(node_idx: int, dof: int) -> int:
    """Label of dof 1..6 at a node row."""
    return PER_NODE * node_idx + dof - 1


def dof_labels(nodes_idx: IntArray, dofs: IntArray) -> IntArray:
    """Labels of dofs 1..6, each at its node row; arrays of any shapes that fit each other."""
    return PER_NODE * np.asarray(nodes_idx, dtype=np.int64) + dofs - 1


def node_dofs(nodes_idx: IntArray, dofs: tuple[int, ...] = ALL) -> IntArray:
    """(n_node * n_dof,) labels, node by node."""
    return dof_labels(np.asarray(nodes_idx)[:, None], np.array(dofs, dtype=np.int64)).ravel()


def nodes_of(labels: IntArray) -> IntArray:
    """Node row of each label."""
    return np.asarray(labels, dtype=np.int64) // PER_NODE


def dofs_of(labels: IntArray) -> IntArray:
    """Dof 1..6 of each label."""
    return np.asarray(labels, dtype=np.int64) % PER_NODE + 1


def node_and_dof(label: int) -> tuple[int, int]:
    """Node row and dof 1..6 of a label."""
    node, axis = divmod(int(label), PER_NODE)
    return node, axis + 1
