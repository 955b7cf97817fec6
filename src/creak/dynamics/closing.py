"""Does a gap close in the course of a step?"""

from __future__ import annotations

import math

from creak.jit import njit
from creak.linalg.compiled import inner


@njit()
def closes_between(gap0, rate0, gap1, rate1, h):  # type: ignore[no-untyped-def]
    """True where the cubic through gaps and gap rates (m,) at both ends of a step of length h reaches zero in it."""
    for i in range(gap0.size):  # noqa: SIM110 (compiled)
        if dips(gap0[i], h * rate0[i], gap1[i], h * rate1[i]):
            return True
    return False


@njit()
def first_closing(gap, rate, step):  # type: ignore[no-untyped-def]
    """The first of k pieces, `step` (k,) long, in which a gap reaches zero by the cubic through its ends; k: none.

    Parameters
    ----------
    gap, rate : (k + 1, m) at the ends of the pieces.
    """
    for j in range(step.size):
        if closes_between(gap[j], rate[j], gap[j + 1], rate[j + 1], step[j]):
            return j
    return step.size


@inner
def dips(g0, d0, g1, d1):  # type: ignore[no-untyped-def]
    """True where the cubic with values g and slopes d at 0 and 1 reaches zero between them.

    It lies above min(g) - 4/27 (what d0 falls and d1 rises). Its only minimum is where g' = 3 a x^2 + 2 b x + d0 rises
    through zero, also between slopes of one sign; the root is taken in a form without cancellation.
    """
    if g1 <= 0.0:
        return True
    if min(g0, g1) > 4.0 / 27.0 * (max(-d0, 0.0) + max(d1, 0.0)):
        return False
    a, b = 2.0 * (g0 - g1) + d0 + d1, -3.0 * (g0 - g1) - 2.0 * d0 - d1
    turns = b * b - 3.0 * a * d0
    if turns < 0.0:
        return False
    root = math.sqrt(turns)
    low, by = (-d0, b + root) if b > 0.0 else (root - b, 3.0 * a)
    if by == 0.0:
        return False
    x = low / by
    return 0.0 < x < 1.0 and g0 + x * (d0 + x * (b + x * a)) <= 0.0
