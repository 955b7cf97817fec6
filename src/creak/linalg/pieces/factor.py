"""A factor that memory need not hold: pieces of the matrix, factorised one at a time, and what joins them.

With the rows of the pieces first, A = [A_pp, A_ps; A_sp, A_ss] with A_pp block-diagonal, and the separator carries the
Schur complement S = A_ss - sum over pieces of A_sp A_pp^-1 A_ps. S stays; the factor of a piece is made again when it
was given back meanwhile. The answer is that of a factor of A, and so is the inertia (Haynsworth: that of the
pieces and of S together).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dsyconv, dsytrf, dsytrf_lwork

from creak.arrays import FloatArray, IntArray, Matrix
from creak.linalg.factor import Factor, SingularMatrixError, _PardisoFactor, factor, factor_bytes
from creak.linalg.memory import require
from creak.linalg.mkl import has_pardiso
from creak.linalg.pieces.dissection import Dissection, cut_once_more, whole

COLUMNS = 48
"""Columns of a piece, on their way in a solve, that count with its factor."""
MOST, FURTHER = 64, 3
"""Pieces at most, and over the fewest that fit."""
ENTRY = 18.0
"""Bytes of a stored entry beside the factor that is made of it: the matrix, its upper triangle."""
WHAT, FIX = "what joins {count} pieces of {n:,} equations", "Use a coarser mesh or a machine with more memory."
AT_ONCE = 16
"""Right-hand sides at a time where it takes a solve for each column."""


@dataclass(frozen=True)
class Pieces:
    """A matrix in pieces, and what their factors take."""

    dissection: Dissection
    factors: tuple[float, ...]
    """Bytes of a factor of each piece."""
    room: float
    """Bytes that factors of pieces may hold at a time."""
    instead: float = 0.0
    """Bytes of a factor of the whole."""
    work: float = 0.0
    """Bytes of a piece of the matrix while it is factorised, and of columns on their way."""

    @property
    def count(self) -> int:
        return len(self.dissection.pieces)

    @property
    def joint(self) -> int:
        """Equations of the separator."""
        return int(self.dissection.separator.size)

    @property
    def made_again(self) -> float:
        """Bytes of factors that a solve, there and back, makes again: at either end those stay that fit."""
        ends = (np.cumsum(self.factors), np.cumsum(self.factors[::-1]))
        return float(sum(end[-1] - max(end[end <= self.room], default=0.0) for end in ends))

    @property
    def left(self) -> float:
        """Bytes that may be taken."""
        return self.room + self.work + joint_bytes(self.joint)

    @property
    def fits(self) -> bool:
        """Whether that is enough."""
        return self.bytes <= self.left

    @property
    def bytes(self) -> float:
        """Memory of S beside the largest factor with what is there while it is made, or beside the factor of S."""
        return joint_bytes(self.joint) + max(joint_bytes(self.joint), max(self.factors) + self.work)


def joint_bytes(n: int) -> float:
    """Memory of S, n x n, or of its factor."""
    return 8.0 * float(n) ** 2


def cut_to_fit(A: sp.csr_matrix, needed: float, room: float) -> Pieces | None:
    """Pieces with which the factor of a piece and S take `room` bytes at most, or come closest; None: nothing to cut.

    The fewest would do, but smaller ones leave less of the room empty, so that more factors stay: of up to `FURTHER`
    times as many those are taken that have least made again. Costs the analysis of the pieces, a third of the time of
    their factors each time. `needed`: bytes of a factor of A.
    """
    best: Pieces | None = None
    least: Pieces | None = None
    found, fewest, n = whole(A.shape[0]), MOST, int(A.shape[0])
    known = {(0, n): (needed, ENTRY * A.nnz + 8.0 * COLUMNS * n)}

    def sizes_of(rows: IntArray) -> tuple[float, float]:
        key = int(rows[0]), rows.size
        if key not in known:
            piece = A[rows][:, rows]
            known[key] = factor_bytes(piece), ENTRY * piece.nnz + 8.0 * COLUMNS * rows.size
        return known[key]

    def size(rows: IntArray) -> float:
        return sizes_of(rows)[0]

    while len(found.pieces) < MOST:
        sizes, works = zip(*(sizes_of(rows) for rows in found.pieces), strict=True)
        joint = joint_bytes(found.separator.size)
        here = Pieces(found, sizes, room - max(works) - joint, needed, max(works))
        if here.fits:
            fewest = min(fewest, here.count)
            if best is None or here.made_again < best.made_again:
                best = here
        if here.count > 1 and (least is None or here.bytes < least.bytes):
            least = here
        most = room if best is not None else np.inf if least is None else least.bytes
        enough = best is not None and (best.made_again == 0.0 or not here.fits or here.count >= FURTHER * fewest)
        further = None if 2.0 * joint > most or enough else cut_once_more(A, found, size)
        if further is None:
            break
        found = further
    return best or least


@dataclass(frozen=True)
class Shifted:
    """K - shift M, made block by block."""

    K: Matrix
    M: Matrix
    shift: float

    def block(self, rows: IntArray, columns: IntArray) -> sp.csr_matrix:
        """The entries in some rows and columns."""
        K, M = (sp.csr_matrix(sp.csr_matrix(A)[rows][:, columns]) for A in (self.K, self.M))
        return sp.csr_matrix(K - self.shift * M)


@dataclass(frozen=True)
class _Plain:
    """A matrix as it is."""

    A: sp.csr_matrix

    def block(self, rows: IntArray, columns: IntArray) -> sp.csr_matrix:
        return self.A[rows][:, columns]


@dataclass(frozen=True)
class _Piece:
    """Rows of a piece, rows of the separator that it touches, as positions there, and the entries between them."""

    rows: IntArray
    edge: IntArray
    side: sp.csr_matrix
    """(n_row, n_edge)"""


class PieceFactor:
    """A factor of a symmetric sparse matrix in pieces (`factor`'s interface).

    A solve passes twice over the pieces, there and back, so it makes each factor again that is not held: all but one
    at worst. Many right-hand sides at once cost little more than one.

    Raises
    ------
    SingularMatrixError, OutOfMemory : as `factor`.
    """

    def __init__(self, A: Matrix | Shifted, pieces: Pieces, *, definite: bool = True) -> None:
        self._pieces, self._definite = pieces, definite
        self.n_negative = 0
        self._make(A)

    @property
    def memory(self) -> float:
        """Bytes that it holds now: S, and factors of pieces."""
        return self._joint.memory + sum(found.memory for found in self._held.values())

    @property
    def nbytes(self) -> float:
        """The same."""
        return self.memory

    def replace(self, A: Matrix | Shifted) -> None:
        """Be the factor of A from now on, which has the same pieces."""
        self._make(A)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """x with A x = b; b is (n,) or (n, k)."""
        B = b.reshape(b.shape[0], -1)
        X = np.empty(B.shape, order="F") if out is None else out.reshape(B.shape, order="F")
        joined = self._pieces.dissection.separator
        rest, order = B[joined], list(self._order())
        for k in order:
            piece = self._list[k]
            inner = np.asfortranarray(B[piece.rows])
            if inner.any():
                rest[piece.edge] -= piece.side.T @ self._factor(k).solve(inner)
        X[joined] = answer = self._joint.solve(rest) if joined.size else rest
        for k in reversed(order):
            piece = self._list[k]
            inner = np.asfortranarray(B[piece.rows] - piece.side @ answer[piece.edge])
            X[piece.rows] = self._factor(k).solve(inner)
        return X.reshape(b.shape, order="F")

    def _make(self, given: Matrix | Shifted) -> None:
        """Factorise piece by piece and collect S."""
        rows, joined = self._pieces.dissection.pieces, self._pieces.dissection.separator
        n = joined.size + sum(some.size for some in rows)
        require(2.0 * joint_bytes(joined.size), WHAT.format(count=self._pieces.count, n=n), FIX)
        A = given if isinstance(given, Shifted) else _Plain(sp.csr_matrix(given))
        self._A, self._held = A, dict[int, Factor]()
        self._list = [_piece(some, A.block(some, joined)) for some in rows]
        S, self.n_negative = np.asfortranarray(A.block(joined, joined).toarray()), 0
        for piece in self._list:
            found, below = schur_complement(A.block(piece.rows, piece.rows), piece.side, definite=self._definite)
            S[np.ix_(piece.edge, piece.edge)] += found
            self.n_negative += below
        self._joint = factor(S) if self._definite else SymmetricFactor(S)
        self.n_negative += self._joint.n_negative

    def _order(self) -> Iterator[int]:
        """The pieces from that end at which factors are held."""
        last = next(reversed(self._held), 0)
        every = range(len(self._list))
        return reversed(every) if 2 * last >= len(every) else iter(every)

    def _factor(self, k: int) -> Factor:
        """The factor of a piece; those used longest ago make room for it."""
        found = self._held.pop(k, None)
        if found is None:
            needed = self._pieces.factors[k]
            while self._held and needed + sum(self._pieces.factors[j] for j in self._held) > self._pieces.room:
                del self._held[next(iter(self._held))]
            rows = self._list[k].rows
            found = factor(self._A.block(rows, rows), definite=self._definite)
        self._held[k] = found
        return found


def _piece(rows: IntArray, block: sp.csr_matrix) -> _Piece:
    side = sp.csc_matrix(block)
    edge = np.flatnonzero(np.diff(side.indptr))
    return _Piece(rows, edge, sp.csr_matrix(side[:, edge]))


class SymmetricFactor:
    """P' A P = L D L' with the pivots of Bunch and Kaufman, D of blocks of one row or two.

    LAPACK's dsytrf makes it and dsyconv takes L and D apart; the solve is that of its dsytrs2, which SciPy does not
    bring in all versions that creak runs with.

    Raises
    ------
    SingularMatrixError : a block of D vanished.
    """

    def __init__(self, A: FloatArray) -> None:
        pivots, info = np.zeros(0, dtype=np.int32), 0
        self._L, self._below, self._rows = A, np.zeros(0), np.zeros(0, dtype=np.int64)
        if A.size:
            work, _ = dsytrf_lwork(A.shape[0], lower=1)
            made, pivots, info = dsytrf(A, lower=1, lwork=int(work), overwrite_a=1)
            if info == 0:
                self._L, self._below, info = dsyconv(made, pivots, lower=1, way=0, overwrite_a=1)
                self._rows = _order(pivots)
        if info > 0:
            raise SingularMatrixError(int(info) - 1, f"dense matrix is singular at row {int(info) - 1}")
        single = pivots > 0  # a block of two rows has an eigenvalue of either sign
        self._single, self._first = np.flatnonzero(single), np.flatnonzero(~single)[::2]
        self._diagonal = self._L.diagonal().copy()
        below = np.count_nonzero(self._diagonal[self._single] < 0.0)
        self.n_negative = int(below + self._first.size)
        self.memory = float(self._L.nbytes)

    def solve(self, b: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """x with A x = b; b is (n,) or (n, k)."""
        if not b.size:
            return np.zeros(b.shape)
        X = np.asfortranarray(b.reshape(b.shape[0], -1)[self._rows], dtype=np.float64)
        X = dtrsm(1.0, self._L, X, lower=1, diag=1, overwrite_b=1)
        one, i = self._single, self._first
        X[one] /= self._diagonal[one, None]
        if i.size:
            across, upper, lower = (x[:, None] for x in (self._below[i], self._diagonal[i], self._diagonal[i + 1]))
            a, c, u, v = upper / across, lower / across, X[i] / across, X[i + 1] / across
            X[i], X[i + 1] = (c * u - v) / (a * c - 1.0), (a * v - u) / (a * c - 1.0)
        X = dtrsm(1.0, self._L, X, lower=1, trans_a=1, diag=1, overwrite_b=1)
        found = np.empty(X.shape, order="F") if out is None else out.reshape(X.shape, order="F")
        found[self._rows] = X
        return found.reshape(b.shape, order="F")


def _order(pivots: IntArray) -> IntArray:
    """Rows of A in the order of L: the interchanges that the pivots tell, one after the other."""
    rows, k = np.arange(pivots.size), 0
    while k < pivots.size:
        two = pivots[k] < 0
        moved, other = (k + 1, -pivots[k + 1] - 1) if two else (k, pivots[k] - 1)
        rows[[moved, other]] = rows[[other, moved]]
        k += 2 if two else 1
    return rows


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
    for start in range(0, side.shape[1], AT_ONCE):
        some = slice(start, start + AT_ONCE)
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
