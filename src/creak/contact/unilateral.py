"""The few nonlinear equations of a step: g = g_free + A p with unilateral penalty channels."""

from __future__ import annotations

import numba
import numpy as np

from creak.arrays import FloatArray
from creak.errors import NumericalError

OPEN, HOLDING, CLOSED = 0, 1, 2
MAX_PIVOTS = 10_000


def solve_channels(
    A: FloatArray,
    gap_free: FloatArray,
    rate_free: FloatArray,
    rate_gain: float,
    stiffness: FloatArray,
    damping: FloatArray,
) -> FloatArray:
    """Channel forces p >= 0 at the end of a step.

    Solves g = gap_free + A p, g' = rate_free + rate_gain (g - gap_free) together with the law
    p = max(0, -k g - c g') for g < 0, p = 0 for g > 0. Where a closing damper makes the force jump at g = 0
    the channel may also hold there with any force below the jump (the closure of the law), so the law is
    monotone and the solution unique for symmetric positive definite A.

    Method: block principal pivoting with Murty's least-index rule as fallback (Judice and Pires, Comput.
    Oper. Res. 21, 1994), finite for such matrices; exact to round-off.

    Parameters
    ----------
    A : (m, m) compliance of the step, length / force. gap_free, rate_free : (m,) without contact forces.
    stiffness, damping : (m,) penalty k > 0, damper c >= 0.

    Raises
    ------
    NumericalError : the pivoting did not end (A is not positive definite).
    """
    k_hat = stiffness + damping * rate_gain
    c_hat = damping * (rate_free - rate_gain * gap_free)
    p, pivots = _pivot(A, gap_free, k_hat, c_hat)
    if pivots >= MAX_PIVOTS:
        raise NumericalError("the contact solve did not end: the compliance matrix is not positive definite")
    return np.asarray(p)


def compile_kernels() -> None:
    """Compile now what would otherwise be compiled at the first contact of a run."""
    one = np.ones(1)
    solve_channels(np.eye(1), -one, 0.0 * one, 1.0, one, 0.0 * one)


@numba.njit(cache=True)
def _pivot(A, gap_free, k_hat, c_hat):  # type: ignore[no-untyped-def]
    m = gap_free.size
    state = np.zeros(m, dtype=np.int64)
    for i in range(m):
        if gap_free[i] < 0.0:
            state[i] = HOLDING if c_hat[i] < 0.0 else CLOSED
    p = np.zeros(m)
    target = np.zeros(m, dtype=np.int64)
    best, patience = m + 1, 8
    for pivots in range(MAX_PIVOTS):
        gap = _equilibrium(A, gap_free, k_hat, c_hat, state, p)
        wrong, first = 0, -1
        for i in range(m):
            target[i] = _right_state(state[i], gap[i], p[i], k_hat[i], c_hat[i])
            if target[i] != state[i]:
                wrong += 1
                if first < 0:
                    first = i
        if wrong == 0:
            return p, pivots
        if wrong < best:
            best, patience = wrong, 8
        else:
            patience -= 1
        if patience > 0:
            state[:] = target
        else:
            state[first] = target[first]
    return p, MAX_PIVOTS


@numba.njit(cache=True)
def _equilibrium(A, gap_free, k_hat, c_hat, state, p):  # type: ignore[no-untyped-def]
    """Forces for given states: (A + D) p = -gap_free - D c_hat on the closed, D = 1/k_hat, 0 where holding."""
    active = np.flatnonzero(state != OPEN)
    p[:] = 0.0
    n = active.size
    if n > 0:
        S = np.empty((n, n))
        b = np.empty(n)
        for r in range(n):
            i = active[r]
            for s in range(n):
                S[r, s] = A[i, active[s]]
            b[r] = -gap_free[i]
            if state[i] == CLOSED:
                S[r, r] += 1.0 / k_hat[i]
                b[r] -= c_hat[i] / k_hat[i]
        x = np.linalg.solve(S, b)
        for r in range(n):
            p[active[r]] = x[r]
    gap = gap_free.copy()
    for i in range(gap.size):
        for r in range(n):
            gap[i] += A[i, active[r]] * p[active[r]]
    return gap


@numba.njit(cache=True)
def _right_state(state, gap, p, k_hat, c_hat):  # type: ignore[no-untyped-def]
    """The state that the law asks for; the given one if it is consistent to round-off."""
    jump = max(0.0, -c_hat)
    shift = max(0.0, c_hat) / k_hat
    if state == OPEN:
        if gap + shift < 0.0:
            return HOLDING if jump > 0.0 else CLOSED
    elif state == HOLDING:
        if p < 0.0:
            return OPEN
        if p > jump:
            return CLOSED
    elif p < jump:
        return HOLDING if jump > 0.0 else OPEN
    return state
