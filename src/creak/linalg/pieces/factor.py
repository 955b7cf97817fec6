"""A factor that memory need not hold: pieces of the matrix, factorised one at a time, and what joins them.

With the rows of the pieces first, A = [A_pp, A_ps; A_sp, A_ss] with A_pp block-diagonal, and the separator carries the
Schur complement S = A_ss - sum over pieces of A_sp A_pp^-1 A_ps. S stays; the factor of a piece is made again when it
was given back meanwhile. The answer is that of a factor of A, and so is the inertia (Haynsworth: that of the
pieces and of S together).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.linalg.factor import Factor, factor, factor_bytes
from creak.linalg.memory import require
from creak.linalg.pieces.dissection import Dissection, cut_once_more, whole
from creak.linalg.pieces.schur import schur_complement
from creak.linalg.pieces.symmetric import SymmetricFactor

COLUMNS = 48
"""Columns of a piece, on their way in a solve, that count with its factor."""
MOST, FURTHER = 64, 3
"""Pieces at most, and over the fewest that fit."""
ENTRY = 18.0
"""Bytes of a stored entry beside the factor that is made of it: the matrix, its upper triangle."""
WHAT, FIX = "what joins {count} pieces of {n:,} equations", "Use a coarser mesh or a machine with more memory."


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
