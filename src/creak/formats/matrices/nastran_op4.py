"""External superelements of Nastran (MSC, NX, OptiStruct): OUTPUT4 matrices and the map in the .asm file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from creak.errors import InputError
from creak.formats.complete_file import write_text
from creak.formats.matrices import nastran_points as nastran
from creak.formats.matrices.checks import beside, by_node, checked, first_of, read_dof_map, refuse_structural, reordered
from creak.formats.matrices.op4_file import read_op4_matrices, write_op4_matrices
from creak.formats.nastran.text.bulk_data import free_card
from creak.model.superelement import Superelement

STIFFNESS = ("KXX", "KAA", "KAAX")
MASS = ("MXX", "MAA", "MAAX")
DAMPING = ("BXX", "BXX1", "BAA", "BAAX")
STRUCTURAL = ("K4XX", "K4XX1", "K4AA", "K4AAX")


def read_op4(path: Path, map_file: Path | None = None) -> Superelement:
    """Read what EXTSEOUT(ASMBULK, MATOP4=unit) wrote: KXX, MXX, BXX1, K4XX1 and the .asm file beside it.

    Rows are sorted by (interior) id: six dofs per grid, one per scalar point; EXTRN cards in the map give grids with
    fewer. Matrices of grids with CD frames are turned to the basic frame. `map_file` may also be a table
    node,dof,x,y,z, which tells no frames: grids then move in those of the deck they join
    (`Superelement.in_deck_frames`). Damping matrices of another size than K are placeholders and are left out.

    Raises
    ------
    InputError : a file is missing, cut off or does not fit; K or M is missing or not symmetric; K4 is not 0.
    """
    found = read_op4_matrices(path, {*STIFFNESS, *MASS, *DAMPING, *STRUCTURAL})
    K, M = first_of(found, STIFFNESS, "stiffness", path), first_of(found, MASS, "mass", path)
    fitting = {name: matrix for name, matrix in found.items() if matrix.shape == K.shape}
    C = next((fitting[name] for name in DAMPING if name in fitting), None)
    K4 = next((fitting[name] for name in STRUCTURAL if name in fitting), None)
    refuse_structural(K4, path)
    C = C if C is not None and np.any(C) else None
    map_file = map_file or beside(path, ".asm") or beside(path, "_dofs.csv")
    if map_file is None:
        raise InputError(
            "the map of rows to grids is missing",
            where=path,
            fix=f"Give the .asm file of the same run, or put it beside as {path.stem}.asm",
        )
    if map_file.suffix.lower() == ".csv":
        made = checked(path.stem, read_dof_map(map_file), K, M, C, path)
        return replace(made, in_deck_frames=frozenset(made.node_ids[made.node_ids > 0].tolist()))
    points = nastran.read_points(map_file)
    rows = nastran.all_rows(points, map_file)
    _check_size(K.shape[0], rows, path, map_file)
    rotation = nastran.to_basic(points, rows, map_file)
    stiffness, mass, damping = (nastran.rotated(matrix, rotation) for matrix in (K, M, C))
    return checked(path.stem, nastran.labels(points, rows), stiffness, mass, damping, path)


def _check_size(n: int, rows: list[tuple[int, int]], path: Path, map_file: Path) -> None:
    if n == len(rows):
        return
    scalars = sum(dof == nastran.SCALAR for _, dof in rows)
    grids = len({i for i, dof in rows if dof != nastran.SCALAR})
    raise InputError(
        f"the stiffness matrix has {n} rows, the map {map_file.name} {len(rows)}: {len(rows) - scalars} dofs of "
        f"{grids} grids and {scalars} scalar points",
        where=path,
        fix="Give the .asm file of the same run; if grids have fewer than six dofs, add an EXTRN card to it, "
        "or give a table node,dof,x,y,z as .csv",
    )


def write_op4(superelement: Superelement, path: Path, *, superelement_id: int = 101) -> list[Path]:
    """Write NAME.op4 (binary, double: KXX, MXX, BXX1) and NAME.asm (SEBULK, SECONCT, GRID, SPOINT; basic frame).

    Rows are sorted by node and dof; generalised coordinates become scalar points numbered above the largest node.
    Where a node has fewer than six dofs, an EXTRN card says which; it belongs to the BEGIN SUPER section of the run.

    Raises
    ------
    InputError : the place of a node is not known, or ids are too large for Nastran.
    """
    order = by_node(superelement)
    matrices = {"KXX": superelement.K, "MXX": superelement.M, "BXX1": superelement.C}
    text = _assembly(superelement, path, superelement_id)
    write_op4_matrices({name: reordered(m, order) for name, m in matrices.items() if m is not None}, path)
    map_file = path.with_suffix(".asm")
    write_text(map_file, text)
    return [path, map_file]


def _assembly(superelement: Superelement, path: Path, superelement_id: int) -> str:
    grids = sorted({int(n) for n in superelement.node_ids if n > 0})
    points = [*grids, *nastran.scalar_ids(superelement)[superelement.generalised].tolist()]
    pairs = [i for point in points for i in (point, point)]
    text = "$ Bulk data of an external superelement for the main bulk data of the assembly run\n"
    text += free_card("SEBULK", [superelement_id, "EXTOP4", None, "MANUAL", None, None, superelement_id])
    text += free_card("SECONCT", [superelement_id, 0, None, "NO", None, None, None, None, *pairs])
    text += "".join(nastran.point_cards(superelement, path))
    return text + _partial_dofs(superelement, grids)


def _partial_dofs(superelement: Superelement, grids: list[int]) -> str:
    """EXTRN cards where a node has fewer than six dofs, else nothing."""
    ids, dofs = nastran.scalar_ids(superelement), superelement.dofs
    given = {node: "".join(map(str, sorted(dofs[ids == node].tolist()))) for node in grids}
    if all(components == "123456" for components in given.values()):
        return ""
    given |= dict.fromkeys(ids[superelement.generalised].tolist(), "0")
    fields = [item for point, components in given.items() for item in (point, components)]
    return "$ belongs to the BEGIN SUPER section of this superelement\n" + free_card("EXTRN", fields)
