"""The pencil K - s M: its factors at one shift after the other, whole or in pieces, and what their inertia counts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numba
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.linalg.factor import Factor, SingularMatrixError, factor, refactor
from creak.linalg.pieces.factor import PieceFactor, Pieces, Shifted
from creak.linalg.scratch import rows_of, spared
from creak.linalg.sparse_product import BlockProduct

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
