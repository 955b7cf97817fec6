"""The part of the channels' forces that goes on between kicks, in compiled code.

Where parts press at rest, a vibration may be small against what they press by, and nothing of its energy hangs on that.
What the forces p of all channels were when the last long step ended, or at the start, c, acts on through short steps as
it does in long ones, and the kicks are of p - c. Without damping that is the motion that kicks of p give, whatever c
is: half kicks of c before and after a step move each pair, in the middle of its kicks, just as c that goes on does
through the rows by which forces lean (`model.filtered`). But kicks of p throw a pair to and fro by h p / (2 m) about
its rest, and of that it loses some in each step where it is damped: energy by the square of p, given and lost. What is
booked of kicks and long steps, too, differs by some (omega h)^2 p times the way of the vibration.

A channel that opens, or has no force any more, has no such part until the next long step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.books import EXTERNAL, GIVEN
from creak.dynamics.flow.books import in_contact
from creak.dynamics.flow.model import FlowModel
from creak.dynamics.flow.motion import fly
from creak.linalg.compiled import inner, inner_fast
from creak.linalg.loops import acts, fill, put

NONE, NEW, KNOWN = 0, 1, 2


class Steady(NamedTuple):
    """Forces that go on, and what they do together."""

    force: FloatArray
    """(m + 2 f,) c"""
    push: FloatArray
    lean: FloatArray
    """(p1 - p0,) push' c, lean' c"""
    rate: FloatArray
    """(v1 - v0,) rates' c"""
    way: FloatArray
    """(u1 - u0,) rows' c"""
    way_s: FloatArray
    lean_s: FloatArray
    rate_s: FloatArray
    """(n_support,) rows_s' c, lean_s' c, rates_s' c"""
    mark: IntArray
    """(1,) `NONE` act, they are `NEW`, or it is `KNOWN` what they do."""


def new_steady(model: FlowModel) -> Steady:
    """None act."""
    n = model.p1 - model.p0
    return Steady(
        np.zeros(model.rows.shape[0]),
        np.zeros(n),
        np.zeros(n),
        np.zeros(model.v1 - model.v0),
        np.zeros(model.u1 - model.u0),
        np.zeros(model.rows_s.shape[1]),
        np.zeros(model.rows_s.shape[1]),
        np.zeros(model.rows_s.shape[1]),
        np.array([NONE]),
    )


@inner
def go_on_with(steady, force):  # type: ignore[no-untyped-def]
    """These forces go on from now."""
    put(steady.force, 0, force)
    steady.mark[0] = NEW


@inner
def let_go(model, laws, W, h, steady, x, gap):  # type: ignore[no-untyped-def]
    """Nothing goes on where a channel has no force at the instant x, or is open by `gap` (m,); h: step near contact.

    Returns what is to be booked as given: that much less does the kick at x hold (`books.in_contact`).
    """
    m, going = x.gap.size, False
    for i in range(m):
        going = going or (steady.force[i] != 0.0 and (x.force[i] <= 0.0 or gap[i] > 0.0))
    if not going:
        return 0.0
    before = in_contact(model, laws, W, h, x, steady.force)
    for i in range(m):
        if x.force[i] <= 0.0 or gap[i] > 0.0:
            steady.force[i] = 0.0
    for j in range(m, steady.force.size):
        if steady.force[laws.rubs[(j - m) // 2]] == 0.0:
            steady.force[j] = 0.0
    steady.mark[0] = NEW if acts(steady.force, 0, steady.force.size) else NONE
    return before - in_contact(model, laws, W, h, x, steady.force)


@inner
def fly_on(model, P, gain, D, h, steady, now, after, kicked):  # type: ignore[no-untyped-def]
    """`motion.fly` with the forces that go on: in half kicks at both ends they are taken back.

    Returns what they give beyond that: the way that they push, as in a long step, less that of both half kicks.
    """
    if steady.mark[0] == NONE:
        fly(P, gain, D, now, after, kicked)
        return 0.0
    if steady.mark[0] == NEW:
        gather(model, steady)
        steady.mark[0] = KNOWN
    add(now.F, -1.0, steady.push)
    add(D[0], 1.0, steady.lean)
    fly(P, gain, D, now, after, kicked)
    add(D[0], -1.0, steady.lean)
    return take_back(model, gain, h, steady, now, after)


@inner_fast
def gather(model, steady):  # type: ignore[no-untyped-def]
    """What the forces that go on do together."""
    fill(steady.push, 0.0)
    fill(steady.lean, 0.0)
    fill(steady.rate, 0.0)
    fill(steady.way, 0.0)
    fill(steady.way_s, 0.0)
    fill(steady.lean_s, 0.0)
    fill(steady.rate_s, 0.0)
    for j in range(steady.force.size):
        if steady.force[j] != 0.0:
            add(steady.push, steady.force[j], model.push[j])
            add(steady.lean, steady.force[j], model.lean[j])
            add(steady.rate, steady.force[j], model.rates[j])
            add(steady.way, steady.force[j], model.rows[j])
            add(steady.way_s, steady.force[j], model.rows_s[j])
            add(steady.lean_s, steady.force[j], model.lean_s[j])
            add(steady.rate_s, steady.force[j], model.rates_s[j])


@inner_fast
def add(to, by, row):  # type: ignore[no-untyped-def]
    """to += by row"""
    for i in range(to.size):
        to[i] += by * row[i]


@inner_fast
def take_back(model, gain, h, steady, now, after):  # type: ignore[no-untyped-def]
    """The half kick at the end of a step; the work of `fly_on`. Rates: after the half kick at its beginning, and before
    that at its end; forces push the coordinates whose rates channels see (p0:p1 is v0:v1)."""
    z0, z1 = now.x.reshape(now.x.size), after.x.reshape(after.x.size)
    u0, u1, v0, v1 = z0[model.u0 : model.u1], z1[model.u0 : model.u1], z0[model.v0 : model.v1], z1[model.v0 : model.v1]
    work = rates = 0.0
    for i in range(steady.way.size):
        work += steady.way[i] * (u1[i] - u0[i])
    for i in range(steady.rate.size):
        rates += steady.rate[i] * (v0[i] + gain[i] * now.F[i] + v1[i])
    for i in range(steady.push.size):
        v1[i] -= gain[i] * steady.push[i]
    return work - 0.5 * h * rates


@inner
def book_steady(steady, h, given, now, after):  # type: ignore[no-untyped-def]
    """What the forces that go on gave in a step: to the motion (`fly_on`), and to the supports."""
    after.energy[GIVEN] += given
    for a in range(steady.way_s.size):
        way = after.support[0, a] - now.support[0, a]
        kicked = 0.5 * h * (now.support[1, a] + after.support[1, a])
        after.energy[GIVEN] += (steady.way_s[a] - steady.lean_s[a]) * way
        after.energy[EXTERNAL] -= steady.lean_s[a] * way - steady.rate_s[a] * kicked
