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
from creak.contact.step_problem import solve_step
from creak.dynamics.books import EXTERNAL, FRICTION, GIVEN
from creak.dynamics.closing import dips
from creak.dynamics.flow.block import look_near, under_way
from creak.dynamics.flow.kicks import GIVE
from creak.dynamics.flow.model import DONE
from creak.dynamics.flow.motion import fly, gap_of, look, quiet, rate_of, settle_supports, times
from creak.linalg.by_reference import by_value
from creak.linalg.compiled import inner, inner_fast, with_arrays
from creak.linalg.loops import dot, fill, put

PATIENCE = 25
"""Long steps that the same channels press before one is taken: touches are over by then, their force is followed."""
LOSS = 0.02
"""Of what a spring's force changes by in a step this share acts too late."""


class Lasting(NamedTuple):
    """Steps of lasting contact."""

    level: int
    """H / 2^level long; beyond the last level: there are none."""
    B: FloatArray
    """(m + 2 f, m + 2 f) what a constant force moves in one, length / force."""
    A: FloatArray
    """(m + 2 f, m + 2 f) what a force at its end moves, and what sticks gives way; (0, 0) where nothing rubs."""


@inner
def same_set(laws, now, after):  # type: ignore[no-untyped-def]
    """Do the same channels press, and stick, at both instants, and at least one?"""
    any_presses = False
    for f in range(now.stuck.size):
        if now.stuck[f] != after.stuck[f] and now.force[laws.rubs[f]] > 0.0:
            return False
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
    """(m,) right side, forces at the end of a step."""
    mean: FloatArray
    """(m,) of the forces of all channels over it."""


def new_held(m: int) -> Held:
    """For m channels."""
    one = np.zeros(m)
    return Held(np.zeros(1, dtype=np.int64), np.zeros(m, dtype=np.int64), np.zeros(m * m), one, one.copy(), one.copy())


@with_arrays
def hold_together(laws, B, force, held):  # type: ignore[no-untyped-def]
    """The channels that press now."""
    n, pressing = 0, held.pressing
    for i in range(force.size):
        if force[i] != 0.0:
            pressing[n] = i
            n += 1
    C = np.empty((n, n))
    for a in range(n):
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
    fly(model, P, gain, D, now, after, np.bool_(False))
    settle_supports(course, h, after)
    n, u = held.number[0], after.x.reshape(after.x.size)[model.u0 : model.u1]
    pressing, right, p1, mean = held.pressing[:n], held.right[:n], held.end[:n], held.mean
    for a in range(n):
        right[a] = -gap_of(model, pressing[a], u, after)
        for b in range(n):
            right[a] -= (0.5 - LOSS) * B[pressing[a], pressing[b]] * now.force[pressing[b]]
    times(held.inverse[: n * n].reshape((n, n)), right, p1)
    quiet(after)
    fill(mean, 0.0)
    for a in range(n):
        if p1[a] <= 0.0:
            return False
        after.force[pressing[a]] = p1[a]
        mean[pressing[a]] = (0.5 - LOSS) * now.force[pressing[a]] + (0.5 + LOSS) * p1[a]
    return go(model, laws, slope, P, gain, D, h, mean, now, after, block)


@with_arrays
def hold_rubbing(model, laws, slope, P, lasting, gain, D, course, h, now, after, block):  # type: ignore[no-untyped-def]
    """The same of channels that rub; False also where one begins or ends to slide, or turns round in it."""
    fly(model, P, gain, D, now, after, np.bool_(False))
    settle_supports(course, h, after)
    B, A, m, n = lasting.B, lasting.A, now.gap.size, now.force.size
    u = after.x.reshape(after.x.size)[model.u0 : model.u1]
    free, mean = np.empty(n), np.empty(n)
    for i in range(n):
        free[i] = gap_of(model, i, u, after) if i < m else moved(model, i, now, after)
        mean[i] = (0.5 - LOSS) * now.force[i]
    for j in range(n):
        if mean[j] != 0.0:
            for i in range(n):
                free[i] += B[j, i] * mean[j]
            if j >= m:
                free[j] -= GIVE / (1.0 + GIVE) * A[j, j] * now.force[j]
    for j in range(m, n):  # what sticks comes to rest at the end: v / 2 of the way, else it would go back and forth
        if now.stuck[(j - m) // 2]:
            free[j] -= 0.5 * h * now.rate[j]
    put(after.force, 0, now.force)
    put(after.stuck, 0, now.stuck)
    if solve_step(A, free[:m], free[:m], 0.0, free[m:], 1.0, h, by_value(laws), after.stuck, after.force) != DONE:
        return False
    if not same_set(laws, now, after):
        return False
    for j in range(n):
        mean[j] += (0.5 + LOSS) * after.force[j]
    return go(model, laws, slope, P, gain, D, h, mean, now, after, block)


@inner
def moved(model, j, now, after):  # type: ignore[no-untyped-def]
    """Way of channel j in a step."""
    u0 = now.x.reshape(now.x.size)[model.u0 : model.u1]
    u1 = after.x.reshape(after.x.size)[model.u0 : model.u1]
    return dot(model.rows[j], u1) - dot(model.rows[j], u0) + carried(model, j, now, after)


@inner
def carried(model, j, now, after):  # type: ignore[no-untyped-def]
    """What of it the supports make."""
    way = 0.0
    for s in range(now.support.shape[1]):
        way += model.rows_s[j, s] * (after.support[0, s] - now.support[0, s])
    return way


@inner
def go(model, laws, slope, P, gain, D, h, mean, now, after, block):  # type: ignore[no-untyped-def]
    """The step under the mean forces (m + 2 f,), `after.force` being those at its end; False where it is not taken."""
    fill(after.F, 0.0)
    push(model, mean, after.F)
    add(D[0], after.F, 1.0)
    fly(model, P, gain, D, now, after, np.bool_(False))
    add(D[0], after.F, -1.0)
    if under_way(block):
        look_near(block, model, now, after, h, np.bool_(True))
    else:
        look(model, after)
    m, v = now.gap.size, after.x.reshape(after.x.size)[model.v0 : model.v1]
    for i in range(m):
        watched = slope[i] > 0.0 and now.force[i] <= 0.0 and block.is_near[i]
        if watched and dips(now.gap[i], h * now.rate[i], after.gap[i], h * after.rate[i]):
            return False
    fill(after.sliding, 0.0)
    for f in range(after.stuck.size):
        along = 0.0
        for j in range(m + 2 * f, m + 2 * f + 2):
            after.rate[j] = rate_of(model, j, v, after)
            if not after.stuck[f] and after.force[laws.rubs[f]] > 0.0:
                after.sliding[j - m] = after.rate[j]
                along += after.rate[j] * moved(model, j, now, after)
        if along < 0.0:
            return False
    for j in range(mean.size):
        if mean[j] == 0.0:
            continue
        by_supports = carried(model, j, now, after)
        way = after.gap[j] - now.gap[j] if j < m else moved(model, j, now, after)
        after.energy[GIVEN] += mean[j] * (way - by_supports)
        after.energy[EXTERNAL] -= mean[j] * by_supports
        if j >= m and not after.stuck[(j - m) // 2]:
            after.energy[FRICTION] -= mean[j] * way
    fill(after.F, 0.0)
    push(model, after.force, after.F)
    return True


@inner_fast
def push(model, p, F):  # type: ignore[no-untyped-def]
    """F += push' p"""
    for j in range(p.size):
        if p[j] != 0.0:
            force, row = p[j], model.push[j]
            for i in range(F.size):
                F[i] += force * row[i]


@inner_fast
def add(to, what, times):  # type: ignore[no-untyped-def]
    """to += times what"""
    for i in range(to.size):
        to[i] += times * what[i]
