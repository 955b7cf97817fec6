"""The pencil K - s M: its factors at one shift after the other, whole or in pieces, and what their inertia counts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from creak.arrays import Matrix
from creak.linalg.factor import Factor, SingularMatrixError, factor, refactor
from creak.linalg.pieces.factor import PieceFactor, Pieces, Shifted
from creak.linalg.shifted import shifted
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
