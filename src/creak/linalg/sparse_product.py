"""Sparse matrix times a block of columns."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, Matrix


def times(A: Matrix, X: FloatArray) -> FloatArray:
    """A X for sparse A (n, m) and dense X (m, k), in Fortran order."""
    return np.asfortranarray(A @ X)
