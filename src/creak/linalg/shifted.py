"""K - s M of sparse matrices, its entries where those of K are."""

from __future__ import annotations

import numba
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.linalg.scratch import rows_of, spared


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
