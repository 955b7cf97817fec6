"""A diagonal System, one of its instants and its table of output as arrays for compiled code; the smallest kernels."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.dynamics.books import SCHEME

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order; infinities and NaN keep their meaning."""
ACCELERATION, VELOCITY, DISPLACEMENT, FORCE, CONSTANT = 2, 1, 0, 3, 4
"""What drives a load column."""
DONE, NOT_FINITE = 0, -1


class ModalModel(NamedTuple):
    """A diagonal System with its channels and loads."""

    m: FloatArray
    c: FloatArray
    k: FloatArray
    rows: FloatArray
    """(m + 2 f, n) G above T."""
    rows_s: FloatArray
    """(m + 2 f, n_support)"""
    gap0: FloatArray
    preload: FloatArray
    presses: bool
    damped: bool
    X: FloatArray
    """(n_x, n) modal force of each load column for its amplitude 1."""
    order: IntArray
    """(n_x,) what drives it: a derivative of the supports, a force, or nothing (constant)."""
    column: IntArray
    """(n_x,) which support or force."""
    M_ss: FloatArray
    C_ss: FloatArray
    K_ss: FloatArray
    support: FloatArray
    """(3, n_instant, n_support) samples."""
    force: FloatArray
    """(n_instant, n_force)"""


class MarchState(NamedTuple):
    """Everything that is known at one instant."""

    x: FloatArray
    """(3, n) u, v, a; the exact scheme keeps no a."""
    F: FloatArray
    """(n,) channel forces on the modes."""
    force: FloatArray
    """(m + 2 f,)"""
    gap: FloatArray
    rate: FloatArray
    sliding: FloatArray
    """(2 f,) slip velocity."""
    stuck: BoolArray
    support: FloatArray
    """(3, n_support)"""
    amplitude: FloatArray
    """(n_x,) of the load columns."""
    dots: FloatArray
    """(2, n_x) X u, X v."""
    damper: FloatArray
    """(n_support,) damper forces on the supports."""
    reaction: FloatArray
    """(n_support,) of the supports, without inertia."""
    momentum: FloatArray
    """(n_support,) M_sq v + M_ss s'."""
    energy: FloatArray
    """The book (`books`)."""
    recent: BoolArray
    """(1,) a channel pressed in the output step that ends here."""


class Output(NamedTuple):
    """Where a run is written to."""

    table: FloatArray
    """(rows, 1 + m + (m + 2 f) + 2 f + 8): time, gaps, forces, sliding, energies."""
    at: IntArray
    """(chunk,) rows of the table at which motion is kept."""
    u: FloatArray
    """(chunk, n)"""
    s: FloatArray
    """(chunk, n_support)"""
    whole_at: IntArray
    whole: FloatArray
    """(n_whole, n)"""


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
def two_dots(row, u, v):  # type: ignore[no-untyped-def]
    """row . u and row . v, row read once."""
    a = b = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
        b += row[i] * v[i]
    return a, b


@numba.njit(cache=True, fastmath=FAST)
def dot(row, u):  # type: ignore[no-untyped-def]
    """row . u"""
    a = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
    return a


@numba.njit(cache=True)
def look(model, after, rated):  # type: ignore[no-untyped-def]
    """Gaps, and their rates where asked for, of a motion."""
    m = after.gap.size
    np.dot(model.rows[:m], after.x[0], after.gap)
    if rated:
        np.dot(model.rows[:m], after.x[1], after.rate)
    for i in range(m):
        after.gap[i] += model.gap0[i]
        for j in range(after.support.shape[1]):
            after.gap[i] += model.rows_s[i, j] * after.support[0, j]
            if rated:
                after.rate[i] += model.rows_s[i, j] * after.support[1, j]


@numba.njit(cache=True)
def slide(model, now, after, out):  # type: ignore[no-untyped-def]
    """Tangential displacement of the rubbing channels in a step."""
    m = model.gap0.size
    for i in range(out.size):
        row = model.rows[m + i]
        out[i] = dot(row, after.x[0]) - dot(row, now.x[0])
        for j in range(now.support.shape[1]):
            out[i] += model.rows_s[m + i, j] * (after.support[0, j] - now.support[0, j])


@numba.njit(cache=True)
def write(out, row, time, x):  # type: ignore[no-untyped-def]
    """One row of the table."""
    to = out.table[row]
    to[0] = time
    at = put(to, 1, x.gap)
    at = put(to, at, x.force)
    at = put(to, at, x.sliding)
    for i in range(SCHEME + 1):
        to[at + i] = x.energy[i]
