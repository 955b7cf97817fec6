"""Memory that is free, and the refusal of what would not fit, before it starts; large blocks of columns in memory where
that holds them, else in a file that vanishes with them."""

from __future__ import annotations

import ctypes
import functools
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.errors import InputError, NumericalError
from creak.linalg.mkl import has_pardiso, mkl_library

GB = 1e9
ENTRY, PRODUCT = 12.0, 16.0
"""Bytes of a stored entry: in a sparse matrix, in MKL's copy of it for products."""
MADE = 30.0
"""Bytes of an entry of K while a factor is made: K - s M, where its upper triangle lies, and that triangle."""
SHARE = 0.6
"""Of what is free, that a block of columns may take which nothing but its answers outlives."""
LARGE, MUCH = 16e6, 0.1
"""Bytes that are worth being given back, and their share of what is free from which on they are."""
OVERRIDE = "CREAK_MEMORY_GB"
"""Environment variable: gigabytes to count on instead of what the system says is free."""
MEMINFO, GROUP, STATM = Path("/proc/meminfo"), Path("/sys/fs/cgroup"), Path("/proc/self/statm")


class OutOfMemory(NumericalError):
    """Something would not fit into memory."""


def free_bytes() -> float:
    """Memory that this process may still take, swap included; infinite where the system does not say.

    Raises
    ------
    InputError : the environment variable `OVERRIDE` is no positive number.
    """
    given = os.environ.get(OVERRIDE, "").strip()
    if given:
        return GB * _positive(given)
    return min(_of_machine(), _of_group())


def held_bytes() -> float:
    """Memory that this process has; 0 where the system does not say."""
    try:
        pages = STATM.read_text().split()[1]
    except OSError:  # not Linux
        return 0.0
    return float(pages) * os.sysconf("SC_PAGE_SIZE")


def left_beside(held: float) -> float:
    """What would be free if this process held so many bytes; what `OVERRIDE` says however many they are."""
    return free_bytes() if os.environ.get(OVERRIDE, "").strip() else free_bytes() + held_bytes() - held


def give_back(freed: float) -> None:
    """Return what the process no longer uses to the system, where `freed` bytes are much against what is free.

    MKL keeps half of a factor that is gone for its next calls, and the C library the holes of its heap. Takes 3 ms.
    """
    if freed < LARGE or freed < MUCH * free_bytes():
        return
    if has_pardiso():
        mkl_library().mkl_free_buffers()
    trim = _trim()
    if trim is not None:
        trim(0)


@functools.cache
def _trim() -> Any:
    """malloc_trim of the GNU C library; None elsewhere."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None


def fits(needed: float) -> bool:
    """Whether so many bytes are free."""
    return needed <= free_bytes()


def blocks_that_fit(n: int, rows: int, copies: int, most: int, fewest: int) -> Iterator[slice]:
    """Slices of n columns of so many rows to work on at a time.

    Of `most`, or of fewer where `copies` of them would take more than `SHARE` of what is free; of `fewest` at least.
    """
    held = min(SHARE * free_bytes() / (copies * 8.0 * max(rows, 1)), most)
    step = max(int(held), fewest)
    for start in range(0, n, step):
        yield slice(start, min(start + step, n))


def require(needed: float, what: str, fix: str) -> None:
    """Refuse what needs more bytes than are free.

    Raises
    ------
    OutOfMemory : with both figures, what to do and how to go on all the same.
    """
    free = free_bytes()
    if needed > free:
        raise OutOfMemory(
            f"memory does not hold {what}: {needed / GB:.3g} GB are needed, {free / GB:.3g} GB are free. {fix} "
            f"To try all the same, set {OVERRIDE}={needed / GB * 1.01:.3g} in the environment."
        )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value > 0.0:
        raise InputError(f"{OVERRIDE}={text!r}", expected="a positive number of gigabytes", fix="Change or unset it.")
    return value


def _of_machine() -> float:
    try:
        lines = [line.split() for line in MEMINFO.read_text().splitlines()]
    except OSError:  # not Linux
        return float("inf")
    kilobytes = {words[0].rstrip(":"): float(words[1]) for words in lines if len(words) > 1}
    if "MemAvailable" not in kilobytes:
        return float("inf")
    return 1024.0 * (kilobytes["MemAvailable"] + kilobytes.get("SwapFree", 0.0))


def _of_group() -> float:
    """What a container's limit leaves; pages of files do not count, they are given back."""
    try:
        limit, used = ((GROUP / name).read_text().strip() for name in ("memory.max", "memory.current"))
        figures = dict(line.split() for line in (GROUP / "memory.stat").read_text().splitlines())
    except OSError:  # no container, or one that does not tell
        return float("inf")
    return float("inf") if limit == "max" else float(limit) - float(used) + float(figures.get("inactive_file", 0))


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
