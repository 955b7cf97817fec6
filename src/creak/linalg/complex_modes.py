"""Complex modes of a structure whose damping couples its undamped modes.

In coordinates x = (S q, q') of the undamped modes, S = diag(omega), free motion x' = A x with

    A = [[0, S], [-S, -C]]

is skew but for the damping, so that its eigenvectors are nearly orthogonal where damping is light. x = X z, z two real
numbers for each pair of conjugate or real eigenvalues; a pair moves by itself, z_j' = B_j z_j. Modes that C does not
couple stay as they are, rigid ones among them. Where X is ill-conditioned (damping near critical: eigenvectors that
nearly coincide) C is changed by `NUDGE` of itself, which separates them: Davies, Approximate diagonalization, SIAM J.
Matrix Anal. Appl. 29, 2007.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla

from creak.arrays import BoolArray, ComplexArray, FloatArray, brief
from creak.errors import NumericalError
from creak.linalg.secular import eigenpairs, few_dashpots, left_of

OFF_DIAGONAL = 1e-6
"""Modal damping that couples modes by less than this share of their own damping counts as diagonal."""
ILL = 1e6
"""Condition of the eigenvectors above which the damping is nudged."""
NUDGE = 1e-11
"""Share of itself: motion is off by as much for each radian, and round-off times 1 / sqrt(NUDGE)."""
TRUSTED = 1e-6
"""Largest residual of the eigenvectors: |A X - X B| and |X Y - 1|."""
PROBES = 3
"""Vectors by which X Y is held to 1."""


@dataclass(frozen=True)
class ComplexModes:
    """n pairs z (2 n) of complex modes: all first members, then all second ones; z' = B z + push f, pair by pair.

    First stand the `alone` modes that damping does not couple, with (S q, q') as their pair. Coordinates q (n,) are
    those in which M and K are diagonal.
    """

    __repr__ = brief

    omega2: FloatArray
    """(n,) k / m of the coordinates."""
    damping: FloatArray
    """(n,) of each coordinate by itself over its mass, 1 / time."""
    alone: int
    blocks: FloatArray
    """(4, n) B as (00, 01, 10, 11): of pairs a rotation, or the diagonal of two real eigenvalues."""
    basis: FloatArray
    """(n, 2 n) q = basis z."""
    speeds: FloatArray
    """(n, 2 n) q' = speeds z."""
    place: FloatArray
    push: FloatArray
    """(2 n, n) z = place q + push M q'; impulses add push times them."""
    coupling: FloatArray
    """(2 p, 2 p) X: of the p pairs, (S q, q') = X z."""
    strain: FloatArray
    """(n,) omega over S, in the order of the pairs."""

    def energies(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(k,) kinetic and strain energy of motions z (k, 2 n)."""
        first, second = np.hsplit(z, 2)
        x = np.hstack([first[:, self.alone :], second[:, self.alone :]]) @ self.coupling.T
        among = np.split(x, 2, axis=1)
        q, v = (np.hstack([own[:, : self.alone], other]) for own, other in zip((first, second), among, strict=True))
        return 0.5 * np.einsum("ki,ki->k", v, v), 0.5 * np.square(self.strain * q).sum(axis=1)


def complex_modes(m: FloatArray, k: FloatArray, C: FloatArray, shared: FloatArray | None = None) -> ComplexModes:
    """Of a structure with diagonal M and K, m and k (n,), m above 0, and symmetric C (n, n).

    Parameters
    ----------
    shared : (n, n) the part of C that couples modes, where it is known; few dashpots are faster (`linalg.secular`).

    Raises
    ------
    NumericalError : no trustworthy eigenvectors were found.
    """
    mass, n = np.sqrt(m), m.size
    omega, C = np.sqrt(np.maximum(k, 0.0)) / mass, C / np.outer(mass, mass)
    own, turn = C.diagonal().copy(), _rigid_apart(C, omega)
    C = turn.T @ C @ turn
    together = coupled(C)
    alone, pairs, scale = np.flatnonzero(~together), np.flatnonzero(together), _scales(omega)
    some, found = np.ix_(pairs, pairs), None
    if shared is not None and np.all(omega[pairs] > 0.0):
        found = _of_few_dashpots(omega[pairs], C[some], (shared / np.outer(mass, mass))[some])
    X, Y, B = found or _eigenpairs(scale[pairs], omega[pairs], C[some])
    order, a = np.concatenate([alone, pairs]), alone.size
    of_x, of_z = np.concatenate([pairs, n + pairs]), np.concatenate([np.arange(a, n), n + np.arange(a, n)])
    lone_x, lone_z = np.concatenate([alone, n + alone]), np.concatenate([np.arange(a), n + np.arange(a)])
    whole, inverse = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    whole[np.ix_(of_x, of_z)], inverse[np.ix_(of_z, of_x)] = X, Y
    whole[lone_x, lone_z] = inverse[lone_z, lone_x] = 1.0
    # Coordinates are turn (x / scale) / mass.
    q, v, to_x, to_v = whole[:n] / scale[:, None], whole[n:], inverse[:, :n] * scale, inverse[:, n:]
    if np.any(omega == 0.0):
        q, v, to_x, to_v = turn @ q, turn @ v, to_x @ turn.T, to_v @ turn.T
    s, c = scale[alone], C.diagonal()[alone]
    return ComplexModes(
        omega2=omega**2,
        damping=own,
        alone=a,
        blocks=np.hstack([np.stack([0.0 * c, s, -(omega[alone] ** 2) / s, -c]), B]),
        basis=q / mass[:, None],
        speeds=v / mass[:, None],
        place=to_x * mass,
        push=to_v / mass,
        coupling=X,
        strain=(omega / scale)[order],
    )


def coupled(C: FloatArray) -> BoolArray:
    """(n,) modes that share damping with others, beyond `OFF_DIAGONAL` of their own."""
    d = np.maximum(C.diagonal(), 0.0)
    size = np.sqrt(d)
    off = np.abs(C) > OFF_DIAGONAL * np.maximum(np.outer(size, size), OFF_DIAGONAL * d.max(initial=0.0))
    np.fill_diagonal(off, False)
    return np.asarray(off.any(axis=1))


def _rigid_apart(C: FloatArray, omega: FloatArray) -> FloatArray:
    """(n, n) orthogonal: turns the rigid modes so that damping does not couple them with each other."""
    turn, rigid = np.eye(omega.size), np.flatnonzero(omega == 0.0)
    if rigid.size:
        turn[np.ix_(rigid, rigid)] = np.linalg.eigh(C[np.ix_(rigid, rigid)])[1]
    return turn


def _scales(omega: FloatArray) -> FloatArray:
    """S: omega, and the lowest of them for rigid modes."""
    moving = omega > 0.0
    return np.where(moving, omega, omega[moving].min() if moving.any() else 1.0)


Found = tuple[FloatArray, FloatArray, FloatArray]


def _of_few_dashpots(omega: FloatArray, C: FloatArray, shared: FloatArray) -> Found | None:
    """As `_eigenpairs`; None where there are too many, or these cannot be trusted."""
    few = few_dashpots(C, shared)
    found = None if few is None else eigenpairs(omega, *few)
    if few is None or found is None:
        return None
    values, vectors = found
    with np.errstate(all="ignore"):
        left = left_of(values, vectors)
    (X, B), Y = _real_pairs(values, vectors, left)
    p, (d, W) = omega.size, few
    if not np.all(np.isfinite(Y)) or np.linalg.norm(X, 1) * np.linalg.norm(Y, 1) > ILL * p:
        return None
    some = np.random.default_rng(2).standard_normal((2 * p, PROBES))
    top, low = X[:p], X[p:]
    A_X = np.vstack([omega[:, None] * low, -omega[:, None] * top - d[:, None] * low - W @ (W.T @ low)])
    fits = np.abs(A_X - _times(X, B)).max(axis=1) <= TRUSTED * np.concatenate([omega, np.maximum(omega, C.max(axis=1))])
    return (X, Y, B) if np.all(fits) and np.abs(X @ (Y @ some) - some).max() <= TRUSTED else None


def _times(X: FloatArray, B: FloatArray) -> FloatArray:
    """X times the blocks."""
    first, second = np.hsplit(X, 2)
    return np.hstack([first * B[0] + second * B[2], first * B[1] + second * B[3]])


def _eigenpairs(scale: FloatArray, omega: FloatArray, C: FloatArray) -> Found:
    """X (2 p, 2 p), its inverse, and the blocks B (4, p); columns j and p + j belong to block j.

    The eigensolver gets the fastest modes first, velocities before displacements: it is off by round-off of the largest
    number only in rows as large then (of a matrix that falls from its first row to its last).
    """
    p = omega.size
    if p == 0:
        return np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((4, 0))
    A = np.block([[np.zeros((p, p)), np.diag(scale)], [-np.diag(omega**2 / scale), -C]])
    size = np.sqrt(np.maximum(C.diagonal(), 0.0))
    fastest = np.argsort(-omega, kind="stable")
    order = np.stack([p + fastest, fastest], axis=1).ravel()
    for nudge, ill in ((0.0, ILL), (NUDGE, ILL**2), (100.0 * NUDGE, ILL**2)):
        if nudge > 0.0:
            noise = np.random.default_rng(1).standard_normal((p, p))
            A[p:, p:] = -C - nudge * size[:, None] * (noise + noise.T) * size
        values, vectors = sla.eig(A[np.ix_(order, order)])
        (X, B), _ = _real_pairs(values, vectors[np.argsort(order)])
        try:
            Y = np.asarray(np.linalg.inv(X), dtype=float)
        except np.linalg.LinAlgError:
            continue
        if np.linalg.norm(X, 1) * np.linalg.norm(Y, 1) > ill * p:
            continue
        if np.all(np.abs(A @ X - _times(X, B)).max(axis=1) <= TRUSTED * np.abs(A).max(axis=1)):
            return X, Y, B
    raise NumericalError("the complex modes of the damped System cannot be told apart")


def _real_pairs(
    values: ComplexArray, vectors: ComplexArray, left: ComplexArray | None = None
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Real columns and blocks: rotations of conjugate pairs, diagonal ones of two neighbouring real eigenvalues.

    Parameters
    ----------
    left : (k, 2 p) left eigenvectors, their product with the right ones 1: then the inverse of the columns is found.
    """
    upper = np.flatnonzero(values.imag > 0.0)
    real = np.flatnonzero(values.imag == 0.0)
    real = real[np.argsort(values[real].real)]
    one, two = real[0::2], real[1::2]
    X = vectors[:, upper]
    # Each conjugate pair turned so that its real and imaginary parts are orthogonal: the best conditioned choice.
    angle = 0.5 * np.angle(np.sum(X * X, axis=0))
    turn = np.exp(-1j * angle) * math.sqrt(2.0)
    X = X * turn
    first = np.hstack([X.real, vectors[:, one].real])
    second = np.hstack([X.imag, vectors[:, two].real])
    a, b, none = values[upper].real, values[upper].imag, np.zeros(one.size)
    turning = np.stack([a, b, -b, a])
    growing = np.stack([values[one].real, none, none, values[two].real])
    Y = np.zeros((0, 0))
    if left is not None:
        own = 2.0 * left[upper] / turn[:, None]
        Y = np.vstack([own.real, left[one].real, -own.imag, left[two].real])
    return (np.hstack([first, second]), np.hstack([turning, growing])), Y
