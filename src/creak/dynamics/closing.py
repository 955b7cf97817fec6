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
    """True where the cubic with values g and slopes d at 0 and 1 reaches zero between them."""
    if g1 <= 0.0:
        return True
    if d0 < 0.0 < d1:  # g' = 3 a x^2 + 2 b x + d0 changes sign: its root inside, in a form without cancellation
        a, b = 2.0 * (g0 - g1) + d0 + d1, -3.0 * (g0 - g1) - 2.0 * d0 - d1
        q = b + math.sqrt(max(b * b - 3.0 * a * d0, 0.0))
        x = -d0 / q if q != 0.0 else 0.5
        if g0 + x * (d0 + x * (b + x * a)) <= 0.0:
            return True
    return False
