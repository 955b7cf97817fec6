"""Forces of a step with friction: Newton, sweeps where it does not converge, a proximal point method around both.

Newton is tried first and again after more and more sweeps. The last resort, needed for nearly dependent channels, is
the proximal point method (Rockafellar, SIAM J. Control Optim. 14, 1976). No method is proven to solve every problem
with friction; all of this is bounded, and what is returned as solved satisfies the laws.
"""

from __future__ import annotations

import math

import numpy as np

from creak.contact.coulomb import SLIDE, STICK, Rubbing
from creak.contact.coulomb_newton import newton, room_for
from creak.contact.coulomb_sweeps import sweep
from creak.contact.pivoting import NO_SOLUTION, SOLVED, UNENDED, solve_frictionless
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
