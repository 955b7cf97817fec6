"""The march by exact flow on a GPU: a block marches a run, step by step as `flow.kernel.march` does on a core.

Of springs alone, on single modes with mass, without the books of energy. All threads of a block take the same way:
what they choose by is the same for all.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

from numba import cuda, float64, int64

from creak.dynamics.compiled import DONE, NOT_FINITE, inner
from creak.dynamics.cuda.block import THREADS, any_of, sync, team_of
from creak.dynamics.cuda.contact import (
    amend,
    bands,
    close_block,
    hold,
    hold_together,
    lessen,
    look_closed,
    look_gaps,
    look_near,
    look_rates,
    open_block,
    press,
    width_of_forces,
)
from creak.dynamics.cuda.model import cone_of, instant, laws_of, own_of, part
from creak.dynamics.flow.block import APART
from creak.dynamics.flow.kernel import FULL, may_close
from creak.dynamics.flow.lasting import PATIENCE, rests
from creak.dynamics.flow.motion import fly_single, load_step, quiet, settle_supports, shift, shift_loads
from creak.dynamics.flow.rows import bends, changes, restart
from creak.dynamics.vector_kernels import acts, put


class Desk(NamedTuple):
    """Where a block works: views of a run in `Work`."""

    gap0: Any
    D_own: Any
    course: Any
    drive: Any
    energy: Any
    share: Any
    lowest: Any
    flag: Any
    near: Any
    is_near: Any
    chosen: Any
    gap_then: Any
    rate_then: Any
    pressing: Any
    right: Any
    end: Any
    mean: Any
    inverse: Any
    h: float


@inner
def desk_of(team, work, v, h):  # type: ignore[no-untyped-def]
    """That of run v."""
    return Desk(
        work.gap0[v],
        work.D[v][:, team.lane :: team.width],
        work.course[v],
        work.drive[v],
        work.energy[v],
        work.share[v],
        work.lowest[v],
        work.flag[v],
        work.near[v],
        work.is_near[v],
        work.chosen[v],
        work.gap_then[v],
        work.rate_then[v],
        work.pressing[v],
        work.right[v],
        work.end[v],
        work.mean[v],
        work.inverse[v],
        h,
    )


@inner
def advance(  # type: ignore[no-untyped-def]
    team, shared, own, desk, laws, sizes, at, level, kicked, near, now, now_own, after, after_own
):
    """Motion up to the next instant, as `flow.kernel.advance`: its level."""
    levels, t, T = sizes.levels, team.lane, team.width
    if kicked:
        level = levels
    elif level > 0 and at % ((1 << levels) >> (level - 1)) == 0:
        level -= 1
    if level < levels:
        bands(team, own, desk, now_own)
    while True:
        h = sizes.H / (1 << level)
        fly_single(shared.P[level][:, t::T], own.gain, desk.D_own, now_own, after_own, kicked)
        settle_supports(desk.course, h, after)
        if near >= 0:
            look_near(team, shared, desk, near, now, after, h, False)
            break
        look_gaps(team, shared, desk.gap0, after)
        if level == levels:
            break
        look_rates(team, shared, after)
        if not any_of(may_close(now_own, after_own, h, shared.reach[level][:, t::T], desk.energy[0], own.slope)):
            break
        level += 1
    if kicked and lessen(team, shared, own, desk, laws, h, now, now_own, after):
        fly_single(shared.P[level][:, t::T], own.gain, desk.D_own, now_own, after_own, kicked)
        if near >= 0:
            look_near(team, shared, desk, near, now, after, h, False)
        else:
            look_gaps(team, shared, desk.gap0, after)
    if level == levels:
        look_closed(team, shared, desk, near, after)
    return level


@inner
def write(team, table, row, time, x_own):  # type: ignore[no-untyped-def]
    """Time, gaps and forces of an instant."""
    m = (table.shape[1] - 1) // 2
    if team.lane == 0:
        table[row, 0] = time
    put(table[row, 1 + team.lane : 1 + m : team.width], 0, x_own.gap)
    put(table[row, 1 + m + team.lane : 1 + 2 * m : team.width], 0, x_own.force)


@inner
def march(team, shared, sizes, work, out, v):  # type: ignore[no-untyped-def]
    """As `flow.kernel.march`, of run v from where it is, `sizes.chunk` flight steps at most."""
    state, table, H, levels, lasting = out.state[v], out.table[v], sizes.H, sizes.levels, sizes.lasting
    parts, h_near, m = 1 << levels, H / (1 << levels), shared.every.size
    laws, desk = laws_of(shared, work.stiffness[v]), desk_of(team, work, v, h_near)
    own, cone = own_of(team, shared, laws, work.loads[v]), cone_of(team, work, v, m)
    a, begin, end = state[4], state[1], state[5]
    now, after = instant(shared, work, v, a), instant(shared, work, v, 1 - a)
    now_own, after_own = part(team, now), part(team, after)
    sync()
    patience = PATIENCE * (parts >> lasting) if lasting <= levels else 0
    code, done, used, kept, level = DONE, begin, 0, 0, 0
    near, end_at, first, left, begun, known = -1, 0, 0, 0.0, 0.0, False
    time, written, edge, n_held = begin * H, True, False, 0
    restart(cone, time, now_own, True)
    calm = 0 if any_of(not rests(own, now_own)) else patience
    for step in range(begin, min(end, begin + sizes.chunk)):
        if used + parts > table.shape[0]:
            code = FULL
            break
        sync()
        load_step(own, 3 * step, H / 3.0, desk.course, desk.drive, desk.D_own)
        sync()
        at = 0
        while at < parts:
            kicked, held = any_of(acts(now_own.force, 0, now_own.force.size)), False
            if kicked and sizes.length > 0 and near < 0 and at % APART == 0:
                near, steps, left = open_block(team, shared, own, desk, laws, sizes.length, known, h_near, now, now_own)
                end_at, first, begun = (at // steps + 1) * steps, used, (step + at / parts) * H
            if kicked and lasting <= levels and at % (parts >> lasting) == 0 and calm >= patience:
                level = lasting
                h = H / (1 << lasting)
                if calm == patience:
                    look_rates(team, shared, now)
                    n_held = hold_together(team, shared, desk, laws, now.force)
                P_own = shared.P[level][:, team.lane :: team.width]
                held = hold(team, shared, own, desk, laws, P_own, n_held, near, h, now, now_own, after, after_own)
                calm = calm + 1 if held else 0
            if not held:
                level = advance(
                    team, shared, own, desk, laws, sizes, at, level, kicked, near, now, now_own, after, after_own
                )
            h = H / (1 << level)
            shift_loads(desk.D_own, h)
            presses = held
            if level == levels and not held:
                presses = press(team, shared, own, desk, laws, h, now, after, after_own)
                if not presses:
                    look_rates(team, shared, after)
            elif not held:
                quiet(after_own)
            changed = any_of(changes(now_own, after_own))
            if not held:
                same = level == levels and presses and not changed
                calm = (calm + 1 if calm < patience else calm) if same else 0
            if team.lane == 0:
                for j in range(desk.drive.shape[0]):
                    shift(desk.drive[j], h)
                for order in range(3):
                    for j in range(desk.course.shape[1]):
                        shift(desk.course[order, j], h)
            at += parts >> level
            then = (step + at / parts) * H
            over = False
            if near >= 0:
                left -= h * width_of_forces(team, shared, after)
                over = at >= end_at or left <= 0.0 or not presses
                if over:
                    close_block(team, shared, desk, after)
            known = over
            lost = False
            for i in range(after_own.gap.size):
                lost = lost or not math.isfinite(after_own.gap[i])
            if any_of(lost):
                code, time = NOT_FINITE, then
                break
            if not written:
                keep = edge or changed
                if not keep:
                    keep = any_of(bends(cone, time, now_own, then, after_own))
                if keep:
                    write(team, table, used, time, now_own)
                    restart(cone, time, now_own, edge or changed)
                    used += 1
            if over:
                sync()
                amend(team, desk, table, first, used, begun, then, after)
                near = -1
            now, after, now_own, after_own, a = after, now, after_own, now_own, 1 - a
            time, edge, written = then, changed, at == parts
        if code != DONE:
            break
        write(team, table, used, time, now_own)
        restart(cone, time, now_own, edge)
        used += 1
        done = step + 1
        time = done * H
        for i in range(team.lane, now.x.shape[1], team.width):
            out.u[v, kept, i] = now.x[0, i]
        for i in range(team.lane, now.support.shape[1], team.width):
            out.s[v, kept, i] = now.support[0, i]
        if team.lane == 0:
            out.at[v, kept] = used - 1
        kept += 1
    sync()
    if team.lane == 0:
        state[0], state[1], state[2], state[3], state[4] = code, done, used, kept, a
        out.time[v] = time


def march_block(shared, sizes, work, out):  # type: ignore[no-untyped-def]
    """The kernel: block v marches run v."""
    v = cuda.blockIdx.x
    scratch = cuda.shared.array(THREADS, float64)
    counter = cuda.shared.array(1, int64)
    if out.state[v, 0] == DONE or out.state[v, 0] == FULL:
        if out.state[v, 1] < out.state[v, 5]:
            march(team_of(scratch, counter), shared, sizes, work, out, v)
        elif cuda.threadIdx.x == 0:
            out.state[v, 2], out.state[v, 3] = 0, 0


@lru_cache(maxsize=1)
def compiled() -> Any:
    """The kernel for the device, compiled at its first launch on a machine and kept."""
    return cuda.jit(march_block, cache=True)
