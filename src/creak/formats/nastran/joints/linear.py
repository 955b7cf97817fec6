"""Linear equations between dofs in displacement frames, written in global dofs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.equations import ZERO, global_equations
from creak.formats.nastran.mesh.grids import Grids
from creak.model.constraints import Equation

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
