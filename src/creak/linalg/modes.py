"""Undamped modes of K x = omega^2 M x: shift-invert block Lanczos with a Sturm check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.errors import NumericalError
from creak.linalg.factor import Factor, SingularMatrixError, factor

DENSE_LIMIT = 600
"""Up to this size the dense eigensolver is faster and simpler."""
TOLERANCE = 1e-9
"""Lanczos residual relative to the eigenvalue; the eigenvalue's own error is of its square."""
BLOCK = 16
RIGID = 0.02
"""Eigenvalues of a free body below this share of the shift are its rigid-body modes."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Modes:
    """Eigenpairs, mass-normalised and sorted."""

    omega2: FloatArray
    """(n_mode,) eigenvalues, rad^2/s^2; rigid-body modes are exactly 0."""
    shapes: FloatArray
    """(n, n_mode), shapes' M shapes = I."""
    residual: float
    """Largest |K x - omega^2 M x| / |K x| over the elastic modes."""
    sturm_ok: bool
    """The inertia count at the upper end agrees with the number of modes found."""

    @property
    def frequencies(self) -> FloatArray:
        """(n_mode,) Hz."""
        return np.sqrt(np.maximum(self.omega2, 0.0)) / (2.0 * np.pi)


def modes(
    K: Matrix,
    M: Matrix,
    *,
    f_max: float | None = None,
    count: int | None = None,
    free: bool = False,
    stiffness_factor: Factor | None = None,
    progress: Progress | None = None,
) -> Modes:
    """All modes up to `f_max` (Hz), or the `count` lowest.

    Parameters
    ----------
    K, M : (n, n) symmetric sparse or dense; M may be singular, K + s M must not be.
    free : the body may have rigid-body modes: a small negative shift is used. A clamped K is factorised as is.
    stiffness_factor : a factor of K that already exists (clamped only).

    Raises
    ------
    NumericalError : K is singular though the body was called clamped, or Lanczos missed a mode.

    Method: Grimes, Lewis, Simon, SIAM J. Matrix Anal. 15 (1994), with full reorthogonalisation and no
    restart; the number of modes below `f_max` comes from the inertia of K - omega^2 M.
    """
    n = K.shape[0]
    if (f_max is None) == (count is None):
        raise ValueError("give either f_max or count")
    if n <= DENSE_LIMIT:
        return _dense_modes(K, M, f_max, count, free)
    shift = -small_shift(K, M) if free else 0.0
    try:
        inverse = stiffness_factor or factor(_shifted(K, M, shift))
    except SingularMatrixError as error:
        raise NumericalError(f"the stiffness matrix is singular at row {error.row}: is the body held?") from error
    if f_max is not None:
        upper = (2.0 * np.pi * f_max) ** 2
        wanted = factor(_shifted(K, M, upper), definite=False).n_negative
    else:
        upper, wanted = np.inf, min(int(count or 0), n)
    if wanted == 0:
        return Modes(np.zeros(0), np.zeros((n, 0)), 0.0, True)
    omega2, shapes = _lanczos(inverse, M, shift, wanted, n, progress)
    return _checked(K, M, omega2, shapes, f_max, free)


def _shifted(K: Matrix, M: Matrix, shift: float) -> Matrix:
    return K if shift == 0.0 else K - shift * M


def small_shift(K: Matrix, M: Matrix) -> float:
    """A shift far below the first elastic eigenvalue of any mesh, far above round-off in K."""
    k, m = K.diagonal(), M.diagonal()
    both = (k > 0.0) & (m > 0.0)
    return float(1e-9 * np.median(k[both] / m[both]))


def _dense_modes(K: Matrix, M: Matrix, f_max: float | None, count: int | None, free: bool) -> Modes:
    dense_K, dense_M = (A.toarray() if hasattr(A, "toarray") else np.asarray(A) for A in (K, M))
    if dense_K.shape[0] == 0:
        return Modes(np.zeros(0), np.zeros((0, 0)), 0.0, True)
    try:
        omega2, shapes = sla.eigh(dense_K, dense_M)
    except np.linalg.LinAlgError:
        omega2, shapes = _massless_eigh(dense_K, dense_M)
    keep = omega2 <= (2.0 * np.pi * f_max) ** 2 if f_max is not None else np.arange(omega2.size) < (count or 0)
    round_off = 100.0 * np.finfo(float).eps * float(np.abs(omega2).max(initial=0.0))
    return _checked(dense_K, dense_M, omega2[keep], shapes[:, keep], None, free, round_off)


def _massless_eigh(K: FloatArray, M: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenpairs when M is singular: solve M x = mu (K + s M) x and drop mu = 0 (infinite frequency)."""
    shift = float(np.trace(K) / np.trace(M)) if np.trace(M) > 0 else 1.0
    try:
        mu, x = sla.eigh(M, K + shift * M)
    except np.linalg.LinAlgError as error:
        raise NumericalError("a degree of freedom has neither mass nor stiffness") from error
    finite = mu > 1e-14 * mu.max()
    mu, x = mu[finite][::-1], x[:, finite][:, ::-1]
    return 1.0 / mu - shift, x / np.sqrt(mu)


def _lanczos(
    inverse: Factor, M: Matrix, shift: float, wanted: int, n: int, progress: Progress | None
) -> tuple[FloatArray, FloatArray]:
    """The `wanted` eigenpairs nearest above the shift, by block Lanczos on (K - shift M)^-1 M."""
    rng = np.random.default_rng(20190527)
    capacity = min(n, int(2.6 * wanted) + 10 * BLOCK)
    Q = np.empty((n, capacity), order="F")
    MQ = np.empty((n, capacity), order="F")
    T = np.zeros((capacity + BLOCK, capacity + BLOCK))
    block = _orthonormalised(inverse.solve(np.asarray(M @ rng.standard_normal((n, min(BLOCK, n))))), M)[0]
    used, look = 0, max(wanted + 2 * BLOCK, int(1.9 * wanted))
    while True:
        width = block.shape[1]
        if used + width > Q.shape[1]:
            Q, MQ, T = _grown(Q, MQ, T, min(n, int(1.5 * Q.shape[1]) + BLOCK))
        if used + width > n:
            block, width = block[:, : n - used], n - used
        here = slice(used, used + width)
        Q[:, here] = block
        MQ[:, here] = M @ block
        W = inverse.solve(np.ascontiguousarray(MQ[:, here]))
        used += width
        near = slice(max(0, used - 2 * width - BLOCK), used)
        local = MQ[:, near].T @ W
        W -= Q[:, near] @ local
        rest = MQ[:, :used].T @ W
        W -= Q[:, :used] @ rest
        T[:used, here] = rest
        T[near, here] += local
        T[here, :used] = T[:used, here].T
        block, R = _orthonormalised(W, M)
        if progress is not None:
            progress(min(used // 2, wanted), wanted)
        exhausted = used >= n or block.shape[1] == 0
        if exhausted or used >= look:
            look = used + max(2 * BLOCK, wanted // 8)
            theta, s = sla.eigh(0.5 * (T[:used, :used] + T[:used, :used].T))
            order = np.argsort(-theta)[:wanted]
            error = np.linalg.norm(R @ s[used - width : used, order], axis=0)
            if exhausted or np.all(error <= TOLERANCE * theta[order]):
                return shift + 1.0 / theta[order], Q[:, :used] @ s[:, order]


def _grown(Q: FloatArray, MQ: FloatArray, T: FloatArray, capacity: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    def wider(A: FloatArray) -> FloatArray:
        B = np.empty((A.shape[0], capacity), order="F")
        B[:, : A.shape[1]] = A
        return B

    bigger = np.zeros((capacity + BLOCK, capacity + BLOCK))
    bigger[: T.shape[0], : T.shape[1]] = T
    return wider(Q), wider(MQ), bigger


def _orthonormalised(W: FloatArray, M: Matrix) -> tuple[FloatArray, FloatArray]:
    """M-orthonormal basis of W's columns (rank revealing) and R with W = basis R."""
    R = np.eye(W.shape[1])
    for _ in range(2):
        values, vectors = sla.eigh(W.T @ (M @ W))
        keep = values > 1e-24 * max(values.max(), 1e-300)
        scaled = np.sqrt(values[keep])
        W = (W @ vectors[:, keep]) / scaled
        R = (scaled[:, None] * vectors[:, keep].T) @ R
    return W, R


def _checked(
    K: Matrix, M: Matrix, omega2: FloatArray, shapes: FloatArray, f_max: float | None, free: bool,
    round_off: float = 0.0,
) -> Modes:  # fmt: skip
    """Clean rigid-body values to 0, measure residuals, compare the count with the inertia just above the last."""
    order = np.argsort(omega2)
    omega2, shapes = omega2[order], shapes[:, order]
    scale = max(abs(small_shift(K, M)), 1e-300)
    rigid = max(RIGID * scale, round_off)
    omega2 = np.where(np.abs(omega2) < rigid, 0.0, omega2) if free else omega2
    Kx = K @ shapes
    size = np.linalg.norm(Kx, axis=0)
    elastic = omega2 > 0.0
    gap = np.linalg.norm(Kx - (M @ shapes) * omega2, axis=0)[elastic] / size[elastic] if elastic.any() else np.zeros(1)
    sturm_ok = True
    if sp.issparse(K) and f_max is None and omega2.size and omega2.size < K.shape[0]:
        above = _shifted(K, M, omega2[-1] * (1.0 + 1e-6) + 1e-3 * scale)
        sturm_ok = factor(above, definite=False).n_negative == omega2.size or _last_is_repeated(omega2)
    return Modes(omega2, shapes, float(gap.max()), sturm_ok)


def _last_is_repeated(omega2: FloatArray) -> bool:
    """The count may cut through a repeated eigenvalue; then the inertia counts its twin too."""
    return bool(omega2.size > 1 and omega2[-1] > 0.0 and omega2[-2] > omega2[-1] * (1.0 - 1e-5))
