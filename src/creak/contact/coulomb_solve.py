"""Forces of a step with friction: Newton, sweeps where it does not converge, a proximal point method around both.

Newton is tried first and again after more and more sweeps. The last resort, needed for nearly dependent channels, is
the proximal point method (Rockafellar, SIAM J. Control Optim. 14, 1976). No method is proven to solve every problem
with friction; all of this is bounded, and what is returned as solved satisfies the laws.
"""

from __future__ import annotations

import math

import numpy as np

from creak.contact.coulomb import SLIDE, STICK, Rubbing, assess, bounded, response, tidy
from creak.contact.coulomb_newton import newton, room_for
from creak.contact.laws.friction import coefficient
from creak.contact.laws.pieces import force_against
from creak.contact.pivoting import NO_SOLUTION, ROUND, SOLVED, UNENDED, solve_frictionless
from creak.linalg.compiled import inner, with_arrays
from creak.linalg.loops import acts, put

ROUNDS = 5
"""Newton is tried this often, after 0, 10, 20, 40, ... sweeps."""
PACES = (0.3, 0.7, 0.9)
"""Of the proximal point method, tried one after the other."""
MAX_PROXIMAL = 300
FIRST_SWEEPS = 10
STILL = 1e-9
"""Sliding over what the static limit would move a channel by, up to which it is round-off."""
STALL = 20
"""Sweeps after which a residual that has not halved means damping."""
FREE = 1e20
"""Lag over compliance from which on a channel slides without friction."""


@with_arrays
def solve_rubbing(c, stuck, x, kept):  # type: ignore[no-untyped-def]
    """x in place (on entry the forces of the step before); stuck (n,) in and out. Returns a code of `pivoting`.

    A channel that was stuck keeps its static limit until it cannot hold; then the step is solved again with its
    kinetic one (only without decay; with a decay mu(v) is continuous and one solve is enough).
    """
    n = stuck.size
    r, excess, status = np.empty(x.size), np.empty(n), np.empty(n, dtype=np.int64)
    holds, kept = stuck.copy(), room_for(kept, x.size)
    code = SOLVED
    if not acts(x, 0, n):
        p = np.zeros(n)
        code = solve_frictionless(c.A[:n, :n].copy(), c.free[:n], c.law, p)
        if code == SOLVED:
            put(x, 0, p)
    for _ in range(n + 1):
        if not _converge(c, holds, x, r, excess, status, kept):
            return NO_SOLUTION if code == NO_SOLUTION else UNENDED
        if not _released(c, holds, x, r, status):
            break
    for i in range(n):
        stuck[i] = status[i] != SLIDE
    return SOLVED


@inner
def _released(c, holds, x, r, status):  # type: ignore[no-untyped-def]
    """Channels that slid off their static limit lose it; True if there are any.

    One that is at its limit and does not move sticks: others that are rigidly linked with it hold it.
    """
    found = False
    for i in range(holds.size):
        if status[i] == SLIDE and holds[i] and c.decay[i] == 0.0 and c.static[i] > c.kinetic[i]:
            t = c.tangent[i]
            if math.hypot(r[t], r[t + 1]) <= STILL * c.slack[i] * c.static[i] * x[i]:
                status[i] = STICK
            else:
                holds[i] = False
                found = True
    return found


@with_arrays
def _converge(c, holds, x, r, excess, status, kept):  # type: ignore[no-untyped-def]
    """Newton with sweeps; where that fails, within a proximal point method. x, r and status at the solution.

    Its problems have A + w R and free - w R x_before, R the diagonal of A: regular and easy for large w, and at the
    limit x = x_before the problem itself is solved. w falls by a pace as long as they are solved, and rises where one
    is not; every fourth time the problem itself (w = 0) is tried.
    """
    start = x.copy()
    if _newton_and_sweeps(c, holds, x, r, excess, status, kept):
        return True
    A, free, slack, before = c.A.copy(), c.free.copy(), c.slack.copy(), x.copy()
    near = Rubbing(A, free, c.law, c.tangent, c.static, c.kinetic, c.decay, c.speed, slack)
    for pace in PACES:
        put(x, 0, start)
        weight = 1.0
        for k in range(1, MAX_PROXIMAL):
            w = 0.0 if k % 4 == 0 else weight
            for i in range(x.size):
                before[i] = x[i]
                A[i, i] = (1.0 + w) * c.A[i, i]
                free[i] = c.free[i] - w * c.A[i, i] * x[i]
            for i in range(slack.size):
                slack[i] = (1.0 + w) * c.slack[i]
            solved = _newton_and_sweeps(near, holds, x, r, excess, status, kept)
            if w == 0.0:
                if solved:
                    return True
                put(x, 0, before)
            else:
                weight = weight * pace if solved else min(1.0, 3.0 * weight)
    return False


@with_arrays
def _newton_and_sweeps(c, holds, x, r, excess, status, kept):  # type: ignore[no-untyped-def]
    """Newton, tried again after more and more sweeps; False with x after the last of them."""
    sweeps = np.int64(FIRST_SWEEPS)  # a plain number would have `sweep` compiled twice
    y = x.copy()
    for _ in range(ROUNDS):
        if newton(c, holds, x, r, excess, status, kept):
            return True
        put(x, 0, y)
        if sweep(c, holds, x, r, excess, status, sweeps):
            return True
        put(y, 0, x)
        sweeps *= 2
    return False


@with_arrays
def sweep(c, holds, x, r, excess, status, sweeps):  # type: ignore[no-untyped-def]
    """Block Gauss-Seidel with exact solutions of one channel at a time, damped when it stalls; True if the laws hold.

    Source: Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng. 155, 1998.
    """
    size = np.empty(x.size)
    best, keep, since = np.inf, 1.0, 0
    for _ in range(sweeps):
        for i in range(status.size):
            _one_channel(c, holds, x, i, keep)
        response(c, x, r, size)
        worst = assess(c, holds, x, r, size, excess, status)
        if worst <= 1.0 and bounded(c, x):
            tidy(c, x, status)
            return True
        since += 1
        if worst < 0.5 * best:
            best, since = worst, 0
        elif since >= STALL:
            best, since, keep = worst, 0, max(0.1, 0.7 * keep)
    return False


@inner
def _one_channel(c, holds, x, i, keep):  # type: ignore[no-untyped-def]
    """Replace the forces of one channel by the exact solution for the others as they are, weighted with `keep`."""
    t = c.tangent[i]
    gap = c.free[i]
    for j in range(x.size):
        gap += c.A[i, j] * x[j]
    gap -= c.A[i, i] * x[i]
    if t < 0:
        x[i] += keep * (force_against(c.law, i, gap, c.A[i, i]) - x[i])
        return
    gap -= c.A[i, t] * x[t] + c.A[i, t + 1] * x[t + 1]
    d1, d2 = c.free[t], c.free[t + 1]
    for j in range(x.size):
        if j != i and j != t and j != t + 1:
            d1 += c.A[t, j] * x[j]
            d2 += c.A[t + 1, j] * x[j]
    p, tau1, tau2 = _rub_alone(c, holds[i], i, gap, d1, d2)
    x[i] += keep * (p - x[i])
    x[t] += keep * (tau1 - x[t])
    x[t + 1] += keep * (tau2 - x[t + 1])


@inner
def _rub_alone(c, holds, i, gap, d1, d2):  # type: ignore[no-untyped-def]
    """One rubbing channel, exact: gap, d1, d2 without its own forces.

    For a given lag = |d| / |tau| >= 0 the sliding is d = -lag tau, so tau = -(A_tt + lag)^-1 (d_free + A_tn p) and p
    follows from a scalar law with a positive compliance. The lag is then the root of |tau| = mu(v) p: 0 if the
    channel sticks, else found between brackets, which exist as |tau| -> 0 for lag -> inf.
    """
    if gap + c.law.overclosure[c.law.first[i]] >= 0.0:
        return 0.0, 0.0, 0.0
    excess, p, tau1, tau2 = _lagging(c, holds, i, gap, d1, d2, 0.0)
    if excess <= 0.0:
        return p, tau1, tau2
    low, f_low, high = 0.0, excess, c.slack[i]
    f_high = 1.0
    while f_high > 0.0:
        f_high = _lagging(c, holds, i, gap, d1, d2, high)[0]
        if f_high > 0.0:
            low, f_low = high, f_high
            high *= 4.0
        if high > FREE * c.slack[i]:
            return force_against(c.law, i, gap, c.A[i, i]), 0.0, 0.0
    side = 0
    for k in range(120):
        lag = (low * f_high - high * f_low) / (f_high - f_low) if k % 4 < 3 else 0.5 * (low + high)
        excess, p, tau1, tau2 = _lagging(c, holds, i, gap, d1, d2, lag)
        if excess == 0.0 or high - low <= 1e-16 * high:
            break
        if excess > 0.0:
            low, f_low = lag, excess
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = lag, excess
            if side == -1:
                f_low *= 0.5
            side = -1
    return p, tau1, tau2


@inner
def _lagging(c, holds, i, gap, d1, d2, lag):  # type: ignore[no-untyped-def]
    """|tau| - mu p and the forces of one channel that slides by -lag tau."""
    t = c.tangent[i]
    more = lag + ROUND * c.slack[i]
    b11, b22, b12 = c.A[t, t] + more, c.A[t + 1, t + 1] + more, c.A[t, t + 1]
    det = b11 * b22 - b12 * b12
    n1, n2 = c.A[i, t], c.A[i, t + 1]
    s1, s2 = (b22 * n1 - b12 * n2) / det, (b11 * n2 - b12 * n1) / det
    compliance = max(c.A[i, i] - s1 * n1 - s2 * n2, ROUND * c.A[i, i])
    p = force_against(c.law, i, gap - s1 * d1 - s2 * d2, compliance)
    tau1 = -(b22 * d1 - b12 * d2) / det - s1 * p
    tau2 = -(b11 * d2 - b12 * d1) / det - s2 * p
    tau = math.hypot(tau1, tau2)
    mu = coefficient(lag * tau * c.speed, c.static[i], c.kinetic[i], c.decay[i], holds)
    return tau - mu * p, p, tau1, tau2
