"""Which instants of a march are kept, in compiled code: as many as the course of contact needs, not as many as steps.

Kept are the ends of flight steps, both sides of every change of contact (a channel opens, closes, sticks, slips), the
largest force between two changes, and so many instants besides that straight lines through them pass all others within
`CLOSE` of the largest value since the last change, for gap, force and sliding of every channel. The lines are found on
the way: the slopes that from the last kept instant on pass within reach of all since form a cone; where an instant
leaves it, the one before is kept (swinging door: Bristol, ISA Adv. Instrum. 45, 1990).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray
from creak.contact.step_problem import spring_force
from creak.dynamics.books import SCHEME
from creak.dynamics.flow.block import cubic
from creak.dynamics.flow.held import rate_at
from creak.linalg.compiled import inner
from creak.linalg.loops import fill, put

CLOSE = 1e-5
"""Of the largest value since contact last changed."""
SUDDEN = 1 / 1024
"""Least share of a step in which the force of a damper rises as it touches, and that is left of it then."""


class Cone(NamedTuple):
    """Slopes that are still possible from the last kept instant."""

    at: FloatArray
    """(1,) its time, s"""
    tip: FloatArray
    """(w,) gaps, forces, sliding there."""
    low: FloatArray
    high: FloatArray
    top: FloatArray
    """(w,) largest values since contact last changed."""
    now: FloatArray
    after: FloatArray
    """(w,) at both ends of the step."""


def new_cone(width: int) -> Cone:
    """For `width` columns."""
    return Cone(np.zeros(1), *(np.zeros(width) for _ in range(6)))


@inner
def courses(x, out):  # type: ignore[no-untyped-def]
    """Gaps, mean forces and sliding of an instant side by side."""
    put(out, put(out, put(out, 0, x.gap), x.mean), x.sliding)


@inner
def restart(cone, time, x, fresh):  # type: ignore[no-untyped-def]
    """The instant x is kept; `fresh`: contact changes there."""
    courses(x, cone.tip)
    begin(cone, time, fresh)


@inner
def begin(cone, time, fresh):  # type: ignore[no-untyped-def]
    """Lines from the tip, kept at a time, on."""
    cone.at[0] = time
    for j in range(cone.tip.size):
        cone.low[j], cone.high[j] = -np.inf, np.inf
        cone.top[j] = abs(cone.tip[j]) if fresh else max(cone.top[j], abs(cone.tip[j]))


@inner
def changes(now, after):  # type: ignore[no-untyped-def]
    """Does a channel open, close, stick or slip between two instants?"""
    for i in range(now.gap.size):
        if (now.force[i] > 0.0) != (after.force[i] > 0.0):
            return True
    for i in range(now.stuck.size):  # noqa: SIM110 (compiled)
        if now.stuck[i] != after.stuck[i]:
            return True
    return False


@inner
def bends(cone, time, now, time_after, after):  # type: ignore[no-untyped-def]
    """Is no line left from the last kept instant to `after` that passes all others, `now` the last of them?"""
    courses(now, cone.now)
    courses(after, cone.after)
    bent, m = False, now.gap.size
    for j in range(cone.tip.size):
        largest = m <= j < m + now.force.size and cone.now[j] >= cone.top[j] and cone.after[j] < cone.now[j]
        cone.top[j] = max(cone.top[j], abs(cone.now[j]))
        off, passed = CLOSE * cone.top[j], time - cone.at[0]
        cone.low[j] = max(cone.low[j], (cone.now[j] - off - cone.tip[j]) / passed)
        cone.high[j] = min(cone.high[j], (cone.now[j] + off - cone.tip[j]) / passed)
        slope = (cone.after[j] - cone.tip[j]) / (time_after - cone.at[0])
        bent = bent or largest or slope < cone.low[j] or slope > cone.high[j]
    return bent


@inner
def write(out, row, time, x):  # type: ignore[no-untyped-def]
    """An instant as a row of the table, with the mean forces of its kick: times the steps they are the impulse."""
    to = out.table[row]
    to[0] = time
    at = put(to, put(to, put(to, 1, x.gap), x.mean), x.sliding)
    for i in range(SCHEME + 1):
        to[at + i] = x.energy[i]


@inner
def share_taken(laws, i, now, after):  # type: ignore[no-untyped-def]
    """Share of the first half of its kick that a channel with a damper has, which touched in the step; else 0."""
    if laws.damping[i] == 0.0 or after.force[i] <= 0.0 or now.force[i] > 0.0 or now.gap[i] < 0.0:
        return 0.0
    return 2.0 * after.mean[i] / after.force[i] - 1.0


@inner
def write_touch(laws, time, h, now, after, out, used):  # type: ignore[no-untyped-def]
    """A row between two instants where a damper touches in the first half of the step: its force is there at once.

    A step h gives the share s of F h / 2. A line from 0 at its start to F at s - 1 steps before its end, and F from
    there on, is that impulse. So `after` has F, and not the mean (1 + s) F / 2 of its kick, which is more. What does
    not touch like that goes in straight lines, so that its impulse stays, too. Returns the rows then used.
    """
    m, late, hardest = now.gap.size, 0.0, 0.0
    for i in range(m):
        share = share_taken(laws, i, now, after)
        if share > 1.0 + SUDDEN and after.force[i] > hardest:
            hardest, late = after.force[i], min(share - 1.0, 1.0 - SUDDEN)
    if hardest == 0.0:
        return used
    row, sliding = out.table[used], 1 + m + now.force.size
    put(row, 0, out.table[used - 1])
    row[0] = time + (1.0 - late) * h
    for i in range(m):
        row[1 + i] = late * now.gap[i] + (1.0 - late) * after.gap[i]
    for j in range(now.force.size - 1, -1, -1):  # pressure last: friction has its share
        i = j if j < m else laws.rubs[(j - m) // 2]
        own = share_taken(laws, i, now, after) - late
        row[1 + m + j] = late * now.mean[j] + (1.0 - late) * after.mean[j]
        if j >= m:
            row[sliding + j - m] = late * now.sliding[j - m] + (1.0 - late) * after.sliding[j - m]
        if 0.0 < own <= 1.0 + SUDDEN:
            row[1 + m + j], after.mean[j] = own * after.force[j], after.force[j]
            if j >= m:
                row[sliding + j - m] = after.sliding[j - m]
    return used + 1


@inner
def pieces(held, cone, most):  # type: ignore[no-untyped-def]
    """Straight lines, `most` at most, that pass the forces of a long step within `CLOSE` of the largest."""
    n, c, m, worst = held.ends[0], held.ends[2], held.rest.gap.size, 0.0
    for i in range(n):
        q = held.channel[i]
        top = max(cone.top[m + q], abs(held.line[q]))
        curve = 0.75 * held.slope[i] * abs(held.seen[i] - 2.0 * held.seen[c + i])
        worst = max(worst, curve / (CLOSE * top) if curve > 0.0 else 0.0)
    return min(most, math.ceil(math.sqrt(worst)))


@inner
def write_between(laws, held, cone, count, time, h, now, after, out, used):  # type: ignore[no-untyped-def]
    """Rows of the instants between the ends of a long step that part it into `count`, from row `used` on; the next."""
    n, b, c = held.ends[0], held.ends[1], held.ends[2]
    m, sliding = now.gap.size, 1 + now.gap.size + now.force.size
    for k in range(1, count):
        share, row = k / count, out.table[used]
        x = 2.0 * share - 1.0
        fill(row, 0.0)
        row[0] = time + share * h
        for i in range(m):
            row[1 + i] = cubic(share, now.gap[i], h * now.rate[i], after.gap[i], h * after.rate[i])
        for i in range(c):
            q, way, mean = held.channel[i], held.seen[i], held.seen[c + i]
            if i < n:
                row[1 + q] = now.gap[q] + share * way + 0.75 * (way - 2.0 * mean) * (x * x - 1.0)
                damper = laws.damping[q] * rate_at(held, i, c, h, x)
                row[1 + m + q] = max(0.0, spring_force(laws, q, row[1 + q]) - damper)
            else:
                row[1 + m + q] = held.force[i] + x * held.force[c + i]
            if i >= b:
                row[sliding + q - m] = rate_at(held, i, c, h, x)
        for j in range(SCHEME + 1):
            row[sliding + now.sliding.size + j] = now.energy[j] + share * (after.energy[j] - now.energy[j])
        used += 1
    last = out.table[used - 1]
    for j in range(cone.tip.size):
        cone.tip[j] = last[1 + j]
    begin(cone, last[0], np.bool_(False))
    return used
