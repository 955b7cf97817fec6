"""Abaqus .mtx files: *SUBSTRUCTURE MATRIX OUTPUT (user element text) and *MATRIX OUTPUT (one entry per line).

Sources: Abaqus keyword reference, *SUBSTRUCTURE MATRIX OUTPUT, *USER ELEMENT, *MATRIX, *MATRIX OUTPUT.

Convention for generalised coordinates, which have no user node: a node label that is not positive, or above
Abaqus' largest user label 999 999 999, is an internal node, and its dofs are generalised coordinates. A map
NAME_dofs.csv with node 0 in their rows says the same of a user element text whose internal nodes have other labels.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import (
    DofMap,
    beside,
    by_node,
    checked,
    dense,
    first_of,
    number,
    read_dof_map,
    read_text,
    reordered,
    write_dof_map,
)
from creak.formats.matrices.triplets import from_entries, lower_entries, read_table
from creak.model.superelement import Superelement

LARGEST_LABEL = 999_999_999
CONSTRAINED = 1e36
"""Abaqus puts this on the diagonal of constrained dofs in *MATRIX OUTPUT."""
_DOFS = 1000
_END = np.array([[_DOFS, 0], [1, 0], [0, _DOFS], [0, 1]])
"""(label, dof, label, dof) @ _END = (1000 label + dof) of row and column."""
_KINDS = {"STIFFNESS": "K", "MASS": "M", "VISCOUSDAMPING": "C", "DAMPING": "C"}
_WHAT = {"K": "stiffness", "M": "mass"}


def read_abaqus(path: Path, map_file: Path | None = None) -> Superelement:
    """Read either kind of .mtx file, told apart by *USER ELEMENT.

    Raises
    ------
    InputError : see `read_user_element` and `read_matrix_output`.
    """
    text = read_text(path)
    if re.search(r"^\*USER ELEMENT", text, re.I | re.M):
        return read_user_element(path, map_file)
    return read_matrix_output(path, map_file)


# ---------------------------------------------------------------------------------------- user element
@dataclass
class _Element:
    """What has been read of a user element so far."""

    nodes: list[int] = field(default_factory=list)
    count: int = 0
    dof_lines: list[tuple[str, list[int]]] = field(default_factory=list)
    values: dict[str, list[float]] = field(default_factory=dict)


LARGEST_INTEGER = 10**15


def read_user_element(path: Path, map_file: Path | None = None) -> Superelement:
    """Read *USER ELEMENT, LINEAR with *MATRIX, TYPE=STIFFNESS, MASS (and VISCOUS DAMPING).

    The node labels are those of the comment ** ELEMENT NODES. The first data line lists the dofs of the first node
    and all that follow, a further line the position of a node and the dofs from there on. A matrix is the upper
    triangle column by column, or (UNSYM) the whole matrix, which must be symmetric all the same. Places
    come from `map_file` (node,dof,x,y,z; NAME_dofs.csv beside is taken by itself).

    Raises
    ------
    InputError : nodes, dofs, K or M are missing, the numbers are too few or too many, the map does not agree.
    """
    element = _parse(path)
    rows = _element_rows(element, path)
    n = len(rows)
    matrices = {key: _unpacked(values, n, key, path) for key, values in element.values.items()}
    K, M = (first_of(matrices, (key,), _WHAT[key], path) for key in "KM")
    nodes = np.array([node if 0 < node <= LARGEST_LABEL else 0 for node, _ in rows], dtype=np.int64)
    dofs = np.where(nodes > 0, [dof for _, dof in rows], 0)
    map_file = map_file or beside(path, "_dofs.csv")
    table = DofMap(nodes, dofs) if map_file is None else read_dof_map(map_file)
    if map_file is not None:
        _check_map(nodes, dofs, table, map_file)
    return checked(path.stem, table, K, M, matrices.get("C"), path)


def _check_map(nodes: IntArray, dofs: IntArray, table: DofMap, map_file: Path) -> None:
    """The map may only turn labelled rows into generalised coordinates."""
    if table.node_ids.size != nodes.size:
        raise InputError(
            f"the map has {table.node_ids.size} rows, the user element {nodes.size}",
            where=map_file,
            fix="Give one row per dof of the user element, in its order",
        )
    differs = (table.node_ids != 0) & ((table.node_ids != nodes) | (table.dofs != dofs))
    if np.any(differs):
        k = int(np.argmax(differs))
        raise InputError(
            f"row {k + 1} is dof {table.dofs[k]} of node {table.node_ids[k]} in the map, "
            f"dof {dofs[k]} of node {nodes[k]} in the user element",
            where=map_file,
            fix="List the rows in the order of the user element",
        )


def _parse(path: Path) -> _Element:
    element, state = _Element(), ""
    for i, raw in enumerate(read_text(path).splitlines(), start=1):
        line, where = raw.strip(), f"{path}:{i}"
        if line.startswith("**"):
            state = _comment(line, state, element, where)
        elif line.startswith("*"):
            state = _keyword(line, element, where)
        elif line and state == "dofs":
            element.dof_lines.append((where, _integers(line, where)))
        elif line and state in "KMC" and state:
            element.values[state] += _reals(line, where)
    return element


def _comment(line: str, state: str, element: _Element, where: str) -> str:
    """Comments carry the node labels; within the data they mean nothing."""
    words = line.strip("* ").upper()
    if words == "ELEMENT NODES":
        return "nodes"
    if state == "nodes" and re.fullmatch(r"[-\d,\s]+", words):
        element.nodes += _integers(words, where)
        if len(element.nodes) >= element.count:
            return "dofs"
    return state


def _keyword(line: str, element: _Element, where: str) -> str:
    """The state after a keyword line: which data follow."""
    parts = [part.strip().upper().replace(" ", "") for part in line[1:].split(",")]
    options = dict(part.partition("=")[::2] for part in parts[1:])
    if parts[0] == "USERELEMENT":
        if element.count:
            raise InputError("there is a second *USER ELEMENT", where=where, fix="Put each in its own file")
        element.count = _integers(options.get("NODES", ""), where)[0] if options.get("NODES") else 0
        return "dofs"
    if parts[0] != "MATRIX":
        return ""
    kind = options.get("TYPE", "")
    if kind not in _KINDS:
        raise InputError(
            f"*MATRIX, TYPE={kind}",
            where=where,
            expected="STIFFNESS, MASS or VISCOUS DAMPING",
            fix="Leave this matrix out; structural damping has no equivalent in time",
        )
    element.values[_KINDS[kind]] = []
    return _KINDS[kind]


def _integers(line: str, where: str) -> list[int]:
    try:
        found = [int(c) for c in line.replace(",", " ").split()]
        if any(abs(i) > LARGEST_INTEGER for i in found):
            raise ValueError("more digits than any program writes")
        return found
    except ValueError as error:
        raise InputError(f"{line!r} is no list of integers", where=where) from error


def _reals(line: str, where: str) -> list[float]:
    try:
        return [number(c) for c in line.replace(",", " ").split()]
    except ValueError as error:
        raise InputError(
            f"{line!r} is no list of numbers",
            where=where,
            fix="If this is the last line, the file was cut off: copy it again",
        ) from error


def _element_rows(element: _Element, path: Path) -> list[tuple[int, int]]:
    """(node label, dof) of every row."""
    if not element.nodes or len(element.nodes) != (element.count or len(element.nodes)):
        raise InputError(
            f"{len(element.nodes)} node labels for a user element with {element.count} nodes",
            where=path,
            expected="all labels in the comment lines after ** ELEMENT NODES",
            fix="Keep the comments that Abaqus writes",
        )
    if not element.dof_lines:
        raise InputError("the user element has no list of dofs", where=path, fix="Write it again")
    dofs_from = {1: element.dof_lines[0][1]}
    for where, numbers in element.dof_lines[1:]:
        if not 1 <= numbers[0] <= len(element.nodes):
            raise InputError(f"node position {numbers[0]}", where=where, expected=f"1 to {len(element.nodes)}")
        dofs_from[numbers[0]] = numbers[1:]
    rows: list[tuple[int, int]] = []
    dofs: list[int] = []
    for position, node in enumerate(element.nodes, start=1):
        dofs = dofs_from.get(position, dofs)
        rows += [(node, dof) for dof in dofs]
    return rows


def _unpacked(values: list[float], n: int, name: str, path: Path) -> FloatArray:
    """The matrix from its columns, whole or down to the diagonal (as masses are even with UNSYM)."""
    whole, triangle = n * n, n * (n + 1) // 2
    if len(values) not in (whole, triangle):
        raise InputError(
            f"matrix {name} has {len(values)} entries for {n} dofs",
            where=path,
            expected=f"{triangle}, or {whole} for an unsymmetric one",
            fix="Copy the file again; if it is complete, its list of dofs is wrong",
        )
    if len(values) == whole:
        return np.array(values).reshape(n, n).T
    matrix = np.zeros((n, n))
    matrix[np.tril_indices(n)] = values
    return matrix + np.tril(matrix, -1).T


def write_user_element(superelement: Superelement, path: Path) -> list[Path]:
    """Write NAME.mtx as *SUBSTRUCTURE MATRIX OUTPUT does, with 17 digits, and NAME_dofs.csv with the places.

    Rows of a node are put together, generalised coordinates last, as internal nodes -1, -2, ... with dof 1.
    """
    order = by_node(superelement)
    dofs_of: dict[int, list[int]] = {}
    for row in _rows_with_labels(superelement)[order].tolist():
        dofs_of.setdefault(row[0], []).append(row[1])
    lines: list[str] = []
    last: list[int] = []
    for position, dofs in enumerate(dofs_of.values(), start=1):
        if dofs != last:
            lines.append(", ".join(f"{i:10d}" for i in ([position, *dofs] if position > 1 else dofs)) + "\n")
        last = dofs
    nodes = list(dofs_of)
    table = _in_order(superelement, order)
    matrices = {"STIFFNESS": table.K, "MASS": table.M, "VISCOUS DAMPING": table.C}
    with complete_file(path) as partial, partial.open("w", encoding="ascii") as file:
        file.write(f"**\n** GENERATION OF SUBSTRUCTURE\n*USER ELEMENT, NODES={len(nodes):10d}, LINEAR\n")
        file.write("** ELEMENT NODES\n")
        for k in range(0, len(nodes), 10):
            file.write("** " + ", ".join(f"{node:10d}" for node in nodes[k : k + 10]) + "\n")
        file.writelines(lines)
        for kind, matrix in matrices.items():
            if matrix is not None:
                file.write(f"*MATRIX,TYPE={kind}\n")
                for j in range(table.n):
                    file.write(_four_a_line(matrix[: j + 1, j]))
    return [path, write_dof_map(table, path.with_name(f"{path.stem}_dofs.csv"))]


def _in_order(superelement: Superelement, order: IntArray) -> Superelement:
    K, M, C = (None if m is None else reordered(m, order) for m in (superelement.K, superelement.M, superelement.C))
    nodes, dofs = superelement.node_ids[order], superelement.dofs[order]
    return Superelement(superelement.name, nodes, dofs, K, M, C, superelement.positions, superelement.source)


def _rows_with_labels(superelement: Superelement) -> IntArray:
    """(n, 2) label and dof, generalised coordinates as dof 1 of the internal nodes -1, -2, ..."""
    rows = np.stack([superelement.node_ids, superelement.dofs], axis=1)
    generalised = superelement.generalised
    rows[generalised, 0] = -1 - np.arange(generalised.size)
    rows[generalised, 1] = 1
    return rows


def _four_a_line(values: FloatArray) -> str:
    lines = (values[k : k + 4] for k in range(0, values.size, 4))
    return "".join(", ".join(f"{v:24.16E}" for v in line) + "\n" for line in lines)


# --------------------------------------------------------------------------------------- matrix output
def read_matrix_output(path: Path, map_file: Path | None = None) -> Superelement:
    """Read NAME_STIFn.mtx with NAME_MASSn.mtx (and NAME_DMPVn.mtx, viscous damping) of *MATRIX OUTPUT beside it.

    FORMAT=MATRIX INPUT or LABELS: row node, dof, column node, dof, value; rows come sorted by label and dof, internal
    nodes last. FORMAT=COORDINATE: row, column, value, with the rows of the map NAME_STIFn_dofs.csv or `map_file`. One
    triangle is enough. Constrained dofs (1e36 on the diagonal) are an error: the matrices must be free.

    Raises
    ------
    InputError : a file is missing or cut off, COORDINATE without a map, dofs above 6, constrained dofs.
    """
    match = re.search(r"_(STIF|MASS|DMPV)(?=\d*\.mtx$)", path.name, re.I)
    if not match:
        raise InputError(
            "this name does not tell which matrix it is",
            where=path,
            expected="NAME_STIF1.mtx beside NAME_MASS1.mtx",
            fix="Rename the files so",
        )
    start, end = match.span(1)
    names = {
        key: path.name[:start] + kind + path.name[end:] for key, kind in (("K", "STIF"), ("M", "MASS"), ("C", "DMPV"))
    }
    stiffness, others = path.with_name(names["K"]), {key: path.with_name(names[key]) for key in "MC"}
    tables = {"K": _entries(stiffness)} | {key: _entries(p) for key, p in others.items() if p.is_file()}
    first_of(tables, ("M",), f"mass ({others['M'].name})", stiffness)
    map_file = map_file or beside(stiffness, "_dofs.csv")
    if all(table.shape[1] == 3 for table in tables.values()):
        if map_file is None:
            raise InputError(
                "this is FORMAT=COORDINATE, which does not say which dof a row is",
                where=stiffness,
                fix="Give a map node,dof,x,y,z as .csv, or write FORMAT=MATRIX INPUT",
            )
        return _from_coordinates(tables, read_dof_map(map_file), stiffness)
    if any(table.shape[1] == 3 for table in tables.values()):
        raise InputError(
            "one matrix is FORMAT=COORDINATE, another is not", where=stiffness, fix="Write all in the same format"
        )
    return _from_labels(tables, map_file, stiffness)


def _entries(path: Path) -> FloatArray:
    """(entries, 5) or (entries, 3)."""
    lines = (line for line in read_text(path).splitlines() if line.strip() and line.strip()[0] not in "*%#")
    columns = len(next(lines, "").replace(",", " ").split())
    what = "row node, dof, column node, dof, value (or row, column, value)"
    table = read_table(path, 3 if columns == 3 else 5, what)
    if np.any(np.abs(table[:, -1]) >= CONSTRAINED):
        raise InputError(
            "the matrix has constrained dofs (1e36 on the diagonal)",
            where=path,
            fix="Write the matrices in a step without boundary conditions",
        )
    return table


def _from_coordinates(tables: dict[str, FloatArray], table: DofMap, path: Path) -> Superelement:
    n = table.node_ids.size
    matrices: dict[str, Matrix] = {}
    for key, entries in tables.items():
        rows, columns = entries[:, 0].astype(np.int64) - 1, entries[:, 1].astype(np.int64) - 1
        outside = (np.minimum(rows, columns) < 0) | (np.maximum(rows, columns) >= n)
        if np.any(outside):
            k = int(np.argmax(outside))
            raise InputError(
                f"matrix {key} has an entry in row {rows[k] + 1}, column {columns[k] + 1}; the map has {n} rows",
                where=path,
                fix="Give the map of these matrices",
            )
        matrices[key] = from_entries(rows, columns, entries[:, 2], n)
    return checked(_name(path), table, matrices["K"], matrices["M"], matrices.get("C"), path)


def _from_labels(tables: dict[str, FloatArray], map_file: Path | None, path: Path) -> Superelement:
    ends = {key: table[:, :4].astype(np.int64) @ _END for key, table in tables.items()}
    codes = np.unique(np.concatenate([code.ravel() for code in ends.values()]))
    labels, dofs = np.divmod(codes, _DOFS)
    internal = (labels <= 0) | (labels > LARGEST_LABEL)
    order = np.lexsort((dofs, np.abs(labels), internal))
    row_of_code = np.argsort(order)
    matrices: dict[str, Matrix] = {}
    for key, table in tables.items():
        i, j = row_of_code[np.searchsorted(codes, ends[key])].T
        matrices[key] = from_entries(i, j, table[:, 4], codes.size)
    nodes, dofs = (np.where(internal, 0, numbers)[order] for numbers in (labels, dofs))
    positions = {} if map_file is None else read_dof_map(map_file).positions
    return checked(_name(path), DofMap(nodes, dofs, positions), matrices["K"], matrices["M"], matrices.get("C"), path)


def _name(path: Path) -> str:
    return re.sub(r"_STIF\d*$", "", path.stem, flags=re.I)


def write_matrix_output(superelement: Superelement, path: Path) -> list[Path]:
    """Write NAME_STIF1.mtx, NAME_MASS1.mtx, (NAME_DMPV1.mtx) as FORMAT=MATRIX INPUT, and NAME_STIF1_dofs.csv.

    `path` is folder/NAME or folder/NAME_STIF1.mtx. Lower triangle, 17 digits; generalised coordinates are dof 1 of the
    internal nodes -1, -2, ...; rows come back sorted by node and dof.
    """
    prefix = path.with_name(_name(path)) if path.suffix == ".mtx" else path
    table = _in_order(superelement, by_node(superelement))
    labels = _rows_with_labels(table).tolist()
    written = []
    for kind, matrix in (("STIF", table.K), ("MASS", table.M), ("DMPV", table.C)):
        if matrix is None:
            continue
        target = prefix.with_name(f"{prefix.name}_{kind}1.mtx")
        values = dense(matrix)
        with complete_file(target) as partial, partial.open("w", encoding="ascii") as file:
            for i, j in np.stack(lower_entries(values), axis=1).tolist():
                file.write(f"{labels[i][0]},{labels[i][1]}, {labels[j][0]},{labels[j][1]}, {values[i, j]:.16E}\n")
        written.append(target)
    return [*written, write_dof_map(table, prefix.with_name(f"{prefix.name}_STIF1_dofs.csv"))]
