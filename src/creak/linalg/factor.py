"""One interface to symmetric factorisations: `factor(A).solve(b)`.

Sparse matrices go to MKL PARDISO where it is installed (x86-64) and to SuperLU elsewhere, dense ones to
LAPACK, diagonal ones to a division. The caller never asks which.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.linalg.lapack import dpotrf

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.memory import give_back, require
from creak.linalg.mkl import has_pardiso, mkl_library

SMALLER = "Use fewer nodes, or reduce with substructures."
"""What to do where a factor is too large."""


class SingularMatrixError(NumericalError):
    """The matrix has no (positive definite) factorisation; `row` is the failing equation, -1 if unknown."""

    def __init__(self, row: int, message: str) -> None:
        self.row = row
        super().__init__(message)


class Factor(Protocol):
    """A factorised symmetric matrix."""

    n_negative: int
    """Number of negative eigenvalues (Sylvester's inertia)."""

    @property
    def memory(self) -> float:
        """Bytes that it holds."""
        ...

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """x with A x = b; b is (n,) or (n, k).

        `out`: memory of the shape of b, in Fortran order and not b itself, where x may be put; use what is returned.
        """
        ...


def factor(A: Matrix, *, definite: bool = True, beside: float = 0.0) -> Factor:
    """Factorise the symmetric matrix A.

    Parameters
    ----------
    A : (n, n) Diagonal, ndarray or SciPy sparse; both triangles stored.
    definite : A should be positive definite (Cholesky). False: L D L', which also gives the inertia.
    beside : bytes that have to fit beside all that the factor holds; 0: what is made yet has to.

    Raises
    ------
    SingularMatrixError : a pivot vanished, or was negative although `definite`.
    OutOfMemory : MKL foretells more than is free.
    NumericalError : a sparse matrix without rows.
    """
    if isinstance(A, Diagonal):
        return _DiagonalFactor(A, definite)
    if not sp.issparse(A):
        return _CholeskyFactor(A) if definite else _DenseFactor(A)
    if A.shape[0] == 0:
        why = "supports hold every node, or no element has stiffness or mass"
        raise NumericalError(f"the model has no degree of freedom that can move: {why}")
    if has_pardiso():
        return _PardisoFactor(A, definite, beside=beside)
    return _SuperLUFactor(A, definite)


class Make(Protocol):
    """How a matrix is factorised: `factor` or another way."""

    def __call__(self, A: Matrix, *, definite: bool = True) -> Factor: ...


def refactor(old: Factor, A: Matrix) -> Factor:
    """A factor L D L' of A in the place of `old`, one of those too, which is gone then.

    Where A has the pattern of old's matrix its equations are neither ordered nor analysed again.
    """
    if isinstance(old, _PardisoFactor) and old.replaced(A):
        return old
    del old
    return factor(A, definite=False)


def factor_bytes(A: Matrix) -> float:
    """Memory of a factor of the sparse matrix A, from its analysis alone (a third of its time); 0 where not known."""
    return _PardisoFactor(A, True, analyse_only=True).memory if has_pardiso() and A.shape[0] else 0.0


REGULAR = 1e-2
"""Largest relative error of a trial solution for which a matrix counts as regular."""


def regular_factor(A: Matrix, make: Make = factor) -> Factor | None:
    """A factor of the positive definite matrix A, or None where A is singular to working precision.

    Round-off turns the zero pivots of a body that can move freely into tiny ones of either sign, so a
    factorisation that ends is no proof. A trial solution is: one inverse iteration turns a random vector into
    free motion if there is any, and A x = A x0 then loses x0 altogether (error of order 1), while a merely
    ill-conditioned A keeps most digits. (A random x0 itself holds only sqrt(6 / n) of free motion.)
    """
    try:
        found = make(A)
    except SingularMatrixError:
        return None
    x0 = found.solve(np.random.default_rng(7).standard_normal(A.shape[0]))
    error = np.linalg.norm(found.solve(np.asarray(A @ x0)) - x0)
    return found if error <= REGULAR * np.linalg.norm(x0) else None


class LaterFactor:
    """A factor of a positive definite matrix that is made when it is asked for, and again after it was given back."""

    n_negative = 0

    def __init__(self, make: Callable[[], Factor], made: Factor | None = None) -> None:
        self._make, self._made = make, made

    @property
    def made(self) -> Factor:
        """The factor itself."""
        if self._made is None:
            self._made = self._make()
        return self._made

    @property
    def memory(self) -> float:
        """Bytes that it holds now."""
        return 0.0 if self._made is None else self._made.memory

    @property
    def nbytes(self) -> float:
        """Bytes of its entries; infinite where that is not known or it is not there."""
        return float(getattr(self._made, "nbytes", np.inf))

    def release(self) -> None:
        """Give its memory back."""
        self._made = None

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        return self.made.solve(b, out)


class _DiagonalFactor:
    def __init__(self, A: Diagonal, definite: bool) -> None:
        d = A.d
        bad = np.flatnonzero(d <= 0.0 if definite else d == 0.0)
        if bad.size:
            raise SingularMatrixError(int(bad[0]), f"diagonal matrix has pivot {d[bad[0]]:.3g} in row {bad[0]}")
        self._inverse = 1.0 / d
        self.n_negative = int(np.count_nonzero(A.d < 0.0))
        self.memory = float(self._inverse.nbytes)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        return self._inverse * b if b.ndim == 1 else self._inverse[:, None] * b


class _CholeskyFactor:
    n_negative = 0

    def __init__(self, A: FloatArray) -> None:
        whole = np.asarray_chkfinite(A, dtype=np.float64)
        self._c, info = dpotrf(whole, lower=True, clean=False)
        if info > 0:  # the leading minor of this order is not positive
            row = int(info) - 1
            raise SingularMatrixError(row, f"dense matrix is not positive definite at row {row}")
        self.memory = float(self._c.nbytes)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        return sla.cho_solve((self._c, True), b, check_finite=False)


class _DenseFactor:
    def __init__(self, A: FloatArray) -> None:
        values = sla.eigvalsh(A)
        scale = float(np.abs(values).max()) if values.size else 1.0
        if values.size and np.abs(values).min() <= 1e-15 * scale:
            raise SingularMatrixError(-1, "dense matrix is singular to round-off")
        self.n_negative = int(np.count_nonzero(values < 0.0))
        self._lu = sla.lu_factor(A)
        self.memory = float(self._lu[0].nbytes)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        return sla.lu_solve(self._lu, b, check_finite=False)


class _SuperLUFactor:
    """SuperLU in symmetric mode: no row pivoting, so the signs of U's diagonal give the inertia."""

    def __init__(self, A: Any, definite: bool) -> None:
        try:
            self._lu = spla.splu(
                sp.csc_matrix(A),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SingularMatrixError(-1, f"sparse matrix is singular ({error})") from error
        pivots = self._lu.U.diagonal()
        self.n_negative = int(np.count_nonzero(pivots < 0.0))
        if definite and self.n_negative:
            row = int(self._lu.perm_c[np.flatnonzero(pivots < 0.0)[0]])
            raise SingularMatrixError(row, "sparse matrix is not positive definite")

    @property
    def memory(self) -> float:
        return 12.0 * float(self._lu.nnz)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        return self._lu.solve(np.ascontiguousarray(b))


def _upper(A: Any) -> Any:
    """The upper triangle of a symmetric matrix, columns rising in every row."""
    A = sp.csr_matrix(A)
    if not A.has_canonical_format:
        A = A.copy()
        A.sum_duplicates()
    kept = A.indices >= np.repeat(np.arange(A.shape[0], dtype=A.indices.dtype), np.diff(A.indptr))
    before = np.zeros(A.nnz + 1, dtype=A.indptr.dtype)
    np.cumsum(kept, out=before[1:])
    return sp.csr_matrix((A.data[kept], A.indices[kept], before[A.indptr]), shape=A.shape, copy=False)


class _PardisoFactor:
    """MKL PARDISO on the upper triangle: Cholesky (definite) or Bunch-Kaufman L D L'."""

    _ANALYSE, _FACTOR, _SOLVE, _RELEASE = 11, 22, 33, -1
    _perm: IntArray = np.zeros(1, dtype=np.int32)

    def __init__(self, A: Any, definite: bool, *, analyse_only: bool = False, beside: float = 0.0) -> None:
        upper = _upper(A)
        if upper.diagonal().size and np.any(np.diff(upper.indptr) == 0):
            row = int(np.flatnonzero(np.diff(upper.indptr) == 0)[0])
            raise SingularMatrixError(row, f"matrix has an empty row {row}")
        self._given(upper, definite)
        if analyse_only:
            self._call(self._ANALYSE, np.zeros(1), np.zeros(1), 1)
            return
        self._factorise(np.zeros(1), beside)
        self.n_negative = int(self._iparm[22]) if not definite else 0
        self.nnz_factor = int(self._iparm[17])

    def _given(self, upper: Any, definite: bool) -> None:
        """The upper triangle in PARDISO's form, and its settings; complex numbers are pairs of real ones."""
        self._n, real = int(upper.shape[0]), not np.iscomplexobj(upper.data)
        self._values: FloatArray = np.ascontiguousarray(upper.data, dtype=np.float64 if real else np.complex128).view(
            np.float64
        )
        self._ia = (upper.indptr + 1).astype(np.int32)
        self._ja = (upper.indices + 1).astype(np.int32)
        self._pardiso, self._mtype = mkl_library().pardiso, (2 if definite else -2) if real else 6
        self._pt, self._iparm = np.zeros(64, dtype=np.int64), np.zeros(64, dtype=np.int32)
        self._iparm[[0, 1, 9, 17, 23]] = 1, 2, 12, -1, 0  # own settings, METIS, pivot 1e-12
        self._iparm[[7, 10, 12]] = 0, 0, 0  # no refinement, no scaling or matching: keep the inertia
        self._iparm[20] = 3  # pivots of 1 x 1 and 2 x 2, and no refinement of its own where one was perturbed

    def _factorise(self, nothing: FloatArray, beside: float = 0.0) -> None:
        """Order the equations, refuse a factor that memory would not hold, make it."""
        self._call(self._ANALYSE, nothing, nothing, 1)
        needed = self.memory + beside if beside else 1024.0 * float(self._iparm[16])
        require(needed, f"the factor of {self._n:,} equations", SMALLER)
        self._call(self._FACTOR, nothing, nothing, 1)

    def replaced(self, A: Any) -> bool:
        """Whether A has the pattern of the matrix; then the factor is that of A from now on."""
        upper = _upper(A)
        if not (np.array_equal(upper.indptr + 1, self._ia) and np.array_equal(upper.indices + 1, self._ja)):
            return False
        self._values = np.ascontiguousarray(upper.data, dtype=np.float64)
        self._call(self._FACTOR, np.zeros(1), np.zeros(1), 1)
        self.n_negative = int(self._iparm[22])
        return True

    @property
    def nbytes(self) -> int:
        """Memory of the factor's entries, bytes; PARDISO's work space comes on top."""
        return 8 * self.nnz_factor

    @property
    def memory(self) -> float:
        """Bytes that it holds: what PARDISO says, and the matrix."""
        return 1024.0 * float(self._iparm[15] + self._iparm[16]) + 12.0 * self._values.size

    def _call(self, phase: int, b: FloatArray, x: FloatArray, n_rhs: int) -> None:
        def one(value: int) -> Any:
            return ctypes.byref(ctypes.c_int32(value))

        error = ctypes.c_int32(0)
        self._pardiso(
            self._pt.ctypes.data,
            one(1),
            one(1),
            one(self._mtype),
            one(phase),
            one(self._n),
            self._values.ctypes.data,
            self._ia.ctypes.data,
            self._ja.ctypes.data,
            self._perm.ctypes.data,
            one(n_rhs),
            self._iparm.ctypes.data,
            one(0),
            b.ctypes.data,
            x.ctypes.data,
            ctypes.byref(error),
        )
        if error.value == -4:
            row = int(self._iparm[29]) - 1
            raise SingularMatrixError(row, f"matrix is singular or not positive definite at row {row}")
        if error.value in (-2, -9):
            raise NumericalError(
                f"memory does not hold the factor of {self._n:,} equations with {self._values.size:,} entries (PARDISO "
                f"code {error.value}). {SMALLER}"
            )
        if error.value != 0:
            raise NumericalError(f"PARDISO failed with code {error.value} on a matrix of size {self._n}")

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """x with A x = b, in Fortran order; a b in Fortran order is used where it lies."""
        rhs = np.asfortranarray(b, dtype=np.float64)
        x = np.empty_like(rhs, order="F") if out is None else out
        self._call(self._SOLVE, rhs, x, 1 if b.ndim == 1 else int(b.shape[1]))
        return x

    def __del__(self) -> None:
        if hasattr(self, "_pt") and not sys.is_finalizing():
            freed = self.memory
            self._call(self._RELEASE, np.zeros(1), np.zeros(1), 1)
            give_back(freed)
