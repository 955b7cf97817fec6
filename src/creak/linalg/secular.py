"""Complex modes of a structure that few dashpots damp, from an equation as small as they are few.

Modes of mass 1 with C = diag(d) + W W', W (p, r), have eigenvalues where

    T(s) = 1 + s W' D(s)^-1 W,     D = diag(s^2 + d s + omega^2),

is singular, and eigenvectors q = -s D^-1 W y with T y = 0: the secular equation of a change of low rank (Golub, Some
modified matrix eigenvalue problems, SIAM Rev. 15, 1973). All 2 p roots of det D det T are found at once by the
Ehrlich-Aberth iteration, Newton's with the roots already at hand divided out (Aberth, Math. Comp. 27, 1973; Bini and
Robol for secular equations, J. Comput. Appl. Math. 272, 2014). Time goes with p^2 r^2, where the whole eigenvalue
problem goes with p^3.

With S = omega the matrix of x = (S q, q') is symmetric but for J = diag(-1, 1), so that left eigenvectors are J times
right ones: no inverse is needed.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from creak.linalg.compiled import inner, outer

WORTH, FEWEST = 25.0, 600
"""p over r^2, and p, from which on this is faster than all at once."""
ROUND_OFF = 1e-12
"""Of the largest entry, what a factor of low rank may leave."""
SWEEPS = 60
NEAR = 0.3
"""Of the distance to the next mode, most damping by the dashpots with which a root begins: strong ones hold a few
combinations of the modes, the others lie between those without dashpots."""
CLOSE = 1e-12
"""Of a root, its last correction."""
TINY = 1e-16
"""Of a square of a frequency, or of a root, what stands for none."""
WEAK, TURNS = 0.1, 30
"""Share of others in an eigenvector, up to which it is one mode's, little changed; and turns of what finds it then."""
FAINT, ALIKE = 1e-11, 1e-7
"""Of a frequency, damping that is left out between two modes, and how near these are then."""
ON_AXIS = 1e-9
"""Of a root, its distance from the real axis that is round-off."""


def few_dashpots(C: FloatArray, shared: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """d (p,) and W (p, r) of C (p, p), of which `shared` couples modes; None: these are too many."""
    p = C.shape[0]
    if p < FEWEST:
        return None
    most = int(np.sqrt(p / WORTH))
    size = np.abs(shared.diagonal()).max(initial=0.0)
    factor, pivot, rank, _ = lapack.dpstrf(shared, tol=ROUND_OFF * size, lower=1)
    if rank > most:
        return None
    W = np.zeros((p, rank))
    W[pivot - 1] = np.tril(factor)[:, :rank]
    d = np.maximum(C.diagonal() - np.square(W).sum(axis=1), 0.0)
    left = C - W @ W.T
    np.fill_diagonal(left, 0.0)
    return (d, W) if np.abs(left).max() <= p * ROUND_OFF * size else None


def eigenpairs(omega: FloatArray, d: FloatArray, W: FloatArray) -> tuple[ComplexArray, ComplexArray] | None:
    """Eigenvalues on the real axis and above it, and (2 p, k) eigenvectors (omega q, s q); None: not all found."""
    weak, s_weak, q_weak = _hardly_coupled(omega, d, W)
    p, strong = omega.size, np.flatnonzero(~weak)
    own = np.square(W[strong]).sum(axis=1)
    begin = _poles(omega[strong], d[strong] + np.minimum(own, NEAR * _apart(omega)[strong]))
    without = _poles(omega[strong], d[strong])
    turn = np.exp(2j * np.pi * np.random.default_rng(1).uniform(size=begin.shape))
    both = np.empty((2, p), dtype=complex)
    both[:, strong], both[:, weak] = begin + 0.1 * np.abs(begin - without) * turn, [s_weak, s_weak.conj()]
    values = both.ravel()
    square = np.zeros((2, W.shape[1], W.shape[1]), dtype=complex)
    unsettled = _aberth(omega, d, W, values, np.tile(~weak, 2), *square)
    found = values.reshape(2, p)[:, strong].ravel()
    if unsettled or not np.isfinite(found).all():
        return None
    real = np.abs(found.imag) <= ON_AXIS * np.abs(found)
    found[real] = found[real].real
    found, count = found[found.imag >= 0.0], np.count_nonzero(real)
    if 2 * found.size - count != 2 * strong.size or count % 2:
        return None
    weight = found / _D(found, omega, d)
    T = np.eye(W.shape[1]) + _among(weight.T, W)
    y = np.conj(np.linalg.svd(T)[2][:, -1])
    s, q = np.append(found, s_weak), np.hstack([-weight * (W @ y.T), q_weak])
    vectors = np.vstack([omega[:, None] * q, s * q])
    return s, vectors / np.linalg.norm(vectors, axis=0)


def _hardly_coupled(omega: FloatArray, d: FloatArray, W: FloatArray) -> tuple[BoolArray, ComplexArray, ComplexArray]:
    """Modes whose share in other eigenvectors is small: which (p,), eigenvalues (k,) above the axis, their q (p, k).

    Mode i has q_i = 1, y = (1 + s sum_(j != i) w_j w_j' / D_j)^-1 w_i, so that s^2 + (d_i + w_i'y) s + omega_i^2 = 0.
    What is as near as `ALIKE` and couples with it by less than `FAINT` is left out: round-off cannot tell more.
    """
    pole, coupling = _poles(omega, d)[0], np.abs(W @ W.T)
    apart = np.abs(pole[:, None] - pole)
    left_out = (coupling <= FAINT * omega[:, None]) & (apart <= ALIKE * omega[:, None])
    np.fill_diagonal(left_out, True)
    ratio = np.where(left_out, 0.0, coupling / np.maximum(apart, TINY * omega[:, None]))
    weak: BoolArray = (np.square(ratio).sum(axis=1) < WEAK**2) & (np.square(W).sum(axis=1) + d < omega)
    i = np.flatnonzero(weak)
    s, q, still = pole[i], np.zeros((omega.size, i.size), dtype=complex), np.ones(i.size, dtype=bool)
    for _ in range(TURNS):
        y, q = _shapes(s, i, left_out[i], (omega, d, W))
        half, before = 0.5 * (d[i] + np.einsum("ka,ka->k", W[i], y)), s
        s = -half + 1j * np.sqrt(omega[i] ** 2 - half**2)
        still = np.abs(s - before) <= CLOSE * np.abs(s)
        if still.all():
            break
    weak[i] = still
    return weak, s[still], q[:, still]


def _shapes(
    s: ComplexArray, i: IntArray, left_out: BoolArray, of: tuple[FloatArray, FloatArray, FloatArray]
) -> tuple[ComplexArray, ComplexArray]:
    """y (k, r) and q (p, k) at eigenvalues (k,), q_i = 1, where pairs `left_out` (k, p) do not couple."""
    omega, d, W = of
    weight = np.where(left_out, 0.0, (s / _D(s, omega, d)).T)
    y = np.linalg.solve(np.eye(W.shape[1]) + _among(weight, W), W[i][:, :, None])[:, :, 0]
    q = -(weight * (y @ W.T)).T
    q[i, np.arange(i.size)] = 1.0
    return np.asarray(y), q


def _D(s: ComplexArray, omega: FloatArray, d: FloatArray) -> ComplexArray:
    """(p, k), no entry 0."""
    D = s * (s + d[:, None]) + (omega**2)[:, None]
    return np.where(D == 0.0, TINY * np.square(omega)[:, None], D)


def _among(weight: ComplexArray, W: FloatArray) -> ComplexArray:
    """(k, r, r) sums of w_j w_j' times weights (k, p)."""
    r = W.shape[1]
    return np.asarray(weight @ (W[:, :, None] * W[:, None]).reshape(-1, r * r)).reshape(-1, r, r)


def _poles(omega: FloatArray, d: FloatArray) -> ComplexArray:
    """(2, p) roots of s^2 + d s + omega^2."""
    root = np.sqrt((0.25 * d**2 - omega**2).astype(complex))
    return np.stack([-0.5 * d + root, -0.5 * d - root])


def _apart(omega: FloatArray) -> FloatArray:
    """(p,) distance to the nearest other one."""
    order, found = np.argsort(omega), np.empty_like(omega)
    steps = np.diff(omega[order], prepend=0.0, append=np.inf)
    found[order] = np.minimum(steps[:-1], steps[1:])
    return found


def left_of(values: ComplexArray, vectors: ComplexArray) -> ComplexArray:
    """(k, 2 p) left eigenvectors, their product with the right ones 1."""
    turned = vectors.copy()
    turned[: vectors.shape[0] // 2] *= -1.0
    return np.asarray((turned / np.einsum("ik,ik->k", turned, vectors)).T)


@inner
def _trace_of_quotient(T, S):  # type: ignore[no-untyped-def]
    """Of T^-1 S, both overwritten (Gauss-Jordan)."""
    r, trace = T.shape[0], 0.0 + 0.0j
    for c in range(r):
        best = c
        for a in range(c + 1, r):
            if abs(T[a, c]) > abs(T[best, c]):
                best = a
        if best != c:
            for b in range(r):
                T[c, b], T[best, b] = T[best, b], T[c, b]
                S[c, b], S[best, b] = S[best, b], S[c, b]
        for a in range(r):
            if a != c:
                share = T[a, c] / T[c, c]
                for b in range(r):
                    T[a, b] -= share * T[c, b]
                    S[a, b] -= share * S[c, b]
    for c in range(r):
        trace += S[c, c] / T[c, c]
    return trace


@outer
def _aberth(omega, d, W, values, unsettled, T, slope):  # type: ignore[no-untyped-def]
    """Roots in place from where they begin; how many did not settle. T, slope: (r, r), to work in."""
    p, r, n = omega.size, W.shape[1], values.size
    left = 0
    for j in range(n):
        left += unsettled[j]
    for _ in range(SWEEPS):
        for j in range(n):
            if not unsettled[j]:
                continue
            s = values[j]
            log_slope = 0.0 + 0.0j
            for a in range(r):
                for b in range(r):
                    T[a, b] = slope[a, b] = 0.0
            for i in range(p):
                D = s * (s + d[i]) + omega[i] * omega[i]
                inverse = 1.0 / (D if D != 0.0 else TINY * omega[i] * omega[i])
                steep = (2.0 * s + d[i]) * inverse
                log_slope += steep
                weight = s * inverse
                change = inverse - weight * steep
                for a in range(r):
                    for b in range(a + 1):
                        product = W[i, a] * W[i, b]
                        T[a, b] += product * weight
                        slope[a, b] += product * change
            for a in range(r):
                T[a, a] += 1.0
                for b in range(a):
                    T[b, a] = T[a, b]
                    slope[b, a] = slope[a, b]
            log_slope += _trace_of_quotient(T, slope)
            for i in range(n):
                if s != values[i]:
                    log_slope -= 1.0 / (s - values[i])
            step = 1.0 / log_slope if log_slope != 0.0 else TINY * s
            values[j] = s - step
            if abs(step) <= CLOSE * abs(s):
                unsettled[j] = False
                left -= 1
        if left == 0:
            break
    return left
