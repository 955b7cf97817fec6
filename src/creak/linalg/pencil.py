"""The pencil K - s M: its factors at one shift after the other, whole or in pieces, and what their inertia counts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import Csr, FloatArray, Matrix
from creak.errors import InputError, NumericalError
from creak.jit import njit
from creak.linalg.dense_product import symmetric
from creak.linalg.factor import Factor, SingularMatrixError, factor, refactor
from creak.linalg.memory import rows_of, spared
from creak.linalg.pieces.factor import PieceFactor, Pieces, Shifted
from creak.linalg.sparse_product import BlockProduct
from creak.linalg.threads import dense_threads

NOTHING = 1e-13
"""Below this share of the largest a term of the diagonal of K + s M, or its eigenvalue once scaled to ones, is none."""
NEGATIVE = 1e-9
"""Eigenvalues of the same below minus this are more than round-off."""
INDEFINITE = 1e-8
"""Share of its terms below minus which x' A x is more than the round-off of a matrix, reduced ones included."""
FAINT = 1e-4
"""Share of the largest entry that counts among the terms, so that entries of round-off have no sign."""
FIXES = {
    "K": "Look for wrong signs in K. A structure that has buckled and that its stops alone hold has no modes: move its "
    "unreduced System (creak.simulate).",
    "M": "Look for wrong signs in M, negative point masses, or rows and columns in different orders.",
}
ASIDE = 1e-6
"""A shift that hits an eigenvalue is moved up by this share."""


APART = 1e-4
"""Share of the largest eigenvalue below which pairs that round-off blurs are found once more among themselves."""
MASSLESS = 1e-12
"""Eigenvalues 1 / (lam + s) below this share of the largest are those of directions without mass."""
ROUND_OFF = 100.0
"""Round-off of eigenvalues in units of eps times the largest, at most."""
BLURRED = 1e-5
"""The same as a share of the lowest elastic one from which on it is too much."""


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
        if _subtract((K.indptr, K.indices, K.data), (M.indptr, M.indices, M.data), s, entries):
            return sp.csr_matrix((entries, K.indices, K.indptr), shape=K.shape, copy=False)
    return spared(K - s * M)


@njit(nogil=True)
def _subtract(of_K: Csr, of_M: Csr, s: float, out: FloatArray) -> bool:
    """`out` = K - s M entry by entry; False where M has one that K lacks."""
    K_rows, K_columns, K = of_K
    M_rows, M_columns, M = of_M
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


def require_positive(name: str, A: FloatArray | Matrix, X: FloatArray) -> None:
    """Refuse a matrix A (n, n) with x' A x < 0 for a column of X (n, k), beyond the round-off of its entries.

    Parameters
    ----------
    name : for the message.

    Raises
    ------
    InputError : with x' A x over |x|' |A| |x|; x' K x is omega^2 where x' M x = 1.
    """
    if not X.shape[1]:
        return
    energy = np.einsum("ij,ij->j", X, np.asarray(A @ X))
    size = np.einsum("ij,ij->j", abs(X), np.asarray(abs(A) @ abs(X)))
    share = energy / (size + FAINT * float(abs(A).max()) * np.einsum("ij,ij->j", X, X) + np.finfo(float).tiny)
    k = int(share.argmin())
    if share[k] >= -INDEFINITE:
        return
    far = f" (omega^2 = {energy[k]:.4g} (rad/s)^2)" if name == "K" else ""
    raise InputError(
        f"{name} is not positive: a shape x has x' {name} x / (|x|' |{name}| |x|) = {share[k]:.2g}{far}",
        expected=f"at least {-INDEFINITE:g}, which is round-off",
        fix=FIXES[name],
    )


class Pairs(NamedTuple):
    """Eigenpairs of a dense pencil, rising."""

    lam: FloatArray
    vectors: FloatArray
    """(n, n_pair), M-orthonormal."""
    blur: float
    """What round-off may leave of an eigenvalue of zero."""


def dense_pairs(K: FloatArray, M: FloatArray) -> Pairs:
    """All finite eigenpairs of dense K x = lam M x; M may be singular."""
    try:
        return regular_pairs(K, M)
    except np.linalg.LinAlgError:
        return _massless_pairs(K, M)


def regular_pairs(K: FloatArray, M: FloatArray) -> Pairs:
    """The same of a positive M.

    The round-off of all eigenvalues is that of the largest, eps lam_max, which rotations with next to no inertia make
    huge: at 1e19 (rad/s)^2 a mode of 80 Hz is off by 0.1 %. Where it blurs the lowest, they are found once more in
    the space of the vectors X of all that lie far below the largest: (X' K X) y = mu (X' M X) y (Rayleigh and Ritz);
    of these once more the lowest, until nothing blurs them but what the terms of x' K x lose to each other.

    Raises
    ------
    LinAlgError : M is not positive.
    """
    return _sharp_pairs(K, M, 0.0)


def _sharp_pairs(K: FloatArray, M: FloatArray, lost: float) -> Pairs:
    """The same; `lost`: round-off that the entries of K have already."""
    with dense_threads(len(K)):
        lam, X = sla.eigh(K, M, driver="gvd")
    blur = max(_blur(lam), lost)
    elastic, low = lam[lam > blur], lam < APART * lam.max(initial=0.0)
    if not (blur > lost and low.any() and elastic.size and blur > BLURRED * elastic[0]):
        return Pairs(lam, X, blur)
    space = np.asfortranarray(X[:, low])
    size = np.abs(space[:, 0])
    lost = max(lost, ROUND_OFF * np.finfo(float).eps * float(np.linalg.norm(size * (np.abs(K) @ size))))
    lam[low], Y, blur = _sharp_pairs(symmetric(space.T @ K @ space), symmetric(space.T @ M @ space), lost)
    X[:, low] = space @ Y
    return Pairs(lam, X, blur)


def _blur(lam: FloatArray) -> float:
    return ROUND_OFF * np.finfo(float).eps * float(np.abs(lam).max(initial=0.0))


def _massless_pairs(K: FloatArray, M: FloatArray) -> Pairs:
    """Eigenpairs when M is singular: solve M x = mu (K + s M) x and drop mu = 0 (infinite frequency).

    So are directions with neither mass nor stiffness, which take part in no mode: a bar that turns about itself. Those
    of no mass have a mu of round-off, either sign of some eps times the largest: `MASSLESS`. The round-off of an
    eigenvalue 1 / mu - s far below s is that of s.
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
    require_positive("M", M, x[:, mu < 0.0])
    finite = mu > MASSLESS * mu.max(initial=0.0)
    mu, x = mu[finite][::-1], x[:, finite][:, ::-1]
    lam = 1.0 / mu - shift
    return Pairs(lam, x / np.sqrt(mu), _blur(np.append(lam[lam < shift], shift)))
