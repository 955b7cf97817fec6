"""Looks, kicks and blocks of contact by the threads of a block: what `flow.motion`, `flow.kicks`, `flow.block` and
`flow.lasting` do one after the other, of springs alone. The arithmetic is theirs.
"""

from __future__ import annotations

import math

from creak.contact.step_problem import spring_force
from creak.dynamics.closing import dips
from creak.dynamics.compiled import inner
from creak.dynamics.cuda.block import any_of, gather, invert, look_at, sync, total
from creak.dynamics.flow.block import MORE, can_close, cubic, lowest_within, new_impulse
from creak.dynamics.flow.kicks import any_closed, drift_of, force_on, share_out, turn_rates
from creak.dynamics.flow.lasting import LOSS, add, push_by
from creak.dynamics.flow.motion import band_energies, fly_single, quiet, settle_supports
from creak.dynamics.vector_kernels import acts, fill


@inner
def look_gaps(team, shared, gap0, x):  # type: ignore[no-untyped-def]
    """Gaps of a motion."""
    look_at(team, shared.rows, x.x[0], gap0, shared, x.support[0], shared.every, shared.every.size, x.gap)


@inner
def look_rates(team, shared, x):  # type: ignore[no-untyped-def]
    """Their rates."""
    look_at(team, shared.rates, x.x[1], shared.zero, shared, x.support[1], shared.every, shared.every.size, x.rate)


@inner
def rates_of(team, shared, which, count, x):  # type: ignore[no-untyped-def]
    """Rates of some channels."""
    look_at(team, shared.rates, x.x[1], shared.zero, shared, x.support[1], which, count, x.rate)


@inner
def look_closed(team, shared, desk, near, x):  # type: ignore[no-untyped-def]
    """Rates of closed channels; near: how many may be, -1: all."""
    for i in range(team.lane, x.gap.size, team.width):
        desk.flag[i] = x.gap[i] < 0.0
    if near >= 0:
        count = gather(team, desk.flag, desk.near, near, desk.chosen)
    else:
        count = gather(team, desk.flag, shared.every, x.gap.size, desk.chosen)
    rates_of(team, shared, desk.chosen, count, x)


@inner
def look_open(team, shared, desk, x):  # type: ignore[no-untyped-def]
    """Rates of the channels without force."""
    for i in range(team.lane, x.gap.size, team.width):
        desk.flag[i] = x.force[i] == 0.0
    count = gather(team, desk.flag, shared.every, x.gap.size, desk.chosen)
    rates_of(team, shared, desk.chosen, count, x)


@inner
def look_near(team, shared, desk, near, now, after, h, rated):  # type: ignore[no-untyped-def]
    """Gaps, and rates where asked for, of the channels that may close; the others go on in straight lines."""
    sync()
    for i in range(team.lane, after.gap.size, team.width):
        if not desk.is_near[i]:
            after.gap[i], after.rate[i] = now.gap[i] + h * now.rate[i], now.rate[i]
    look_at(team, shared.rows, after.x[0], desk.gap0, shared, after.support[0], desk.near, near, after.gap)
    if rated:
        rates_of(team, shared, desk.near, near, after)


@inner
def bands(team, own, desk, now_own):  # type: ignore[no-untyped-def]
    """sqrt(2 E) by band in `desk.energy[0]`. Syncs."""
    mine = desk.energy[team.lane]
    band_energies(own, own.band, desk.D_own, now_own, mine)
    sync()
    for b in range(team.lane, mine.size, team.width):
        s = 0.0
        for t in range(team.width):
            s += desk.energy[t, b] * desk.energy[t, b]
        desk.energy[0, b] = math.sqrt(s)
    sync()


@inner
def press(team, shared, own, desk, laws, h, now, after, after_own):  # type: ignore[no-untyped-def]
    """Channel forces at an instant, and the first half of their kick; True where there are any. As `flow.kicks`."""
    quiet(after_own)
    share, share_own, m = desk.share, desk.share[team.lane :: team.width], after.gap.size
    if not any_of(any_closed(after_own)):
        return False
    for i in range(team.lane, m, team.width):
        after.drift[i] = drift_of(i, laws, shared.W, h, now, share, after) if after.gap[i] < 0.0 else 0.0
        if after.gap[i] < 0.0:
            after.force[i] = spring_force(laws, i, after.gap[i])
    if not any_of(acts(after_own.force, 0, after_own.force.size)):
        return False
    closing = False
    for i in range(team.lane, m, team.width):
        share[i] = 1.0
        closing = closing or (after.force[i] > 0.0 and now.gap[i] >= 0.0)
    closing = any_of(closing)
    if closing:
        if team.lane == 0:
            share_out(laws, shared.W, h, after, now.gap, -1.0, share)
        sync()
    force_on(own, laws, after.force, share, after_own.F)
    for i in range(own.gain.size):
        after_own.x[1, i] += own.gain[i] * after_own.F[i]
    turn_rates(laws, own.W, 0.5 * h, after.force, share, after_own.rate)
    if closing:
        sync()
        fill(share_own, 1.0)
        sync()
        force_on(own, laws, after.force, share, after_own.F)
    sync()
    return True


@inner
def lessen(team, shared, own, desk, laws, h, now, now_own, after):  # type: ignore[no-untyped-def]
    """Shares of the second half of a kick where channels open in the step that it begins; True if there are any."""
    opening = False
    for i in range(team.lane, now.gap.size, team.width):
        desk.share[i] = 1.0
        opening = opening or (now.force[i] > 0.0 and after.gap[i] > 0.0)
    opening = any_of(opening)
    if opening:
        if team.lane == 0:
            share_out(laws, shared.W, h, now, after.gap, 1.0, desk.share)
        sync()
        force_on(own, laws, now.force, desk.share, now_own.F)
    return opening


@inner
def within(team, shared, desk, laws, n, length, forces, h, now):  # type: ignore[no-untyped-def]
    """As `flow.block.may_close_within`: flags of the channels that may close, their number, and the budget."""
    T, energy = (length >> n) * h, desk.energy[0]
    more, slope = 0.0, laws.stiffness
    for i in range(team.lane, now.gap.size, team.width):
        desk.lowest[i] = lowest_within(i, T, shared.off[n], shared, energy, desk.course, now)
        more += new_impulse(i, T, slope, desk.lowest[i], now) * shared.width[i]
    budget = MORE * T * forces + total(team, more)
    count = 0.0
    for i in range(team.lane, now.gap.size, team.width):
        can = can_close(i, desk.lowest[i], shared.width[i] * T * budget, shared, slope, now)
        desk.is_near[i] = can
        if can:
            count += 1.0
    return total(team, count), budget - h * forces


@inner
def width_of_forces(team, shared, x):  # type: ignore[no-untyped-def]
    """sum_j w_j |p_j|"""
    forces = 0.0
    for j in range(team.lane, x.force.size, team.width):
        forces += abs(x.force[j]) * shared.width[j]
    return total(team, forces)


@inner
def open_block(team, shared, own, desk, laws, length, known, h, now, now_own):  # type: ignore[no-untyped-def]
    """As `flow.block.open_block`: (channels that may close, steps, budget); -1 channels where no block is worth it."""
    m = now.gap.size
    if not known:
        look_open(team, shared, desk, now)
    bands(team, own, desk, now_own)
    forces = width_of_forces(team, shared, now)
    fewest, best, steps = 0.75 * m, -1, length
    for n in range(shared.off.shape[0]):
        count, _ = within(team, shared, desk, laws, n, length, forces, h, now)
        looks = count + 3.0 * m / (length >> n)
        if looks < fewest:
            fewest, best, steps = looks, n, length >> n
    if best < 0:
        fill(desk.is_near[team.lane :: team.width], True)
        sync()
        return -1, steps, 0.0
    _, budget = within(team, shared, desk, laws, best, length, forces, h, now)
    for i in range(team.lane, m, team.width):
        desk.gap_then[i], desk.rate_then[i] = now.gap[i], now.rate[i]
    return gather(team, desk.is_near, shared.every, m, desk.near), steps, budget


@inner
def close_block(team, shared, desk, after):  # type: ignore[no-untyped-def]
    """Look at the gaps that were left out, and at all rates of open channels."""
    for i in range(team.lane, after.gap.size, team.width):
        desk.flag[i] = not desk.is_near[i]
    count = gather(team, desk.flag, shared.every, after.gap.size, desk.chosen)
    look_at(team, shared.rows, after.x[0], desk.gap0, shared, after.support[0], desk.chosen, count, after.gap)
    look_open(team, shared, desk, after)


@inner
def amend(team, desk, table, first, used, begun, time, after):  # type: ignore[no-untyped-def]
    """Gaps that were left out, in the rows of a block that ended at `after`: cubics through its ends."""
    T = time - begun
    for r in range(first, used):
        x = (table[r, 0] - begun) / T
        if x < 0.0 or x > 1.0:
            continue
        for i in range(team.lane, after.gap.size, team.width):
            if not desk.is_near[i]:
                table[r, 1 + i] = cubic(x, desk.gap_then[i], T * desk.rate_then[i], after.gap[i], T * after.rate[i])
    fill(desk.is_near[team.lane :: team.width], True)
    sync()


@inner
def hold_together(team, shared, desk, laws, force):  # type: ignore[no-untyped-def]
    """The channels that press now in lasting contact: how many, and the inverse of their compliance."""
    for i in range(team.lane, force.size, team.width):
        desk.flag[i] = force[i] != 0.0
    n, C = gather(team, desk.flag, shared.every, force.size, desk.pressing), desk.inverse
    for a in range(team.lane, n, team.width):
        for b in range(n):
            C[a * n + b] = (0.5 + LOSS) * shared.B[desk.pressing[a], desk.pressing[b]]
        C[a * n + a] += 1.0 / laws.stiffness[desk.pressing[a]]
    invert(team, C, n)
    return n


@inner
def hold(team, shared, own, desk, laws, P_own, n, near, h, now, now_own, after, after_own):  # type: ignore[no-untyped-def]
    """A step of lasting contact, as `flow.lasting.hold`; False where the set of channels would change in it."""
    fly_single(P_own, own.gain, desk.D_own, now_own, after_own, False)
    settle_supports(desk.course, h, after)
    look_at(team, shared.rows, after.x[0], desk.gap0, shared, after.support[0], desk.pressing, n, after.gap)
    pressing, right, end, mean = desk.pressing[:n], desk.right[:n], desk.end[:n], desk.mean[:n]
    for a in range(team.lane, n, team.width):
        right[a] = -after.gap[pressing[a]]
        for b in range(n):
            right[a] -= (0.5 - LOSS) * shared.B[pressing[a], pressing[b]] * now.force[pressing[b]]
    sync()
    opens = False
    for a in range(team.lane, n, team.width):
        p = 0.0
        for b in range(n):
            p += desk.inverse[a * n + b] * right[b]
        end[a] = p
        mean[a] = (0.5 - LOSS) * now.force[pressing[a]] + (0.5 + LOSS) * p
        opens = opens or p <= 0.0
    if any_of(opens):
        return False
    fill(after_own.F, 0.0)
    push_by(own, pressing, mean, after_own.F)
    add(desk.D_own[0], after_own.F, 1.0)
    fly_single(P_own, own.gain, desk.D_own, now_own, after_own, False)
    add(desk.D_own[0], after_own.F, -1.0)
    if near >= 0:
        look_near(team, shared, desk, near, now, after, h, True)
    else:
        look_gaps(team, shared, desk.gap0, after)
        look_rates(team, shared, after)
    closes = False
    for i in range(team.lane, now.gap.size, team.width):
        watched = laws.stiffness[i] > 0.0 and now.force[i] <= 0.0 and desk.is_near[i]
        if watched and dips(now.gap[i], h * now.rate[i], after.gap[i], h * after.rate[i]):
            closes = True
    if any_of(closes):
        return False
    fill(after_own.force, 0.0)
    sync()
    for a in range(team.lane, n, team.width):
        after.force[pressing[a]] = end[a]
    fill(after_own.F, 0.0)
    push_by(own, pressing, end, after_own.F)
    sync()
    for i in range(team.lane, now.gap.size, team.width):  # what the kicks at rest undo (`flow.kicks.settled`)
        after.drift[i] = 0.0
        for j in range(after.force.size):
            if after.force[j] != 0.0:
                after.drift[i] -= desk.h * shared.W[j, i] * after.force[j]
    sync()
    return True
