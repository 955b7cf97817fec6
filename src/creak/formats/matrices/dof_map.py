"""The map of rows to nodes and dofs as a table: NAME_dofs.csv with the header node,dof,x,y,z."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import DofMap, read_text
from creak.formats.measured.csv_rows import csv_rows
from creak.model.superelement import Superelement

HEADER = ("node", "dof", "x", "y", "z")
LARGEST = 10**15
"""Of a label."""


def read_dof_map(path: Path) -> DofMap:
    """Read node,dof,x,y,z per row of the matrices; x,y,z may be left blank or out.

    Raises
    ------
    InputError : the file is missing, has another header, or a row that is not numbers.
    """
    lines = list(csv_rows(read_text(path).splitlines(), path))
    if not lines or [c.strip().lower() for c in lines[0][1][:2]] != list(HEADER[:2]):
        raise InputError("the header of the map is missing", where=f"{path}:1", expected=",".join(HEADER))
    nodes, dofs, positions = [], [], {}
    for number, cells in lines[1:]:
        if not cells:
            continue
        try:
            node, dof = int(cells[0]), int(cells[1])
            place = [float(c) for c in cells[2:5] if c.strip()]
            if max(abs(node), abs(dof)) > LARGEST:
                raise ValueError("a label of more digits than any program writes")
        except (ValueError, IndexError) as error:
            raise InputError(
                f"{','.join(cells)!r} is no row of a map", where=f"{path}:{number}", expected=",".join(HEADER)
            ) from error
        nodes.append(node)
        dofs.append(dof)
        if len(place) == 3 and node:
            positions[node] = np.array(place)
    return DofMap(np.array(nodes, dtype=np.int64), np.array(dofs, dtype=np.int64), positions)


def write_dof_map(superelement: Superelement, path: Path) -> Path:
    """Write the map of a superelement; numbers read back exactly."""
    with complete_file(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        for node, dof in zip(superelement.node_ids.tolist(), superelement.dofs.tolist(), strict=True):
            place = superelement.positions.get(node) if node else None
            writer.writerow([node, dof, *(["", "", ""] if place is None else map(float, place))])
    return path


def beside(path: Path, ending: str) -> Path | None:
    """The file with the same stem and this ending, if there is one: part.mtx, part_dofs.csv."""
    other = path.with_name(path.stem + ending)
    return other if other.is_file() else None
