"""Rigid motion of nodes: where every rigid-body mass, weight and effective mass has it from."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.dofs import dofs_of, nodes_of
from creak.model.mesh import Nodes


def rigid_vectors(labels: IntArray, nodes: Nodes, about: FloatArray) -> FloatArray:
    """(k, 6) u = e_j and u = e_j x (x - about), theta = e_j at labels of dofs; 0 at scalar points, as in Nastran."""
    node, axis = nodes_of(labels), dofs_of(labels) - 1
    arm = nodes.coords[node] - about
    R = np.zeros((labels.size, 6))
    R[np.arange(labels.size), axis] = 1.0
    for j, e in enumerate(np.eye(3)):
        moves = np.flatnonzero(axis < 3)
        R[moves, 3 + j] = np.cross(e, arm[moves])[np.arange(moves.size), axis[moves]]
    R[np.isin(node, nodes.scalar)] = 0.0
    return R
