"""Linear equations between dofs in displacement frames, written in global dofs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.formats.nastran.mesh.grids import Grids
from creak.model.constraints import Equation

ZERO = 1e-13
"""Coefficients below this share of the largest of their equation are rounding."""

LocalDof = tuple[int, int]
"""Node row and dof 1..6 in the node's displacement frame."""


def local_equations(
    grids: Grids, dofs: Sequence[LocalDof], C: FloatArray, n_dependent: int, where: str
) -> Iterator[Equation]:
    """C u = 0 on local dofs; those of the first `n_dependent` are to be eliminated.

    The dofs are turned to global axes, and the equations combined so that each eliminates a global dof of its own
    (of a node with a dependent dof, the translations and the rotations apart) with the largest pivot there is.
    """
    columns: dict[LocalDof, int] = {}
    entries: list[tuple[int, int, float]] = []
    dependent: set[int] = set()
    for k, (row, dof) in enumerate(dofs):
        first = 4 if dof > 3 else 1
        for axis, share in enumerate(grids.direction(row, dof)):
            if abs(share) > ZERO:
                column = columns.setdefault((row, first + axis), len(columns))
                entries.append((k, column, float(share)))
                if k < n_dependent:
                    dependent.add(column)
    turn = np.zeros((len(dofs), len(columns)))
    for k, column, share in entries:
        turn[k, column] = share
    yield from global_equations(list(columns), np.asarray(C) @ turn, dependent, where)


def global_equations(dofs: Sequence[LocalDof], C: FloatArray, dependent: set[int], where: str) -> Iterator[Equation]:
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


def _equation(dofs: Sequence[LocalDof], row: FloatArray, pivot: int, where: str) -> Equation:
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
