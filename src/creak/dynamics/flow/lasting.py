"""Contact that lasts, in compiled code: long steps while the same channels press, stick and slide (`held`).

A step is as long as the forces are lines: they are made from the step alone, so they jump against those of the step
before by what a line leaves out; where that is too much of what the forces swing by, the step is not taken but half of
it is tried. So is a step in which another channel may close, or one opens, comes to another piece of its curve, begins
or ceases to slide, or turns round; the shortest belong to the kicks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from creak.contact.laws.friction import coefficient
from creak.contact.step_problem import spring_force
from creak.dynamics.books import CONTACT_DAMPING, EXTERNAL, FRICTION, GIVEN
from creak.dynamics.closing import dips
from creak.dynamics.flow.block import END, look_near, under_way
from creak.dynamics.flow.held import (
    CALM,
    GAUSS,
    LEVEL,
    LONG,
    PAUSE,
    SAME,
    WAIT,
    bind,
    cost,
    gather,
    is_held,
    lean_on,
    moves,
    piece_at,
    rate_at,
    respond,
    see,
)
from creak.dynamics.flow.motion import fly, look, mean_of, mean_value, quiet, rate_of, settle_supports
from creak.dynamics.flow.slides import slide
from creak.linalg.compiled import inner, inner_fast
from creak.linalg.loops import put

PATIENCE = 4
"""Steps near contact that the same channels press before a long one is tried. Kicks keep the energy less
(h^2 / 8) p W p, so a force p is to be small against that of the blow when long steps begin."""
SHORTEST = 1.0
"""Product of the shortest long step and the frequency of the contact springs, less than twice: at 1/4 for the step near
contact it costs as much as its four kicks, and where it is longer a line follows no vibration of the contact."""
STIFF = 8.0
"""Largest product of a long step and the frequency of the contact springs: between its ends what a spring holds moves
as if it were free, and a line that misses the force by e leaves it e omega h / 60 of a vibration."""
MEMORY = 8.0
"""Flight steps over which the swing of the forces is remembered."""
STILL = 1e-5
"""Jump over all forces together that is allowed whatever they swing by: what is left of a blow would keep the march in
kicks for long, and a hundred-thousandth of the load is nothing to anyone."""
EASY = 0.125
"""Jump over what is allowed from which on a step of twice the length is tried: its jump is eight times as large."""
FIRST_PAUSE, LAST_PAUSE = 4, 64
"""Steps near contact to the next try after one that failed: twice as many each time."""


class Lasting(NamedTuple):
    """What is asked of long steps."""

    tried: bool
    first: int
    """Level of the longest."""
    last: int
    """Level of the shortest."""
    jump: float
    """Largest of all forces together, over what they swing by."""


@inner
def same_pressing(now, after):  # type: ignore[no-untyped-def]
    """Do the same channels press at both instants?"""
    for i in range(now.gap.size):  # noqa: SIM110 (compiled)
        if (now.force[i] > 0.0) != (after.force[i] > 0.0):
            return False
    return True


@inner
def rests(model, now):  # type: ignore[no-untyped-def]
    """Does every channel that presses do so at rest?"""
    for i in range(now.gap.size):  # noqa: SIM110 (compiled)
        if now.force[i] > 0.0 and model.preload[i] <= 0.0:
            return False
    return True


@inner
def follow_swing(held, h, H, force):  # type: ignore[no-untyped-def]
    """The running means of the forces, and what they swing by about them, after a step h."""
    share = min(1.0, h / (MEMORY * H))
    for j in range(force.size):
        held.middle[j] += share * (force[j] - held.middle[j])
        held.swing[j] = max(abs(force[j] - held.middle[j]), (1.0 - share) * held.swing[j])


@inner
def wait_on(held, changed, now, after):  # type: ignore[no-untyped-def]
    """After a step near contact; changed: a channel began or ceased to press or to stick."""
    put(held.line, 0, after.force)
    held.next[WAIT] -= 1
    held.next[SAME] += 1
    held.next[CALM] = held.next[CALM] + 1 if not changed or same_pressing(now, after) else 0
    if changed:
        held.next[WAIT], held.next[SAME], held.next[PAUSE] = 0, 0, FIRST_PAUSE


@inner
def hold_on(model, scheme, desk, at, now, after, block):  # type: ignore[no-untyped-def]
    """The longest step that the channels go on as they are from part `at` of a flight step: its level, -1 of none."""
    held, laws, lasting = desk.together, scheme.laws, scheme.lasting
    next_, levels = held.next, scheme.P.shape[0] - 1
    parts, level = 1 << levels, max(next_[LEVEL], lasting.first)
    if not is_held(held, laws, now):
        early = cost(model, laws, now) - next_[SAME]
        if early > 0:
            next_[WAIT] = early
            return -1
        gather(held, laws, now)
    end = block.mark[END] if under_way(block) else parts
    while level < levels and (at % (parts >> level) != 0 or at + (parts >> level) > end):
        level += 1
    if level > lasting.last:  # where such a step may begin is ahead
        return -1
    begin = desk.later
    put(begin.x[0], 0, now.x[0])
    put(begin.x[1], 0, now.x[1])
    if not next_[LONG]:
        throw(model, desk.steady, -1.0, now, begin.x)
    while level <= lasting.last:
        jump = hold(model, scheme, desk, level, scheme.H / (1 << level), begin, now, after, block)
        if jump <= 1.0:
            easy = jump <= EASY and level > 0
            next_[LEVEL], next_[WAIT], next_[PAUSE] = level - 1 if easy else level, 0, FIRST_PAUSE
            return level
        level += 1
    next_[LEVEL], next_[WAIT] = lasting.last, next_[PAUSE]
    next_[PAUSE] = min(2 * next_[PAUSE], LAST_PAUSE)
    return -1


@inner_fast
def throw(model, steady, sign, at, x):  # type: ignore[no-untyped-def]
    """z (2, n) += sign times what the kicks of an instant throw up, beyond the motion under forces that go on."""
    z = x.reshape(x.size)[model.p0 : model.p1]
    for j in range(at.force.size):
        kicked = sign * (at.force[j] - steady.force[j])
        if kicked != 0.0:
            row = model.thrown[j]
            for i in range(row.size):
                z[i] += kicked * row[i]


@inner
def into_kicks(model, steady, now):  # type: ignore[no-untyped-def]
    """Kicks go on from the end of a long step."""
    throw(model, steady, 1.0, now, now.x)
    v = now.x.reshape(now.x.size)[model.v0 : model.v1]
    for i in range(now.rate.size):
        now.rate[i] = rate_of(model, i, v, now)


@inner
def hold(model, scheme, desk, level, h, begin, now, after, block):  # type: ignore[no-untyped-def]
    """A long step: its jump over what is allowed; more than 1, and nothing is done, where one channel would not go on
    as it is, or a force is no line. begin: with z as forces that go on would have it now."""
    held, laws, P, gain, D = desk.together, scheme.laws, scheme.P[level], scheme.gain, desk.D
    slot = level % held.known.size
    if held.known[slot] != level:
        respond(model, laws, P, gain, h, held, slot, after)
        held.known[slot] = level
    fly(P, gain, D, begin, after, np.bool_(False))
    mean_of(P, D, begin, held.mean)
    settle_supports(desk.course, h, after)
    see(model, held, desk.course, h, now, after)
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    R = held.response[slot][: 4 * c * c].reshape((2 * c, 2 * c))
    for i in range(n, b):
        if held.free[i] != 0.0 and not moves(R, n, i):
            return np.inf
    for i in range(b, c):
        held.force[i] = held.force[c + i] = 0.0
    bind(model, laws, held, slot, h, now)
    if c > b:
        if not slide(laws, held, slot, h, now):
            return np.inf
        bind(model, laws, held, slot, h, now)
    jump = jump_of(held, scheme.lasting, now)
    if not jump <= 1.0 or not stays(laws, held, h, now) or (under_way(block) and spent(held, c, h, block)):
        return np.inf
    return jump if go(model, scheme, desk, P, h, begin, now, after, block) else np.inf


@inner
def jump_of(held, lasting, now):  # type: ignore[no-untyped-def]
    """Jump of all forces against the lines of the step before, over what is allowed."""
    c, force = held.ends[2], held.force
    jump = total = swing = 0.0
    for i in range(c):
        q = held.channel[i]
        jump += abs(force[i] - force[c + i] - held.line[q])
        total += abs(now.force[q])
        swing += held.swing[q]
    return jump / (lasting.jump * min(swing, total) + STILL * total)


@inner
def stays(laws, held, h, now):  # type: ignore[no-untyped-def]
    """Do all channels go on as they are?"""
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    force, m = held.force, now.gap.size
    for i in range(n):
        q = held.channel[i]
        if force[i] <= abs(force[c + i]) or piece_at(laws, q, now.gap[q] + held.seen[i]) != held.piece[i]:
            return False
    for at in range(n, b, 2):
        p, f = held.presses[at], (held.channel[at] - m) // 2
        most = coefficient(0.0, laws.mu_static[f], laws.mu_kinetic[f], laws.decay[f], True)
        for x in (-1.0, 1.0):
            along = math.hypot(force[at] + x * force[c + at], force[at + 1] + x * force[c + at + 1])
            if along > most * (force[p] + x * force[c + p]):
                return False
    for at in range(b, c, 2):
        v0, v1 = now.rate[held.channel[at]], now.rate[held.channel[at + 1]]
        for x in (-GAUSS, GAUSS, 1.0):
            w0, w1 = rate_at(held, at, c, h, x), rate_at(held, at + 1, c, h, x)
            pushes = (force[at] + x * force[c + at]) * w0 + (force[at + 1] + x * force[c + at + 1]) * w1 > 0.0
            if v0 * w0 + v1 * w1 <= 0.0 or (pushes and x < 1.0):
                return False
    return True


@inner
def spent(held, c, h, block):  # type: ignore[no-untyped-def]
    """Would the step's impulses spend what is left of the budget of a block?"""
    left = block.left[0]
    for i in range(c):
        left -= h * (abs(held.force[i]) + abs(held.force[c + i])) * block.width[held.channel[i]]
    return left <= 0.0


@inner
def go(model, scheme, desk, P, h, begin, now, after, block):  # type: ignore[no-untyped-def]
    """The step under the channels' forces; False where another one closes in it."""
    held, laws, gain, D, course = desk.together, scheme.laws, scheme.gain, desk.D, desk.course
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    quiet(after)
    put(after.stuck, 0, now.stuck)
    load(model, held, c, h, 1.0, D)
    fly(P, gain, D, begin, after, np.bool_(False))
    mean_of(P, D, begin, held.mean)
    load(model, held, c, h, -1.0, D)
    if under_way(block):
        look_near(block, model, now, after, h, np.bool_(True))
    else:
        look(model, after)
    for i in range(now.gap.size):
        watched = scheme.slope[i] > 0.0 and now.force[i] <= 0.0 and block.is_near[i]
        if watched and dips(now.gap[i], h * now.rate[i], after.gap[i], h * after.rate[i]):
            return False
    v = after.x.reshape(after.x.size)[model.v0 : model.v1]
    for j in range(now.gap.size, now.force.size):
        after.rate[j] = rate_of(model, j, v, after)
    put(held.line, 0, after.force)
    for i in range(c):
        q, a, b1 = held.channel[i], held.force[i], held.force[c + i]
        held.line[q] = a + b1
        after.force[q] = a + b1
        if i < n:
            after.force[q] = max(0.0, spring_force(laws, q, after.gap[q]) - laws.damping[q] * after.rate[q])
        way, mean = held.seen[i], held.seen[c + i]
        turn = way - 2.0 * mean
        if n <= i < b:
            way, turn = 0.0, 0.0
        elif i >= b:
            after.sliding[q - now.gap.size] = after.rate[q]
            after.energy[FRICTION] -= a * way + b1 * turn
        else:
            after.energy[CONTACT_DAMPING] += laws.damping[q] * (way * way + 3.0 * turn * turn) / h
        carried = turned = 0.0
        for j in range(now.support.shape[1]):
            s0, s1 = now.support[0, j], after.support[0, j]
            carried += model.lean_s[q, j] * (s1 - s0)
            turned += model.lean_s[q, j] * (s0 + s1 - 2.0 * mean_value(course[j], h))
        after.energy[GIVEN] += a * (way - carried) + b1 * (turn - turned)
        after.energy[EXTERNAL] -= a * carried + b1 * turned
    put(after.mean, 0, after.force)
    push(model, after.force, after.F)
    return True


@inner
def load(model, held, c, h, sign, D):  # type: ignore[no-untyped-def]
    """D += sign lean' (a + b x), x from -1 to 1 in a step h."""
    for j in range(c):
        lean_on(model.lean[held.channel[j]], sign * held.force[j], sign * held.force[c + j], h, D)


@inner_fast
def push(model, p, F):  # type: ignore[no-untyped-def]
    """F += push' p"""
    for j in range(p.size):
        if p[j] != 0.0:
            force, row = p[j], model.push[j]
            for i in range(F.size):
                F[i] += force * row[i]
