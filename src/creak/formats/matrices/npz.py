"""Superelements in one NumPy file, which opens with numpy.load."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from creak.arrays import Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import checked, dense, read_bytes
from creak.model.superelement import Superelement

Arrays = dict[str, NDArray]


def read_npz(path: Path) -> Superelement:
    """Read K, M, C (arrays, or triplets K_row, K_column, K_value), node_ids, dofs, position_nodes, positions.

    Raises
    ------
    InputError : the file is missing, incomplete or damaged, or lacks K, M, node_ids or dofs.
    """
    arrays = _load(path)
    for key in ("node_ids", "dofs"):
        if key not in arrays:
            raise InputError(f"there is no array {key}", where=path, fix="Write it beside K and M: one entry per row")
    n = arrays["node_ids"].size
    if arrays["dofs"].shape != (n,) or arrays["node_ids"].shape != (n,):
        raise InputError(
            f"there are {n} node_ids and {arrays['dofs'].size} dofs",
            where=path,
            expected="two vectors, one entry per row of K",
        )
    K, M, C = (_matrix(arrays, key, n, path) for key in "KMC")
    if K is None or M is None:
        raise InputError(f"there is no array {'K' if K is None else 'M'}", where=path, fix="Write both K and M")
    positions = dict(
        zip(
            arrays.get("position_nodes", np.empty(0, int)).tolist(),
            arrays.get("positions", np.empty((0, 3))),
            strict=False,
        )
    )
    name = str(arrays["name"]) if "name" in arrays else path.stem
    return checked(name, arrays["node_ids"], arrays["dofs"], K, M, C, positions, path)


def _load(path: Path) -> Arrays:
    data = read_bytes(path)
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            return {key: file[key] for key in file.files}
    except (zipfile.BadZipFile, zlib.error, ValueError, EOFError, OSError, AttributeError, KeyError) as error:
        raise InputError(
            f"this is no complete NumPy file ({error})",
            where=path,
            fix="Copy or write it again; numpy.savez makes such files",
        ) from error


def _matrix(arrays: Arrays, key: str, n: int, path: Path) -> Matrix | None:
    if key in arrays:
        return arrays[key].astype(float)
    names = [f"{key}_{part}" for part in ("row", "column", "value")]
    if not all(name in arrays for name in names):
        return None
    rows, columns, values = (arrays[name] for name in names)
    try:
        return sparse.coo_array((values.astype(float), (rows, columns)), shape=(n, n)).tocsr()
    except ValueError as error:
        raise InputError(
            f"the triplets of {key} do not make a {n} x {n} matrix ({error})",
            where=path,
            fix="Number rows and columns from 0",
        ) from error


def write_npz(superelement: Superelement, path: Path) -> list[Path]:
    """Write one file; sparse matrices as triplets, others as arrays, all bit by bit."""
    arrays: Arrays = {"name": np.array(superelement.name), "node_ids": superelement.node_ids, "dofs": superelement.dofs}
    nodes = sorted(superelement.positions)
    arrays["position_nodes"] = np.array(nodes, dtype=np.int64)
    arrays["positions"] = np.array([superelement.positions[n] for n in nodes], dtype=float).reshape(-1, 3)
    for key, matrix in (("K", superelement.K), ("M", superelement.M), ("C", superelement.C)):
        if sparse.issparse(matrix):
            triplets = sparse.coo_array(matrix)
            arrays |= {f"{key}_row": triplets.row, f"{key}_column": triplets.col, f"{key}_value": triplets.data}
        elif matrix is not None:
            arrays[key] = dense(matrix)
    with complete_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    return [path]
