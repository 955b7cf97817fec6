"""Block Lanczos on (K - shift M)^-1 M for the lowest modes, with measured partial reorthogonalisation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray
from creak.linalg.dense_product import inner, product, right_solve, subtract_product, symmetric
from creak.linalg.factor import Factor
from creak.linalg.memory import require, rows_of
from creak.linalg.ritz import Projection, Sought
from creak.linalg.sparse_product import BlockProduct
from creak.progress import Steps

ORTHOGONAL = 1e-9
"""A new vector may have this much of the old ones in it; semi-orthogonality would do with 1e-8."""
DEPENDENT = 1e-13
"""A column that the old ones explain up to this share of the largest eigenvalue is replaced by a random one."""
PROBES = 8
"""Random combinations of the old vectors that a new block is tested with."""
FRESH = 1e-6
"""The same limit for columns of length 1."""
DEPENDENT_GRAM = 1e-12
"""Smallest eigenvalue of the scaled Gram matrix of a block that Cholesky is trusted with."""
WELL = 1e4
"""Condition of the scaled Gram matrix up to which one Cholesky orthonormalisation is enough."""
CONVERGING = 0.48
"""Eigenvalues that converge per new vector once the process has settled."""
LOOK = 0.03
"""Vectors until the next look, at least, as a share of those that there are: its cost grows with their cube."""
MAX_PASSES = 8
"""Orthonormalisations of one block; two are enough but where columns are dependent."""
ROWS = 8192
"""Rows of the basis turned into eigenvectors at a time."""
BESIDE = 1.4
"""Free memory over that of the vectors that are expected, from which on they lie in memory and not in a file."""
WORK, DENSE = 8, 4
"""Blocks beside the basis, and matrices of the size of T, that are there at a time."""
FEWER = "Ask for fewer modes (a lower f_max or count), or cut the part into substructures."
"""What to do where the vectors are too many."""


@dataclass(frozen=True)
class Ritz:
    """Lowest eigenvalues of K x = lam M x and what they cost."""

    lam: FloatArray
    """(n_value,), rising; one more than vectors where one more was asked for and exists."""
    shapes: FloatArray
    """(n, n_vector) in Fortran order, M-orthonormal."""
    columns: int
    """Vectors that went through the factor."""


class _Basis:
    """Lanczos vectors Q (n, used) in one piece, which the eigenvectors later take over.

    Where they take much of the memory they lie in a file that the system keeps there as far as it can: more of them
    than were expected slow the work down, and do not end it.
    """

    def __init__(self, n: int, capacity: int, expected: int) -> None:
        self._rows = rows_of(n, capacity, BESIDE * min(expected / capacity, 1.0))  # what is not written takes no memory
        self._signs = np.random.default_rng(1984)
        self._probe = np.zeros((n, PROBES), order="F")
        self.used = 0

    def append(self, W: FloatArray) -> None:
        width = W.shape[1]
        if self.used + width > self._rows.shape[0]:
            self._enlarge(int(1.3 * self._rows.shape[0]) + width)
        self._rows[self.used : self.used + width] = W.T
        subtract_product(self._probe, W, self._signs.choice([-1.0, 1.0], (width, PROBES)))
        self.used += width

    def _enlarge(self, capacity: int) -> None:
        if isinstance(self._rows, np.memmap):
            before, self._rows = self._rows, rows_of(self._rows.shape[1], capacity)
            self._rows[: self.used] = before[: self.used]
        else:
            self._rows.resize((capacity, self._rows.shape[1]), refcheck=False)

    def loss(self, Z: FloatArray, R: FloatArray) -> float:
        """Largest |Q' z| over the columns z of Z R^-1, where Z = M W and W = Q_new R, from random combinations of Q:
        |g' Q' z| is |Q' z| in the mean square for random signs g."""
        if self.used == 0 or Z.shape[1] == 0:
            return 0.0
        share = sla.solve_triangular(R, inner(self._probe, Z).T, trans="T")
        return float(np.linalg.norm(share, axis=1).max() / np.sqrt(PROBES))

    def remove(self, W: FloatArray, Z: FloatArray) -> FloatArray:
        """W -= Q Q' Z in place; returns Q' Z."""
        Q = self._rows[: self.used].T
        share = inner(Q, Z)
        subtract_product(W, Q, share)
        return share

    def remove_block(self, W: FloatArray, start: int, share: FloatArray) -> None:
        """W -= Q[:, start:start + k] share in place."""
        subtract_product(W, self._rows[start : start + share.shape[0]].T, share)

    def combined(self, S: FloatArray) -> FloatArray:
        """Q S (n, k) in the memory of Q; the basis is gone then."""
        n, k = self._rows.shape[1], S.shape[1]
        for first in range(0, n, ROWS):
            part = slice(first, first + ROWS)
            self._rows[:k, part] = product(self._rows[: self.used, part].T, S).T
        if isinstance(self._rows, np.memmap):
            return self._rows[:k].T
        self._rows.resize((k, n), refcheck=False)
        return self._rows.T


def lanczos(
    inverse: Factor,
    mass: BlockProduct,
    shift: float,
    wanted: int,
    *,
    extra: int = 0,
    skip: int = 0,
    lower: float = -np.inf,
    upper: float = np.inf,
    within: int | None = None,
    width: int | None = None,
    progress: Steps | None = None,
) -> Ritz:
    """The `wanted` lowest eigenpairs of K x = lam M x, and `extra` eigenvalues more.

    Parameters
    ----------
    inverse : factor of K - shift M. Its negative eigenvalues, as many as there are modes below the shift, are
        `wanted` at most.
    mass : product with M (n, n), positive semidefinite; A = inverse M is self-adjoint in its inner product.
    wanted, extra : number of eigenpairs, and of further eigenvalues without their vectors.
    skip, lower : so many lowest eigenpairs, none of them above `lower`, are left out; all lie below the shift.
    width : of a block of vectors; default: `block_width`.
    upper, within : so many of the lowest eigenvalues, the `wanted` ones by default, are known to be smaller than
        `upper`; the search goes on until they are.

    Method: A Q_j = Q_j-1 R_j-1' + Q_j alpha_j + Q_j+1 R_j, with one product with M per block; theta = 1 / (lam -
    shift) are eigenvalues of A, and those on either side of 0 that are largest converge first (Grimes, Lewis, Simon,
    SIAM J. Matrix Anal. 15, 1994). A shift amid the wanted modes needs fewer vectors than one below them, and
    the inertia of the factor tells how many there are below it. Orthogonality to the earlier blocks is lost as
    eigenvalues converge. Instead of estimating it by a recurrence, which must guess the round-off of the factor, it
    is measured on random combinations of the old vectors, and restored when it exceeds `ORTHOGONAL` (partial
    reorthogonalisation, Simon, Math. Comp. 42, 1984). Dependent columns are replaced by random ones, so
    multiplicities may exceed the block width. The memory is that of the basis, 2 to 3 times `wanted` vectors.
    """
    n = mass.n
    values = min(wanted + extra, n)
    width = min(width or block_width(values), n)
    below = inverse.n_negative - skip
    needed = basis_bytes(n, values, amid=below > 0, width=width)
    require(needed, f"the vectors that {wanted:,} modes of {n:,} equations take", FEWER)
    sought = Sought(shift, below, wanted if within is None else within, values, lower, upper)
    krylov = _Krylov(inverse, mass, min(n, 3 * values + 4 * width), _first_look(values, width, below > 0))
    W, Z, _ = krylov.next_block(np.zeros((n, 0)), width, 0.0)
    if W.shape[1] == 0:  # no mass at all
        return Ritz(np.zeros(0), np.zeros((n, 0)), krylov.columns)
    projection, back, look = Projection(sought), np.zeros((0, W.shape[1])), _first_look(values, width, below > 0)
    while True:
        W, alpha = krylov.step(W, Z, back)
        scale = projection.border(back, alpha)
        used = krylov.basis.used
        W, Z, R = krylov.next_block(W, min(width, n - used), DEPENDENT * scale, Z)
        back = R.T
        exhausted = W.shape[1] == 0
        if progress is not None and not exhausted:
            progress(min(used // 3, max(wanted - 1, 0)), wanted)
        if exhausted or used >= look:
            missing = projection.missing(R, exhausted)
            if exhausted or missing == 0:
                break
            look = used + max(_next_look(missing, width, below > 0), int(LOOK * used))
    del W, Z
    if progress is not None:
        progress(wanted, wanted)
    order, S = projection.order, projection.vectors
    return Ritz(shift + 1.0 / projection.theta[order], krylov.basis.combined(S[:, order[:wanted]]), krylov.columns)


def _first_look(values: int, width: int, amid: bool) -> int:
    """Size of the basis at which most of the eigenvalues have converged; the eigenproblem of T is not for free."""
    if amid:
        return int(1.66 * values) + 7 * width
    return int(2.2 * values) + min(5 * width, values + width)


def _next_look(missing: int, width: int, amid: bool) -> int:
    """Vectors until the next look; with a shift amid the modes the last third of them converges all at once."""
    return width if amid else max(width, int(missing / CONVERGING))


def basis_bytes(n: int, values: int, *, amid: bool = True, width: int | None = None) -> float:
    """Memory that `values` eigenpairs of n equations take, the shift `amid` them or below: basis, blocks of work."""
    width = width or block_width(values)
    vectors = _first_look(values, width, amid)
    return 8.0 * n * (min(vectors, n) + WORK * width) + DENSE * 8.0 * vectors**2


def block_width(values: int) -> int:
    """Wide blocks solve faster per column, narrow ones need fewer columns."""
    return 16 if values < 200 else 24


class _Krylov:
    """The growing Krylov space of A = inverse M."""

    def __init__(self, inverse: Factor, mass: BlockProduct, capacity: int, expected: int) -> None:
        self._inverse, self._mass = inverse, mass
        self._rng = np.random.default_rng(20190527)
        self.basis = _Basis(mass.n, capacity, expected)
        self.columns = 0

    def step(self, W: FloatArray, Z: FloatArray, back: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Store the block W, with Z = M W; return A W without its part in this block and the one before, and alpha.

        A W takes the memory of W.
        """
        self.basis.append(W)
        before = self.basis.used - W.shape[1] - back.shape[0]
        W = self._solve(Z, W)
        self.basis.remove_block(W, before, back)
        alpha = inner(Z, W)
        self.basis.remove_block(W, before + back.shape[0], alpha)
        return W, symmetric(alpha)

    def next_block(
        self, W: FloatArray, width: int, floor: float, spare: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Q (n, width), M Q and R with W = Q R: M-orthonormal, also to the basis, filled up with random columns.

        `floor`: columns whose independent part is smaller are taken for dependent. Q is narrower than `width`
        only where the space is exhausted. `spare`: memory that M Q may take.
        """
        R = np.eye(W.shape[1])
        W, Z, R = self._orthonormal(W, R, floor, spare)
        if W.shape[1] > width:
            W, Z, R = np.asfortranarray(W[:, :width]), np.asfortranarray(Z[:, :width]), R[:width]
        if W.shape[1] < width:
            W = np.asfortranarray(np.hstack([W, self._random(width - W.shape[1])]))
            R = np.vstack([R, np.zeros((width - R.shape[0], R.shape[1]))])
            W, Z, R = self._orthonormal(W, R, FRESH)
        return W, Z, R

    def _orthonormal(
        self, W: FloatArray, R: FloatArray, floor: float, spare: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cholesky orthonormalisation, repeated while it was ill-conditioned or old vectors had to be removed."""
        Z = self._mass(W, spare)
        for left in reversed(range(MAX_PASSES)):
            if W.shape[1] == 0:
                break
            gram = symmetric(inner(W, Z))
            factor_R, condition = _cholesky(gram, floor)
            if factor_R is None:
                W, factor_R = _independent(W, gram, floor)
                Z = self._mass(W)
            else:
                old = self.basis.loss(Z, factor_R) > ORTHOGONAL
                if old and condition < WELL and left:
                    self.basis.remove(W, Z)
                    Z = self._mass(W, Z)
                    continue
                right_solve(W, factor_R)
                right_solve(Z, factor_R)
                if condition < WELL and not old:
                    return W, Z, factor_R @ R
            R, floor = factor_R @ R, FRESH
        return W, Z, R

    def _random(self, width: int) -> FloatArray:
        """Columns in the range of A, of M-length 1."""
        W = self._solve(self._mass(self._rng.standard_normal((self._mass.n, width))))
        size = np.sqrt(np.einsum("ij,ij->j", W, self._mass(W)))
        return W / np.where(size > 0.0, size, 1.0)

    def _solve(self, Z: FloatArray, out: FloatArray | None = None) -> FloatArray:
        self.columns += Z.shape[1]
        return np.asfortranarray(self._inverse.solve(Z, out))


def _cholesky(gram: FloatArray, floor: float) -> tuple[FloatArray | None, float]:
    """R with R' R = gram and the condition of the scaled gram; None where columns shorter than `floor` or dependent
    ones forbid it."""
    size = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    values = sla.eigvalsh(gram / np.outer(size, size))
    if values[0] <= DEPENDENT_GRAM or size.min() <= floor:
        return None, np.inf
    return np.asarray(sla.cholesky(gram)), float(1.0 / values[0])


def _independent(W: FloatArray, gram: FloatArray, floor: float) -> tuple[FloatArray, FloatArray]:
    """The independent part V of W, nearly M-orthonormal, and R with W = V R; columns shorter than `floor` go."""
    values, vectors = sla.eigh(gram)
    keep = values > max(floor**2, 1e-20 * values[-1])
    length = np.sqrt(values[keep])
    return product(W, vectors[:, keep] / length), length[:, None] * vectors[:, keep].T
