"""Frictionless contact of a step: g = gap_free + A p with 0 <= p, 0 <= g + y(p), p (g + y(p)) = 0, exact.

Block principal pivoting with Murty's least-index rule as fallback (Judice and Pires, Comput. Oper. Res. 21, 1994),
carried over to laws of several straight pieces: a channel is open or on one piece of its law; all channels move to
the piece that their force asks for, and when that makes no progress only the first wrong one moves, by one piece. A + D
(D the compliance of the pieces) is a P-matrix where it is symmetric positive definite: the solution is unique, and the
single moves end, since with the channels before it solved a channel passes each of its pieces once, in one direction.
"""

from __future__ import annotations

import numpy as np

from creak.contact.laws.pieces import overclosure_at, piece_of
from creak.contact.small_systems import solve_symmetric
from creak.linalg.compiled import inner, with_arrays
from creak.linalg.loops import fill, largest, put

SOLVED, UNENDED, NO_SOLUTION, SINGULAR = 0, 1, 2, 3
OPEN = -1
ROUND = 16.0 * np.finfo(np.float64).eps
PATIENCE = 8
"""Block moves without progress before single moves begin."""
WIDEN = 64
"""Pivots after which the allowance for round-off doubles."""
MAX_PIVOTS = 25 * WIDEN
"""Then it would be 1e-7."""
REGULARISATION = 1e-11
"""Of the scaled diagonal; only where redundant channels make A singular."""
MAX_PROXIMAL = 6
INFEASIBLE = 1e-6
"""Part of the largest free penetration that may be left of a solution."""


@with_arrays
def solve_frictionless(A, gap_free, law, p):  # type: ignore[no-untyped-def]
    """p (n,) in place; on entry forces of the step before, which only choose the first guess of the pieces.

    Where A + D is singular (channels that repeat each other) p is not unique but g and p' A p are: the proximal point
    method, p_(j+1) = solution with A + D + e R and gap_free - e R p_j, p_0 = 0, R the diagonal of A + D, converges to
    an exact solution, near the one of least norm in R (Rockafellar, SIAM J. Control Optim. 14, 1976).

    Returns
    -------
    SOLVED, UNENDED or NO_SOLUTION (hard channels that shut each other in, or without any compliance).
    """
    state = _first_guess(gap_free, law, p)
    centre = np.zeros(p.size)
    code = _pivot(A, gap_free, law, state, p, centre, 0.0)
    if code != SINGULAR:
        return code
    for _ in range(MAX_PROXIMAL):
        code = _pivot(A, gap_free, law, state, p, centre, REGULARISATION)
        if code != SOLVED:
            return NO_SOLUTION if code == SINGULAR else code
        for i in range(p.size):
            centre[i] -= p[i]
        if largest(centre) <= 1e-6 * largest(p):
            break
        put(centre, 0, p)
    return SOLVED if _feasible(A, gap_free, law, p) else NO_SOLUTION


@with_arrays
def _first_guess(gap_free, law, p):  # type: ignore[no-untyped-def]
    """Channels that pressed before and still would penetrate; all that would, when none pressed."""
    n = gap_free.size
    state = np.empty(n, dtype=np.int64)
    fill(state, OPEN)
    none = True
    for i in range(n):
        if p[i] > 0.0 and gap_free[i] + law.overclosure[law.first[i]] < 0.0:
            state[i] = piece_of(law, i, p[i])
            none = False
    if none:
        for i in range(n):
            if gap_free[i] + law.overclosure[law.first[i]] < 0.0:
                state[i] = law.first[i]
    return state


@with_arrays
def _pivot(A, gap_free, law, state, p, centre, e):  # type: ignore[no-untyped-def]
    n = gap_free.size
    target = np.empty(n, dtype=np.int64)
    gap, size = np.empty(n), np.empty(n)
    best, patience = n + 1, PATIENCE
    for pivots in range(MAX_PIVOTS):
        if not _equilibrium(A, gap_free, law, state, p, centre, e):
            return SINGULAR
        _gaps(A, gap_free, p, gap, size)
        slack = ROUND * 2.0 ** (pivots // WIDEN)
        wrong, first = 0, -1
        for i in range(n):
            target[i] = _right_state(A, law, i, state[i], gap[i], slack * size[i], p)
            if target[i] != state[i]:
                wrong += 1
                if first < 0:
                    first = i
        if wrong == 0:
            for i in range(n):
                p[i] = max(p[i], 0.0)
            return SOLVED
        if wrong < best:
            best, patience = wrong, PATIENCE
        else:
            patience -= 1
        if patience > 0:
            put(state, 0, target)
        else:
            state[first] = _next_state(law, first, state[first], target[first])
    return UNENDED


@inner
def _gaps(A, gap_free, p, gap, size):  # type: ignore[no-untyped-def]
    """Gaps, and the size of the terms that make them up, which bounds their round-off."""
    for i in range(p.size):
        gap[i], size[i] = gap_free[i], abs(gap_free[i])
    for j in range(p.size):
        if p[j] != 0.0:
            for i in range(p.size):
                push = A[j, i] * p[j]
                gap[i] += push
                size[i] += abs(push)


@with_arrays
def _equilibrium(A, gap_free, law, state, p, centre, e):  # type: ignore[no-untyped-def]
    """Forces on the chosen pieces: (A + D + e R) p = e R centre - gap_free - y + D force; False if singular."""
    active, n = np.empty(p.size, dtype=np.int64), 0
    for i in range(p.size):
        p[i] = 0.0
        if state[i] != OPEN:
            active[n] = i
            n += 1
    S, b, scale = np.empty((n, n)), np.empty(n), np.empty(n)
    for r in range(n):
        i = active[r]
        D = law.compliance[state[i]]
        own = A[i, i] + D
        if not own > 0.0:
            return False
        scale[r] = 1.0 / np.sqrt(own)
        b[r] = scale[r] * (e * own * centre[i] - gap_free[i] - overclosure_at(law, state[i], 0.0))
        for s in range(r):
            S[s, r] = A[i, active[s]] * scale[s] * scale[r]
        S[r, r] = 1.0 + e
    if not solve_symmetric(S, b):
        return False
    for r in range(n):
        p[active[r]] = b[r] * scale[r]
    return True


@inner
def _right_state(A, law, i, state, gap, slack, p):  # type: ignore[no-untyped-def]
    """The piece that the law asks for; the given one if it is consistent to round-off."""
    first, end = law.first[i], law.first[i + 1]
    if state == OPEN:
        return first if gap + law.overclosure[first] < -slack else OPEN
    allowed = slack / (A[i, i] + law.compliance[state])
    if p[i] < law.force[state] - allowed:
        return OPEN if p[i] < 0.0 else piece_of(law, i, p[i])
    if state + 1 < end and p[i] > law.force[state + 1] + allowed:
        return piece_of(law, i, p[i])
    return state


@inner
def _next_state(law, i, state, target):  # type: ignore[no-untyped-def]
    """One piece towards the target."""
    if state == OPEN or target > state:
        return max(state + 1, law.first[i])
    return state - 1 if state > law.first[i] else OPEN


@with_arrays
def _feasible(A, gap_free, law, p):  # type: ignore[no-untyped-def]
    """True if next to nothing is left of the free penetrations."""
    gap, size = np.empty(p.size), np.empty(p.size)
    _gaps(A, gap_free, p, gap, size)
    deepest = -gap_free[0]
    for i in range(p.size):
        deepest = max(deepest, -gap_free[i])
    for i in range(p.size):
        s = piece_of(law, i, p[i])
        if gap[i] + overclosure_at(law, s, p[i]) < -INFEASIBLE * deepest:
            return False
    return True
