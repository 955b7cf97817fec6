"""Superelements as Matrix Market files: NAME_K.mtx, NAME_M.mtx, NAME_C.mtx and NAME_dofs.csv."""

from __future__ import annotations

from inspect import signature
from pathlib import Path

from scipy import io, sparse

from creak.arrays import Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import check_size, checked, dense, read_text
from creak.formats.matrices.dof_map import read_dof_map, write_dof_map
from creak.model.superelement import Superelement

ENDINGS = ("_K.mtx", "_M.mtx", "_C.mtx", "_dofs.csv")
SPARSE_ARRAY = {"spmatrix": False} if "spmatrix" in signature(io.mmread).parameters else {}
"""From 1.18 on SciPy warns where one does not say which kind of sparse matrix is wanted."""


def read_matrix_market(path: Path, map_file: Path | None = None) -> Superelement:
    """Read the files of a superelement, given any one of them (or the common beginning of their names).

    Format: https://math.nist.gov/MatrixMarket/formats.html, read by SciPy.

    Raises
    ------
    InputError : K, M or the map is missing or damaged, or they do not fit together.
    """
    prefix = _prefix(path)
    files = [prefix.with_name(prefix.name + ending) for ending in ENDINGS]
    for file in files[:2]:
        if not file.is_file():
            raise InputError(
                "there is no such file", where=file, expected="NAME_K.mtx, NAME_M.mtx and NAME_dofs.csv side by side"
            )
    rows = read_dof_map(map_file or files[3])
    n = rows.node_ids.size
    K, M = (_read(file, key, n) for file, key in zip(files, "KM", strict=False))
    C = _read(files[2], "C", n) if files[2].is_file() else None
    return checked(prefix.name, rows.node_ids, rows.dofs, K, M, C, rows.positions, path)


def _prefix(path: Path) -> Path:
    for ending in ENDINGS:
        if path.name.endswith(ending):
            return path.with_name(path.name.removesuffix(ending))
    return path


def _read(path: Path, key: str, n: int) -> Matrix:
    try:
        check_size(_checked_shape(path), key, n, path)
        matrix = io.mmread(path, **SPARSE_ARRAY)
    except (ValueError, OverflowError, OSError, EOFError, StopIteration) as error:
        raise InputError(
            f"this is no complete Matrix Market file ({error})", where=path, fix="Copy or write it again"
        ) from error
    return sparse.csr_array(matrix) if sparse.issparse(matrix) else matrix


def _checked_shape(path: Path) -> tuple[int, int]:
    """Rows and columns; ValueError if the file is not real or has another number of entries than it announces.

    SciPy fills the rest of an array that was cut off with zeros, and crashes at a zero byte.
    """
    text = read_text(path)
    if "\0" in text:
        raise ValueError("it holds zero bytes")
    rows, columns, entries, layout, field, symmetry = io.mminfo(path)
    if field not in ("real", "integer"):
        raise ValueError(f"its entries are {field}, not real")
    if layout == "array":
        entries = rows * columns if symmetry == "general" else rows * (rows + 1) // 2
    lines = sum(1 for line in text.splitlines() if line.strip() and not line.startswith("%")) - 1
    if lines != entries:
        raise ValueError(f"it announces {entries} entries and has {lines}")
    return rows, columns


def write_matrix_market(superelement: Superelement, path: Path) -> list[Path]:
    """Write NAME_K.mtx, NAME_M.mtx, (NAME_C.mtx), NAME_dofs.csv for path = folder/NAME; 17 digits, lower triangles."""
    prefix, written = _prefix(path), []
    for ending, matrix in zip(ENDINGS[:3], (superelement.K, superelement.M, superelement.C), strict=True):
        if matrix is None:
            continue
        target = prefix.with_name(prefix.name + ending)
        values = sparse.coo_array(matrix) if sparse.issparse(matrix) else dense(matrix)
        with complete_file(target) as partial, partial.open("wb") as file:
            io.mmwrite(file, values, symmetry="symmetric", precision=17)
        written.append(target)
    return [*written, write_dof_map(superelement, prefix.with_name(prefix.name + ENDINGS[3]))]
