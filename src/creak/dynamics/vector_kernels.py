"""The vector operations of steps: of large models each vector is read and written once; the smallest kernels.

Written out in NumPy they are some forty passes through memory, a third of the step of a million dofs.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.jit import njit

CHUNK = 4096
"""Rows that stay in the cache while columns are added."""
Two = tuple[float, float]
Three = tuple[FloatArray, FloatArray, FloatArray]
Five = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
Six = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


@njit(nogil=True)
def predict(motion: Three, products: Six, h: float, to_motion: Two, rayleigh: Two, alphas: Two) -> Six:
    """u + h v + c_u a, v + c_v a, their products K u, K v, M v, and

    r = -(1 - af)(alpha M v + beta K v + K u) - af (C v0 + K u0) - am M a0, all (n,).

    Parameters
    ----------
    motion : u, v, a, each (n,). products : K u, K v, K a, M v, M a, C v, each (n,). to_motion : c_u, c_v.
    rayleigh : alpha, beta. alphas : af, am.
    """
    u, v, a = motion
    Ku, Kv, Ka, Mv, Ma, Cv = products
    (c_u, c_v), (alpha, beta), (af, am) = to_motion, rayleigh, alphas
    n = u.size
    u1, v1, Ku1, Kv1, Mv1, r = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        u1[i] = u[i] + h * v[i] + c_u * a[i]
        v1[i] = v[i] + c_v * a[i]
        Ku_i, Kv_i, Mv_i = Ku[i] + h * Kv[i] + c_u * Ka[i], Kv[i] + c_v * Ka[i], Mv[i] + c_v * Ma[i]
        r[i] = -(1.0 - af) * (alpha * Mv_i + beta * Kv_i + Ku_i) - af * (Cv[i] + Ku[i]) - am * Ma[i]
        Ku1[i], Kv1[i], Mv1[i] = Ku_i, Kv_i, Mv_i
    return u1, v1, Ku1, Kv1, Mv1, r


@njit(nogil=True)
def correct(half: Five, step: Three, to_motion: Two, of_S: Two, rayleigh: Two) -> tuple[FloatArray, FloatArray]:
    """Add the step's acceleration to u, v, K u, K v, M v in place; returns M a = (Sa - c_K K a) / c_M and C v, (n,).

    Parameters
    ----------
    half : u, v, K u, K v, M v, each (n,). step : a, K a, S a, each (n,). to_motion : c_u, c_v. of_S : c_M, c_K.
    rayleigh : alpha, beta.
    """
    u, v, Ku, Kv, Mv = half
    a, Ka, Sa = step
    (c_u, c_v), (c_M, c_K), (alpha, beta) = to_motion, of_S, rayleigh
    n = u.size
    Ma, Cv = np.empty(n), np.empty(n)
    for i in range(n):
        Ma_i = (Sa[i] - c_K * Ka[i]) / c_M
        u[i] += c_u * a[i]
        v[i] += c_v * a[i]
        Ku[i] += c_u * Ka[i]
        Kv[i] += c_v * Ka[i]
        Mv[i] += c_v * Ma_i
        Ma[i] = Ma_i
        Cv[i] = alpha * Mv[i] + beta * Kv[i]
    return Ma, Cv


@njit(nogil=True)
def combination(W: FloatArray, columns: IntArray, factors: FloatArray) -> FloatArray:
    """sum_j factors_j W[:, columns_j], (n,); W (n, k) in Fortran order, given as its transpose (k, n)."""
    n = W.shape[1]
    total = np.zeros(n)
    for first in range(0, n, CHUNK):
        last = min(first + CHUNK, n)
        for j in range(columns.size):
            column, factor = W[columns[j]], factors[j]
            for i in range(first, last):
                total[i] += factor * column[i]
    return total


def times_few(A: Matrix, X: FloatArray) -> FloatArray:
    """A X for X (n, k) in C order: with five columns a sparse A is read once, without a loop over the columns."""
    if not sp.issparse(A) or X.shape[1] != 5:
        return np.ascontiguousarray(A @ X)
    Y = np.empty((A.shape[0], 5))
    _times_five(A.indptr, A.indices, A.data, X, Y)
    return Y


@njit(nogil=True)
def _times_five(indptr: IntArray, indices: IntArray, data: FloatArray, X: FloatArray, Y: FloatArray) -> None:
    for i in range(Y.shape[0]):
        a, b, c, d, e = 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(indptr[i], indptr[i + 1]):
            value, j = data[p], indices[p]
            a += value * X[j, 0]
            b += value * X[j, 1]
            c += value * X[j, 2]
            d += value * X[j, 3]
            e += value * X[j, 4]
        Y[i, 0], Y[i, 1], Y[i, 2], Y[i, 3], Y[i, 4] = a, b, c, d, e


@njit(nogil=True)
def weighted(r, Kv, e, d, b):  # type: ignore[no-untyped-def]
    """b = e r - d K v of a real or complex pole, (n,)."""
    for i in range(r.size):
        b[i] = e * r[i] - d * Kv[i]
    return b
