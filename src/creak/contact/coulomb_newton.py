"""Semismooth Newton on the projected laws of contact with friction, mu(v) included: few and quadratic steps.

Source: Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991. It need not converge; then `newton` says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.coulomb import OPEN, SLIDE, STICK, assess, bounded, response, set_open, tidy
from creak.contact.laws.friction import against, coefficient, coefficient_slope
from creak.contact.laws.pieces import overclosure_at, piece_of
from creak.contact.pivoting import REGULARISATION
from creak.contact.small_systems import factor_general, solve_factored
from creak.linalg.compiled import inner, with_arrays
from creak.linalg.loops import fill, places, put

MAX_NEWTON = 20
"""Matrices that are factored."""
SHARP = 0.01
"""A factor serves again while each step brings the residual down to this share: next to a solution all but the turning
of what slides is the same, and the factor costs as much as five steps."""


class Kept(NamedTuple):
    """A factor and what it was made for: it is tried first in the next step, where it mostly serves again."""

    matrix: FloatArray
    """(N N,) that of the `counts[2]` forces of closed channels, row by row."""
    order: IntArray
    unknown: IntArray
    """(N,) rows that were taken; places in x."""
    status: IntArray
    """(N,) of the channels"""
    counts: IntArray
    """(3,) channels, forces, and those of closed channels; -1: there is none."""


def new_kept(size: int) -> Kept:
    """For up to `size` forces; none is there yet."""
    none = np.zeros(size, dtype=np.int64)
    return Kept(np.zeros(size * size), none, none.copy(), none.copy(), np.full(3, -1))


fresh = with_arrays(new_kept)


@with_arrays
def room_for(kept, size):  # type: ignore[no-untyped-def]
    """`kept`, or a new one where it is too small."""
    return kept if kept.order.size >= size else fresh(size)


@with_arrays
def newton(c, holds, x, r, excess, status, kept):  # type: ignore[no-untyped-def]
    """True with x, r, status at the solution; False where it does not get there. kept: with room for all forces."""
    size, last, factored, b = np.empty(x.size), np.inf, 0, np.empty(x.size)
    while factored < MAX_NEWTON:
        response(c, x, r, size)
        worst = assess(c, holds, x, r, size, excess, status)
        if worst <= 1.0 and bounded(c, x):
            tidy(c, x, status)
            return True
        if not worst < np.inf:
            return False
        if _opened(c, x, status):
            response(c, x, r, size)
        if not (worst < SHARP * last and _serves(kept, x, status)):
            factored += 1
            if not _factor(c, holds, x, r, status, kept):
                return False
        last = worst
        _right_side(c, holds, x, r, status, b)
        known = kept.counts[2]
        step = b[kept.unknown[:known]]
        solve_factored(kept.matrix[: known * known].reshape((known, known)), kept.order[:known], step)
        for k in range(known):
            x[kept.unknown[k]] += step[k]
    return False


@inner
def _serves(kept, x, status):  # type: ignore[no-untyped-def]
    """Was the factor made for these states?"""
    if kept.counts[0] != status.size or kept.counts[1] != x.size:
        return False
    for i in range(status.size):  # noqa: SIM110 (compiled)
        if kept.status[i] != status[i]:
            return False
    return True


@inner
def _opened(c, x, status):  # type: ignore[no-untyped-def]
    """The open channels lose their force; True if any had one."""
    lost = False
    for i in range(status.size):
        if status[i] == OPEN:
            lost = lost or x[i] != 0.0
            set_open(c, x, i)
    return lost


@with_arrays
def _closed(c, x, status):  # type: ignore[no-untyped-def]
    """(x.size,) bool: forces of closed channels."""
    active = np.zeros(x.size, dtype=np.bool_)
    for i in range(status.size):
        t = c.tangent[i]
        if status[i] != OPEN:
            active[i] = True
            if t >= 0:
                active[t] = active[t + 1] = True
    return active


@with_arrays
def _factor(c, holds, x, r, status, kept):  # type: ignore[no-untyped-def]
    """The matrix of the closed channels and its factor; False where it is singular."""
    known = places(_closed(c, x, status), kept.unknown)
    J, unknown = kept.matrix[: known * known].reshape((known, known)), kept.unknown[:known]
    put(kept.status, 0, status)
    kept.counts[0], kept.counts[1], kept.counts[2] = status.size, x.size, known
    for e in (0.0, REGULARISATION):
        _linearise(c, holds, x, r, status, unknown, e, J)
        if factor_general(J, kept.order[:known]):
            return True
    kept.counts[0] = -1
    return False


@with_arrays
def _linearise(c, holds, x, r, status, unknown, e, J):  # type: ignore[no-untyped-def]
    """Rows in force: p and sticking tangents over their compliance, sliding as tau - mu p z / |z|.

    `e` on the diagonal makes dependent rows solvable and does not change the equations that are solved for.
    """
    place = np.empty(x.size, dtype=np.int64)
    fill(place, -1)
    for k in range(unknown.size):
        place[unknown[k]] = k
    for i in range(status.size):
        if status[i] == OPEN:
            continue
        own = 1.0 / (c.A[i, i] + c.law.compliance[piece_of(c.law, i, x[i])])
        k = place[i]
        for q in range(unknown.size):
            J[k, q] = c.A[i, unknown[q]] * own
        J[k, k] = 1.0 + e
        if status[i] == STICK:
            t, k, own = c.tangent[i], place[c.tangent[i]], 1.0 / c.slack[i]
            for a in range(2):
                for q in range(unknown.size):
                    J[k + a, q] = c.A[t + a, unknown[q]] * own
                J[k + a, k + a] += e
        elif status[i] == SLIDE:
            _linearise_sliding(c, holds, x, r, i, unknown, place, J)


@inner
def _right_side(c, holds, x, r, status, b):  # type: ignore[no-untyped-def]
    """What the rows of `_linearise` lack; of closed channels."""
    for i in range(status.size):
        if status[i] == OPEN:
            continue
        s, t = piece_of(c.law, i, x[i]), c.tangent[i]
        b[i] = -(r[i] + overclosure_at(c.law, s, x[i])) / (c.A[i, i] + c.law.compliance[s])
        if status[i] == STICK:
            b[t], b[t + 1] = -r[t] / c.slack[i], -r[t + 1] / c.slack[i]
        elif status[i] == SLIDE:
            e1, e2, _, _, mu = _sliding(c, holds, x, r, i)
            most = mu * max(x[i], 0.0)
            b[t], b[t + 1] = most * e1 - x[t], most * e2 - x[t + 1]


@inner
def _sliding(c, holds, x, r, i):  # type: ignore[no-untyped-def]
    """Direction and length of z = tau - d / compliance, the speed along -z, and mu there."""
    t = c.tangent[i]
    e1, e2, length, way = against(x[t], x[t + 1], r[t], r[t + 1], c.slack[i])
    speed = way * c.speed
    return e1, e2, length, speed, coefficient(speed, c.static[i], c.kinetic[i], c.decay[i], holds[i])


@inner
def _linearise_sliding(c, holds, x, r, i, unknown, place, J):  # type: ignore[no-untyped-def]
    """d(tau - mu p z / |z|), mu at the speed along -z.

    The turning of z is weighted with mu p / |z| cut at 1, which keeps the matrix regular on the way.
    """
    t, p, w = c.tangent[i], max(x[i], 0.0), 1.0 / c.slack[i]
    k = place[t]
    e1, e2, length, speed, mu = _sliding(c, holds, x, r, i)
    slope = -coefficient_slope(speed, c.static[i], c.kinetic[i], c.decay[i]) * c.speed * p if speed > 0.0 else 0.0
    turn = min(1.0, mu * p / length)
    q11, q12, q22 = turn * e2 * e2, -turn * e1 * e2, turn * e1 * e1
    for q in range(unknown.size):
        a1, a2 = c.A[t, unknown[q]], c.A[t + 1, unknown[q]]
        along = slope * (e1 * a1 + e2 * a2)
        J[k, q] = (q11 * a1 + q12 * a2) * w - along * e1
        J[k + 1, q] = (q12 * a1 + q22 * a2) * w - along * e2
    J[k, k] += 1.0 - q11
    J[k, k + 1] -= q12
    J[k + 1, k] -= q12
    J[k + 1, k + 1] += 1.0 - q22
    J[k, place[i]] -= mu * e1
    J[k + 1, place[i]] -= mu * e2
