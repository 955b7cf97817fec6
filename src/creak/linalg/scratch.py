"""Large blocks of columns: in memory where that holds them, else in a file that vanishes with them."""

from __future__ import annotations

import os
import shutil
import tempfile

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.linalg.memory import ENTRY, GB, OutOfMemory, fits

RESERVE = 2e9
"""Bytes of the disk that are left to others, or half of what is free where that is less."""
ROOM = 2.5
"""Free memory over that of what is to stay in it."""
SPARE = 8.0
"""The same where it is to stay beside a factor: the entries of a matrix, and vectors that are made with one."""


def held_in_memory(n: int, k: int, room: float = ROOM) -> bool:
    """Whether `vectors` come from memory: they leave most of it to others."""
    return fits(room * 8.0 * n * k)


def vectors(n: int, k: int, room: float = ROOM) -> FloatArray:
    """(k, n), each row a vector, not filled; its memory is given back once nothing refers to it.

    The file lies where `tempfile` puts files (TMPDIR) and has no name; the system keeps what fits of it in memory.

    Raises
    ------
    OutOfMemory : neither memory nor disk holds it.
    """
    return np.empty((k, n)) if held_in_memory(n, k, room) else _on_disk(n, k)


def rows_of(n: int, k: int, room: float = ROOM) -> FloatArray:
    """`vectors`, in memory where the disk does not hold them either.

    Parameters
    ----------
    room : free memory over theirs from which on they come from memory; `SPARE` where a factor is made beside them.
    """
    try:
        return vectors(n, k, room)
    except OutOfMemory:
        return np.empty((k, n))


def set_aside(X: FloatArray) -> FloatArray:
    """Columns X (n, k) in a file; as they are where the disk does not hold them."""
    try:
        kept = _on_disk(X.shape[0], X.shape[1])
    except OutOfMemory:
        return X
    for row, column in zip(kept, X.T, strict=True):
        row[:] = column
    return kept.T


def spared(A: Matrix) -> Matrix:
    """A sparse matrix as it is, or `on_disk` where memory is short."""
    return A if not sp.issparse(A) or fits(SPARE * ENTRY * A.nnz) else on_disk(A)


def on_disk(A: Matrix) -> Matrix:
    """A sparse matrix whose entries lie in such a file: the system takes their memory back when others need it.

    Where the disk does not hold them they stay where they are.
    """
    if getattr(A, "format", "") != "csr" or not A.nnz or A.indices.dtype != np.int32:
        return A
    try:
        data, indices = _on_disk(A.nnz, 1)[0], _on_disk(-(-A.nnz // 2), 1)[0].view(np.int32)[: A.nnz]
    except OutOfMemory:
        return A
    data[:], indices[:] = A.data, A.indices
    return sp.csr_matrix((data, indices, A.indptr), shape=A.shape, copy=False)


def disk_room(folder: str) -> float:
    """Bytes that may be taken of the disk of a folder."""
    free = shutil.disk_usage(folder).free
    return max(free - RESERVE, 0.5 * free)


def _on_disk(n: int, k: int) -> FloatArray:
    folder, needed = tempfile.gettempdir(), 8 * n * k
    room = disk_room(folder)
    if needed > room:
        raise OutOfMemory(
            f"neither memory nor {folder} holds {k:,} vectors of {n:,} numbers: {needed / GB:.3g} GB are needed, "
            f"{room / GB:.3g} GB of the disk may be taken. Ask for fewer modes (a lower f_max), or set TMPDIR to "
            "a folder with more space."
        )
    with tempfile.TemporaryFile(prefix="creak-", dir=folder) as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, needed)  # a disk that fills up later would kill the process
        return np.memmap(file, dtype=np.float64, mode="r+" if hasattr(os, "posix_fallocate") else "w+", shape=(k, n))
