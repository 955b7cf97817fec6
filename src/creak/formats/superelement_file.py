"""Saved superelements: HDF5 with matrices, modes, the dofs of every row, and what they were made from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.hdf5_file import hdf5_file

VERSION = 2


@dataclass(frozen=True)
class SavedSuperelement:
    """One reduced part as it lies in the file."""

    name: str
    made_from: Mapping[str, str]
    """What it depends on -> fingerprint."""
    matrices: Mapping[str, Matrix]
    """K, M, M_alone and, where there is one, C; (n, n) each."""
    shape: Matrix
    """P (n_b, n_xi)."""
    omega2: FloatArray
    """(n_mode,) rad^2/s^2."""
    modes: FloatArray
    """(n_i, n_mode) fixed-interface modes."""
    first_left_out: float
    """Eigenvalue of the first mode left out, rad^2/s^2."""
    node_ids: IntArray
    """(n,) node label of each row of the matrices as in the deck, 0 for generalised coordinates."""
    dofs: IntArray
    """(n,) 1..6, 0 for generalised coordinates."""
    about: Mapping[str, Any]
    """Provenance and health, as JSON."""
    static_at: IntArray
    """(k,) inner coordinates whose static motion is kept."""
    static_rows: FloatArray
    """(k, n_xi) that motion, for each coordinate of the boundary."""


def write_superelement_file(path: Path, saved: SavedSuperelement) -> None:
    """Write the file, complete or absent."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with complete_file(path, stream=False) as partial, hdf5_file(partial) as out:
        file = out.file
        file.attrs["creak_superelement"] = VERSION
        file.attrs["name"] = saved.name
        file.attrs["made_from"] = json.dumps(dict(saved.made_from))
        file.attrs["about"] = json.dumps(dict(saved.about))
        file.attrs["first_left_out"] = saved.first_left_out
        for key, A in {**saved.matrices, "P": saved.shape}.items():
            _put(file, key, A)
        for key in ("omega2", "modes", "node_ids", "dofs", "static_at", "static_rows"):
            file.create_dataset(key, data=getattr(saved, key))


def read_made_from(path: Path) -> dict[str, str]:
    """Only the fingerprints, to see whether the file still fits.

    Raises
    ------
    InputError : not a superelement file, or cut short.
    """
    with _opened(path) as file:
        return dict(json.loads(file.attrs["made_from"]))


def read_superelement_file(path: Path) -> SavedSuperelement:
    """Read a saved superelement.

    Raises
    ------
    InputError : not a superelement file, or cut short.
    """
    with _opened(path) as file:
        try:
            names = [k for k in ("K", "M", "M_alone", "C") if k in file]
            return SavedSuperelement(
                str(file.attrs["name"]),
                dict(json.loads(file.attrs["made_from"])),
                {k: _get(file, k) for k in names},
                _get(file, "P"),
                file["omega2"][:],
                file["modes"][:],
                float(file.attrs["first_left_out"]),
                file["node_ids"][:],
                file["dofs"][:],
                dict(json.loads(file.attrs["about"])),
                file["static_at"][:],
                file["static_rows"][:],
            )
        except (OSError, KeyError, ValueError) as error:
            raise _damaged(path, error) from error


def _opened(path: Path) -> h5py.File:
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise _damaged(path, error) from error
    if "creak_superelement" not in file.attrs or "made_from" not in file.attrs:
        file.close()
        raise InputError("not a superelement that creak has saved", where=path, fix="Name another file, or delete it.")
    if int(file.attrs["creak_superelement"]) != VERSION:
        version = int(file.attrs["creak_superelement"])
        file.close()
        raise InputError(
            f"superelement file of version {version}",
            where=path,
            expected=f"version {VERSION}",
            fix="Delete it and run `creak reduce` again.",
        )
    return file


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError(
        f"the superelement file is damaged or cut short ({str(error).splitlines()[0]})",
        where=path,
        fix="Delete it and run `creak reduce` again.",
    )


def _put(file: h5py.File, key: str, A: Matrix) -> None:
    if not sp.issparse(A):
        file.create_dataset(key, data=A)
        return
    B, group = sp.csr_matrix(A), file.create_group(key)
    group.attrs["shape"] = B.shape
    for part in ("data", "indices", "indptr"):
        group.create_dataset(part, data=getattr(B, part))


def _get(file: h5py.File, key: str) -> Matrix:
    item = file[key]
    if isinstance(item, h5py.Dataset):
        return item[:]
    parts = (item["data"][:], item["indices"][:], item["indptr"][:])
    return sp.csr_matrix(parts, shape=tuple(np.asarray(item.attrs["shape"]).tolist()))
