"""Superelements in one NumPy file, which opens with numpy.load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices.checks import DofMap, checked, dense
from creak.formats.stored.npz_arrays import read_arrays
from creak.formats.stored.sealed import Damaged
from creak.model.superelement import Superelement

Arrays = dict[str, NDArray]
LARGEST = 2.0**53
"""Of an integer that a float holds exactly."""


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
    nodes = _whole(arrays.get("position_nodes", np.empty(0, int)), "position_nodes", path)
    places = _numbers(arrays.get("positions", np.empty((0, 3))), "positions", path)
    if places.shape != (nodes.size, 3):
        raise InputError(
            f"positions is {_shape(places)} for {nodes.size} position_nodes",
            where=path,
            expected="three coordinates for each",
        )
    name = str(arrays["name"]) if "name" in arrays and not arrays["name"].ndim else path.stem
    positions = dict(zip(nodes.tolist(), places, strict=True))
    node_ids, dofs = (_whole(arrays[key], key, path) for key in ("node_ids", "dofs"))
    rows = DofMap(node_ids, dofs, positions)
    return checked(name, rows, K, M, C, path)


def _whole(array: NDArray, key: str, path: Path) -> IntArray:
    """A vector of integers; floats that are integers too."""
    values = _numbers(array, key, path)
    if array.ndim != 1 or not (np.abs(values) < LARGEST).all() or not (values == np.rint(values)).all():
        raise InputError(f"{key} is {_shape(array)} of {array.dtype}", where=path, expected="a vector of integers")
    return values.astype(np.int64)


def _numbers(array: NDArray, key: str, path: Path) -> FloatArray:
    if array.dtype.kind not in "iuf":
        raise InputError(f"{key} is {_shape(array)} of {array.dtype}", where=path, expected="numbers")
    return array.astype(float)


def _shape(array: NDArray) -> str:
    return " x ".join(map(str, array.shape)) or "a single value"


def _load(path: Path) -> Arrays:
    try:
        return read_arrays(path)
    except Damaged as error:
        raise InputError(
            f"this is no complete NumPy file ({error})",
            where=path,
            fix="Copy or write it again; numpy.savez makes such files",
        ) from error


def _matrix(arrays: Arrays, key: str, n: int, path: Path) -> Matrix | None:
    if key in arrays:
        return _numbers(arrays[key], key, path)
    names = [f"{key}_{part}" for part in ("row", "column", "value")]
    if not all(name in arrays for name in names):
        return None
    rows, columns = (_whole(arrays[name], name, path) for name in names[:2])
    values = _numbers(arrays[names[2]], names[2], path)
    outside = (rows < 0) | (rows >= n) | (columns < 0) | (columns >= n) if rows.shape == columns.shape else True
    if rows.shape != columns.shape or rows.shape != values.shape or np.any(outside):
        raise InputError(
            f"the triplets of {key} do not make a {n} x {n} matrix",
            where=path,
            expected="three vectors of one length, rows and columns numbered from 0",
        )
    return sparse.coo_array((values, (rows, columns)), shape=(n, n)).tocsr()


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
