"""Does a gap close in the course of a step?"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def closes_between(gap0: FloatArray, rate0: FloatArray, gap1: FloatArray, rate1: FloatArray, h: float) -> bool:
    """True where the cubic through gaps and gap rates (m,) at both ends of a step reaches zero in it."""
    if gap0.size == 0:
        return False
    if gap1.min() <= 0.0:
        return True
    turns = np.flatnonzero((rate0 < 0.0) & (rate1 > 0.0))
    if not turns.size:
        return False
    g0, d0, g1, d1 = gap0[turns], h * rate0[turns], gap1[turns], h * rate1[turns]
    a, b = 2.0 * (g0 - g1) + d0 + d1, -3.0 * (g0 - g1) - 2.0 * d0 - d1
    # g' = 3 a x^2 + 2 b x + d0 goes from below to above zero: its root inside, in a form without cancellation
    root = np.sqrt(np.maximum(b * b - 3.0 * a * d0, 0.0))
    x = np.where(b + root != 0.0, -d0 / np.where(b + root != 0.0, b + root, 1.0), 0.5)
    return bool((g0 + x * (d0 + x * (b + x * a))).min() <= 0.0)
