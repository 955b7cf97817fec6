"""Whether memory holds a factor of the inside of a part beside the vectors of its modes, or only of its pieces."""

from __future__ import annotations

from functools import partial

import scipy.sparse as sp

from creak.arrays import Matrix
from creak.linalg.factor import Factor, factor, factor_bytes, regular_factor
from creak.linalg.memory import MADE, PRODUCT, OutOfMemory, free_bytes
from creak.linalg.pieces.factor import PieceFactor, Pieces, cut_to_fit
from creak.linalg.windows import window_bytes

BOUND, POWER = 240.0, 4.0 / 3.0
"""A factor of n equations takes at most BOUND n^POWER bytes (a solid cube), and the rest of the work twice that."""
PLENTY = 0.3
"""Share of the free memory up to which that bound needs no closer look."""


def plenty(*sizes: int) -> bool:
    """Whether so many equations plainly fit."""
    return 3.0 * sum(BOUND * float(n) ** POWER for n in sizes) <= PLENTY * free_bytes()


def beside_factor(n: int, K: float, M: float) -> float:
    """The product with M, and what K - s M takes until its factor is there or the vectors of the smallest window then.

    Parameters
    ----------
    K, M : stored entries.
    """
    return PRODUCT * M + max(MADE * K, window_bytes(n))


def beside_pieces(n: int, M: float) -> float:
    """The same where the factor is one of pieces, of which K - s M is made too."""
    return PRODUCT * M + window_bytes(n)


def pieces_of(K: Matrix, M: Matrix, free: float | None = None) -> Pieces | None:
    """How K x = lam M x is cut where a factor of K does not fit beside the rest; None where it does, or no cut helps.

    Where pieces do not fit either those that come closest are told.

    Costs the analysis of K, a third of the time of its factor, and as much again for the pieces.

    Parameters
    ----------
    free : bytes that may be taken; default: all that are free.
    """
    if not sp.issparse(K) or plenty(K.shape[0]):
        return None
    free, needed = free_bytes() if free is None else free, factor_bytes(K)
    if needed + beside_factor(K.shape[0], K.nnz, M.nnz) <= free:
        return None
    cut = cut_to_fit(sp.csr_matrix(abs(K) + abs(M)), needed, free - beside_pieces(K.shape[0], M.nnz))
    return cut if cut is not None and cut.bytes < needed else None


def regular_factor_that_fits(
    K: Matrix, M: Matrix, cut: Pieces | None = None, *, first: bool = True
) -> tuple[Factor | None, Pieces | None]:
    """`regular_factor` of K, and the pieces that it is one of; None where it is one of all.

    Parameters
    ----------
    cut : pieces, where they are known. first : the modes are still to come, and what they take has to fit beside it.

    Raises
    ------
    OutOfMemory : K does not fit, in pieces neither.
    """
    if cut is None:
        beside = beside_factor(K.shape[0], K.nnz, M.nnz) if first else 0.0
        try:
            return regular_factor(K, partial(factor, beside=beside)), None
        except OutOfMemory:
            cut = pieces_of(K, M)
    return regular_factor(K, factor if cut is None else partial(PieceFactor, pieces=cut)), cut
