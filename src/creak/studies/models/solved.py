"""Modes and checks that an earlier run of the same matrices has left beside its superelements."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import CreakError
from creak.formats.stored.solved import read_solved, write_solved
from creak.version import version

LARGEST = 200_000_000
"""Bytes above which nothing is kept."""
KEPT = 4
"""Files of a kind that are kept, those written last."""


def solved(
    store: Path | None, kind: str, made_from: Sequence[str], make: Callable[[], dict[str, FloatArray]]
) -> dict[str, FloatArray]:
    """Arrays by name, from the store or made now; a damaged file, or one that cannot be written, costs time alone.

    Parameters
    ----------
    store : folder of saved superelements; None, or a folder that is not there: nothing is looked for or kept.
    kind : first word of the file's name. made_from : all that the arrays depend on but the version of creak.
    """
    if store is None or not store.is_dir():
        return make()
    key = hashlib.blake2b("\n".join([version(), kind, *made_from]).encode(), digest_size=16).hexdigest()
    path = store / "solved" / f"{kind}.{key}.h5"
    found = read_solved(path, key)
    if found is not None:
        return found
    found = {name: np.ascontiguousarray(array) for name, array in make().items()}  # as they are read: the same sums
    if sum(array.nbytes for array in found.values()) <= LARGEST:
        try:
            write_solved(path, key, found)
            _forget(path.parent, kind)
        except (OSError, CreakError):
            return found  # a folder that may only be read
    return found


def _forget(folder: Path, kind: str) -> None:
    """Remove the files of a kind but the last ones."""
    files = sorted(folder.glob(f"{kind}.*.h5"), key=lambda p: p.stat().st_mtime)
    for old in files[:-KEPT]:
        old.unlink(missing_ok=True)


def digest_of(A: Matrix | IntArray) -> str:
    """Of the entries of a matrix or an array."""
    digest = hashlib.blake2b(digest_size=16)
    if sp.issparse(A):
        B = sp.csr_matrix(A)
        B.sort_indices()
        for part in (B.data, B.indices.astype(np.int64), B.indptr.astype(np.int64)):
            digest.update(np.ascontiguousarray(part).data)
    else:
        digest.update(np.ascontiguousarray(A).data)
    return digest.hexdigest()


def as_numbers(text: str) -> FloatArray:
    """A text as it is kept: its bytes."""
    return np.frombuffer(text.encode(), dtype=np.uint8).astype(np.float64)


def as_text(numbers: FloatArray) -> str:
    """The text of `as_numbers`."""
    return numbers.astype(np.uint8).tobytes().decode()
