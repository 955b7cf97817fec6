"""The inside of a part whose boundary is held: what every static reduction needs of it.

Memory holds its factor beside the vectors of its modes, or only pieces of it at a time."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.factor import Factor, LaterFactor, factor, factor_bytes, regular_factor
from creak.linalg.memory import MADE, PRODUCT, OutOfMemory, free_bytes, spared
from creak.linalg.pieces.factor import PieceFactor, Pieces, cut_to_fit
from creak.linalg.sparse_product import BlockProduct, copy_fits
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


OTHERS = 8.0
"""Factors of the size of a part's own, that its others may take: where memory holds so many more each keeps its own."""


class Inside:
    """Internal dofs i and boundary dofs b of a System: M and K in blocks, and one factor of K_ii.

    The factor is made when first needed and given back by `release`; it comes again by itself when something
    asks for it later, so that a superelement at rest holds no factor.
    """

    def __init__(self, system: System, boundary: IntArray) -> None:
        self.name = system.name
        self.b = np.unique(boundary).astype(np.int64)
        self.i = np.setdiff1d(np.arange(system.n), self.b)
        self._system = system
        self._inner: dict[str, Matrix] = {}
        self._factor = LaterFactor(self._regular)
        self._pieces: Pieces | None = None
        self._first = True
        self._stiffness: BlockProduct | None = None
        self._mass: BlockProduct | None = None

    @cached_property
    def _sides(self) -> dict[str, tuple[Matrix, Matrix]]:
        """A_ib and A_bb of stiffness and mass."""
        both = {name: sp.csr_matrix(getattr(self._system, name)) for name in ("K", "M")}
        return {name: (A[self.i][:, self.b], A[self.b][:, self.b]) for name, A in both.items()}

    @property
    def K_ib(self) -> Matrix:
        """Stiffness of the inside against the boundary."""
        return self._sides["K"][0]

    @property
    def K_bb(self) -> Matrix:
        """Stiffness of the boundary."""
        return self._sides["K"][1]

    @property
    def M_ib(self) -> Matrix:
        """Mass of the inside against the boundary."""
        return self._sides["M"][0]

    @property
    def M_bb(self) -> Matrix:
        """Mass of the boundary."""
        return self._sides["M"][1]

    @property
    def K_ii(self) -> Matrix:
        """Stiffness of the inside; cut out anew after `release`."""
        return self._block("K")

    @property
    def M_ii(self) -> Matrix:
        """Mass of the inside."""
        return self._block("M")

    def _block(self, name: str) -> Matrix:
        if name not in self._inner:
            A = sp.csr_matrix(getattr(self._system, name))
            self._inner[name] = spared(A[self.i][:, self.i])
        return self._inner[name]

    @property
    def factor(self) -> LaterFactor:
        """A factor of K_ii, there already.

        Raises
        ------
        NumericalError : the boundary does not hold the part (K_ii is singular).
        """
        _ = self._factor.made
        return self._factor

    @property
    def pieces(self) -> Pieces | None:
        """How the inside was cut where memory did not hold a factor of it; None as long as none was made, too."""
        return self._pieces

    def in_one(self) -> bool:
        """Whether memory holds a factor of the inside in one; it is made for that."""
        if self.i.size:
            _ = self.factor
        return self._pieces is None

    def _regular(self) -> Factor:
        found, self._pieces = regular_factor_that_fits(self.K_ii, self.M_ii, self._pieces, first=self._first)
        self._first = False
        if found is None:
            raise NumericalError(
                f"part {self.name} cannot be reduced: its {self.b.size} retained dofs do not hold it (the stiffness "
                "of the others is singular). Couple or support it, or retain more nodes."
            )
        return found

    @property
    def stiffness(self) -> BlockProduct:
        """The product with K_ii."""
        if self._stiffness is None:
            self._stiffness = BlockProduct(self.K_ii, own=copy_fits(self.K_ii))
        return self._stiffness

    @property
    def mass(self) -> BlockProduct:
        """The product with M_ii."""
        if self._mass is None:
            self._mass = BlockProduct(self.M_ii)
        return self._mass

    def release(self, above: int = 0) -> None:
        """Give the memory of blocks, factor and products back, unless the factor has `above` bytes at most."""
        if self._factor.nbytes > above:
            self._factor.release()
            self._forget()

    def _forget(self) -> None:
        """Blocks and products, of which each is cut out anew where it is asked for."""
        self._inner.clear()
        self._stiffness = self._mass = None

    def solve_only(self) -> None:
        """Make the factor; where memory is short, what it was made of goes."""
        self.in_one()
        if self._short:
            self._forget()

    def spare(self) -> None:
        """`release` where memory is short."""
        if self._short:
            self.release()

    @property
    def _short(self) -> bool:
        """Memory would not hold those of other parts beside this factor."""
        return OTHERS * self._factor.memory > free_bytes()

    def solve(self, f: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """K_ii^-1 f; f is (n_i,) or (n_i, k). `out`: memory of that shape where it may be put; use what is returned."""
        if self.i.size == 0 or f.size == 0:
            return np.zeros(f.shape)
        return self.factor.solve(np.asfortranarray(f), out)

    def follow(self, u_b: Matrix) -> FloatArray:
        """The static motion of the inside, Psi u_b = -K_ii^-1 K_ib u_b; u_b is (n_b, k)."""
        f = self.K_ib @ u_b
        return -self.solve(f.toarray(order="F") if sp.issparse(f) else np.asarray(f))
