"""Contact in blocks, in compiled code: a channel that cannot close in a block is not looked at in each of its steps.

With gap g, rate r, energies E_b of the bands of modes at the start of a block of length T, a channel i stays open if

    g + min(r, 0) T - sum_b off_b sqrt(2 E_b) - |G_s s''| T^2 / 2 - w_i T sum_j w_j P_j > 0,     w_i^2 = W_ii,

since an impulse P_j moves gap i at most at w_i w_j P_j (Cauchy-Schwarz on the modes). The impulses of the block are not
known before: they get a budget, and the block ends where it is spent. So no touch is missed, and nothing is done twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.dynamics.flow.motion import band_energies, gap_of, rate_of
from creak.linalg.compiled import inner
from creak.linalg.loops import acts

STEPS = (1024, 512, 256, 128, 64, 32, 16)
"""Steps near contact of a block."""
SHORT = 128
"""The longest where contact does not last: its impulses are not known beforehand."""
APART = 8
"""Steps near contact between two instants at which a block may begin."""
FEWEST = 8
"""Channels from which on blocks are worth it."""
MORE = 2.0
"""Budget of impulse over what the forces at the start of a block give in it."""
NEAR, END, ROW, KNOWN = 0, 1, 2, 3


class Block(NamedTuple):
    """The block that is under way, if any."""

    length: int
    """Of the longest, in steps near contact; 0: there are none."""
    off: FloatArray
    """(n_length, n_band, m) distance of a gap from a straight line in T, over sqrt(2 energy); each half as long as the
    one before."""
    width: FloatArray
    """(m + 2 f,) w."""
    near: IntArray
    """(m,) channels that may close; the first `mark[NEAR]` count."""
    is_near: BoolArray
    """(m,) those, all outside a block."""
    mark: IntArray
    """(4,) channels that may close, -1 outside a block; the part of the flight step at which it ends; the first row of
    the table that may lie in it; are rates of open channels known?"""
    left: FloatArray
    """(2,) of the budget, and the time at the start."""
    gap: FloatArray
    rate: FloatArray
    """(m,) at the start"""


def new_block(length: int, off: FloatArray, width: FloatArray) -> Block:
    """None under way."""
    m = off.shape[2]
    mark = np.array([-1, 0, 0, 0])
    near, is_near = np.zeros(m, dtype=np.int64), np.ones(m, dtype=np.bool_)
    return Block(length, off, width, near, is_near, mark, np.zeros(2), np.zeros(m), np.zeros(m))


@inner
def open_block(block, model, slope, band, D, energy, course, h, time, used, at, now, lasts):  # type: ignore[no-untyped-def]
    """Begin a block at the instant `now`, as long as it takes the fewest looks, where that is worth it.

    Looks at a channel are counted: in each step at those that may close, at all some three times for a block. lasts:
    long steps may be taken in it.
    """
    m = now.gap.size
    if block.mark[KNOWN] == 0:
        look_open(model, now)
    band_energies(model, band, D, h * block.length, now, energy)
    fewest, best, steps = 0.75 * m, -1, block.length
    for n in range(block.off.shape[0]):
        if block.length >> n > SHORT and not lasts:
            continue
        count, _ = may_close_within(block, n, model, slope, energy, course, h, now)
        looks = count + 3.0 * m / (block.length >> n)
        if looks < fewest:
            fewest, best, steps = looks, n, block.length >> n
    if best < 0:
        for i in range(m):
            block.is_near[i] = True
        return
    # best is a plain -1 at first: handed on as such it would have the call compiled twice
    count, budget = may_close_within(block, np.int64(best), model, slope, energy, course, h, now)
    for i in range(m):
        block.gap[i], block.rate[i] = now.gap[i], now.rate[i]
    block.mark[NEAR], block.mark[END], block.mark[ROW] = count, (at // steps + 1) * steps, used
    block.left[0], block.left[1] = budget, time


@inner
def may_close_within(block, n, model, slope, energy, course, h, now):  # type: ignore[no-untyped-def]
    """Channels that may close in the n-th length of blocks, put down in the block; their number, and the budget."""
    m, T, lowest = now.gap.size, (block.length >> n) * h, block.gap
    forces = 0.0
    for j in range(now.force.size):
        forces += abs(now.force[j]) * block.width[j]
    budget = MORE * T * forces
    for i in range(m):
        lowest[i] = lowest_within(i, T, block.off[n], model, energy, course, now)
        if slope[i] > 0.0 and lowest[i] <= 0.0 and now.force[i] <= 0.0:  # a touch that is new
            budget += 0.5 * T * T * slope[i] * max(-now.rate[i], 0.0) * block.width[i]
    count = 0
    for i in range(m):
        can = lowest[i] <= block.width[i] * T * budget or now.force[i] > 0.0 or model.preload[i] > 0.0
        block.is_near[i] = can and slope[i] > 0.0
        if block.is_near[i]:
            block.near[count] = i
            count += 1
    return count, budget - h * forces


@inner
def lowest_within(i, T, off, model, energy, course, now):  # type: ignore[no-untyped-def]
    """Bound of gap i in the next T without impulses; off (n_band, m)."""
    lowest = now.gap[i] + min(now.rate[i], 0.0) * T
    for b in range(energy.size):
        lowest -= off[b, i] * energy[b]
    for a in range(now.support.shape[1]):
        p = course[a]
        turns = abs(p[2]) + T * (abs(p[3]) + T * (0.5 * abs(p[4]) + T / 6.0 * abs(p[5])))
        lowest -= 0.5 * T * T * abs(model.rows_s[i, a]) * turns
    return lowest


@inner
def under_way(block):  # type: ignore[no-untyped-def]
    return block.mark[NEAR] >= 0


@inner
def ends(block, h, at, after):  # type: ignore[no-untyped-def]
    """Does the block end at the instant `after`, where steps (h long) have led to part `at`?"""
    for j in range(after.force.size):
        block.left[0] -= h * abs(after.force[j]) * block.width[j]
    return at >= block.mark[END] or block.left[0] <= 0.0 or not acts(after.force, 0, after.force.size)


@inner
def close_block(block, model, after):  # type: ignore[no-untyped-def]
    """Look at the gaps that were left out, and at all rates of open channels."""
    u = after.x.reshape(after.x.size)[model.u0 : model.u1]
    for i in range(after.gap.size):
        if not block.is_near[i]:
            after.gap[i] = gap_of(model, i, u, after)
    look_open(model, after)


@inner
def amend(block, table, used, time, after):  # type: ignore[no-untyped-def]
    """Gaps that were left out, in the rows of a block that ended at `after`: cubics through its ends."""
    T = time - block.left[1]
    for r in range(block.mark[ROW], used):
        x = (table[r, 0] - block.left[1]) / T
        if x < 0.0 or x > 1.0:
            continue
        for i in range(after.gap.size):
            if not block.is_near[i]:
                table[r, 1 + i] = cubic(x, block.gap[i], T * block.rate[i], after.gap[i], T * after.rate[i])
    block.mark[NEAR] = -1
    for i in range(block.is_near.size):
        block.is_near[i] = True


@inner
def cubic(x, g0, d0, g1, d1):  # type: ignore[no-untyped-def]
    """At x from 0 to 1, through values g and slopes d at both ends."""
    return g0 + x * (d0 + x * (3.0 * (g1 - g0) - 2.0 * d0 - d1 + x * (2.0 * (g0 - g1) + d0 + d1)))


@inner
def look_near(block, model, now, after, h, rated):  # type: ignore[no-untyped-def]
    """Gaps, and their rates where asked for, of the channels that may close; the others go on in straight lines."""
    for i in range(after.gap.size):
        if not block.is_near[i]:
            after.gap[i], after.rate[i] = now.gap[i] + h * now.rate[i], now.rate[i]
    z = after.x.reshape(after.x.size)
    for n in range(block.mark[NEAR]):
        i = block.near[n]
        after.gap[i] = gap_of(model, i, z[model.u0 : model.u1], after)
        if rated:
            after.rate[i] = rate_of(model, i, z[model.v0 : model.v1], after)


@inner
def look_watched(block, model, now):  # type: ignore[no-untyped-def]
    """Rates of all channels that may close in the block, or of all where none is under way."""
    v = now.x.reshape(now.x.size)[model.v0 : model.v1]
    for i in range(now.gap.size):
        if block.is_near[i]:
            now.rate[i] = rate_of(model, i, v, now)


@inner
def look_open(model, after):  # type: ignore[no-untyped-def]
    """Rates of the channels without force."""
    v = after.x.reshape(after.x.size)[model.v0 : model.v1]
    for i in range(after.gap.size):
        if after.force[i] == 0.0:
            after.rate[i] = rate_of(model, i, v, after)
