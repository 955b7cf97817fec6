"""What every superelement must satisfy, whatever file it came from; the map of its rows to nodes and dofs as a table,
NAME_dofs.csv with the header node,dof,x,y,z."""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy import sparse

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.csv_rows import csv_rows
from creak.given import LARGEST, computable
from creak.model.superelement import Superelement

SYMMETRY = 1e-8
"""Largest |A_ij - A_ji| relative to the largest |A_ij| that still counts as rounding."""

T = TypeVar("T")


@dataclass(frozen=True)
class DofMap:
    """Node and dof of every row; 0, 0 for a generalised coordinate."""

    node_ids: IntArray
    dofs: IntArray
    positions: Mapping[int, FloatArray] = field(default_factory=dict)


def checked(name: str, rows: DofMap, K: Matrix, M: Matrix, C: Matrix | None, source: Path) -> Superelement:
    """A superelement with symmetric, finite matrices that fit its rows; rounding of symmetry is averaged out.

    Raises
    ------
    InputError : matrices of the wrong size, not finite, not symmetric to 1e-8; dofs outside 1..6; a row given twice.
    """
    nodes, components = np.asarray(rows.node_ids, dtype=np.int64), np.asarray(rows.dofs, dtype=np.int64)
    _check_rows(nodes, components, source)
    matrices = {"K": K, "M": M} if C is None else {"K": K, "M": M, "C": C}
    fine = {key: symmetric(matrix, key, nodes.size, source) for key, matrix in matrices.items()}
    known = {int(n) for n in nodes if n > 0}
    places = {n: np.asarray(x, dtype=float) for n, x in rows.positions.items() if n in known}
    lost = [n for n, x in places.items() if x.shape != (3,) or not np.all(np.isfinite(x))]
    if lost:
        raise InputError(
            f"the place of node {lost[0]} is {places[lost[0]].tolist()}",
            where=source,
            expected="three finite coordinates",
        )
    return Superelement(name, nodes, components, fine["K"], fine["M"], fine.get("C"), places, str(source))


def _check_rows(nodes: IntArray, dofs: IntArray, source: Path) -> None:
    physical = nodes > 0
    bad = np.flatnonzero(physical & ((dofs < 1) | (dofs > 6)) | (nodes < 0))
    if bad.size:
        raise InputError(
            f"row {bad[0] + 1} belongs to dof {dofs[bad[0]]} of node {nodes[bad[0]]}",
            where=source,
            expected="dofs 1 to 6 of a node, or node 0 and dof 0 for a generalised coordinate",
            fix="Reduce to displacements and rotations only",
        )
    keys, counts = np.unique(np.stack([nodes, dofs], axis=1)[physical], axis=0, return_counts=True)
    if np.any(counts > 1):
        node, dof = keys[np.argmax(counts > 1)]
        raise InputError(f"dof {dof} of node {node} has more than one row", where=source, fix="List each dof once")


def symmetric(matrix: Matrix, name: str, n: int, source: Path) -> Matrix:
    """The matrix with rounding of symmetry averaged out; an error if it is not n x n, finite and symmetric."""
    check_size(tuple(matrix.shape), name, n, source)
    values = matrix.data if sparse.issparse(matrix) else matrix
    if not np.all(np.abs(values) <= LARGEST):
        raise InputError(
            f"matrix {name} has entries that are not finite, or beyond {LARGEST:g}", where=source, fix="Export it again"
        )
    largest = float(np.max(np.abs(values), initial=0.0))
    difference = matrix - matrix.T
    skew = float(abs(difference).max()) if n else 0.0
    if skew == 0.0:
        return matrix
    if skew > SYMMETRY * largest:
        raise InputError(
            f"matrix {name} is not symmetric: largest |A_ij - A_ji| is {skew:.3g}, largest entry {largest:.3g}",
            where=source,
            expected=f"symmetry to {SYMMETRY:g} of the largest entry",
            fix="Export the symmetric part, without follower loads, friction or gyroscopic terms",
        )
    return 0.5 * (matrix + matrix.T)


def check_size(shape: tuple[int, ...], name: str, n: int, source: Path) -> None:
    """Raise InputError where a matrix is not n x n."""
    if shape != (n, n):
        raise InputError(
            f"matrix {name} is {' x '.join(map(str, shape))} but the map of nodes and dofs has {n} rows",
            where=source,
            fix="Give the map that was written together with the matrices",
        )


def dense(matrix: Matrix) -> FloatArray:
    """Any matrix as an array."""
    if sparse.issparse(matrix):
        return np.asarray(matrix.toarray(), dtype=float)
    if isinstance(matrix, np.ndarray):
        return np.asarray(matrix, dtype=float)
    return np.asarray(matrix @ np.eye(matrix.shape[1]), dtype=float)


def compact(matrix: Matrix) -> Matrix:
    """A sparse matrix as an array where more than a quarter of its entries are filled."""
    filled = matrix.nnz > 0.25 * matrix.shape[0] * matrix.shape[1]
    return dense(matrix) if filled else sparse.csr_array(matrix)


def first_of(found: Mapping[str, T], names: Iterable[str], what: str, source: Path) -> T:
    """The first of the known names that is there."""
    known = tuple(names)
    for name in known:
        if name in found:
            return found[name]
    there = ", ".join(sorted(found)) or "none"
    raise InputError(
        f"there is no {what} matrix (found: {there})",
        where=source,
        expected=" or ".join(known),
        fix=f"Write the {what} matrix to the file too, or rename it",
    )


def refuse_structural(K4: Matrix | None, source: Path) -> None:
    """Raise InputError where there is a structural damping matrix."""
    if K4 is not None and abs(K4).max() > 0.0:
        raise InputError(
            "there is a structural damping matrix, which has no equivalent in time without a frequency",
            where=source,
            fix="Export the superelement without it (K4); give viscous damping there, or [damping] in the study",
        )


def reordered(matrix: Matrix, rows: IntArray) -> FloatArray:
    """Rows and columns of a matrix in another order, as an array."""
    return dense(matrix)[np.ix_(rows, rows)]


def by_node(superelement: Superelement) -> IntArray:
    """Rows sorted by node and dof, generalised coordinates last, in their order."""
    generalised = superelement.node_ids == 0
    dofs = np.where(generalised, np.arange(superelement.n), superelement.dofs)
    return np.lexsort((dofs, superelement.node_ids, generalised))


def read_text(path: Path) -> str:
    """The text of a file without a mark of UTF-8; latin-1 takes any byte, so comments in any language pass."""
    try:
        return plain_file(path).read_text(encoding="latin-1").removeprefix(codecs.BOM_UTF8.decode("latin-1"))
    except OSError as error:
        raise InputError(f"the file cannot be read: {error.strerror}", where=path, fix="Check the path") from error


def read_bytes(path: Path) -> bytes:
    """The bytes of a file."""
    try:
        return plain_file(path).read_bytes()
    except OSError as error:
        raise InputError(f"the file cannot be read: {error.strerror}", where=path, fix="Check the path") from error


def number(text: str) -> float:
    """A number as Fortran or Nastran writes it: 1.0E+03, 1.0D+03, 1.0+3. ValueError if it is none."""
    try:
        return float(text)
    except ValueError:
        plain = text.strip().upper().replace("D", "E")
        if "E" not in plain:
            plain = re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", plain)
        return float(plain)


def field_value(text: str) -> float | None:
    """The finite number of a field of a card, as `number` reads it; None: it is none, or too large or small."""
    try:
        value = math.nan if "_" in text else computable(number(text))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


HEADER = ("node", "dof", "x", "y", "z")
LARGEST_LABEL = 10**15


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
            if max(abs(node), abs(dof)) > LARGEST_LABEL:
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
