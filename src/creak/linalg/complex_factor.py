"""Factors of complex symmetric matrices: `complex_factor(A).solve(b)`.

The matrices of implicit time steps with complex poles, A = A' (not Hermitian). Those that creak factorises have a
positive definite real part, which every Schur complement inherits: elimination needs no pivoting (George, Ikramov,
Kucherov, SIAM J. Matrix Anal. Appl. 23, 2002).
"""

from __future__ import annotations

import warnings
from typing import Any, Protocol

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from creak.arrays import ComplexArray, Matrix
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import SingularMatrixError, _PardisoFactor
from creak.linalg.mkl import has_pardiso


class ComplexFactor(Protocol):
    """A factorised complex symmetric matrix."""

    def solve(self, b: ComplexArray) -> ComplexArray:
        """x with A x = b; b is (n,) or (n, k)."""
        ...


def complex_factor(A: Matrix, *, upper: bool = False) -> ComplexFactor:
    """Factorise the complex symmetric matrix A.

    Parameters
    ----------
    A : (n, n) Diagonal, ndarray or SciPy sparse; both triangles stored.
    upper : of a sparse matrix the upper one alone is.

    Raises
    ------
    SingularMatrixError : a pivot vanished.
    """
    if isinstance(A, Diagonal):
        return _Diagonal(A)
    if not sp.issparse(A):
        return _Dense(A)
    if has_pardiso():
        return _Pardiso(A)
    return _SuperLU(A + sp.triu(A, 1).T if upper else A)


def complex_refactor(old: ComplexFactor, A: Matrix, *, upper: bool = False) -> ComplexFactor:
    """A factor of A in the place of `old`, which is gone then.

    Where A has the pattern of old's matrix its equations are neither ordered nor analysed again.
    """
    if isinstance(old, _Pardiso) and old.replaced(A):
        return old
    del old
    return complex_factor(A, upper=upper)


class _Diagonal:
    def __init__(self, A: Diagonal) -> None:
        zero = np.flatnonzero(A.d == 0.0)
        if zero.size:
            raise SingularMatrixError(int(zero[0]), f"diagonal matrix has no pivot in row {zero[0]}")
        self._inverse: ComplexArray = 1.0 / np.asarray(A.d, dtype=np.complex128)

    def solve(self, b: ComplexArray) -> ComplexArray:
        return self._inverse * b if b.ndim == 1 else self._inverse[:, None] * b


class _Dense:
    def __init__(self, A: Any) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", sla.LinAlgWarning)  # a zero pivot is an error below
            self._lu = sla.lu_factor(A)
        pivots = np.abs(np.diagonal(self._lu[0]))
        if pivots.size and pivots.min() == 0.0:
            raise SingularMatrixError(int(pivots.argmin()), "dense matrix is singular")

    def solve(self, b: ComplexArray) -> ComplexArray:
        return np.asarray(sla.lu_solve(self._lu, b, check_finite=False))


class _SuperLU:
    """SuperLU in symmetric mode, without row pivoting."""

    def __init__(self, A: Any) -> None:
        try:
            self._lu = spla.splu(
                sp.csc_matrix(A), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularMatrixError(-1, f"sparse matrix is singular ({error})") from error

    def solve(self, b: ComplexArray) -> ComplexArray:
        return np.asarray(self._lu.solve(np.ascontiguousarray(b, dtype=np.complex128)))


def _upper_of(A: Any) -> Any:
    """The upper triangle of a sparse matrix, columns rising in every row."""
    upper = sp.triu(sp.csr_matrix(A), format="csr")
    upper.sort_indices()
    return upper


class _Pardiso(_PardisoFactor):
    """MKL PARDISO, L D L' of the upper triangle; numbers are handed over as pairs of real ones."""

    def __init__(self, A: Any) -> None:
        upper = _upper_of(A)
        empty = np.flatnonzero(np.diff(upper.indptr) == 0)
        if empty.size:
            raise SingularMatrixError(int(empty[0]), f"matrix has an empty row {empty[0]}")
        self._given(upper.astype(np.complex128), False)
        self._iparm[20] = 0  # no pivoting is needed
        self._factorise(np.zeros(2))
        self.nnz_factor = int(self._iparm[17])

    def replaced(self, A: Any) -> bool:
        """Whether A has the pattern of the matrix; then the factor is that of A from now on."""
        upper = _upper_of(A)
        if not (np.array_equal(upper.indptr + 1, self._ia) and np.array_equal(upper.indices + 1, self._ja)):
            return False
        self._values = np.ascontiguousarray(upper.data, dtype=np.complex128).view(np.float64)
        self._call(self._FACTOR, np.zeros(2), np.zeros(2), 1)
        return True

    @property
    def nbytes(self) -> int:
        """Memory of the factor's entries, bytes."""
        return 16 * self.nnz_factor

    def solve(self, b: Any, out: Any = None) -> Any:
        """x with A x = b, in Fortran order."""
        rhs = np.asfortranarray(b, dtype=np.complex128)
        x = np.empty_like(rhs, order="F")
        real = (rhs.ravel(order="F").view(np.float64), x.ravel(order="F").view(np.float64))
        self._call(self._SOLVE, *real, 1 if b.ndim == 1 else int(b.shape[1]))
        return x
