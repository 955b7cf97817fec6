"""Which way gap channels push: the two faces of a play or of a slot are not one place."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.model.dofs import dofs_of, nodes_of

AGAINST = -0.5
"""Cosine below which two channels push against each other: normals more than 120 degrees apart."""


def sides(gaps: GapOperator) -> list[IntArray]:
    """Channels of each contact by the way they push, contact by contact; every channel is in one of them."""
    way, found = pushes(gaps), []
    for group in dict.fromkeys(gaps.group):
        left = np.array([j for j, g in enumerate(gaps.group) if g == group], dtype=np.int64)
        while left.size:
            against = way[left] @ way[left[0]] < AGAINST
            found.append(left[~against])
            left = left[against]
    return found


def pushes(gaps: GapOperator) -> FloatArray:
    """(m, 6) unit direction in which a channel pushes its secondary node.

    In space where it moves the node's place, else about the axes of rotation; where G does not hold the node, the sum
    of its row over all nodes.
    """
    G = gaps.G.tocoo()
    at, dof = nodes_of(gaps.labels[G.col]), dofs_of(gaps.labels[G.col]) - 1
    own, whole = np.zeros((gaps.m, 6)), np.zeros((gaps.m, 6))
    np.add.at(whole, (G.row, dof), G.data)
    mine = at == gaps.nodes_idx[G.row]
    np.add.at(own, (G.row[mine], dof[mine]), G.data[mine])
    way = np.where(own.any(axis=1, keepdims=True), own, whole)
    way[np.asarray(way[:, :3].any(axis=1)), 3:] = 0.0
    length = np.linalg.norm(way, axis=1)[:, None]
    return np.asarray(np.divide(way, length, out=np.zeros_like(way), where=length > 0.0))
