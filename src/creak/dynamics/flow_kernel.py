"""The march of a diagonal System by exact flow in compiled code: halved near contact, kicked where it presses.

A flight step is taken whole where no gap can close in it, by a bound that holds between the samples. Else it is
halved, and its halves, down to the step near contact; only that one carries forces: kick, exact motion, kick. Laws with
a damper or friction act on the velocity that the kick itself leaves behind (`THETA` of it), in one problem for all
channels that press.
"""

from __future__ import annotations

import numba
import numpy as np

from creak.contact.step_problem import solve_step, spring_force
from creak.dynamics.closing import dips
from creak.dynamics.flow_books import book_flow, in_motion
from creak.dynamics.modal_model import (
    CONSTANT,
    CONTACT,
    DONE,
    FAST,
    FORCE,
    KINETIC,
    NOT_FINITE,
    STRAIN,
    acts,
    dot,
    fill,
    look,
    put,
    write,
)

THETA = 0.6
"""Share of a kick that the laws see: 1/2 conserves the energy of a sticking channel but lets it jitter, 1 stops it."""
RATE = 1e5
"""Rates of a kick over the displacements that stand for them in the problem of the channels, times h: so large that
these displacements do not stretch the springs."""
FULL = -2
"""Code: no room left in the table."""


@numba.njit(cache=True)
def cubic_through(a, b, c, d, third, out):  # type: ignore[no-untyped-def]
    """Value and three derivatives at the first of four samples `third` apart."""
    out[0] = a
    out[1] = (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / (6.0 * third)
    out[2] = (2.0 * a - 5.0 * b + 4.0 * c - d) / (third * third)
    out[3] = (-a + 3.0 * b - 3.0 * c + d) / (third * third * third)


@numba.njit(cache=True)
def shift(p, h):  # type: ignore[no-untyped-def]
    """Value and derivatives of a cubic, h later, in place."""
    p[0] += h * (p[1] + h * (0.5 * p[2] + h / 6.0 * p[3]))
    p[1] += h * (p[2] + 0.5 * h * p[3])
    p[2] += h * p[3]


@numba.njit(cache=True)
def value(p, h):  # type: ignore[no-untyped-def]
    """A cubic, h later."""
    return p[0] + h * (p[1] + h * (0.5 * p[2] + h / 6.0 * p[3]))


@numba.njit(cache=True)
def load_step(model, row, third, course, drive, D):  # type: ignore[no-untyped-def]
    """Cubics of supports (3, n_support, 4), load columns (n_x, 4) and modal loads (4, n) over a flight step."""
    for order in range(3):
        for j in range(course.shape[1]):
            s = model.support[order]
            cubic_through(s[row, j], s[row + 1, j], s[row + 2, j], s[row + 3, j], third, course[order, j])
    fill(D[0], 0.0)
    fill(D[1], 0.0)
    fill(D[2], 0.0)
    fill(D[3], 0.0)
    for j in range(drive.shape[0]):
        if model.order[j] == CONSTANT:
            fill(drive[j], 0.0)
            drive[j, 0] = 1.0
        elif model.order[j] == FORCE:
            f, q = model.force, model.column[j]
            cubic_through(f[row, q], f[row + 1, q], f[row + 2, q], f[row + 3, q], third, drive[j])
        else:
            put(drive[j], 0, course[model.order[j], model.column[j]])
        if acts(drive[j], 0, 4):
            add_column(drive[j], model.X[j], D)


@numba.njit(cache=True, fastmath=FAST)
def add_column(drive, column, D):  # type: ignore[no-untyped-def]
    """D += drive (4,) times column (n,)."""
    a, b, c, d = drive
    D0, D1, D2, D3 = D[0], D[1], D[2], D[3]
    for i in range(column.size):
        x = column[i]
        D0[i] += a * x
        D1[i] += b * x
        D2[i] += c * x
        D3[i] += d * x


@numba.njit(cache=True, fastmath=FAST)
def shift_loads(D, h):  # type: ignore[no-untyped-def]
    """Modal loads, h later."""
    D0, D1, D2, D3 = D[0], D[1], D[2], D[3]
    half, sixth = 0.5 * h, h / 6.0
    for i in range(D0.size):
        d0, d1, d2, d3 = D0[i], D1[i], D2[i], D3[i]
        D0[i] = d0 + h * (d1 + h * (0.5 * d2 + sixth * d3))
        D1[i] = d1 + h * (d2 + half * d3)
        D2[i] = d2 + h * d3


@numba.njit(cache=True, fastmath=FAST)
def fly(P, gain, D, now, after, kicked):  # type: ignore[no-untyped-def]
    """u, v after the second half of a kick and the exact motion of a step."""
    u0, v0, u1, v1 = now.x[0], now.x[1], after.x[0], after.x[1]
    uu, uv, vu, vv, q0, q1, q2, q3, q4 = P[0], P[1], P[2], P[3], P[4], P[5], P[6], P[7], P[8]
    D0, D1, D2, D3, F = D[0], D[1], D[2], D[3], now.F
    for i in range(u0.size):
        u, v = u0[i], v0[i]
        if kicked:
            v += gain[i] * F[i]
        d0, d1, d2, d3 = D0[i], D1[i], D2[i], D3[i]
        u1[i] = uu[i] * u + uv[i] * v + q1[i] * d0 + q2[i] * d1 + q3[i] * d2 + q4[i] * d3
        v1[i] = vu[i] * u + vv[i] * v + q0[i] * d0 + q1[i] * d1 + q2[i] * d2 + q3[i] * d3


@numba.njit(cache=True, fastmath=FAST)
def band_energies(model, band, D, x, out):  # type: ignore[no-untyped-def]
    """sqrt(2 E) of the motion about its quasi-static place, by band."""
    fill(out, 0.0)
    u, v, D0, m, k = x.x[0], x.x[1], D[0], model.m, model.k
    for i in range(u.size):
        if k[i] > 0.0 and m[i] > 0.0:
            y = u[i] - D0[i] / k[i]
            out[band[i]] += m[i] * v[i] * v[i] + k[i] * y * y
    for b in range(out.size):
        out[b] = np.sqrt(out[b])


@numba.njit(cache=True)
def may_close(now, after, h, reach, energy, slope):  # type: ignore[no-untyped-def]
    """Can a gap that has a law reach zero in a step without contact? reach (n_band, m), energy (2, n_band)."""
    for i in range(now.gap.size):
        if slope[i] <= 0.0:
            continue
        off = 0.0
        for b in range(reach.shape[0]):
            off += reach[b, i] * max(energy[0, b], energy[1, b])
        g0, g1 = now.gap[i] - off, after.gap[i] - off
        if g0 <= 0.0 or dips(g0, h * now.rate[i], g1, h * after.rate[i]):
            return True
    return False


@numba.njit(cache=True)
def press(model, laws, A, W, light, gain, h, now, after, gap_free, rate_free, slip):  # type: ignore[no-untyped-def]
    """Channel forces at an instant, and the first half of their kick; 0 or the code of the contact solver."""
    m, f2 = model.gap0.size, after.sliding.size
    fill(after.force, 0.0)
    fill(after.F, 0.0)
    fill(after.sliding, 0.0)
    fill(after.stuck, True)
    closed = False
    for i in range(m):
        closed = closed or after.gap[i] < 0.0
    if not (model.presses and closed):
        return DONE
    if model.damped or f2 or light:
        put(gap_free, 0, after.gap)
        put(rate_free, 0, after.rate)
        for i in range(f2):
            slip[i] = h * dot(model.rows[m + i], after.x[1])
            for j in range(after.support.shape[1]):
                slip[i] += h * model.rows_s[m + i, j] * after.support[1, j]
        put(after.force, 0, now.force)
        put(after.stuck, 0, now.stuck)
        code = solve_step(A, gap_free, rate_free, RATE / h, slip, RATE, h, laws, after.stuck, after.force)
        if code != DONE:
            return code
    else:
        for i in range(m):
            if after.gap[i] < 0.0:
                after.force[i] = spring_force(laws, i, after.gap[i])
    if not acts(after.force, 0, after.force.size):
        return DONE
    respond(model, A, W, light, gain, h, after)
    for i in range(f2):
        if after.force[laws.rubs[i // 2]] > 0.0 and not after.stuck[i // 2]:
            moved = 0.0
            for j in range(after.force.size):
                moved += W[m + i, j] * after.force[j]
            after.sliding[i] = slip[i] / h + 0.5 * h * moved
    return DONE


@numba.njit(cache=True, fastmath=FAST)
def respond(model, A, W, light, gain, h, after):  # type: ignore[no-untyped-def]
    """Modes, gaps and rates after half a kick; coordinates without mass move at once."""
    F, u, v = after.F, after.x[0], after.x[1]
    for j in range(after.force.size):
        p = after.force[j]
        if p != 0.0:
            row = model.rows[j]
            for i in range(F.size):
                F[i] += p * row[i]
            for i in range(after.gap.size):
                after.rate[i] += 0.5 * h * W[i, j] * p
                if light:
                    after.gap[i] += A[i, j] * p
    for i in range(F.size):
        v[i] += gain[i] * F[i]
    if light:
        for i in range(F.size):
            if model.m[i] <= 0.0:
                u[i] += F[i] / model.k[i]


@numba.njit(cache=True)
def settle_supports(course, h, after):  # type: ignore[no-untyped-def]
    """Motion of the supports at the end of a step."""
    for order in range(3):
        for j in range(course.shape[1]):
            after.support[order, j] = value(course[order, j], h)


@numba.njit(cache=True)
def flow_chunk(model, laws, slope, P, A, W, gain, light, band, reach, now, after, out, H, begin, end, every, used):  # type: ignore[no-untyped-def]
    """March from flight step `begin` to `end`; `used` rows of the table are taken.

    Returns
    -------
    code (0 done, -1 not finite, -2 the table is full, else of the contact solver), flight steps done, rows taken,
    motions kept, whether `after` holds the last state, and the time.
    """
    n, m, n_x, levels = model.m.size, model.gap0.size, model.order.size, P.shape[0] - 1
    slip, gap_free, rate_free = np.empty(now.sliding.size), np.empty(m), np.empty(m)
    course, drive, D = np.empty((3, now.support.shape[1], 4)), np.empty((n_x, 4)), np.empty((4, n))
    energy = np.empty((2, reach.shape[1]))
    parts = 1 << levels
    kept, whole_row, swapped, level = 0, 0, False, 0
    for step in range(begin, end):
        if used + parts > out.table.shape[0]:
            return FULL, step, used, kept, swapped, step * H
        load_step(model, 3 * step, H / 3.0, course, drive, D)
        at = 0
        while at < parts:
            kicked = acts(now.force, 0, now.force.size)
            if not model.presses:
                level = 0
            elif kicked:
                level = levels
            elif level > 0 and at % (parts >> (level - 1)) == 0:
                level -= 1
            if model.presses and level < levels:
                band_energies(model, band, D, now, energy[0])
            while True:
                h = H / (1 << level)
                fly(P[level], gain, D, now, after, kicked)
                settle_supports(course, h, after)
                look(model, after, True)
                if level == levels or not model.presses:
                    break
                put(energy[1], 0, energy[0])
                if not may_close(now, after, h, reach[level], energy, slope):
                    break
                level += 1
            flown = in_motion(model, now, after, gain, kicked)
            for j in range(n_x):
                after.amplitude[j] = value(drive[j], h)
            shift_loads(D, h)
            if level == levels:
                code = press(model, laws, A, W, light, gain, h, now, after, gap_free, rate_free, slip)
                if code != DONE:
                    return code, step, used, kept, swapped, step * H + (at + 1) * h
            else:
                fill(after.force, 0.0)
                fill(after.F, 0.0)
                fill(after.sliding, 0.0)
                fill(after.stuck, True)
            book_flow(model, laws, W, drive, h, now, after, flown, light)
            for j in range(n_x):
                shift(drive[j], h)
            for order in range(3):
                for j in range(course.shape[1]):
                    shift(course[order, j], h)
            at += parts >> level
            time = (step + at / parts) * H
            if not np.isfinite(after.energy[KINETIC] + after.energy[STRAIN] + after.energy[CONTACT]):
                return NOT_FINITE, step, used, kept, swapped, time
            now, after = after, now
            swapped = not swapped
            write(out, used, time, now)
            used += 1
        if (step + 1) % every == 0:
            out.at[kept] = used - 1
            put(out.u[kept], 0, now.x[0])
            put(out.s[kept], 0, now.support[0])
            kept += 1
        while whole_row < out.whole_at.size and out.whole_at[whole_row] < step + 1:
            whole_row += 1
        if whole_row < out.whole_at.size and out.whole_at[whole_row] == step + 1:
            put(out.whole[whole_row], 0, now.x[0])
    return DONE, end, used, kept, swapped, end * H
