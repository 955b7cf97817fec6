"""The contact of a step with friction: unknown forces, response, and how far the laws are from being met.

Unknown x = [p (n); tau (2 per rubbing channel)], r = free + A x = [g; d / slip_gain]. With the sliding divided by its
gain A is symmetric, and with hard or soft channels alike a solution exists wherever the gaps can be opened at all
(Cadoux, PhD thesis, Grenoble 2009; Acary, Cadoux, Lemarechal, Malick, ZAMM 91, 2011, for a constant mu). The laws are
written as projections (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.laws.friction import coefficient, friction_violations
from creak.contact.laws.pieces import Pieces, overclosure_at, piece_of
from creak.contact.pivoting import ROUND
from creak.linalg.compiled import inner
from creak.linalg.loops import largest

OPEN, SMOOTH, STICK, SLIDE = 0, 1, 2, 3
ACCURATE = 1e-13
"""Residual of the laws relative to the largest force, beside round-off."""
BOUND = 1e8
"""Largest p times compliance over the free motion; round-off spoils what is beyond."""


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


@inner
def response(c, x, r, size):  # type: ignore[no-untyped-def]
    """r = free + A x, and the size of its terms."""
    for i in range(x.size):
        r[i], size[i] = c.free[i], abs(c.free[i])
    for j in range(x.size):
        if x[j] != 0.0:
            for i in range(x.size):
                push = c.A[j, i] * x[j]
                r[i] += push
                size[i] += abs(push)


@inner
def assess(c, holds, x, r, size, excess, status):  # type: ignore[no-untyped-def]
    """Residual of each channel over its tolerance, and what the projections make of it; returns the worst ratio.

    Tolerances are forces: ACCURATE times the largest one, plus round-off of the motion over the compliance.
    """
    top, worst = largest(x), 0.0
    for i in range(status.size):
        p = x[i]
        s = piece_of(c.law, i, p)
        own = c.A[i, i] + c.law.compliance[s]
        lack = (r[i] + overclosure_at(c.law, s, p)) / own
        status[i] = SMOOTH if p - lack > 0.0 else OPEN
        error = abs(p - max(0.0, p - lack))
        allowed = ACCURATE * top + ROUND * size[i] / own
        excess[i] = _ratio(error, allowed) if lack - lack == 0.0 else np.inf  # no number, no solution
        t = c.tangent[i]
        if t >= 0:
            if status[i] == SMOOTH:
                status[i], error = _tangential(c, holds, i, x, r)
            else:
                error = math.hypot(x[t], x[t + 1])
            allowed = ACCURATE * top + ROUND * (size[t] + size[t + 1]) / c.slack[i]
            excess[i] = max(excess[i], _ratio(error, allowed))
        worst = max(worst, excess[i])
    return worst


@inner
def _ratio(error, allowed):  # type: ignore[no-untyped-def]
    """error / allowed; inf where that is not a number."""
    ratio = error / allowed if error != 0.0 else 0.0
    return ratio if ratio < np.inf else np.inf


@inner
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


@inner
def tidy(c, x, status):  # type: ignore[no-untyped-def]
    """Forces of open channels exactly 0."""
    for i in range(status.size):
        if status[i] == OPEN or x[i] <= 0.0:
            set_open(c, x, i)


@inner
def set_open(c, x, i):  # type: ignore[no-untyped-def]
    x[i] = 0.0
    t = c.tangent[i]
    if t >= 0:
        x[t] = x[t + 1] = 0.0


@inner
def bounded(c, x):  # type: ignore[no-untyped-def]
    """False where forces grow without bound: self-stress of a jam, or gaps that nothing opens."""
    n = c.tangent.size
    push = 0.0
    for i in range(n):
        push = max(push, c.A[i, i] * x[i])
    return push <= BOUND * largest(c.free)
