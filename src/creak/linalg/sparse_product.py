"""Sparse matrix times a block of columns, on all cores."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix

COLUMNS = 32
"""Columns multiplied at a time."""
TILE = 64
"""Rows transposed at a time."""
SERIAL = 200_000
"""Below so many stored entries one thread is faster."""


class BlockProduct:
    """Y = A X for blocks of columns X (n, k), both in Fortran order.

    A is read once per block and every entry meets a whole row of X, so the product runs at the speed of the
    caches. Rows are shared among the cores; each row is summed by one of them in the order of its entries, so the
    result does not depend on their number. What is not sparse is multiplied by its own `@`.
    """

    def __init__(self, A: Matrix) -> None:
        self.n = int(A.shape[0])
        self._A = sp.csr_matrix(A) if sp.issparse(A) else A
        self._cuts = _equal_work(self._A) if sp.issparse(A) else None

    def __call__(self, X: FloatArray) -> FloatArray:
        """A X (m, k), Fortran order."""
        if self._cuts is None or X.shape[1] == 0:
            return np.asfortranarray(self._A @ X)
        Y = np.empty((self._A.shape[0], X.shape[1]), order="F")
        X = np.asfortranarray(X)
        with ThreadPoolExecutor(len(self._cuts) - 1) as pool:
            for first in range(0, X.shape[1], COLUMNS):
                some = slice(first, first + COLUMNS)
                self._group(X[:, some], Y[:, some], self._cuts, pool)
        return Y

    def _group(self, X: FloatArray, Y: FloatArray, cuts: list[int], pool: ThreadPoolExecutor) -> None:
        A, rows = self._A, np.empty(X.shape)
        shares = np.linspace(0, X.shape[0], len(cuts)).astype(np.int64)
        list(pool.map(lambda a, b: _to_rows(X.T, rows, a, b), shares[:-1], shares[1:]))
        list(pool.map(lambda a, b: _multiply(A.indptr, A.indices, A.data, rows, Y.T, a, b), cuts[:-1], cuts[1:]))


def _equal_work(A: sp.csr_matrix) -> list[int]:
    """Row limits that give every core the same number of entries."""
    cores = 1 if A.nnz < SERIAL else len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2
    ends = np.searchsorted(A.indptr, np.linspace(0, A.nnz, cores + 1)[1:-1])
    return [0, *ends.tolist(), A.shape[0]]


@numba.njit(cache=True, nogil=True)
def _to_rows(X: FloatArray, rows: FloatArray, start: int, stop: int) -> None:
    """rows[i, k] = X[k, i]"""
    for first in range(start, stop, TILE):
        last = min(first + TILE, stop)
        for k in range(X.shape[0]):
            for i in range(first, last):
                rows[i, k] = X[k, i]


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
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
