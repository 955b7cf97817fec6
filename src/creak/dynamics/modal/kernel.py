"""The march of a diagonal System in compiled code: loads, modes, channels and energies of a run in one loop.

No memory is taken within a step but by the contact solver. Bytes read in a step of free flight: the channel rows once
and about twenty vectors of n.
"""

from __future__ import annotations

import numba
import numpy as np

from creak.contact.step_problem import solve_step
from creak.dynamics.books import CONTACT, KINETIC, STRAIN
from creak.dynamics.closing import closes_between
from creak.dynamics.modal.books import book
from creak.dynamics.modal.model import (
    ACCELERATION,
    CONSTANT,
    DONE,
    FAST,
    FORCE,
    NOT_FINITE,
    acts,
    dot,
    fill,
    look,
    put,
    slide,
    write,
)


@numba.njit(cache=True)
def amplitudes(model, support, row, out):  # type: ignore[no-untyped-def]
    """Amplitude of every load column at an instant of the samples."""
    for j in range(out.size):
        if model.order[j] == FORCE:
            out[j] = model.force[row, model.column[j]]
        elif model.order[j] == CONSTANT:
            out[j] = 1.0
        else:
            out[j] = support[model.order[j], model.column[j]]


@numba.njit(cache=True)
def move_supports(model, step, now, after, row):  # type: ignore[no-untyped-def]
    """Samples for the exact step; Newmark's rule from the sampled displacement else."""
    s = after.support
    if step.exact:
        for order in range(3):
            put(s[order], 0, model.support[order, row])
        return
    h, beta, gamma = step.h, step.weights[2], step.weights[3]
    for j in range(s.shape[1]):
        s0, v0, a0 = now.support[0, j], now.support[1, j], now.support[2, j]
        s1 = model.support[0, row, j]
        a1 = ((s1 - s0) / h - v0) / (beta * h) - (0.5 / beta - 1.0) * a0
        s[0, j], s[1, j], s[2, j] = s1, v0 + h * ((1.0 - gamma) * a0 + gamma * a1), a1


@numba.njit(cache=True, fastmath=FAST)
def fly_newmark(model, step, now, after, load):  # type: ignore[no-untyped-def]
    """u, v, a after a step without channel forces at its end."""
    am, af, beta, gamma = step.weights
    share = af if acts(now.force, 0, now.force.size) else 0.0
    for i in range(load.size):
        load[i] = share * now.F[i] if share != 0.0 else 0.0
    for j in range(model.order.size):
        w = am if model.order[j] == ACCELERATION else af
        amount = w * now.amplitude[j] + (1.0 - w) * after.amplitude[j]
        if amount != 0.0:
            column = model.X[j]
            for i in range(load.size):
                load[i] += amount * column[i]
    h = step.h
    u_a, u_a1, v_a, v_a1 = h * h * (0.5 - beta), h * h * beta, h * (1.0 - gamma), h * gamma
    u0, v0, a0 = now.x[0], now.x[1], now.x[2]
    u1, v1, a1 = after.x[0], after.x[1], after.x[2]
    fu, fv, fa, fe = step.free[0], step.free[1], step.free[2], step.free[3]
    for i in range(load.size):
        a = fu[i] * u0[i] + fv[i] * v0[i] + fa[i] * a0[i] + fe[i] * load[i]
        u1[i] = u0[i] + h * v0[i] + u_a * a0[i] + u_a1 * a
        v1[i] = v0[i] + v_a * a0[i] + v_a1 * a
        a1[i] = a
    return 0.0, 0.0


@numba.njit(cache=True, fastmath=FAST)
def fly_exactly(model, step, now, after, load):  # type: ignore[no-untyped-def]
    """u, v after first kick and exact motion; work of the loads on modes with mass and what their dampers took."""
    u0, v0, u1, v1 = now.x[0], now.x[1], after.x[0], after.x[1]
    P, kicked = step.free, acts(now.force, 0, now.force.size)
    moving = False
    for j in range(model.order.size):
        moving = moving or now.amplitude[j] != 0.0 or after.amplitude[j] != 0.0
    work = lost = 0.0
    if not moving:
        for i in range(u0.size):
            v = v0[i] + P[12, i] * now.F[i] if kicked else v0[i]
            u1[i] = P[0, i] * u0[i] + P[1, i] * v
            v1[i] = P[2, i] * u0[i] + P[3, i] * v
            if model.c[i] > 0.0 and model.m[i] > 0.0:
                before = model.m[i] * v * v + model.k[i] * u0[i] * u0[i]
                lost += 0.5 * (before - model.m[i] * v1[i] * v1[i] - model.k[i] * u1[i] * u1[i])
        return work, lost
    begin, end = load, after.x[2]
    fill(begin, 0.0)
    fill(end, 0.0)
    for j in range(model.order.size):
        a0, a1, column = now.amplitude[j], after.amplitude[j], model.X[j]
        for i in range(u0.size):
            begin[i] += a0 * column[i]
            end[i] += a1 * column[i]
    for i in range(u0.size):
        v = v0[i] + P[12, i] * now.F[i] if kicked else v0[i]
        E0, E1 = begin[i], end[i]
        u1[i] = P[0, i] * u0[i] + P[1, i] * v + P[6, i] * E0 + P[7, i] * E1
        v1[i] = P[2, i] * u0[i] + P[3, i] * v + P[8, i] * E0 + P[9, i] * E1
        if model.m[i] > 0.0:
            area = P[4, i] * u0[i] + P[5, i] * v + P[10, i] * E0 + P[11, i] * E1
            done = E1 * u1[i] - E0 * u0[i] - (E1 - E0) / step.h * area
            work += done
            if model.c[i] > 0.0:
                before = model.m[i] * v * v + model.k[i] * u0[i] * u0[i]
                lost += done + 0.5 * (before - model.m[i] * v1[i] * v1[i] - model.k[i] * u1[i] * u1[i])
    return work, lost


@numba.njit(cache=True)
def slip_of_step(model, step, now, after, out):  # type: ignore[no-untyped-def]
    """Sliding of a step without channel forces at its end: displacement if exact, h times the end velocity else."""
    if step.exact:
        slide(model, now, after, out)
        return
    m = model.gap0.size
    for i in range(out.size):
        out[i] = dot(model.rows[m + i], after.x[1])
        for j in range(now.support.shape[1]):
            out[i] += model.rows_s[m + i, j] * after.support[1, j]
        out[i] *= step.h


@numba.njit(cache=True)
def press(model, step, A, laws, now, after, gap_free, rate_free, slip):  # type: ignore[no-untyped-def]
    """Channel forces at the end of a step and their effect on it; 0 or the code of the contact solver."""
    m, f2 = model.gap0.size, after.sliding.size
    fill(after.force, 0.0)
    fill(after.sliding, 0.0)
    fill(after.stuck, True)
    closed = False
    for i in range(m):
        closed = closed or after.gap[i] < 0.0
    if not (model.presses and closed):
        return DONE
    if f2:
        slip_of_step(model, step, now, after, slip)
    for i in range(m):
        gap_free[i] = after.gap[i]
        rate_free[i] = (after.gap[i] - now.gap[i]) / step.h if step.exact else after.rate[i]
    put(after.force, 0, now.force)
    put(after.stuck, 0, now.stuck)
    code = solve_step(
        A, gap_free, rate_free, step.rate_gain, slip, step.slip_gain, step.h, laws, after.stuck, after.force
    )
    if code != DONE or not acts(after.force, 0, after.force.size):
        return code
    respond(model, step, A, after)
    for i in range(f2):
        if after.force[laws.rubs[i // 2]] > 0.0 and not after.stuck[i // 2]:
            moved = 0.0
            for j in range(after.force.size):
                moved += A[m + i, j] * after.force[j]
            after.sliding[i] = (slip[i] + step.slip_gain * moved) / step.h
    return DONE


@numba.njit(cache=True, fastmath=FAST)
def respond(model, step, A, after):  # type: ignore[no-untyped-def]
    """Gaps, rates and modes under the channel forces at the end of a step."""
    F = after.F
    fill(F, 0.0)
    for j in range(after.force.size):
        p = after.force[j]
        if p != 0.0:
            row = model.rows[j]
            for i in range(F.size):
                F[i] += p * row[i]
            for i in range(after.gap.size):
                after.gap[i] += A[i, j] * p
                after.rate[i] += step.rate_gain * A[i, j] * p
    u, v, a = after.x[0], after.x[1], after.x[2]
    gu, gv, ga = step.gain[0], step.gain[1], step.gain[2]
    for i in range(F.size):
        u[i] += gu[i] * F[i]
        v[i] += gv[i] * F[i]
    if not step.exact:
        for i in range(F.size):
            a[i] += ga[i] * F[i]


@numba.njit(cache=True)
def fly(model, step, now, after, row, load):  # type: ignore[no-untyped-def]
    """Loads and modes at the end of a step without channel forces at its end."""
    move_supports(model, step, now, after, row)
    amplitudes(model, after.support, row, after.amplitude)
    if step.exact:
        return fly_exactly(model, step, now, after, load)
    return fly_newmark(model, step, now, after, load)


@numba.njit(cache=True)
def march_chunk(model, laws, whole, A_whole, part, A_part, now, after, out, time, begin, end, substeps, every, used):  # type: ignore[no-untyped-def]
    """March from output step `begin` to `end`; `used` rows of the table are taken.

    Returns
    -------
    code (0 done, -1 not finite, else of the contact solver), rows taken, motions kept, and whether `after` holds the
    last state.
    """
    load, slip = np.empty(model.m.size), np.empty(now.sliding.size)
    gap_free, rate_free = np.empty(now.gap.size), np.empty(now.gap.size)
    rated = model.damped or substeps > 1
    kept, whole_row, swapped = 0, 0, False
    for n in range(begin + 1, end + 1):
        row0, flown = (n - 1) * substeps, (0.0, 0.0)
        divided = substeps > 1 and model.presses
        if divided and not now.recent[0] and not acts(now.force, 0, now.gap.size):
            flown = fly(model, whole, now, after, row0 + substeps, load)
            look(model, after, True)
            divided = closes_between(now.gap, now.rate, after.gap, after.rate, whole.h)
        count, stride = (substeps, 1) if divided else (1, substeps)
        pressed = False
        for q in range(count):
            row = row0 + (q + 1) * stride
            step = part if divided else whole
            if divided or substeps == 1 or not model.presses:
                flown = fly(model, step, now, after, row, load)
                look(model, after, rated)
            code = press(model, step, A_part if divided else A_whole, laws, now, after, gap_free, rate_free, slip)
            if code != DONE:
                return code, used, kept, swapped, time[row]
            book(model, step, laws, now, after, flown, slip)
            if not np.isfinite(after.energy[KINETIC] + after.energy[STRAIN] + after.energy[CONTACT]):
                return NOT_FINITE, used, kept, swapped, time[row]
            now, after = after, now
            swapped = not swapped
            write(out, used, time[row], now)
            used += 1
            pressed = pressed or acts(now.force, 0, now.gap.size)
        now.recent[0] = pressed
        if n % every == 0:
            out.at[kept] = used - 1
            put(out.u[kept], 0, now.x[0])
            put(out.s[kept], 0, now.support[0])
            kept += 1
        while whole_row < out.whole_at.size and out.whole_at[whole_row] < n:
            whole_row += 1
        if whole_row < out.whole_at.size and out.whole_at[whole_row] == n:
            put(out.whole[whole_row], 0, now.x[0])
    return DONE, used, kept, swapped, time[end * substeps]
