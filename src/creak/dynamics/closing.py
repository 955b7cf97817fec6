"""Does a gap close in the course of a step?"""

from __future__ import annotations

import numba
import numpy as np

PIECES = 8
"""Cubics that stand for the course of a flight: each within 1e-7 of it at ten steps a period."""


@numba.njit(cache=True)
def closes_between(gap0, rate0, gap1, rate1, h):  # type: ignore[no-untyped-def]
    """True where the cubic through gaps and gap rates (m,) at both ends of a step of length h reaches zero in it."""
    for i in range(gap0.size):  # noqa: SIM110 (compiled)
        if dips(gap0[i], h * rate0[i], gap1[i], h * rate1[i]):
            return True
    return False


@numba.njit(cache=True)
def closes_in_flight(gap, rate0, rate1, acceleration0, acceleration1, known, c, h):  # type: ignore[no-untyped-def]
    """True where a gap may reach zero in a step of length h that was taken by collocation.

    Its course is the quintic through gap, rate and acceleration at both ends, or the quartic without the acceleration
    at the beginning where that is not `known` (it may hold the noise of a contact). The inner stages are less accurate
    than the ends: their distance from the course is taken for its error, and a gap that comes as near to zero counts
    as closing.

    Parameters
    ----------
    gap : (4, m) at the beginning, at both inner stages, and at the end; rates and accelerations are (m,).
    c : (3,) times of the stages as shares of h.
    """
    for i in range(rate0.size):
        g0, g1, d0, d1, a1 = gap[0, i], gap[3, i], h * rate0[i], h * rate1[i], h * h * acceleration1[i]
        a0 = h * h * acceleration0[i] if known else 12.0 * (g1 - g0 - d0) - 6.0 * (d1 - d0) + a1
        D, E, F = g1 - g0 - d0 - 0.5 * a0, d1 - d0 - a0, a1 - a0
        c3, c4, c5 = 10.0 * D - 4.0 * E + 0.5 * F, -15.0 * D + 7.0 * E - F, 6.0 * D - 3.0 * E + 0.5 * F
        margin = 0.0
        for k in range(2):
            x = c[k]
            course = g0 + x * (d0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
            margin = max(margin, abs(course - gap[k + 1, i]))
        if g0 - margin > abs(d0) + 0.5 * abs(a0) + abs(c3) + abs(c4) + abs(c5):
            continue
        before, slope = g0 - margin, d0 / PIECES
        for j in range(1, PIECES + 1):
            x = j / PIECES
            after = g0 - margin + x * (d0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
            steeper = (d0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / PIECES
            if dips(before, slope, after, steeper):
                return True
            before, slope = after, steeper
    return False


@numba.njit(cache=True)
def dips(g0, d0, g1, d1):  # type: ignore[no-untyped-def]
    """True where the cubic with values g and slopes d at 0 and 1 reaches zero between them."""
    if g1 <= 0.0:
        return True
    if d0 < 0.0 < d1:  # g' = 3 a x^2 + 2 b x + d0 changes sign: its root inside, in a form without cancellation
        a, b = 2.0 * (g0 - g1) + d0 + d1, -3.0 * (g0 - g1) - 2.0 * d0 - d1
        q = b + np.sqrt(max(b * b - 3.0 * a * d0, 0.0))
        x = -d0 / q if q != 0.0 else 0.5
        if g0 + x * (d0 + x * (b + x * a)) <= 0.0:
            return True
    return False
