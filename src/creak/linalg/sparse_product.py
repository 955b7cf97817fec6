"""Sparse matrix times a block of columns, on all cores."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import NumericalError
from creak.jit import njit
from creak.linalg.memory import PRODUCT, held_in_memory
from creak.linalg.mkl import MatrixKind, has_pardiso, mkl_library
from creak.linalg.threads import cores, pool

COLUMNS = 32
"""Columns multiplied at a time."""
TILE = 64
"""Rows transposed at a time."""
SERIAL = 200_000
"""Below so many stored entries one thread is faster."""


def copy_fits(A: Matrix) -> bool:
    """Whether memory holds MKL's copy of a matrix and leaves most of itself to others."""
    return held_in_memory(getattr(A, "nnz", 0), int(PRODUCT) // 8)


class BlockProduct:
    """Y = A X for blocks of columns X (n, k), both in Fortran order.

    A is read once per block and every entry meets a whole row of X, so the product runs at the speed of the
    caches: X is turned into rows, multiplied by MKL where that is installed and by a loop of our own elsewhere, and
    turned back. Rows are shared among the cores; each row is summed by one of them in the order of its entries, so
    the result does not depend on their number. What is not sparse is multiplied by its own `@`. MKL makes a copy of its
    own; without `own` there is none, and the loop multiplies.
    """

    def __init__(self, A: Matrix, *, own: bool = True) -> None:
        self.n = int(A.shape[0])
        self._A = sp.csr_matrix(A) if sp.issparse(A) else A
        self._cuts = _equal_work(self._A) if sp.issparse(A) else None
        self._kept = [np.empty(0), np.empty(0)]
        self._mkl = MklRows(self._A) if own and sp.issparse(A) and A.nnz and has_pardiso() else None

    def __call__(self, X: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """A X (m, k), Fortran order; put into `out` where that has the same shape, is in Fortran order and not X."""
        if self._cuts is None or X.shape[1] == 0:
            return np.asfortranarray(self._A @ X)
        shape = (self._A.shape[0], X.shape[1])
        Y = out if out is not None and out.shape == shape else np.empty(shape, order="F")
        X = np.asfortranarray(X)
        for first in range(0, X.shape[1], COLUMNS):
            some = slice(first, first + COLUMNS)
            self._group(X[:, some], Y[:, some], self._cuts)
        return Y

    def _group(self, X: FloatArray, Y: FloatArray, cuts: list[int]) -> None:
        A, rows = self._A, self._memory(0, X.shape)
        _turn(X.T, rows, len(cuts) - 1)
        if self._mkl is None:
            _shared(lambda a, b: _multiply(A.indptr, A.indices, A.data, rows, Y.T, a, b), cuts)
            return
        product = self._memory(1, Y.shape)
        self._mkl.multiply(rows, product)
        _turn(product, Y.T, len(cuts) - 1)

    def _memory(self, which: int, shape: tuple[int, ...]) -> FloatArray:
        """An array (C order) that is kept for the next group: new memory has to be cleared by the system first."""
        if self._kept[which].size < shape[0] * shape[1]:
            self._kept[which] = np.empty(shape[0] * shape[1])
        return self._kept[which][: shape[0] * shape[1]].reshape(shape)


def _turn(X: FloatArray, Y: FloatArray, shares: int) -> None:
    """Y = X' by all cores, both in C order."""
    cuts = np.linspace(0, max(X.shape), shares + 1).astype(np.int64)
    _shared(lambda a, b: _copy(X, Y, a, b), cuts.tolist())


def _shared(work: Callable[[int, int], None], cuts: Sequence[int]) -> None:
    """Do `work` from each cut to the next, all but one share in other threads."""
    others = [pool().submit(work, a, b) for a, b in pairwise(cuts[1:])]
    work(cuts[0], cuts[1])
    for other in others:
        other.result()


class MklRows:
    """Rows of a CSR matrix times a block in C order, by MKL's inspector-executor routines."""

    _PLAIN, _ROW_MAJOR, _GENERAL = 10, 101, 20
    _EXPECTED_CALLS = 1000

    def __init__(self, A: sp.csr_matrix) -> None:
        self._handle = ctypes.c_void_p()
        self._indptr, self._indices = (x.astype(np.int32, copy=False) for x in (A.indptr, A.indices))
        self._data = np.ascontiguousarray(A.data, dtype=np.float64)
        start = self._indptr.ctypes.data
        _accept(
            mkl_library().mkl_sparse_d_create_csr(
                ctypes.byref(self._handle),
                0,
                *A.shape,
                start,
                start + self._indptr.itemsize,
                self._indices.ctypes.data,
                self._data.ctypes.data,
            )
        )
        self._kind = MatrixKind(self._GENERAL, 0, 0)
        _accept(
            mkl_library().mkl_sparse_set_mm_hint(
                self._handle, self._PLAIN, self._kind, self._ROW_MAJOR, COLUMNS, self._EXPECTED_CALLS
            )
        )
        _accept(mkl_library().mkl_sparse_optimize(self._handle))

    def multiply(self, X: FloatArray, Y: FloatArray) -> None:
        """Y = A X for X (n, k) and Y (m, k), both contiguous in C order."""
        k = X.shape[1]
        _accept(
            mkl_library().mkl_sparse_d_mm(
                self._PLAIN, 1.0, self._handle, self._kind, self._ROW_MAJOR, X.ctypes.data, k, k, 0.0, Y.ctypes.data, k
            )
        )

    def __del__(self) -> None:
        if getattr(self, "_handle", None) and not sys.is_finalizing():
            mkl_library().mkl_sparse_destroy(self._handle)


def _accept(status: int) -> None:
    if status != 0:
        raise NumericalError(f"MKL's sparse product failed with code {status}")


def _equal_work(A: sp.csr_matrix) -> list[int]:
    """Row limits that give every core the same number of entries."""
    shares = 1 if A.nnz < SERIAL else cores()
    ends = np.searchsorted(A.indptr, np.linspace(0, A.nnz, shares + 1)[1:-1])
    return [0, *ends.tolist(), A.shape[0]]


@njit(nogil=True)
def _copy(X: FloatArray, Y: FloatArray, start: int, stop: int) -> None:
    """Y[i, k] = X[k, i] for `start` <= the longer index < `stop`."""
    across, along = X.shape
    if across > along:
        for first in range(start, stop, TILE):
            for i in range(along):
                for k in range(first, min(first + TILE, stop)):
                    Y[i, k] = X[k, i]
        return
    for first in range(start, stop, TILE):
        for k in range(across):
            for i in range(first, min(first + TILE, stop)):
                Y[i, k] = X[k, i]


@njit(nogil=True, fastmath={"contract"})
def _multiply(
    indptr: IntArray, indices: IntArray, data: FloatArray, X: FloatArray, Y: FloatArray, start: int, stop: int
) -> None:
    """Y[k, i] = sum_j A[i, j] X[j, k]"""
    width = X.shape[1]
    tile = np.empty((TILE, width))
    for first in range(start, stop, TILE):
        last = min(first + TILE, stop)
        tile[:] = 0.0
        for i in range(first, last):
            total = tile[i - first]
            for p in range(indptr[i], indptr[i + 1]):
                value, row = data[p], X[indices[p]]
                for k in range(width):
                    total[k] += value * row[k]
        for k in range(width):
            for i in range(first, last):
                Y[k, i] = tile[i - first, k]
