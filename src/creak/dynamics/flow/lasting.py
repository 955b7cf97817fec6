"""Contact that lasts, in compiled code: longer steps while the set of channels that press stays the same.

Over such a step the structure moves exactly under channel forces that are constant in it, their mean

    p = (1 - w) p0 + w p1,    p1 = -k g1,    g1 = g_free + B p,    w = 1/2 + LOSS

with B what a constant force moves in the step. With w = 1/2 the work of the forces is what linear springs store,
whatever the step: stable without a limit (Newmark's average acceleration, with the structure exact); LOSS damps the
springs' own vibration where a step does not resolve it. A step in which a channel opens, or another may close, is not
taken: those belong to the kicks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.books import EXTERNAL, GIVEN
from creak.dynamics.closing import dips
from creak.dynamics.compiled import inner, inner_fast, with_arrays
from creak.dynamics.flow.block import look_near, under_way
from creak.dynamics.flow.motion import fly, gap_of, look, settle_supports, times
from creak.dynamics.vector_kernels import fill

PATIENCE = 25
"""Long steps that the same channels press before one is taken: touches are over by then, their force is followed."""
LOSS = 0.02
"""Of what a spring's force changes by in a step this share acts too late."""


@inner
def same_set(now, after):  # type: ignore[no-untyped-def]
    """Do the same channels press at both instants, and at least one?"""
    any_presses = False
    for i in range(now.gap.size):
        if (now.force[i] > 0.0) != (after.force[i] > 0.0):
            return False
        any_presses = any_presses or now.force[i] > 0.0
    return any_presses


@inner
def rests(model, now):  # type: ignore[no-untyped-def]
    """Does every channel that presses do so at rest?"""
    for i in range(now.gap.size):  # noqa: SIM110 (compiled)
        if now.force[i] > 0.0 and model.preload[i] <= 0.0:
            return False
    return True


class Held(NamedTuple):
    """The channels that press in lasting contact."""

    number: IntArray
    """(1,) of them"""
    pressing: IntArray
    """(m,) which: the first `number` count, so of all that follows."""
    inverse: FloatArray
    """(m m,) (1 / k + w B)^-1, rows one after the other."""
    right: FloatArray
    end: FloatArray
    mean: FloatArray
    """(m,) right side, forces at the end of a step, their means."""


def new_held(m: int) -> Held:
    """For m channels."""
    one = np.zeros(m)
    return Held(np.zeros(1, dtype=np.int64), np.zeros(m, dtype=np.int64), np.zeros(m * m), one, one.copy(), one.copy())


@with_arrays
def hold_together(laws, B, force, held):  # type: ignore[no-untyped-def]
    """The channels that press now."""
    pressing = np.flatnonzero(force)
    n = pressing.size
    C = np.empty((n, n))
    for a in range(n):
        held.pressing[a] = pressing[a]
        for b in range(n):
            C[a, b] = (0.5 + LOSS) * B[pressing[a], pressing[b]]
        C[a, a] += 1.0 / laws.stiffness[pressing[a]]
    held.number[0] = n
    inverse = np.linalg.inv(C)
    for a in range(n):
        for b in range(n):
            held.inverse[a * n + b] = inverse[a, b]


@inner
def hold(model, laws, slope, P, B, held, gain, D, course, h, now, after, block):  # type: ignore[no-untyped-def]
    """A step of lasting contact; False, and nothing is done, where the set of channels would change in it."""
    fly(model, P, gain, D, now, after, False)
    settle_supports(course, h, after)
    n, m, u = held.number[0], now.gap.size, after.x.reshape(after.x.size)[model.u0 : model.u1]
    pressing, right, p1, mean = held.pressing[:n], held.right[:n], held.end[:n], held.mean[:n]
    for a in range(n):
        right[a] = -gap_of(model, pressing[a], u, after)
        for b in range(n):
            right[a] -= (0.5 - LOSS) * B[pressing[a], pressing[b]] * now.force[pressing[b]]
    times(held.inverse[: n * n].reshape((n, n)), right, p1)
    for a in range(n):
        if p1[a] <= 0.0:
            return False
        mean[a] = (0.5 - LOSS) * now.force[pressing[a]] + (0.5 + LOSS) * p1[a]
    fill(after.F, 0.0)
    push_by(model, pressing, mean, after.F)
    add(D[0], after.F, 1.0)
    fly(model, P, gain, D, now, after, False)
    add(D[0], after.F, -1.0)
    if under_way(block):
        look_near(block, model, now, after, h, True)
    else:
        look(model, after)
    for i in range(m):
        watched = slope[i] > 0.0 and now.force[i] <= 0.0 and block.is_near[i]
        if watched and dips(now.gap[i], h * now.rate[i], after.gap[i], h * after.rate[i]):
            return False
    fill(after.force, 0.0)
    for a in range(n):
        i = pressing[a]
        after.force[i] = p1[a]
        carried = 0.0
        for s in range(now.support.shape[1]):
            carried += model.rows_s[i, s] * (after.support[0, s] - now.support[0, s])
        after.energy[GIVEN] += mean[a] * (after.gap[i] - now.gap[i] - carried)
        after.energy[EXTERNAL] -= mean[a] * carried
    fill(after.F, 0.0)
    push_by(model, pressing, p1, after.F)
    fill(after.sliding, 0.0)
    fill(after.stuck, True)
    return True


@inner_fast
def push_by(model, pressing, p, F):  # type: ignore[no-untyped-def]
    """F += push' p"""
    for a in range(pressing.size):
        force, row = p[a], model.push[pressing[a]]
        for i in range(F.size):
            F[i] += force * row[i]


@inner_fast
def add(to, what, times):  # type: ignore[no-untyped-def]
    """to += times what"""
    for i in range(to.size):
        to[i] += times * what[i]
