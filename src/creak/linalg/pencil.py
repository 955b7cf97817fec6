"""The pencil K - s M: its factors at one shift after the other, whole or in pieces, and what their inertia counts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import NumericalError
from creak.linalg.dense_product import symmetric
from creak.linalg.factor import Factor, SingularMatrixError, factor, refactor
from creak.linalg.pieces.factor import PieceFactor, Pieces, Shifted
from creak.linalg.scratch import rows_of, spared
from creak.linalg.sparse_product import BlockProduct

NOTHING = 1e-13
"""Below this share of the largest a term of the diagonal of K + s M, or its eigenvalue once scaled to ones, is none."""
NEGATIVE = 1e-9
"""Eigenvalues of the same below minus this are more than round-off."""
ASIDE = 1e-6
"""A shift that hits an eigenvalue is moved up by this share."""


@dataclass(frozen=True)
class Pencil:
    """K x = lam M x."""

    K: Matrix
    M: Matrix
    pieces: Pieces | None = None
    """How they are cut where memory does not hold a factor."""

    @cached_property
    def mass(self) -> BlockProduct:
        """The product with M."""
        return BlockProduct(self.M)

    def factor(self, shift: float, *, definite: bool) -> Factor:
        """Of K - shift M."""
        if self.pieces is None:
            return factor(self.shifted(shift), definite=definite)
        return PieceFactor(Shifted(self.K, self.M, shift), self.pieces, definite=definite)

    def refactor(self, old: Factor, shift: float) -> Factor:
        """Of K - shift M, indefinite, in the place of another one."""
        if not isinstance(old, PieceFactor):
            return refactor(old, self.shifted(shift))
        old.replace(Shifted(self.K, self.M, shift))
        return old

    def counted(self, shift: float, old: Factor | None = None) -> Factor:
        """A factor whose inertia counts the eigenvalues below a shift, in the place of an `old` one; a hit on one of
        them is stepped past (Sylvester)."""
        try:
            return self.factor(shift, definite=False) if old is None else self.refactor(old, shift)
        except SingularMatrixError:
            return self.factor(shift * (1.0 + ASIDE), definite=False)

    def shifted(self, shift: float) -> Matrix:
        """K - shift M; on disk where memory is short."""
        return self.K if shift == 0.0 else shifted(self.K, self.M, shift)


def shifted(K: Matrix, M: Matrix, s: float) -> Matrix:
    """K - s M; in a file where memory is short.

    Where K has an entry wherever M has one, as matrices of finite elements do, the difference takes the places of
    K's entries over, and nothing but its numbers is made.
    """
    if all(sp.issparse(A) and A.format == "csr" and A.has_canonical_format for A in (K, M)):
        entries = rows_of(K.nnz, 1)[0]
        if _subtract(K.indptr, K.indices, K.data, M.indptr, M.indices, M.data, s, entries):
            return sp.csr_matrix((entries, K.indices, K.indptr), shape=K.shape, copy=False)
    return spared(K - s * M)


@numba.njit(cache=True, nogil=True)
def _subtract(
    K_rows: IntArray,
    K_columns: IntArray,
    K: FloatArray,
    M_rows: IntArray,
    M_columns: IntArray,
    M: FloatArray,
    s: float,
    out: FloatArray,
) -> bool:
    """`out` = K - s M entry by entry; False where M has one that K lacks."""
    for i in range(K_rows.size - 1):
        q, last = M_rows[i], M_rows[i + 1]
        for p in range(K_rows[i], K_rows[i + 1]):
            out[p] = K[p]
            if q < last and M_columns[q] == K_columns[p]:
                out[p] -= s * M[q]
                q += 1
        if q < last:
            return False
    return True


def full(A: Matrix) -> FloatArray:
    """Dense, as it is or made so."""
    return np.asarray(A.toarray() if hasattr(A, "toarray") else A)


def dense_pairs(K: FloatArray, M: FloatArray) -> tuple[FloatArray, FloatArray]:
    """All eigenvalues of dense K x = lam M x, rising, and vectors; M may be singular."""
    try:
        return sla.eigh(K, M)
    except np.linalg.LinAlgError:
        return _massless_eigh(K, M)


def _massless_eigh(K: FloatArray, M: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenpairs when M is singular: solve M x = mu (K + s M) x and drop mu = 0 (infinite frequency).

    So are directions with neither mass nor stiffness, which take part in no mode: a bar that turns about itself.
    """
    shift = (float(np.trace(K) / np.trace(M)) if np.trace(M) > 0 else 0.0) or 1.0
    A = K + shift * M
    try:
        mu, x = sla.eigh(M, A)
    except np.linalg.LinAlgError:
        diagonal = A.diagonal()
        some = np.flatnonzero(diagonal > NOTHING * diagonal.max(initial=0.0))
        scale = 1.0 / np.sqrt(diagonal[some])
        size, U = sla.eigh(scale[:, None] * A[np.ix_(some, some)] * scale)
        if diagonal.min() < -NOTHING * diagonal.max(initial=0.0) or size.min(initial=0.0) < -NEGATIVE:
            raise NumericalError("mass or stiffness is not positive") from None
        held = size > NOTHING * size.max(initial=0.0)
        basis = np.zeros((len(A), int(held.sum())))
        basis[some] = scale[:, None] * U[:, held] / np.sqrt(size[held])
        mu, y = sla.eigh(symmetric(basis.T @ M @ basis))
        x = basis @ y
    finite = mu > 1e-14 * mu.max(initial=0.0)
    mu, x = mu[finite][::-1], x[:, finite][:, ::-1]
    return 1.0 / mu - shift, x / np.sqrt(mu)
