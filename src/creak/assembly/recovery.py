"""The motion of every node from the coordinates of a reduced model, a few instants at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.model.dofs import dofs_of, nodes_of

MEMORY = 500_000_000
"""Bytes of motion recovered at a time."""


def recovered(
    system: System, q: FloatArray, s: FloatArray, *, block: int | None = None
) -> Iterator[tuple[slice, FloatArray]]:
    """Full-field motion u (n_label, k_block) of all `system.labels`, block by block: u = V q + R s.

    Inside a superelement a block is one back-substitution, u_i = -K_ii^-1 K_ib u_b + Phi eta; memory is that of a
    block, however many instants there are.

    Parameters
    ----------
    q : (n, k) coordinates. s : (n_support, k) prescribed motion. block : instants at a time.
    """
    width = block or int(np.clip(MEMORY // (8 * max(system.labels.size, 1)), 1, 256))
    for start in range(0, q.shape[1], width):
        here = slice(start, min(start + width, q.shape[1]))
        yield here, system.recover(q[:, here], s[:, here])


def by_node(u: FloatArray, labels: IntArray, n_node: int, dofs: int = 3) -> FloatArray:
    """(k, n_node, dofs) motion of all nodes from (n_label, k) motion; zero where a node has no such dof.

    Parameters
    ----------
    dofs : 3: translations; 6: rotations too.
    """
    out = np.zeros((u.shape[1], n_node, dofs))
    moves = dofs_of(labels) <= dofs
    out[:, nodes_of(labels[moves]), dofs_of(labels[moves]) - 1] = u[moves].T
    return out
