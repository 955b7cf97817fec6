"""The channels that press in lasting contact, and the equations of their forces in a long step, in compiled code.

Over a step h, x from -1 to 1 in it, each channel's force is a line in time,

    p(x) = a + b x,

and the structure moves exactly under it. The laws hold at the two points x = -+1/sqrt(3) of Gauss, of the motion seen
as the quadratic with the same gap g0, g1 at both ends and the same mean gap, where a spring k has

    a = -k mean g,        b = -k (g1 - g0) / 2.

The work of p on the structure is then just what the spring stores, -k (g1^2 - g0^2) / 2, whatever the step: stable
without a limit; friction takes what it takes at the two points; the error of a step falls with its fifth power
(energy-conserving time elements: French, Schaeffer, Appl. Math. Comput. 39, 1990; Betsch, Steinmann, Int. J. Numer.
Methods Eng. 49, 2000, with the structure exact here). What sticks neither moves from end to end nor has a speed at the
end. Unknown are the forces alone, a and b of each channel; their few equations hang on which channels press and stick
and on the length of the step, and are inverted once for both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.laws.tabular import segment_at, segment_slope
from creak.dynamics.flow.model import FlowModel, FlowState, resting
from creak.dynamics.flow.motion import fly, mean_of, mean_value, place_of, rate_of, times
from creak.dynamics.loads import Loads
from creak.linalg.compiled import inner, inner_fast, with_arrays
from creak.linalg.loops import dot, fill, put

NEVER = 1 << 40
"""Steps"""
IMMOBILE = 1e-9
"""Response along one tangent over that along the other below which nothing moves there."""
MOST = 600
"""Channels that are held at once: pressures, and two for what rubs."""
ROOM = 1 << 20
"""Numbers that are kept for steps of other lengths."""
LEVEL, WAIT, SAME, PAUSE, CALM, LONG = 0, 1, 2, 3, 4, 5
GAUSS = 1.0 / math.sqrt(3.0)


class Held(NamedTuple):
    """The channels that press, in this order: those across gaps, both tangents of what sticks, both of what slides."""

    ends: IntArray
    """(3,) n, b, c: where in `channel` end those that press, stick, slide."""
    channel: IntArray
    """(c,) of m + 2 f at most"""
    presses: IntArray
    """(c,) of what sticks and slides: where in `channel` what presses it is."""
    piece: IntArray
    slope: FloatArray
    foot: FloatArray
    """(c,) of what presses: the straight piece of its law, on which its force is slope (foot - gap)."""
    known: IntArray
    """(slots,) the level whose response a slot holds, -1: none."""
    response: FloatArray
    """(slots, 4 c c) what a, b of the channels do to what is seen of them: way, then mean or speed."""
    inverse: FloatArray
    """(slots, 4 c c) of the equations of what presses and sticks; then `parts_of` what slides."""
    free: FloatArray
    seen: FloatArray
    """(2 c,) without and with the channels' forces: way of a step; mean way, or h / 2 times the last speed of what
    sticks."""
    force: FloatArray
    """(2 c,) a, then b."""
    right: FloatArray
    bound: FloatArray
    """(2 c,) of the equations."""
    mean: FloatArray
    """(u1 - u0,) of the displacements"""
    middle: FloatArray
    swing: FloatArray
    """(m + 2 f,) running mean of the forces, and what they swing by about it"""
    line: FloatArray
    """(m + 2 f,) forces at the end of the last step: of a long one those of the lines"""
    next: IntArray
    """(6,) `LEVEL`, `WAIT`, `SAME`, `PAUSE`, `CALM`, `LONG`: the level of the step to be tried next; steps near contact
    to it, since a channel last began or ceased to press or to stick, until the next try after one that fails; and those
    since a channel began or ceased to press; whether the last step was a long one."""
    rest: FlowState
    D: FloatArray
    """(4, p1 - p0) at work, for the response."""


def new_held(model: FlowModel, loads: Loads, levels: int, tried: bool) -> Held:
    """For the channels of a model; tried: there may be long steps."""
    channels = model.rows.shape[0] if tried else 0
    size = 4 * min(channels, MOST) ** 2
    slots = levels + 1 if (levels + 1) * size <= ROOM else 1
    whole, none = np.zeros(channels, dtype=np.int64), np.full(slots, -1)
    one, two = np.zeros(channels), np.zeros(2 * channels)
    return Held(
        np.zeros(3, dtype=np.int64),
        whole,
        whole.copy(),
        whole.copy(),
        one,
        one.copy(),
        none,
        np.empty((slots, size)),
        np.empty((slots, size)),
        two,
        two.copy(),
        two.copy(),
        two.copy(),
        two.copy(),
        np.zeros(model.u1 - model.u0),
        one.copy(),
        one.copy(),
        one.copy(),
        np.array([0, 0, 0, 1, 0, 0]),
        resting(model, loads),
        np.zeros((4, model.p1 - model.p0)),
    )


@inner
def is_held(held, laws, now):  # type: ignore[no-untyped-def]
    """Are the channels of `held` those that press and stick now?"""
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    count, stick, slide = 0, n, b
    for i in range(now.gap.size):
        if now.force[i] > 0.0:
            if count >= n or held.channel[count] != i or held.piece[count] != piece_at(laws, i, now.gap[i]):
                return False
            count += 1
    for f in range(now.stuck.size):
        if now.force[laws.rubs[f]] > 0.0:
            sticks = now.stuck[f]
            at = stick if sticks else slide
            if at >= (b if sticks else c) or held.channel[at] != now.gap.size + 2 * f:
                return False
            stick, slide = stick + 2 * sticks, slide + 2 * (not sticks)
    return count == n and stick == b and slide == c


@inner
def piece_at(laws, i, gap):  # type: ignore[no-untyped-def]
    """The straight piece of the law of channel i at a gap."""
    c = laws.curve[i]
    return segment_at(laws.x, laws.start[c], laws.start[c + 1], -gap) if c >= 0 else np.int64(0)


@inner
def hold_piece(held, laws, n, i, gap):  # type: ignore[no-untyped-def]
    """The law of channel i about a gap, as the n-th that presses."""
    held.piece[n], held.slope[n], held.foot[n] = piece_at(laws, i, gap), laws.stiffness[i], 0.0
    c, j = laws.curve[i], held.piece[n]
    if c >= 0:
        steep = segment_slope(laws.x, laws.y, j, laws.start[c], laws.start[c + 1])
        held.slope[n], held.foot[n] = laws.scale[i] * steep, laws.y[j] / steep - laws.x[j]


@inner
def gather(held, laws, now):  # type: ignore[no-untyped-def]
    """Hold the channels that press and stick now."""
    m, at = now.gap.size, 0
    fill(held.known, -1)
    for i in range(m):
        if now.force[i] > 0.0:
            held.channel[at] = i
            hold_piece(held, laws, at, i, now.gap[i])
            at += 1
    held.ends[0] = at
    for sticks in range(1, -1, -1):
        for f in range(now.stuck.size):
            if now.force[laws.rubs[f]] > 0.0 and now.stuck[f] == sticks:
                for tangent in range(2):
                    held.channel[at] = m + 2 * f + tangent
                    for k in range(held.ends[0]):
                        if held.channel[k] == laws.rubs[f]:
                            held.presses[at] = k
                    at += 1
        held.ends[2 - sticks] = at


@inner
def cost(model, laws, now):  # type: ignore[no-untyped-def]
    """Steps near contact that take as long as the equations of what presses now; NEVER of more than `MOST`."""
    c = 0
    for i in range(now.gap.size):
        c += now.force[i] > 0.0
    rubs = 0
    for f in range(now.stuck.size):
        rubs += 2 * (now.force[laws.rubs[f]] > 0.0)
    c += rubs
    if c > MOST:
        return NEVER
    n = model.u1 - model.u0
    kick = n * (20.0 + now.gap.size + 2.0 * c) + 4e3
    if rubs > 0:
        kick += c * c * (15.0 + c / 3.0)  # matrices of Newton, and the factor of one
    return int(c * (6.0 * c * n + 40.0 * n + 16.0 * c * c) / kick)


@inner
def moves(R, n, i):  # type: ignore[no-untyped-def]
    """Does what the tangent i moves hang on its force?"""
    other = n + ((i - n) ^ 1)
    return R[i, i] > 0.0 and R[i, i] > IMMOBILE * R[other, other]


@inner_fast
def lean_on(row, a, b, h, D):  # type: ignore[no-untyped-def]
    """D += row (a + b x), x from -1 to 1 in a step h."""
    D0, D1, begin, slope = D[0], D[1], a - b, 2.0 / h * b
    for i in range(row.size):
        D0[i] += begin * row[i]
        D1[i] += slope * row[i]


@with_arrays
def respond(model, laws, P, gain, h, held, slot, moved):  # type: ignore[no-untyped-def]
    """Responses to the channels' forces in a step h, and the inverse of the equations of what presses and sticks.

    moved: an instant to work with.
    """
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    R = held.response[slot][: 4 * c * c].reshape((2 * c, 2 * c))
    D = held.D
    for j in range(2 * c):
        fill(D[0], 0.0)
        fill(D[1], 0.0)
        lean_on(model.lean[held.channel[j % c]], 1.0 if j < c else 0.0, 0.0 if j < c else 1.0, h, D)
        fly(P, gain, D, held.rest, moved, np.bool_(False))
        mean_of(P, D, held.rest, held.mean)
        z = moved.x.reshape(moved.x.size)
        u, v = z[model.u0 : model.u1], z[model.v0 : model.v1]
        for i in range(c):
            R[i, j] = dot(model.rows[held.channel[i]], u)
            if n <= i < b:
                R[c + i, j] = 0.5 * h * dot(model.rates[held.channel[i]], v)
            else:
                R[c + i, j] = dot(model.rows[held.channel[i]], held.mean)
    E = np.empty((2 * b, 2 * c))
    for i in range(b):
        damper = laws.damping[held.channel[i]] / (h * held.slope[i]) if i < n else 0.0
        held_fast = i >= n and not moves(R, n, i)
        for j in range(2 * c):
            way, mean = R[i, j], R[c + i, j]
            if i < n:
                E[i, j], E[b + i, j] = mean + damper * way, 0.5 * way + 3.0 * damper * (way - 2.0 * mean)
            elif held_fast:
                E[i, j] = E[b + i, j] = 0.0
            else:
                E[i, j], E[b + i, j] = way, mean
    K = np.empty((2 * b, 2 * b))
    for i in range(2 * b):
        put(K[i], 0, E[i, :b])
        put(K[i], b, E[i, c : c + b])
    for i in range(b):
        if i < n:
            K[i, i] += 1.0 / held.slope[i]
            K[b + i, b + i] += 1.0 / held.slope[i]
        elif moves(R, n, i):
            k = model.give[held.channel[i] - model.gap0.size]
            K[i, i] += k
            K[i, b + i] += k
            K[b + i, i] -= k
            K[b + i, b + i] += k
        else:
            K[i, i] = K[b + i, b + i] = 1.0
    inverse = np.linalg.inv(K)
    for i in range(2 * b):
        put(held.inverse[slot], 2 * b * i, inverse[i])
    if c > b:
        beside(held, slot, R, inverse, E)


@with_arrays
def beside(held, slot, R, inverse, E):  # type: ignore[no-untyped-def]
    """What the forces of sliding do through those of pressing and sticking; E (2b, 2c) of the latter's equations."""
    b, c = held.ends[1], held.ends[2]
    s = c - b
    to, by = parts_of(held, slot)
    for i in range(2 * b):
        row = to[i]
        fill(row, 0.0)
        for k in range(2 * b):
            share = inverse[i, k]
            for j in range(s):
                row[j] -= share * E[k, b + j]
                row[s + j] -= share * E[k, c + b + j]
    for i in range(2 * s):
        row = R[b + i if i < s else c + b + i - s]
        for j in range(2 * s):
            by[i, j] = row[b + j if j < s else c + b + j - s]
            for k in range(b):
                by[i, j] += row[k] * to[k, j] + row[c + k] * to[b + k, j]


@inner
def parts_of(held, slot):  # type: ignore[no-untyped-def]
    """(2b, 2s) forces of pressing and sticking, and (2s, 2s) what is seen of sliding, over the 2s forces of sliding."""
    b, s = held.ends[1], held.ends[2] - held.ends[1]
    first, kept = 4 * b * b, held.inverse[slot]
    to = kept[first : first + 4 * b * s].reshape((2 * b, 2 * s))
    return to, kept[first + 4 * b * s : first + 4 * s * (b + s)].reshape((2 * s, 2 * s))


@inner
def see(model, held, course, h, now, after):  # type: ignore[no-untyped-def]
    """What the channels see of the motion from now to after without their forces, into held.free."""
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    z0, z1 = now.x.reshape(now.x.size), after.x.reshape(after.x.size)
    u0, u1, v1 = z0[model.u0 : model.u1], z1[model.u0 : model.u1], z1[model.v0 : model.v1]
    for i in range(c):
        q = held.channel[i]
        before = now.gap[q] - model.gap0[q] if i < n else place_of(model, q, u0, now, 0.0)
        held.free[i] = place_of(model, q, u1, after, -before)
        if n <= i < b:
            held.free[c + i] = 0.5 * h * rate_of(model, q, v1, after)
        else:
            mean = dot(model.rows[q], held.mean) - before
            for a in range(course.shape[0]):
                mean += model.rows_s[q, a] * mean_value(course[a], h)
            held.free[c + i] = mean


@inner
def bind(model, laws, held, slot, h, now):  # type: ignore[no-untyped-def]
    """Forces of what presses and sticks beside those of what slides, and what all channels then see."""
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    R = held.response[slot][: 4 * c * c].reshape((2 * c, 2 * c))
    force, free, seen = held.force, held.free, held.seen
    for i in range(2 * c):
        seen[i] = free[i]
        for j in range(b, c):
            seen[i] += R[i, j] * force[j] + R[i, c + j] * force[c + j]
    right = held.right[: 2 * b]
    for i in range(b):
        q = held.channel[i]
        if i < n:
            damper = laws.damping[q] / (h * held.slope[i])
            right[i] = held.foot[i] - now.gap[q] - seen[c + i] - damper * seen[i]
            right[b + i] = -0.5 * seen[i] - 3.0 * damper * (seen[i] - 2.0 * seen[c + i])
        elif moves(R, n, i):
            give = model.give[q - model.gap0.size] * now.force[q]
            right[i] = give - seen[i]
            right[b + i] = -give - seen[c + i]
        else:
            right[i] = right[b + i] = 0.0
    times(held.inverse[slot][: 4 * b * b].reshape((2 * b, 2 * b)), right, held.bound[: 2 * b])
    for i in range(b):
        force[i], force[c + i] = held.bound[i], held.bound[b + i]
    for i in range(2 * c):
        for j in range(b):
            seen[i] += R[i, j] * force[j] + R[i, c + j] * force[c + j]


@inner
def rate_at(held, i, c, h, x):  # type: ignore[no-untyped-def]
    """Rate of channel i at x, from -1 to 1 in a step h, of the quadratic through what is seen of it."""
    way, mean = held.seen[i], held.seen[c + i]
    return (way + 3.0 * x * (way - 2.0 * mean)) / h
