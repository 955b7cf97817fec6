"""Contact of a step with friction: pieces of the normal laws and Coulomb's law at the rubbing channels.

Unknown x = [p (n); tau (2 per rubbing channel)], r = free + A x = [g; d / slip_gain]. With the sliding divided by its
gain A is symmetric, and with hard or soft channels alike a solution exists wherever the gaps can be opened at all
(Cadoux, PhD thesis, Grenoble 2009; Acary, Cadoux, Lemarechal, Malick, ZAMM 91, 2011, for a constant mu).

Semismooth Newton on the projected form of the laws (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991),
mu(v) included, for few and quadratic steps. Where it does not converge, block Gauss-Seidel with exact solutions of one
channel at a time (Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng. 155, 1998), damped when it stalls, brings it
closer and Newton is tried again. The last resort, needed for nearly dependent channels, is the proximal point method
around both (Rockafellar, SIAM J. Control Optim. 14, 1976). No method is proven to solve every problem with friction;
all of this is bounded, and what is returned as solved satisfies the laws.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.laws.friction import coefficient, coefficient_slope, friction_violations
from creak.contact.laws.pieces import Pieces, force_against, overclosure_at, piece_of
from creak.contact.pivoting import NO_SOLUTION, REGULARISATION, ROUND, SOLVED, UNENDED, solve_frictionless
from creak.contact.small_systems import solve_general

OPEN, SMOOTH, STICK, SLIDE = 0, 1, 2, 3
ACCURATE = 1e-13
"""Residual of the laws relative to the largest force, beside round-off."""
MAX_NEWTON = 20
ROUNDS = 5
"""Newton is tried this often, after 0, 10, 20, 40, ... sweeps."""
PACES = (0.3, 0.7, 0.9)
"""Of the proximal point method, tried one after the other."""
MAX_PROXIMAL = 300
FIRST_SWEEPS = 10
STALL = 20
"""Sweeps after which a residual that has not halved means damping."""


BOUND = 1e8
"""Largest p times compliance over the free motion; round-off spoils what is beyond."""
FREE = 1e20
"""Lag over compliance from which on a channel slides without friction."""


class Rubbing(NamedTuple):
    """Contact of n channels with friction, tangents of channel i at x[tangent[i]] and x[tangent[i] + 1]."""

    A: FloatArray
    free: FloatArray
    """[gap_free; slip_free / slip_gain]."""
    law: Pieces
    tangent: IntArray
    """(n,) -1: does not rub."""
    static: FloatArray
    """(n,)"""
    kinetic: FloatArray
    decay: FloatArray
    speed: float
    """slip_gain / step: sliding speed of d / slip_gain = 1."""
    slack: FloatArray
    """(n,) tangential compliance of a channel, mean of the two; 0 where it does not rub."""


@numba.njit(cache=True, error_model="numpy")
def solve_rubbing(c, stuck, x):  # type: ignore[no-untyped-def]
    """x in place (on entry the forces of the step before); stuck (n,) in and out. Returns a code of `pivoting`.

    A channel that was stuck keeps its static limit until it cannot hold; then the step is solved again with its
    kinetic one (only without decay; with a decay mu(v) is continuous and one solve is enough).
    """
    n = stuck.size
    r, excess, status = np.empty(x.size), np.empty(n), np.empty(n, dtype=np.int64)
    holds = stuck.copy()
    code = SOLVED
    if not x[:n].any():
        p = np.zeros(n)
        code = solve_frictionless(c.A[:n, :n].copy(), c.free[:n], c.law, p)
        if code == SOLVED:
            x[:n] = p
    for _ in range(n + 1):
        if not _converge(c, holds, x, r, excess, status):
            return NO_SOLUTION if code == NO_SOLUTION else UNENDED
        if not _released(c, holds, status):
            break
    for i in range(n):
        stuck[i] = status[i] != SLIDE
    return SOLVED


@numba.njit(cache=True, error_model="numpy")
def _released(c, holds, status):  # type: ignore[no-untyped-def]
    """Channels that slid off their static limit lose it; True if there are any."""
    found = False
    for i in range(holds.size):
        if status[i] == SLIDE and holds[i] and c.decay[i] == 0.0 and c.static[i] > c.kinetic[i]:
            holds[i] = False
            found = True
    return found


@numba.njit(cache=True, error_model="numpy")
def _converge(c, holds, x, r, excess, status):  # type: ignore[no-untyped-def]
    """Newton with sweeps; where that fails, within a proximal point method. x, r and status at the solution.

    Its problems have A + w R and free - w R x_before, R the diagonal of A: regular and easy for large w, and at the
    limit x = x_before the problem itself is solved. w falls by a pace as long as they are solved, and rises where one
    is not; every fourth time the problem itself (w = 0) is tried.
    """
    A, free, slack, start, before = c.A.copy(), c.free.copy(), c.slack.copy(), x.copy(), x.copy()
    near = Rubbing(A, free, c.law, c.tangent, c.static, c.kinetic, c.decay, c.speed, slack)
    first = 0
    for pace in PACES:
        x[:] = start
        weight = 1.0
        for k in range(first, MAX_PROXIMAL):
            w = 0.0 if k % 4 == 0 else weight
            for i in range(x.size):
                before[i] = x[i]
                A[i, i] = (1.0 + w) * c.A[i, i]
                free[i] = c.free[i] - w * c.A[i, i] * x[i]
            for i in range(slack.size):
                slack[i] = (1.0 + w) * c.slack[i]
            solved = _newton_and_sweeps(near, holds, x, r, excess, status)
            if w == 0.0:
                if solved:
                    return True
                x[:] = before
            else:
                weight = weight * pace if solved else min(1.0, 3.0 * weight)
        first = 1
    return False


@numba.njit(cache=True, error_model="numpy")
def _newton_and_sweeps(c, holds, x, r, excess, status):  # type: ignore[no-untyped-def]
    """Newton, tried again after more and more sweeps; False with x after the last of them."""
    sweeps = FIRST_SWEEPS
    y = x.copy()
    for _ in range(ROUNDS):
        if _newton(c, holds, x, r, excess, status):
            return True
        x[:] = y
        if _sweep(c, holds, x, r, excess, status, sweeps):
            return True
        y[:] = x
        sweeps *= 2
    return False


@numba.njit(cache=True, error_model="numpy")
def _response(c, x, r, size):  # type: ignore[no-untyped-def]
    """r = free + A x, and the size of its terms."""
    for i in range(x.size):
        r[i], size[i] = c.free[i], abs(c.free[i])
    for j in range(x.size):
        if x[j] != 0.0:
            for i in range(x.size):
                push = c.A[j, i] * x[j]
                r[i] += push
                size[i] += abs(push)


@numba.njit(cache=True, error_model="numpy")
def _assess(c, holds, x, r, size, excess, status):  # type: ignore[no-untyped-def]
    """Residual of each channel over its tolerance, and what the projections make of it; returns the worst ratio.

    Tolerances are forces: ACCURATE times the largest one, plus round-off of the motion over the compliance.
    """
    largest, worst = np.abs(x).max(), 0.0
    for i in range(status.size):
        p = x[i]
        s = piece_of(c.law, i, p)
        own = c.A[i, i] + c.law.compliance[s]
        lack = (r[i] + overclosure_at(c.law, s, p)) / own
        status[i] = SMOOTH if p - lack > 0.0 else OPEN
        error = abs(p - max(0.0, p - lack))
        allowed = ACCURATE * largest + ROUND * size[i] / own
        excess[i] = _ratio(error, allowed)
        t = c.tangent[i]
        if t >= 0:
            if status[i] == SMOOTH:
                status[i], error = _tangential(c, holds, i, x, r)
            else:
                error = math.hypot(x[t], x[t + 1])
            allowed = ACCURATE * largest + ROUND * (size[t] + size[t + 1]) / c.slack[i]
            excess[i] = max(excess[i], _ratio(error, allowed))
        worst = max(worst, excess[i])
    return worst


@numba.njit(cache=True, error_model="numpy")
def _ratio(error, allowed):  # type: ignore[no-untyped-def]
    """error / allowed; inf where that is not a number."""
    ratio = error / allowed if error != 0.0 else 0.0
    return ratio if ratio < np.inf else np.inf


@numba.njit(cache=True, error_model="numpy")
def _tangential(c, holds, i, x, r):  # type: ignore[no-untyped-def]
    """STICK or SLIDE, and the violation of Coulomb's law in force.

    The projection decides; where a steep mu(v) has both kinds of solution, that which is nearer.
    """
    t, p = c.tangent[i], max(x[i], 0.0)
    d1, d2 = r[t], r[t + 1]
    limit = coefficient(0.0, c.static[i], c.kinetic[i], c.decay[i], holds[i])
    mu = coefficient(math.hypot(d1, d2) * c.speed, c.static[i], c.kinetic[i], c.decay[i], holds[i])
    stick, slide = friction_violations(p, x[t], x[t + 1], d1, d2, limit, mu, c.slack[i])
    size = math.hypot(x[t] - d1 / c.slack[i], x[t + 1] - d2 / c.slack[i])
    if size > limit * p or (size > mu * p and slide < stick):
        return SLIDE, min(stick, slide)
    return STICK, min(stick, slide)


@numba.njit(cache=True, error_model="numpy")
def _newton(c, holds, x, r, excess, status):  # type: ignore[no-untyped-def]
    """True with x, r, status at the solution; False where it does not get there."""
    size = np.empty(x.size)
    for _ in range(MAX_NEWTON):
        _response(c, x, r, size)
        worst = _assess(c, holds, x, r, size, excess, status)
        if worst <= 1.0 and _bounded(c, x):
            _tidy(c, x, status)
            return True
        if not worst < np.inf or not _newton_step(c, holds, x, r, size, status):
            return False
    return False


@numba.njit(cache=True, error_model="numpy")
def _tidy(c, x, status):  # type: ignore[no-untyped-def]
    """Forces of open channels exactly 0."""
    for i in range(status.size):
        if status[i] == OPEN or x[i] <= 0.0:
            _set_open(c, x, i)


@numba.njit(cache=True, error_model="numpy")
def _set_open(c, x, i):  # type: ignore[no-untyped-def]
    x[i] = 0.0
    t = c.tangent[i]
    if t >= 0:
        x[t] = x[t + 1] = 0.0


@numba.njit(cache=True, error_model="numpy")
def _newton_step(c, holds, x, r, size, status):  # type: ignore[no-untyped-def]
    """One step on the closed channels; the open ones lose their force first."""
    n, lost = status.size, False
    active = np.zeros(x.size, dtype=np.bool_)
    for i in range(n):
        t = c.tangent[i]
        if status[i] == OPEN:
            lost = lost or x[i] != 0.0
            _set_open(c, x, i)
        else:
            active[i] = True
            if t >= 0:
                active[t] = active[t + 1] = True
    if lost:
        _response(c, x, r, size)
    unknown = np.flatnonzero(active)
    J, b = np.empty((unknown.size, unknown.size)), np.empty(unknown.size)
    for e in (0.0, REGULARISATION):
        _linearise(c, holds, x, r, status, unknown, e, J, b)
        if solve_general(J, b):
            for k in range(unknown.size):
                x[unknown[k]] += b[k]
            return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _linearise(c, holds, x, r, status, unknown, e, J, b):  # type: ignore[no-untyped-def]
    """Rows in force: p and sticking tangents over their compliance, sliding as tau - mu p z / |z|.

    `e` on the diagonal makes dependent rows solvable and does not change the equations that are solved for.
    """
    place = np.full(x.size, -1)
    for k in range(unknown.size):
        place[unknown[k]] = k
    for i in range(status.size):
        if status[i] == OPEN:
            continue
        s = piece_of(c.law, i, x[i])
        own = c.A[i, i] + c.law.compliance[s]
        k = place[i]
        for q in range(unknown.size):
            J[k, q] = c.A[i, unknown[q]] / own
        J[k, k] = 1.0 + e
        b[k] = -(r[i] + overclosure_at(c.law, s, x[i])) / own
        if status[i] == STICK:
            t, k = c.tangent[i], place[c.tangent[i]]
            for a in range(2):
                for q in range(unknown.size):
                    J[k + a, q] = c.A[t + a, unknown[q]] / c.slack[i]
                J[k + a, k + a] += e
                b[k + a] = -r[t + a] / c.slack[i]
        elif status[i] == SLIDE:
            _linearise_sliding(c, holds, x, r, i, unknown, place, J, b)


@numba.njit(cache=True, error_model="numpy")
def _linearise_sliding(c, holds, x, r, i, unknown, place, J, b):  # type: ignore[no-untyped-def]
    """d(tau - mu p z / |z|), z = tau - d / compliance, mu at the speed along -z.

    The turning of z is weighted with mu p / |z| cut at 1, which keeps the matrix regular on the way.
    """
    t, p, w = c.tangent[i], max(x[i], 0.0), c.slack[i]
    k = place[t]
    z1, z2 = x[t] - r[t] / w, x[t + 1] - r[t + 1] / w
    length = math.hypot(z1, z2)
    e1, e2 = z1 / length, z2 / length
    speed = max(0.0, -(e1 * r[t] + e2 * r[t + 1])) * c.speed
    mu = coefficient(speed, c.static[i], c.kinetic[i], c.decay[i], holds[i])
    slope = -coefficient_slope(speed, c.static[i], c.kinetic[i], c.decay[i]) * c.speed * p if speed > 0.0 else 0.0
    turn = min(1.0, mu * p / length)
    q11, q12, q22 = turn * e2 * e2, -turn * e1 * e2, turn * e1 * e1
    for q in range(unknown.size):
        a1, a2 = c.A[t, unknown[q]], c.A[t + 1, unknown[q]]
        along = slope * (e1 * a1 + e2 * a2)
        J[k, q] = (q11 * a1 + q12 * a2) / w - along * e1
        J[k + 1, q] = (q12 * a1 + q22 * a2) / w - along * e2
    J[k, k] += 1.0 - q11
    J[k, k + 1] -= q12
    J[k + 1, k] -= q12
    J[k + 1, k + 1] += 1.0 - q22
    J[k, place[i]] -= mu * e1
    J[k + 1, place[i]] -= mu * e2
    b[k] = mu * p * e1 - x[t]
    b[k + 1] = mu * p * e2 - x[t + 1]


@numba.njit(cache=True, error_model="numpy")
def _sweep(c, holds, x, r, excess, status, sweeps):  # type: ignore[no-untyped-def]
    """Gauss-Seidel over the channels; True if the laws hold."""
    size = np.empty(x.size)
    best, keep, since = np.inf, 1.0, 0
    for _ in range(sweeps):
        for i in range(status.size):
            _one_channel(c, holds, x, i, keep)
        _response(c, x, r, size)
        worst = _assess(c, holds, x, r, size, excess, status)
        if worst <= 1.0 and _bounded(c, x):
            _tidy(c, x, status)
            return True
        since += 1
        if worst < 0.5 * best:
            best, since = worst, 0
        elif since >= STALL:
            best, since, keep = worst, 0, max(0.1, 0.7 * keep)
    return False


@numba.njit(cache=True, error_model="numpy")
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


@numba.njit(cache=True, error_model="numpy")
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


@numba.njit(cache=True, error_model="numpy")
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


@numba.njit(cache=True, error_model="numpy")
def _bounded(c, x):  # type: ignore[no-untyped-def]
    """False where forces grow without bound: self-stress of a jam, or gaps that nothing opens."""
    n = c.tangent.size
    push = 0.0
    for i in range(n):
        push = max(push, c.A[i, i] * x[i])
    return push <= BOUND * np.abs(c.free).max()
