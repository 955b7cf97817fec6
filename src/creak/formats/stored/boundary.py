"""A saved superelement without its modes, as arrays by name: what a run needs before motion inside is asked for."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.formats.stored.sealed_hdf5 import BLOCK
from creak.formats.stored.solved import as_numbers, as_text
from creak.formats.stored.superelement import SavedSuperelement
from creak.later import later

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
