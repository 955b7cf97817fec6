"""Linear equations between global dofs, reduced so that each eliminates a dof of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.model.constraints import Equation

ZERO = 1e-13
"""Coefficients below this share of the largest of their equation are rounding."""

Dof = tuple[int, int]
"""Node row and dof 1..6."""


def global_equations(dofs: Sequence[Dof], C: FloatArray, dependent: set[int], where: str) -> Iterator[Equation]:
    """C u = 0 on global dofs, reduced so that each equation has a pivot of its own among the columns `dependent`.

    An equation without any of them pivots on its largest coefficient; one that is 0 = 0 is dropped.
    """
    C = np.array(C, dtype=np.float64)
    size = np.abs(C).max(axis=1, initial=0.0)
    pivots: dict[int, int] = {}
    for _ in range(C.shape[0]):
        free = [i for i in range(C.shape[0]) if i not in pivots and np.abs(C[i]).max(initial=0.0) > ZERO * size[i]]
        if not free:
            break
        mine = sorted(dependent - set(pivots.values()))
        pool = mine if mine and np.abs(C[np.ix_(free, mine)]).max() > 1e-9 * size.max() else list(range(C.shape[1]))
        block = np.abs(C[np.ix_(free, pool)])
        i, j = np.unravel_index(int(np.argmax(block)), block.shape)
        row, column = free[int(i)], pool[int(j)]
        C[row] /= C[row, column]
        others = np.arange(C.shape[0]) != row
        C[others] -= np.outer(C[others, column], C[row])
        pivots[row] = column
    for row, column in pivots.items():
        yield _equation(dofs, C[row], column, where)


def _equation(dofs: Sequence[Dof], row: FloatArray, pivot: int, where: str) -> Equation:
    used = [pivot, *(j for j in np.flatnonzero(np.abs(row) > ZERO * np.abs(row).max()).tolist() if j != pivot)]
    nodes = np.array([dofs[j][0] for j in used], dtype=np.int64)
    return Equation(nodes, np.array([dofs[j][1] for j in used], dtype=np.int64), row[used], where)


def rigid_arm(arm: FloatArray) -> FloatArray:
    """(6, 6): motion of a point at `arm` from a node, from the node's (u, theta): u + theta x arm, theta."""
    x, y, z = arm
    S = np.eye(6)
    S[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return S


def relative_motion(node: int, other: int, arm: FloatArray, rows: FloatArray, where: str) -> Iterator[Equation]:
    """rows (u_node - S(arm) u_other) = 0 in global axes, solved for dofs of `node`."""
    C = np.concatenate([rows, -rows @ rigid_arm(arm)], axis=1)
    dofs = [(n, d) for n in (node, other) for d in range(1, 7)]
    yield from global_equations(dofs, C, set(range(6)), where)
