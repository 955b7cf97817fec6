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
from creak.contact.small_systems import solve_general
from creak.linalg.compiled import with_arrays
from creak.linalg.loops import fill, places

MAX_NEWTON = 20


@with_arrays
def newton(c, holds, x, r, excess, status):  # type: ignore[no-untyped-def]
    """True with x, r, status at the solution; False where it does not get there."""
    size = np.empty(x.size)
    for _ in range(MAX_NEWTON):
        response(c, x, r, size)
        worst = assess(c, holds, x, r, size, excess, status)
        if worst <= 1.0 and bounded(c, x):
            tidy(c, x, status)
            return True
        if not worst < np.inf or not _newton_step(c, holds, x, r, size, status):
            return False
    return False


@with_arrays
def _newton_step(c, holds, x, r, size, status):  # type: ignore[no-untyped-def]
    """One step on the closed channels; the open ones lose their force first."""
    n, lost = status.size, False
    active = np.zeros(x.size, dtype=np.bool_)
    for i in range(n):
        t = c.tangent[i]
        if status[i] == OPEN:
            lost = lost or x[i] != 0.0
            set_open(c, x, i)
        else:
            active[i] = True
            if t >= 0:
                active[t] = active[t + 1] = True
    if lost:
        response(c, x, r, size)
    unknown = np.empty(x.size, dtype=np.int64)
    unknown = unknown[: places(active, unknown)]
    J, b = np.empty((unknown.size, unknown.size)), np.empty(unknown.size)
    for e in (0.0, REGULARISATION):
        _linearise(c, holds, x, r, status, unknown, e, J, b)
        if solve_general(J, b):
            for k in range(unknown.size):
                x[unknown[k]] += b[k]
            return True
    return False


@with_arrays
def _linearise(c, holds, x, r, status, unknown, e, J, b):  # type: ignore[no-untyped-def]
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


@with_arrays
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
