"""T' A T of the matrices of parts side by side: what is not eliminated is copied once, by all cores."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import Csr, FloatArray, IntArray, Matrix
from creak.jit import njit
from creak.linalg.threads import cores, pool

"""indptr, indices, data"""


class SideBySide:
    """The symmetric block-diagonal matrix of `blocks`, plus an `extra` of the same size, never put together."""

    def __init__(self, blocks: Sequence[Matrix], extra: Matrix | None = None) -> None:
        self.blocks = [_sorted(sp.csr_matrix(A)) for A in blocks]
        self.starts = np.cumsum([0, *(A.shape[0] for A in self.blocks)])
        self.extra = extra

    def of_rows(self, rows: IntArray) -> Iterator[tuple[int, int, Matrix, slice]]:
        """First column, columns, block and places in `rows` (ascending) of each block."""
        cuts = np.searchsorted(rows, self.starts)
        for (start, stop), (a, b), A in zip(pairwise(self.starts), pairwise(cuts), self.blocks, strict=True):
            yield int(start), int(stop), A, slice(int(a), int(b))

    def times(self, X: Matrix) -> Matrix:
        """A X, sparse (n, m), for sparse X with few columns or few entries."""
        X = sp.csr_matrix(X)
        each = [A @ X[a:b] for A, (a, b) in zip(self.blocks, pairwise(self.starts), strict=True)]
        AX = sp.csr_matrix(sp.vstack(each, format="csr")) if each else sp.csr_matrix(X.shape)
        return AX if self.extra is None else AX + self.extra @ X


def congruent(T: Matrix, A: SideBySide, own: IntArray) -> Matrix:
    """T' A T in CSR form for T of `elimination.transformation`.

    T = P + E, P the rows of the independents and E those of the dependents: P' A P is a part of A, and only what
    meets the few entries of E, or is in the extra matrix, is multiplied.

    Parameters
    ----------
    own : (n_independent,) rows of T, ascending, where it is the unit matrix.
    """
    T = sp.csr_matrix(T)
    if T.shape[0] == T.shape[1] and len(A.blocks) == 1 and A.extra is None:
        return A.blocks[0]
    dependent = np.ones(T.shape[0])
    dependent[own] = 0.0
    E = sp.csr_matrix(sp.diags(dependent) @ T)
    E.eliminate_zeros()
    AE = SideBySide(A.blocks).times(E)
    side = AE[own]
    more = side + side.T + E.T @ AE
    if A.extra is not None:
        more = more + T.T @ A.extra @ T
    return _part_plus(A, own, sp.csr_matrix(more))


def _part_plus(A: SideBySide, own: IntArray, B: Matrix) -> Matrix:
    """The rows and columns `own` of the blocks of A, plus B."""
    n, wide = own.size, sum(block.nnz for block in A.blocks) + B.nnz > np.iinfo(np.int32).max
    kind = np.dtype(np.int64 if wide else np.int32)
    B.sort_indices()
    place = np.full(A.starts[-1], -1, dtype=kind)
    place[own] = np.arange(n, dtype=kind)
    starts = np.zeros(n + 1, dtype=np.int64)

    def passed(columns: IntArray, data: FloatArray) -> None:
        for first, stop, block, mine in A.of_rows(own):
            of_A, of_B = ((X.indptr, X.indices, X.data) for X in (block, B))
            given = (of_A, (own[mine] - first, place[first:stop]), of_B, mine.start, (starts, columns, data))
            _shared(given, mine.stop - mine.start)

    passed(np.empty(0, dtype=kind), np.empty(0))
    np.cumsum(starts, out=starts)
    columns, data = np.empty(starts[-1], dtype=kind), np.empty(starts[-1])
    if data.size:
        passed(columns, data)
    C = sp.csr_matrix((data, columns, starts.astype(kind)), shape=(n, n))
    C.has_sorted_indices = C.has_canonical_format = True
    return C


def _shared(given: tuple[Any, ...], count: int) -> None:
    """`_merge` of `count` rows, each core a share of them."""
    cuts = np.linspace(0, count, cores() + 1).astype(np.int64).tolist()
    list(pool().map(lambda a, b: _merge(a, b, *given), cuts[:-1], cuts[1:]))


def _sorted(A: Matrix) -> Matrix:
    return A if A.has_canonical_format else _summed(A.copy())


def _summed(A: Matrix) -> Matrix:
    A.sum_duplicates()
    return A


@njit(nogil=True)
def _merge(first: int, last: int, A: Csr, own: tuple[IntArray, IntArray], B: Csr, above: int, out: Csr) -> None:
    """Rows `above` + `first` to `last` of the sum; without room for them, their lengths, one place on in `starts`."""
    (rows, place), (starts, columns, data) = own, out
    room = data.size > 0
    A_starts, A_columns, A_data = A
    B_starts, B_columns, B_data = B
    for r in range(first, last):
        at = starts[above + r] if room else 0
        q, end = B_starts[above + r], B_starts[above + r + 1]
        for p in range(A_starts[rows[r]], A_starts[rows[r] + 1]):
            c = place[A_columns[p]]
            if c < 0:
                continue
            while q < end and B_columns[q] < c:
                if room:
                    columns[at], data[at] = B_columns[q], B_data[q]
                at += 1
                q += 1
            both = q < end and B_columns[q] == c
            if room:
                columns[at], data[at] = c, A_data[p] + (B_data[q] if both else 0.0)
            if both:
                q += 1
            at += 1
        while q < end:
            if room:
                columns[at], data[at] = B_columns[q], B_data[q]
            at += 1
            q += 1
        if not room:
            starts[above + r + 1] = at
