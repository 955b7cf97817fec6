"""Products of tall blocks of columns, in place, on the threads of the sparse solver.

A back-substitution and a dense product follow each other hundreds of times in Lanczos. Where MKL solves, MKL also
multiplies: the idle threads of a second library would spin on the cores that the first one needs. Elsewhere NumPy's
BLAS does the same. All arrays are in Fortran order (or blocks of rows and columns of such).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg.blas as blas

from creak.arrays import FloatArray
from creak.linalg.mkl import has_pardiso, mkl_library

_COLUMN_MAJOR, _PLAIN, _TRANSPOSED, _RIGHT, _UPPER, _NON_UNIT = 102, 111, 112, 142, 121, 131


def inner(A: FloatArray, B: FloatArray) -> FloatArray:
    """A' B, (a, b) for A (n, a) and B (n, b)."""
    C = np.zeros((A.shape[1], B.shape[1]), order="F")
    if has_pardiso() and C.size:
        _gemm(_TRANSPOSED, 1.0, A, B, 0.0, C)
        return C
    return np.asarray(A.T @ B)


def product(A: FloatArray, B: FloatArray) -> FloatArray:
    """A B, (n, b), Fortran order, for A (n, a) and B (a, b)."""
    C = np.zeros((A.shape[0], B.shape[1]), order="F")
    if has_pardiso() and C.size and A.size:
        _gemm(_PLAIN, 1.0, A, np.asfortranarray(B), 0.0, C)
    else:
        np.matmul(B.T, A.T, out=C.T)
    return C


def subtract_product(C: FloatArray, A: FloatArray, B: FloatArray) -> None:
    """C -= A B in place, for C (n, b), A (n, a), B (a, b)."""
    if has_pardiso() and C.size and A.size:
        _gemm(_PLAIN, -1.0, A, np.asfortranarray(B), 1.0, C)
    elif C.size and A.size:
        C -= (B.T @ A.T).T


def right_solve(C: FloatArray, R: FloatArray) -> None:
    """C <- C R^-1 in place, for C (n, b) and upper triangular R (b, b)."""
    if has_pardiso() and C.size:
        R = np.asfortranarray(R)
        mkl_library().cblas_dtrsm(
            _COLUMN_MAJOR,
            _RIGHT,
            _UPPER,
            _PLAIN,
            _NON_UNIT,
            C.shape[0],
            C.shape[1],
            1.0,
            R.ctypes.data,
            _leading(R),
            C.ctypes.data,
            _leading(C),
        )
    elif C.size:
        C[:] = blas.dtrsm(1.0, R, C, side=1)


def symmetric(A: FloatArray) -> FloatArray:
    """The symmetric part, to clean round-off."""
    return 0.5 * (A + A.T)


def _gemm(trans_a: int, alpha: float, A: FloatArray, B: FloatArray, beta: float, C: FloatArray) -> None:
    mkl_library().cblas_dgemm(
        _COLUMN_MAJOR,
        trans_a,
        _PLAIN,
        C.shape[0],
        C.shape[1],
        B.shape[0],
        alpha,
        A.ctypes.data,
        _leading(A),
        B.ctypes.data,
        _leading(B),
        beta,
        C.ctypes.data,
        _leading(C),
    )


def _leading(A: FloatArray) -> int:
    """Distance of the columns, in numbers; the rows must lie side by side in memory."""
    if A.dtype != np.float64 or (A.shape[0] > 1 and A.strides[0] != 8):
        raise ValueError("the block is not in Fortran order")
    return max(A.strides[1] // 8, A.shape[0], 1)
