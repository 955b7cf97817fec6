"""Semismooth Newton on the projected laws of contact with friction, mu(v) included: few and quadratic steps.

Source: Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991. It need not converge; then `newton` says so.
"""

from __future__ import annotations

import math

import numpy as np

from creak.contact.coulomb import OPEN, SLIDE, STICK, assess, bounded, response, set_open, tidy
from creak.contact.laws.friction import coefficient, coefficient_slope
from creak.contact.laws.pieces import overclosure_at, piece_of
from creak.contact.pivoting import REGULARISATION
from creak.contact.small_systems import factor_general, solve_factored
from creak.linalg.compiled import with_arrays
from creak.linalg.loops import fill, places, put

MAX_NEWTON = 20
"""Matrices that are factored."""
SHARP = 0.01
"""A factor serves again while each step brings the residual down to this share: next to a solution all but the turning
of what slides is the same, and the factor costs as much as five steps."""


@with_arrays
def newton(c, holds, x, r, excess, status):  # type: ignore[no-untyped-def]
    """True with x, r, status at the solution; False where it does not get there."""
    size, last, factored = np.empty(x.size), np.inf, 0
    before, unknown = np.empty(status.size, dtype=np.int64), np.empty(x.size, dtype=np.int64)
    order, J, b = np.empty(x.size, dtype=np.int64), np.empty((0, 0)), np.empty(x.size)
    fill(before, -1)
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
        if not (worst < SHARP * last and _alike(before, status)):
            factored += 1
            known = places(_closed(c, x, status), unknown)
            J = np.empty((known, known))
            if not _factor(c, holds, x, r, status, unknown[:known], J, order[:known]):
                return False
            put(before, 0, status)
        last = worst
        _right_side(c, holds, x, r, status, b)
        step = b[unknown[: J.shape[0]]]
        solve_factored(J, order[: step.size], step)
        for k in range(step.size):
            x[unknown[k]] += step[k]
    return False


@with_arrays
def _alike(before, status):  # type: ignore[no-untyped-def]
    """Are the states those that the factor was made for?"""
    for i in range(status.size):  # noqa: SIM110 (compiled)
        if before[i] != status[i]:
            return False
    return True


@with_arrays
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
def _factor(c, holds, x, r, status, unknown, J, order):  # type: ignore[no-untyped-def]
    """The matrix of the closed channels and its factor; False where it is singular."""
    for e in (0.0, REGULARISATION):
        _linearise(c, holds, x, r, status, unknown, e, J)
        if factor_general(J, order):
            return True
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
        own = c.A[i, i] + c.law.compliance[piece_of(c.law, i, x[i])]
        k = place[i]
        for q in range(unknown.size):
            J[k, q] = c.A[i, unknown[q]] / own
        J[k, k] = 1.0 + e
        if status[i] == STICK:
            t, k = c.tangent[i], place[c.tangent[i]]
            for a in range(2):
                for q in range(unknown.size):
                    J[k + a, q] = c.A[t + a, unknown[q]] / c.slack[i]
                J[k + a, k + a] += e
        elif status[i] == SLIDE:
            _linearise_sliding(c, holds, x, r, i, unknown, place, J)


@with_arrays
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


@with_arrays
def _sliding(c, holds, x, r, i):  # type: ignore[no-untyped-def]
    """Direction and length of z = tau - d / compliance, the speed along -z, and mu there."""
    t, w = c.tangent[i], c.slack[i]
    z1, z2 = x[t] - r[t] / w, x[t + 1] - r[t + 1] / w
    length = math.hypot(z1, z2)
    e1, e2 = z1 / length, z2 / length
    speed = max(0.0, -(e1 * r[t] + e2 * r[t + 1])) * c.speed
    return e1, e2, length, speed, coefficient(speed, c.static[i], c.kinetic[i], c.decay[i], holds[i])


@with_arrays
def _linearise_sliding(c, holds, x, r, i, unknown, place, J):  # type: ignore[no-untyped-def]
    """d(tau - mu p z / |z|), mu at the speed along -z.

    The turning of z is weighted with mu p / |z| cut at 1, which keeps the matrix regular on the way.
    """
    t, p, w = c.tangent[i], max(x[i], 0.0), c.slack[i]
    k = place[t]
    e1, e2, length, speed, mu = _sliding(c, holds, x, r, i)
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
