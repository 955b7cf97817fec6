"""Superelements as Matrix Market files: NAME_K.mtx, NAME_M.mtx, NAME_C.mtx and NAME_dofs.csv."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from scipy import io, sparse

from creak.arrays import FloatArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import check_size, checked, dense, read_dof_map, read_text, write_dof_map
from creak.model.superelement import Superelement

ENDINGS = ("_K.mtx", "_M.mtx", "_C.mtx", "_dofs.csv")
WIDTH = {"array": 2, "coordinate": 3}
"""Layout -> numbers of the line of sizes."""


def read_matrix_market(path: Path, map_file: Path | None = None) -> Superelement:
    """Read the files of a superelement, given any one of them (or the common beginning of their names).

    Format: https://math.nist.gov/MatrixMarket/formats.html.

    Raises
    ------
    InputError : K, M or the map is missing or damaged, or they do not fit together.
    """
    prefix = _prefix(path)
    files = [prefix.with_name(prefix.name + ending) for ending in ENDINGS]
    for file in files[:2]:
        if not file.exists():
            raise InputError(
                "there is no such file", where=file, expected="NAME_K.mtx, NAME_M.mtx and NAME_dofs.csv side by side"
            )
    rows = read_dof_map(map_file or files[3])
    n = rows.node_ids.size
    K, M = (_read(file, key, n) for file, key in zip(files, "KM", strict=False))
    C = _read(files[2], "C", n) if files[2].is_file() else None
    return checked(prefix.name, rows, K, M, C, path)


def _prefix(path: Path) -> Path:
    for ending in ENDINGS:
        if path.name.endswith(ending):
            return path.with_name(path.name.removesuffix(ending))
    return path


def _read(path: Path, key: str, n: int) -> Matrix:
    try:
        return _matrix(read_text(path), lambda shape: check_size(shape, key, n, path))
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(
            f"this is no complete Matrix Market file ({error})", where=path, fix="Copy or write it again"
        ) from error


def _matrix(text: str, check: Callable[[tuple[int, int]], None]) -> Matrix:
    """The matrix of a file's text; `check` sees its shape before anything is made of it.

    SciPy's reader is not used: it crashes on damaged numbers, and fills an array that was cut off with zeros.

    Raises
    ------
    ValueError : not real, a wrong number of entries, a place outside the matrix.
    """
    if "\0" in text:
        raise ValueError("it holds zero bytes")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("%")]
    words = text.partition("\n")[0].lower().split()
    if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"] or words[2] not in WIDTH or not lines:
        raise ValueError("its first line does not say what it is")
    layout, field, symmetry = words[2:]
    if field not in ("real", "integer"):
        raise ValueError(f"its entries are {field}, not real")
    if symmetry not in ("general", "symmetric", "skew-symmetric"):
        raise ValueError(f"it is {symmetry}")
    size = [int(word) for word in lines[0].split()]
    if len(size) != WIDTH[layout] or min(size) < 0:
        raise ValueError(f"{lines[0].strip()!r} are no sizes"[:200])
    rows, columns = size[:2]
    check((rows, columns))
    if symmetry != "general" and rows != columns:
        raise ValueError(f"it is {symmetry} with {rows} rows and {columns} columns")
    skew = 1 if symmetry == "skew-symmetric" else 0
    entries = size[2] if layout == "coordinate" else rows * columns
    if layout == "array" and symmetry != "general":
        entries = rows * (rows + 1 - 2 * skew) // 2
    if len(lines) - 1 != entries:
        raise ValueError(f"it announces {entries} entries and has {len(lines) - 1}")
    values = np.fromiter(_numbers(lines[1:], 1 if layout == "array" else 3), np.float64)
    if layout == "array":
        return _of_columns(values, rows, columns, symmetry, skew)
    values = values.reshape(-1, 3)
    place = values[:, :2].astype(np.int64) - 1
    if (place < 0).any() or (place >= [rows, columns]).any() or (place + 1 != values[:, :2]).any():
        raise ValueError("an entry lies outside the matrix")
    i, j = place.T
    if symmetry != "general":
        off = i != j
        i, j = np.concatenate([i, j[off]]), np.concatenate([j, i[off]])
        mirrored = -values[off, 2] if skew else values[off, 2]
        return sparse.csr_array((np.concatenate([values[:, 2], mirrored]), (i, j)), shape=(rows, columns))
    return sparse.csr_array((values[:, 2], (i, j)), shape=(rows, columns))


def _numbers(lines: Iterable[str], width: int) -> Iterator[float]:
    for line in lines:
        words = line.split()
        if len(words) != width or "_" in line:
            raise ValueError(f"{line.strip()[:60]!r} is no entry")
        yield from map(float, words)


def _of_columns(values: FloatArray, rows: int, columns: int, symmetry: str, skew: int) -> FloatArray:
    """A full matrix from its columns, of symmetric ones from the diagonal (skew: below it) down."""
    out = np.zeros((rows, columns))
    if symmetry == "general":
        return values.reshape(columns, rows).T.copy()
    j, i = np.triu_indices(rows, skew)
    out[i, j] = values
    out[j, i] = -values if skew else values
    return out


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
