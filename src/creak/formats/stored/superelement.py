"""Saved superelements: HDF5 with matrices, modes, the dofs of every row, and what they were made from.

Without its modes one is arrays by name: what a run needs before motion inside is asked for."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.stored.sealed import BLOCK, Damaged, hdf5_file, opened_hdf5
from creak.formats.stored.solved import as_numbers, as_text
from creak.later import later

VERSION = 3
"""Since 3 with a checksum."""
ROWS = 1 << 26
"""Bytes of modes that are written or checked at a time."""
MAPPED = 500_000_000
"""Bytes of modes from which on they stay in the file and are read where they are used."""


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
    with complete_file(path, stream=False, kept=True) as partial, hdf5_file(partial) as out:
        file = out.file
        file.attrs["creak_superelement"] = VERSION
        file.attrs["name"] = saved.name
        file.attrs["made_from"] = json.dumps(dict(saved.made_from))
        file.attrs["about"] = json.dumps(dict(saved.about))
        file.attrs["first_left_out"] = saved.first_left_out
        for key, A in {**saved.matrices, "P": saved.shape}.items():
            _put(file, key, A)
        for key in ("omega2", "node_ids", "dofs", "static_at", "static_rows"):
            file.create_dataset(key, data=getattr(saved, key))
        # A block of rows at a time: of a large array in another order no copy is made.
        stored = out.file.create_dataset("modes", shape=saved.modes.shape, dtype=saved.modes.dtype)
        step = max(ROWS // max(8 * saved.modes.shape[1], 1), 1)
        for first in range(0, saved.modes.shape[0], step):
            out.check(8 * (saved.modes.shape[0] - first) * saved.modes.shape[1])
            stored[first : first + step] = saved.modes[first : first + step]


def read_superelement_file(path: Path) -> SavedSuperelement:
    """Read a saved superelement.

    Raises
    ------
    InputError : not a superelement file, cut short, damaged, or of parts that do not fit together.
    """
    with _opened(path) as file:
        return _whole(file)


def read_where_it_fits(
    path: Path, fits: Callable[[Mapping[str, str]], bool]
) -> tuple[Mapping[str, str], SavedSuperelement | None]:
    """The fingerprints, and where these fit the superelement; the file is checked once.

    Raises
    ------
    InputError : as `read_superelement_file`.
    """
    with _opened(path) as file:
        made_from = _text(file, "made_from")
        return made_from, _whole(file) if fits(made_from) else None


def _whole(file: h5py.File) -> SavedSuperelement:
    names = [k for k in ("K", "M", "M_alone", "C") if k in file]
    saved = SavedSuperelement(
        name=str(file.attrs["name"]),
        made_from=_text(file, "made_from"),
        matrices={k: _get(file, k) for k in names},
        shape=_get(file, "P"),
        omega2=_array(file, "omega2", 1, "f"),
        modes=_modes(file),
        first_left_out=float(file.attrs["first_left_out"]),
        node_ids=_array(file, "node_ids", 1, "iu"),
        dofs=_array(file, "dofs", 1, "iu"),
        about=_text(file, "about"),
        static_at=_array(file, "static_at", 1, "iu"),
        static_rows=_array(file, "static_rows", 2, "f"),
    )
    _check(saved)
    return saved


def _check(saved: SavedSuperelement) -> None:
    """Raise Damaged where sizes do not fit, an index is out of range or a number is not finite."""
    n, n_mode, n_xi = saved.node_ids.size, saved.omega2.size, saved.shape.shape[1]
    sizes = {key: (A.shape, (n, n)) for key, A in saved.matrices.items()} | {
        "dofs": (saved.dofs.shape, (n,)),
        "P": ((n_xi + n_mode,), (n,)),
        "modes": (saved.modes.shape[1:], (n_mode,)),
        "static_rows": (saved.static_rows.shape, (saved.static_at.size, n_xi)),
    }
    wrong = [key for key, (found, right) in sizes.items() if tuple(found) != right]
    if wrong or not {"K", "M", "M_alone"} <= saved.matrices.keys():
        raise Damaged(f"{wrong[0] if wrong else 'K, M or M_alone'} does not fit the other parts")
    if saved.static_at.size and not 0 <= saved.static_at.min() <= saved.static_at.max() < saved.modes.shape[0]:
        raise Damaged("static_at names coordinates that there are not")
    arrays = {**saved.matrices, "P": saved.shape, "omega2": saved.omega2, "modes": saved.modes}
    for key, A in {**arrays, "static_rows": saved.static_rows}.items():
        if not _finite(A.data if sp.issparse(A) else A):
            raise Damaged(f"{key} has entries that are not finite")


def _finite(A: FloatArray) -> bool:
    step = max(ROWS // max(8 * A[:1].size, 1), 1)
    return all(bool(np.isfinite(A[first : first + step]).all()) for first in range(0, A.shape[0], step))


def _modes(file: h5py.File) -> FloatArray:
    """The modes, or where they are many a view of the file, which the system reads piece by piece."""
    stored = file.get("modes")
    plain = isinstance(stored, h5py.Dataset) and stored.ndim == 2 and stored.dtype == np.dtype("<f8")
    if not plain or stored.nbytes < MAPPED or sys.platform == "win32" or not stored.id.get_offset():
        return _array(file, "modes", 2, "f")
    return np.memmap(file.filename, "<f8", "r", stored.id.get_offset(), stored.shape)


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """The file, for as long as it is read: what is wrong with it becomes one message."""
    try:
        with opened_hdf5(path) as file:
            if int(file.attrs["creak_superelement"]) != VERSION:
                raise _other(path, f"superelement file of version {int(file.attrs['creak_superelement'])}")
            yield file
    except Damaged as error:
        raise _foreign(path) or _damaged(path, error) from error
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError, AttributeError) as error:
        raise _damaged(path, error) from error


def _foreign(path: Path) -> InputError | None:
    """The message for a whole file that has no checksum because creak, or this version, did not write it."""
    try:
        with h5py.File(path, "r") as file:
            if file.userblock_size:
                return None
            if "creak_superelement" in file.attrs:
                return _other(path, f"superelement file of version {int(file.attrs['creak_superelement'])}")
    except (OSError, TypeError, ValueError):
        return None
    return InputError("not a superelement that creak has saved", where=path, fix="Name another file, or delete it.")


def _other(path: Path, what: str) -> InputError:
    return InputError(what, where=path, expected=f"version {VERSION}", fix="Delete it and run `creak reduce` again.")


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError(
        f"the superelement file is damaged or cut short ({next(iter(str(error).splitlines()), 'unreadable')})",
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
        return np.asarray(_array(file, key, 2, "f"))
    kinds = {"data": "f", "indices": "iu", "indptr": "iu"}
    data, indices, indptr = (_array(item, part, 1, kind) for part, kind in kinds.items())
    n, m = (int(k) for k in item.attrs["shape"])
    lengths = np.diff(indptr)
    fits = indptr.size == n + 1 and indptr[0] == 0 and indptr[-1] == data.size == indices.size and m >= 0
    if not fits or (lengths < 0).any() or (indices.size and not 0 <= indices.min() <= indices.max() < m):
        raise Damaged(f"{key} is no sparse matrix of {n} x {m}")
    return sp.csr_matrix((data, indices, indptr), shape=(n, m))


def _array(group: h5py.Group, key: str, axes: int, kinds: str) -> Any:
    item = group[key]
    if not isinstance(item, h5py.Dataset) or item.ndim != axes or item.dtype.kind not in kinds:
        raise Damaged(f"{key} is not what it should be")
    return item[()]


def _text(file: h5py.File, key: str) -> dict[str, Any]:
    return dict(json.loads(file.attrs[key]))


Arrays = dict[str, FloatArray]
MATRICES = ("K", "M", "M_alone", "C", "P")
TEXTS = ("name", "made_from", "about")
WHOLE = ("node_ids", "dofs", "static_at")
"""Fields that are whole numbers."""
NUMBERS = ("omega2", "static_rows")


@dataclass(frozen=True)
class Boundary:
    """A saved superelement whose modes are read when they are asked for."""

    saved: SavedSuperelement
    inner: int
    """Inner coordinates."""
    modes: FloatArray
    """(k, n_mode) at its `static_at`."""


def state_of(path: Path) -> str:
    """What a file holds, by its seal, and when it was written last: one that was touched since is another.

    Empty where there is none.
    """
    try:
        with path.open("rb") as file:
            seal, found = file.read(BLOCK), os.fstat(file.fileno())
    except OSError:
        return ""
    return f"{path.name} {found.st_size} {found.st_mtime_ns} {seal.hex()}"


def boundary_arrays(saved: SavedSuperelement) -> Arrays:
    """All but the modes, and of these the rows at `static_at`."""
    out = {name: np.asarray(getattr(saved, name), dtype=np.float64) for name in (*WHOLE, *NUMBERS)}
    texts = (saved.name, dict(saved.made_from), dict(saved.about))
    out |= {name: as_numbers(json.dumps(text)) for name, text in zip(TEXTS, texts, strict=True)}
    out |= {"first_left_out": np.array([saved.first_left_out]), "inner": np.array([float(saved.modes.shape[0])])}
    out["modes"] = np.asarray(saved.modes[saved.static_at])
    for name, A in {**saved.matrices, "P": saved.shape}.items():
        out |= _apart(name, A)
    return out


def boundary_of(arrays: Mapping[str, FloatArray], whole: Callable[[], SavedSuperelement]) -> Boundary:
    """What `boundary_arrays` took apart; `whole` reads the superelement with its modes."""
    matrices = {name: _together(name, arrays) for name in MATRICES if name in arrays or f"{name}.data" in arrays}
    known: dict[str, object] = {name: arrays[name].astype(np.int64) for name in WHOLE}
    known |= {name: arrays[name] for name in NUMBERS} | {name: json.loads(as_text(arrays[name])) for name in TEXTS}
    known |= {"shape": matrices.pop("P"), "matrices": matrices, "first_left_out": float(arrays["first_left_out"][0])}
    return Boundary(later(SavedSuperelement, whole, **known), int(arrays["inner"][0]), arrays["modes"])


def _apart(name: str, A: Matrix) -> Arrays:
    if not sp.issparse(A):
        return {name: A}
    B = sp.csr_matrix(A)
    parts = {"data": B.data, "indices": B.indices, "indptr": B.indptr, "shape": B.shape}
    return {f"{name}.{key}": np.asarray(part, dtype=np.float64) for key, part in parts.items()}


def _together(name: str, arrays: Mapping[str, FloatArray]) -> Matrix:
    if name in arrays:
        return arrays[name]
    indices, indptr, shape = (arrays[f"{name}.{key}"].astype(np.int64) for key in ("indices", "indptr", "shape"))
    return sp.csr_matrix((arrays[f"{name}.data"], indices, indptr), shape=tuple(shape.tolist()))
