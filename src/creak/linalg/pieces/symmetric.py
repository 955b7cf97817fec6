"""L D L' of a dense symmetric matrix that may be indefinite, with its inertia, in the memory of the matrix."""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dsyconv, dsytrf, dsytrf_lwork

from creak.arrays import FloatArray, IntArray
from creak.linalg.factor import SingularMatrixError


class SymmetricFactor:
    """P' A P = L D L' with the pivots of Bunch and Kaufman, D of blocks of one row or two.

    LAPACK's dsytrf makes it and dsyconv takes L and D apart; the solve is that of its dsytrs2, which SciPy does not
    bring in all versions that creak runs with.

    Raises
    ------
    SingularMatrixError : a block of D vanished.
    """

    def __init__(self, A: FloatArray) -> None:
        pivots, info = np.zeros(0, dtype=np.int32), 0
        self._L, self._below, self._rows = A, np.zeros(0), np.zeros(0, dtype=np.int64)
        if A.size:
            work, _ = dsytrf_lwork(A.shape[0], lower=1)
            made, pivots, info = dsytrf(A, lower=1, lwork=int(work), overwrite_a=1)
            if info == 0:
                self._L, self._below, info = dsyconv(made, pivots, lower=1, way=0, overwrite_a=1)
                self._rows = _order(pivots)
        if info > 0:
            raise SingularMatrixError(int(info) - 1, f"dense matrix is singular at row {int(info) - 1}")
        single = pivots > 0  # a block of two rows has an eigenvalue of either sign
        self._single, self._first = np.flatnonzero(single), np.flatnonzero(~single)[::2]
        self._diagonal = self._L.diagonal().copy()
        below = np.count_nonzero(self._diagonal[self._single] < 0.0)
        self.n_negative = int(below + self._first.size)
        self.memory = float(self._L.nbytes)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """x with A x = b; b is (n,) or (n, k)."""
        if not b.size:
            return np.zeros(b.shape)
        X = np.asfortranarray(b.reshape(b.shape[0], -1)[self._rows], dtype=np.float64)
        X = dtrsm(1.0, self._L, X, lower=1, diag=1, overwrite_b=1)
        one, i = self._single, self._first
        X[one] /= self._diagonal[one, None]
        if i.size:
            across, upper, lower = (x[:, None] for x in (self._below[i], self._diagonal[i], self._diagonal[i + 1]))
            a, c, u, v = upper / across, lower / across, X[i] / across, X[i + 1] / across
            X[i], X[i + 1] = (c * u - v) / (a * c - 1.0), (a * v - u) / (a * c - 1.0)
        X = dtrsm(1.0, self._L, X, lower=1, trans_a=1, diag=1, overwrite_b=1)
        found = np.empty(X.shape, order="F") if out is None else out.reshape(X.shape, order="F")
        found[self._rows] = X
        return found.reshape(b.shape, order="F")


def _order(pivots: IntArray) -> IntArray:
    """Rows of A in the order of L: the interchanges that the pivots tell, one after the other."""
    rows, k = np.arange(pivots.size), 0
    while k < pivots.size:
        two = pivots[k] < 0
        moved, other = (k + 1, -pivots[k + 1] - 1) if two else (k, pivots[k] - 1)
        rows[[moved, other]] = rows[[other, moved]]
        k += 2 if two else 1
    return rows
