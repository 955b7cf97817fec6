"""What the kernels of exact flow do with vectors, and the marks that they know loads and endings by."""

from __future__ import annotations

import numba

from creak.dynamics.compiled import FAST

ACCELERATION, VELOCITY, DISPLACEMENT, FORCE, CONSTANT = 2, 1, 0, 3, 4
"""What drives a load column."""
DONE, NOT_FINITE = 0, -1
"""How a chunk of steps ends; other codes are those of the contact solver."""


@numba.njit(cache=True)
def fill(to, value):  # type: ignore[no-untyped-def]
    """to[:] = value; a loop compiles in a fraction of the time."""
    for i in range(to.size):
        to[i] = value


@numba.njit(cache=True)
def put(to, begin, values):  # type: ignore[no-untyped-def]
    """to[begin : begin + values.size] = values; returns the next place."""
    for i in range(values.size):
        to[begin + i] = values[i]
    return begin + values.size


@numba.njit(cache=True)
def acts(force, begin, end):  # type: ignore[no-untyped-def]
    """Is any of force[begin:end] not zero?"""
    found = False
    for i in range(begin, end):
        found = found or force[i] != 0.0
    return found


@numba.njit(cache=True, fastmath=FAST)
def dot(row, u):  # type: ignore[no-untyped-def]
    """row . u"""
    a = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
    return a
