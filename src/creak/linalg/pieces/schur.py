"""The Schur complement of a sparse matrix, at the cost of its factor where MKL PARDISO makes both at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.linalg.factor import _PardisoFactor, factor
from creak.linalg.mkl import has_pardiso

COLUMNS = 16
"""Right-hand sides at a time where it takes a solve for each column."""


def schur_complement(A: sp.csr_matrix, side: sp.csr_matrix, *, definite: bool) -> tuple[FloatArray, int]:
    """- side' A^-1 side (k, k), for a symmetric A (n, n) and side (n, k), and the number of A's negative eigenvalues.

    Raises
    ------
    SingularMatrixError, OutOfMemory : as `factor`.
    """
    if has_pardiso() and side.shape[1]:
        made = _PardisoSchur(A, side, definite)
        return made.complement, made.n_negative
    found, S = factor(A, definite=definite), np.empty((side.shape[1], side.shape[1]))
    for start in range(0, side.shape[1], COLUMNS):
        some = slice(start, start + COLUMNS)
        S[:, some] = -(side.T @ found.solve(side[:, some].toarray(order="F")))
    return S, found.n_negative


class _PardisoSchur(_PardisoFactor):
    """PARDISO on [A, side; side', 0], which stops before the last rows and hands over what is left there."""

    _SCHUR = 35
    """Of iparm: what is asked for; `perm` says which rows are the last."""

    def __init__(self, A: Any, side: Any, definite: bool) -> None:
        n, k = side.shape
        corner = sp.csr_matrix((np.zeros(k), np.arange(k), np.arange(k + 1)), shape=(k, k))
        upper = sp.bmat([[sp.triu(A), side], [None, corner]], format="csr")
        upper.sort_indices()
        self._given(upper, definite)
        self._perm = np.repeat(np.array([0, 1], dtype=np.int32), [n, k])
        self._iparm[self._SCHUR] = 1
        self.complement: FloatArray = np.zeros((k, k), order="F")
        self._factorise(self.complement)
        self.n_negative = int(self._iparm[22]) if not definite else 0
