"""CalculiX matrices of *FREQUENCY, SOLVER=MATRIXSTORAGE: NAME.sti, NAME.mas and NAME.dof."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.arrays import Matrix
from creak.errors import InputError
from creak.formats.matrices.checks import DofMap, beside, checked, read_dof_map, read_text
from creak.formats.matrices.triplets import from_entries, read_table
from creak.model.superelement import Superelement

MOST_DIGITS = 20
"""Of a line of the .dof file."""


def read_calculix(path: Path, map_file: Path | None = None) -> Superelement:
    """Read NAME.sti and NAME.mas (row, column, value of one triangle) and NAME.dof (node.dof of each row).

    Places come from `map_file` (node,dof,x,y,z; NAME_dofs.csv beside is taken by itself). CalculiX has no viscous
    damping matrix.

    Raises
    ------
    InputError : a file is missing or cut off, or the files do not fit together.
    """
    nodes, dofs = _rows(path.with_suffix(".dof"))
    n = nodes.size
    K, M = (_matrix(path.with_suffix(ending), n) for ending in (".sti", ".mas"))
    map_file = map_file or beside(path, "_dofs.csv")
    positions = {} if map_file is None else read_dof_map(map_file).positions
    return checked(path.stem, DofMap(nodes, dofs, positions), K, M, None, path)


def _rows(path: Path) -> tuple[np.ndarray, np.ndarray]:
    pairs = []
    for i, line in enumerate(read_text(path).splitlines(), start=1):
        if not line.strip():
            continue
        node, _, dof = line.strip().partition(".")
        if not (line.isascii() and node.isdigit() and dof.isdigit() and len(line) < MOST_DIGITS):
            raise InputError(f"{line.strip()!r} names no dof", where=f"{path}:{i}", expected="node.dof, such as 12.3")
        pairs.append((int(node), int(dof)))
    if not pairs:
        raise InputError("there are no rows", where=path, fix="Copy or write the file again")
    table = np.array(pairs, dtype=np.int64)
    return table[:, 0], table[:, 1]


def _matrix(path: Path, n: int) -> Matrix:
    entries = read_table(path, 3, "row, column, value")
    rows, columns = (entries[:, k].astype(np.int64) - 1 for k in (0, 1))
    if min(rows.min(), columns.min()) < 0 or max(rows.max(), columns.max()) >= n:
        raise InputError(
            f"the matrix has entries outside the {n} rows of the .dof file",
            where=path,
            fix="Give the three files of the same run",
        )
    return from_entries(rows, columns, entries[:, 2], n)
