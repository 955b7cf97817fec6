"""The march by exact flow in compiled code: halved near contact, kicked where it presses.

A flight step is taken whole where no gap can close in it, by a bound that holds between the samples. Else it is
halved, and its halves, down to the step near contact; only that one carries forces: kick, exact motion, kick
(`flow.kicks`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.coulomb_newton import Kept, new_kept
from creak.contact.laws.parameters import LawArrays
from creak.dynamics.books import GIVEN
from creak.dynamics.closing import dips
from creak.dynamics.flow.along import as_slides_went
from creak.dynamics.flow.block import (
    APART,
    KNOWN,
    amend,
    close_block,
    ends,
    look_near,
    look_watched,
    open_block,
    under_way,
)
from creak.dynamics.flow.books import as_springs_saw, book_flow, complete
from creak.dynamics.flow.held import CALM, LONG, MOST, NEVER, SAME, WAIT, Held, new_held
from creak.dynamics.flow.kicks import book_half, book_slack, lessen, press, settled
from creak.dynamics.flow.lasting import PATIENCE, Lasting, follow_swing, hold_on, into_kicks, rests, wait_on
from creak.dynamics.flow.model import DONE, NOT_FINITE, FlowModel, FlowState, resting
from creak.dynamics.flow.motion import (
    band_energies,
    load_step,
    look_closed,
    look_gaps,
    look_rates,
    mean_of,
    quiet,
    settle_supports,
    shift,
    shift_loads,
    value,
)
from creak.dynamics.flow.rows import bends, changes, pieces, restart, write, write_between, write_touch
from creak.dynamics.flow.steady import NONE, Steady, book_steady, fly_on, go_on_with, let_go, new_steady
from creak.dynamics.loads import Loads
from creak.linalg.by_reference import by_reference
from creak.linalg.compiled import inner, outer
from creak.linalg.loops import acts, fill, put

FULL = -2
"""Code: no room left in the table."""


class Scheme(NamedTuple):
    """What a run marches by, from its first step to its last."""

    H: float
    """s, of a flight step"""
    laws: LawArrays
    slope: FloatArray
    """(m,) steepest slope of each law"""
    P: FloatArray
    """(level + 1, ...) exact motion in a step of each level"""
    W: FloatArray
    """(m + 2 f, m + 2 f) mobility of the channels in a step near contact"""
    gain: FloatArray
    """half a step near contact over each mass"""
    band: IntArray
    """(n,) frequency band of each mode"""
    reach: FloatArray
    """(level + 1, n_band, m) how far a gap may be off its cubic, over the root of the band's energy"""
    lasting: Lasting
    light: bool
    """whether channels move coordinates without mass"""


class Desk(NamedTuple):
    """Where a march works."""

    course: FloatArray
    """(n_support, 6): displacement and its derivatives"""
    drive: FloatArray
    """(n_x, 4)"""
    D: FloatArray
    """(4, p1 - p0)"""
    energy: FloatArray
    """(n_band,)"""
    share: FloatArray
    """(m,)"""
    together: Held
    steady: Steady
    factor: Kept
    """Of the friction of the last kick."""
    later: FlowState
    """z a step near contact later, to be looked at."""


def new_desk(model: FlowModel, loads: Loads, bands: int, levels: int, lasts: bool) -> Desk:
    """For one march at a time; lasts: there may be long steps of lasting contact."""
    m, n_support = model.gap0.size, model.support.shape[2]
    course, drive, D = np.empty((n_support, 6)), np.empty((model.order.size, 4)), np.empty((4, model.p1 - model.p0))
    rubbing = model.rows.shape[0] if model.rows.shape[0] > m else 0
    held = new_held(model, loads, levels, lasts)
    kept = new_kept(rubbing if rubbing <= MOST else 0)
    later = resting(model, loads)
    return Desk(course, drive, D, np.empty(bands), np.ones(m), held, new_steady(model), kept, later)


@inner
def may_close(model, course, now, after, h, reach, energy, slope):  # type: ignore[no-untyped-def]
    """Can a gap that has a law reach zero in a step without contact? reach (n_band, m), energy (n_band,).

    The quintic s of a support is off the cubic through both its ends by at most h^4 max |d^4 s / dt^4| / 384.
    """
    for i in range(now.gap.size):
        if slope[i] <= 0.0:
            continue
        off = 0.0
        for b in range(reach.shape[0]):
            off += reach[b, i] * energy[b]
        for a in range(course.shape[0]):
            off += abs(model.rows_s[i, a]) * (abs(course[a, 4]) + h * abs(course[a, 5])) * h**4 / 384.0
        g0, g1 = now.gap[i] - off, after.gap[i] - off
        if g0 <= 0.0 or dips(g0, h * now.rate[i], g1, h * after.rate[i]):
            return True
    return False


@inner
def all_finite(after):  # type: ignore[no-untyped-def]
    """Are gaps and work finite?"""
    total = after.energy[GIVEN]
    for i in range(after.gap.size):
        total += after.gap[i]
    return np.isfinite(total)


@inner
def raise_to(most, energy):  # type: ignore[no-untyped-def]
    """Largest energies so far, where anybody keeps them."""
    for b in range(most.size):
        most[b] = max(most[b], energy[b])


@inner
def is_short(model, level, levels, held):  # type: ignore[no-untyped-def]
    """Is a step one near contact, of those that kicks begin and end?"""
    return model.presses and level == levels and not held


@inner
def advance(model, scheme, springs, desk, at, level, kicked, now, after, block):  # type: ignore[no-untyped-def]
    """Motion up to the next instant: as long a step as no gap can close in, with what is left of a kick; (level, h).

    The step begins at the level of the last one: the shortest where a kick goes on, one longer where its place in the
    flight step allows that, the whole flight step where nothing can press. It is flown, its gaps are looked at, and it
    is flown again half as long as long as a gap may close in it. In a block only the channels that may close are looked
    at, and the step is not halved. Where a channel opens in a step that a kick begins, its share of the second half of
    the kick is found and the step flown once more. Then the works of that half are booked, and the rates are looked at
    that the next kick needs.
    """
    laws, P, W, gain, D, course, energy = scheme.laws, scheme.P, scheme.W, scheme.gain, desk.D, desk.course, desk.energy
    steady = desk.steady
    levels = P.shape[0] - 1
    parts = 1 << levels
    if not model.presses:
        level = 0
    elif kicked:
        level = levels
    elif level > 0 and at % (parts >> (level - 1)) == 0:
        level -= 1
    if model.presses and level < levels:
        band_energies(model, scheme.band, D, 0.0, now, energy)
    while True:
        h = scheme.H / (1 << level)
        given = fly_on(model, P[level], gain, D, h, steady, now, after, kicked)
        settle_supports(course, h, after)
        if under_way(block):
            look_near(block, model, now, after, h, not springs)
            break
        look_gaps(model, after)
        if level == levels or not model.presses:
            break
        look_rates(model, after)
        if not may_close(model, course, now, after, h, scheme.reach[level], energy, scheme.slope):
            break
        level += 1
    if not is_short(model, level, levels, False):
        mean_of(P[level], D, now, desk.together.mean)
    if kicked:
        if lessen(model, laws, W, h, now, after, desk.share):
            less = let_go(model, laws, W, h, steady, now, after.gap)
            now.energy[GIVEN] += less
            after.energy[GIVEN] += less
            given = fly_on(model, P[level], gain, D, h, steady, now, after, kicked)
            if under_way(block):
                look_near(block, model, now, after, h, not springs)
            else:
                look_gaps(model, after)
        book_half(model, laws, W, h, now, desk.share, after.energy)
        if steady.mark[0] != NONE:
            book_steady(steady, h, given, now, after)
    if model.damped:
        book_slack(laws, h, now, after, after.energy)
    if level == levels and model.presses:
        if springs:
            look_closed(model, after)
        elif not under_way(block):
            look_rates(model, after)
    return level, h


@outer
def march(model, scheme, A, block, cone, desk, now, after, out, begin, end, used):  # type: ignore[no-untyped-def]
    """March from flight step `begin` to `end`; `used` rows of the table are taken (`flow.rows`).

    Channels that press at rest count as lasting from the start, and where there are any the forces of lasting contact
    go on between kicks (`flow.steady`). Where only springs press, rates of open channels are looked at when nothing
    presses any more: half of what is read of the model near contact.

    Returns
    -------
    code (0 done, -1 not finite, -2 the table is full, else of the contact solver), flight steps done, rows taken,
    motions kept, whether `after` holds the last state, and the time.

    Notes
    -----
    Each flight step: the cubics of its loads. Until its end, from one instant to the next:

    1. where a kick goes on, a block is opened if that is worth it;
    2. where the same channels have pressed long enough, long steps of lasting contact are tried (`flow.lasting`); where
       none is taken, the motion goes on to the next instant by `advance`;
    3. on the shortest level the channels' forces are found there, with the first half of their kick; on others there
       are none; a long step brings its own;
    4. the works of the step are booked, and loads and supports go on to its end;
    5. a block that ends there is closed: the gaps that it left out are looked at;
    6. the instant before is written where contact changes, or where lines through the written ones would miss it; of a
       long step some between its ends, too; the block's rows then get the gaps that it left out;
    7. both instants change places.

    At its end the instant is written with its energies, and its motion is kept.
    """
    model, scheme, block, cone = by_reference(model), by_reference(scheme), by_reference(block), by_reference(cone)
    desk, out, now, after = by_reference(desk), by_reference(out), by_reference(now), by_reference(after)
    H, laws, W, lasting, light = scheme.H, scheme.laws, scheme.W, scheme.lasting, scheme.light
    n_x, levels = model.order.size, scheme.P.shape[0] - 1
    course, drive, D, energy, together = desk.course, desk.drive, desk.D, desk.energy, desk.together
    steady = desk.steady
    parts = 1 << levels
    most = 2 * parts if model.damped else parts
    springs = not (model.damped or light or now.sliding.size > 0)
    kept, whole_row, swapped, level = 0, 0, False, 0
    time, written, edge = begin * H, True, False
    restart(cone, time, now, np.bool_(True))
    held, rested = False, acts(model.preload, 0, model.preload.size)
    if begin == 0 and lasting.tried:
        put(together.line, 0, now.force)
        put(together.middle, 0, now.force)
        if rests(model, now):
            together.next[CALM], together.next[SAME] = PATIENCE, NEVER
    for step in range(begin, end):
        if used + most > out.table.shape[0]:
            return FULL, step, used, kept, swapped, step * H
        load_step(model, 3 * step, H / 3.0, course, drive, D)
        at = np.int64(0)  # a plain 0 would have `advance` compiled twice
        while at < parts:
            kicked = acts(now.force, 0, now.force.size)
            calm = kicked and lasting.tried and together.next[CALM] >= PATIENCE
            put(after.energy, 0, now.energy)
            if kicked and block.length > 0 and not under_way(block) and at % APART == 0:
                begins = (step + at / parts) * H
                open_block(
                    block, model, scheme.slope, scheme.band, D, energy, course, H / parts, begins, used, at, now, calm
                )
            tried = calm and together.next[WAIT] <= 0
            if tried and not held:
                look_watched(block, model, now)
            longest = -1
            if tried:
                longest = hold_on(model, scheme, desk, at, now, after, block)
            held = longest >= 0
            if held:
                level, h = longest, H / (1 << longest)
                settled(W, H / parts, after)
            if not held:
                if kicked and together.next[LONG]:
                    into_kicks(model, steady, now)
                level, h = advance(model, scheme, springs, desk, at, level, kicked, now, after, block)
                if level < levels:
                    raise_to(out.ring[kept], energy)
            for j in range(n_x):
                after.amplitude[j] = value(drive[j], 0, h)
            shift_loads(D, h)
            if held:
                code = DONE
            elif level == levels:
                code = press(model, scheme, A, h, desk, now, after, block.is_near)
                if code != DONE:
                    return code, step, used, kept, swapped, step * H + (at + 1) * h
                if springs and not acts(after.force, 0, after.force.size):
                    look_rates(model, after)
            else:
                quiet(after)
                together.next[CALM] = 0
            together.next[LONG] = held
            changed = changes(now, after)
            if lasting.tried and level == levels and not held:
                wait_on(together, changed, now, after)
            book_flow(model, drive, h, now, after, is_short(model, level, levels, held), together.mean)
            if lasting.tried and (kicked or acts(after.force, 0, after.force.size)):
                follow_swing(together, h, H, after.force)
            fill(after.before, np.inf)
            if level == levels and not held:
                put(after.before, 0, now.gap)
                if not light:
                    as_springs_saw(laws, h, steady.force, now, after)
                    as_slides_went(laws, h, steady.force, now, after)
            for j in range(n_x):
                shift(drive[j], h)
            for j in range(course.shape[0]):
                shift(course[j], h)
            at += parts >> level
            then = (step + at / parts) * H
            over = under_way(block) and ends(block, h, at, after)
            if over:
                close_block(block, model, after)
            block.mark[KNOWN] = over
            if not all_finite(after):
                return NOT_FINITE, step, used, kept, swapped, then
            count = pieces(together, cone, parts >> level) if held else np.int64(1)
            if not written and (edge or changed or count > 1 or bends(cone, time, now, then, after)):
                complete(model, laws, W, H / parts, steady.force, now)
                write(out, used, time, now)
                restart(cone, time, now, edge or changed)
                used += 1
            if changed and model.damped and level == levels and not held:
                used = write_touch(laws, time, h, now, after, out, used)
            if held and rested:
                go_on_with(steady, after.force)
            elif steady.mark[0] != NONE:
                after.energy[GIVEN] += let_go(model, laws, W, H / parts, steady, after, after.gap)
            if count > 1:
                complete(model, laws, W, H / parts, steady.force, after)
                used = write_between(laws, together, cone, count, time, h, now, after, out, used)
            if over:
                amend(block, out.table, used, then, after)
            now, after, time, edge = after, now, then, changed
            swapped = not swapped
            written = at == parts
        complete(model, laws, W, H / parts, steady.force, now)
        write(out, used, time, now)
        restart(cone, time, now, edge)
        used += 1
        if out.ring.shape[1] > 0 and (level == levels or held):
            band_energies(model, scheme.band, D, 0.0, now, energy)
            raise_to(out.ring[kept], energy)
        out.at[kept] = used - 1
        put(out.u[kept], 0, now.x.reshape(now.x.size)[model.u0 : model.u1])
        put(out.s[kept], 0, now.support[0])
        kept += 1
        while whole_row < out.whole_at.size and out.whole_at[whole_row] < step + 1:
            whole_row += 1
        if whole_row < out.whole_at.size and out.whole_at[whole_row] == step + 1:
            put(out.whole[whole_row], 0, now.x.reshape(now.x.size)[model.u0 : model.u1])
    return DONE, end, used, kept, swapped, end * H
