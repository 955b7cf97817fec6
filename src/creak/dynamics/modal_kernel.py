"""The march of a diagonal System in compiled code: loads, modes, channels and energies of a run in one loop.

No memory is taken within a step but by the contact solver. Bytes read in a step of free flight: the channel rows once
and about twenty vectors of n.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.step_problem import contact_energy, damper_work, solve_step
from creak.dynamics.closing import closes_between

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order; infinities and NaN keep their meaning."""
ACCELERATION, VELOCITY, DISPLACEMENT, FORCE, CONSTANT = 2, 1, 0, 3, 4
"""What drives a load column."""
DONE, NOT_FINITE = 0, -1
KINETIC, STRAIN, CONTACT, DAMPING, CONTACT_DAMPING, FRICTION, EXTERNAL, SCHEME, INITIAL = range(9)


class ModalModel(NamedTuple):
    """A diagonal System with its channels and loads."""

    m: FloatArray
    c: FloatArray
    k: FloatArray
    rows: FloatArray
    """(m + 2 f, n) G above T."""
    rows_s: FloatArray
    """(m + 2 f, n_support)"""
    gap0: FloatArray
    preload: FloatArray
    presses: bool
    damped: bool
    X: FloatArray
    """(n_x, n) modal force of each load column for its amplitude 1."""
    order: IntArray
    """(n_x,) what drives it: a derivative of the supports, a force, or nothing (constant)."""
    column: IntArray
    """(n_x,) which support or force."""
    M_ss: FloatArray
    C_ss: FloatArray
    K_ss: FloatArray
    support: FloatArray
    """(3, n_instant, n_support) samples."""
    force: FloatArray
    """(n_instant, n_force)"""


class MarchState(NamedTuple):
    """Everything that is known at one instant."""

    x: FloatArray
    """(3, n) u, v, a; the exact scheme keeps no a."""
    F: FloatArray
    """(n,) channel forces on the modes."""
    force: FloatArray
    """(m + 2 f,)"""
    gap: FloatArray
    rate: FloatArray
    sliding: FloatArray
    """(2 f,) slip velocity."""
    stuck: BoolArray
    support: FloatArray
    """(3, n_support)"""
    amplitude: FloatArray
    """(n_x,) of the load columns."""
    dots: FloatArray
    """(2, n_x) X u, X v."""
    damper: FloatArray
    """(n_support,) damper forces on the supports."""
    reaction: FloatArray
    """(n_support,) of the supports, without inertia."""
    momentum: FloatArray
    """(n_support,) M_sq v + M_ss s'."""
    energy: FloatArray
    """(9,) the columns of the table, then the energy at t = 0."""
    recent: BoolArray
    """(1,) a channel pressed in the output step that ends here."""


class Output(NamedTuple):
    """Where a run is written to."""

    table: FloatArray
    """(rows, 1 + m + (m + 2 f) + 2 f + 8): time, gaps, forces, sliding, energies."""
    at: IntArray
    """(chunk,) rows of the table at which motion is kept."""
    u: FloatArray
    """(chunk, n)"""
    s: FloatArray
    """(chunk, n_support)"""
    whole_at: IntArray
    whole: FloatArray
    """(n_whole, n)"""


@numba.njit(cache=True)
def fill(to, value):  # type: ignore[no-untyped-def]
    """to[:] = value; a loop compiles in a fraction of the time."""
    for i in range(to.size):
        to[i] = value


@numba.njit(cache=True)
def put(to, begin, values):  # type: ignore[no-untyped-def]
    """to[begin : begin + values.size] = values; returns the next place."""
    for i in range(values.size):
        to[begin + i] = values[i]
    return begin + values.size


@numba.njit(cache=True)
def acts(force, begin, end):  # type: ignore[no-untyped-def]
    """Is any of force[begin:end] not zero?"""
    found = False
    for i in range(begin, end):
        found = found or force[i] != 0.0
    return found


@numba.njit(cache=True, fastmath=FAST)
def two_dots(row, u, v):  # type: ignore[no-untyped-def]
    """row . u and row . v, row read once."""
    a = b = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
        b += row[i] * v[i]
    return a, b


@numba.njit(cache=True, fastmath=FAST)
def dot(row, u):  # type: ignore[no-untyped-def]
    """row . u"""
    a = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
    return a


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
def look(model, after, rated):  # type: ignore[no-untyped-def]
    """Gaps, and their rates where asked for, of a motion."""
    m = after.gap.size
    np.dot(model.rows[:m], after.x[0], after.gap)
    if rated:
        np.dot(model.rows[:m], after.x[1], after.rate)
    for i in range(m):
        after.gap[i] += model.gap0[i]
        for j in range(after.support.shape[1]):
            after.gap[i] += model.rows_s[i, j] * after.support[0, j]
            if rated:
                after.rate[i] += model.rows_s[i, j] * after.support[1, j]


@numba.njit(cache=True)
def slide(model, now, after, out):  # type: ignore[no-untyped-def]
    """Tangential displacement of the rubbing channels in a step."""
    m = model.gap0.size
    for i in range(out.size):
        row = model.rows[m + i]
        out[i] = dot(row, after.x[0]) - dot(row, now.x[0])
        for j in range(now.support.shape[1]):
            out[i] += model.rows_s[m + i, j] * (after.support[0, j] - now.support[0, j])


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


@numba.njit(cache=True, fastmath=FAST)
def modal_energies(model, now, after):  # type: ignore[no-untyped-def]
    """Kinetic and strain energy at the end of a step, trapezoidal work of the dampers in it."""
    u0, v0, u1, v1 = now.x[0], now.x[1], after.x[0], after.x[1]
    m, c, k = model.m, model.c, model.k
    kinetic = strain = damped = 0.0
    for i in range(u0.size):
        kinetic += m[i] * v1[i] * v1[i]
        strain += k[i] * u1[i] * u1[i]
        damped += c[i] * (v0[i] + v1[i]) * (u1[i] - u0[i])
    return 0.5 * kinetic, 0.5 * strain, 0.5 * damped


@numba.njit(cache=True)
def massless_work(model, now, after):  # type: ignore[no-untyped-def]
    """Trapezoidal work of the loads on modes without mass."""
    work = 0.0
    u0, u1 = now.x[0], after.x[0]
    for i in range(u0.size):
        if model.m[i] > 0.0:
            continue
        E0 = E1 = 0.0
        for j in range(model.order.size):
            E0 += model.X[j, i] * now.amplitude[j]
            E1 += model.X[j, i] * after.amplitude[j]
        work += 0.5 * (E0 + E1) * (u1[i] - u0[i])
    return work


@numba.njit(cache=True)
def in_channels(model, laws, gap):  # type: ignore[no-untyped-def]
    """Energy of the springs of the channels, and of what balances their preload."""
    energy = contact_energy(laws, gap)
    for i in range(gap.size):
        energy += model.preload[i] * (gap[i] - model.gap0[i])
    return energy


@numba.njit(cache=True)
def boundary(model, x):  # type: ignore[no-untyped-def]
    """Products of the load columns with the motion; damper forces, reactions and momenta at the supports."""
    for j in range(model.order.size):
        x.dots[0, j], x.dots[1, j] = two_dots(model.X[j], x.x[0], x.x[1])
    s, m = x.support, model.gap0.size
    for a in range(s.shape[1]):
        damper = reaction = momentum = 0.0
        for b in range(s.shape[1]):
            damper += model.C_ss[a, b] * s[1, b]
            reaction += model.K_ss[a, b] * s[0, b]
            momentum += model.M_ss[a, b] * s[1, b]
        for j in range(model.order.size):
            if model.column[j] == a and model.order[j] <= ACCELERATION:
                if model.order[j] == VELOCITY:
                    damper -= x.dots[1, j]
                elif model.order[j] == DISPLACEMENT:
                    reaction -= x.dots[0, j]
                else:
                    momentum -= x.dots[1, j]
        for j in range(x.force.size):
            reaction -= model.rows_s[j, a] * (x.force[j] - (model.preload[j] if j < m else 0.0))
        x.damper[a], x.reaction[a], x.momentum[a] = damper, reaction + damper, momentum


@numba.njit(cache=True)
def carried(model, x):  # type: ignore[no-untyped-def]
    """Kinetic and strain energy that the supports take part in."""
    kinetic = strain = 0.0
    s = x.support
    for a in range(s.shape[1]):
        for b in range(s.shape[1]):
            kinetic += 0.5 * s[1, a] * model.M_ss[a, b] * s[1, b]
            strain += 0.5 * s[0, a] * model.K_ss[a, b] * s[0, b]
    for j in range(model.order.size):
        if model.order[j] == ACCELERATION:
            kinetic -= x.dots[1, j] * s[1, model.column[j]]
        elif model.order[j] == DISPLACEMENT:
            strain -= x.dots[0, j] * s[0, model.column[j]]
    return kinetic, strain


@numba.njit(cache=True)
def forces_on_supports(model, now, after):  # type: ignore[no-untyped-def]
    """Trapezoidal work that moving supports do against the channel forces."""
    work = 0.0
    for a in range(now.support.shape[1]):
        ds = after.support[0, a] - now.support[0, a]
        for j in range(now.force.size):
            work -= 0.5 * (now.force[j] + after.force[j]) * model.rows_s[j, a] * ds
    return work


@numba.njit(cache=True)
def books_of_newmark(model, h, now, after):  # type: ignore[no-untyped-def]
    """Damper work at the supports and external work of a step: trapezoidal, inertia by the change of momentum."""
    damping = external = 0.0
    for a in range(now.support.shape[1]):
        ds = after.support[0, a] - now.support[0, a]
        damping += 0.5 * (now.damper[a] + after.damper[a]) * ds
        external += 0.5 * (now.reaction[a] + after.reaction[a]) * ds
        external += (after.momentum[a] - now.momentum[a]) / h * ds
    for j in range(model.order.size):
        du = after.dots[0, j] - now.dots[0, j]
        mean = 0.5 * (now.amplitude[j] + after.amplitude[j])
        if model.order[j] == VELOCITY:
            damping -= mean * du
        elif model.order[j] == FORCE:
            external += mean * du
    return damping, external


@numba.njit(cache=True)
def books_of_exact(model, now, after):  # type: ignore[no-untyped-def]
    """What damper and external work of a step have beside the loads' own work on the modes."""
    k0, s0 = carried(model, now)
    k1, s1 = carried(model, after)
    external = k1 + s1 - k0 - s0 + forces_on_supports(model, now, after)
    for i in range(now.gap.size):
        external += model.preload[i] * (after.gap[i] - now.gap[i])
    damping = 0.0
    for a in range(now.support.shape[1]):
        ds = after.support[0, a] - now.support[0, a]
        for b in range(now.support.shape[1]):
            damping += 0.5 * (now.support[1, b] + after.support[1, b]) * model.C_ss[a, b] * ds
        for j in range(model.order.size):
            if model.order[j] == VELOCITY and model.column[j] == a:
                damping -= (now.dots[1, j] + after.dots[1, j]) * ds
    return damping, external + damping


@numba.njit(cache=True)
def book(model, step, laws, now, after, flown, slip):  # type: ignore[no-untyped-def]
    """The energy columns at the end of a step."""
    e, e0 = after.energy, now.energy
    put(e, 0, e0)
    boundary(model, after)
    kinetic, strain, damped = modal_energies(model, now, after)
    if step.exact:
        damping, external = books_of_exact(model, now, after)
        damping += flown[1]
        external += flown[0] + massless_work(model, now, after)
    else:
        damping, external = books_of_newmark(model, step.h, now, after)
        damping += damped
    more_kinetic, more_strain = carried(model, after)
    e[KINETIC], e[STRAIN] = kinetic + more_kinetic, strain + more_strain
    e[CONTACT] = in_channels(model, laws, after.gap)
    e[DAMPING] += damping
    e[EXTERNAL] += external
    if model.damped:
        e[CONTACT_DAMPING] += damper_work(laws, now.gap, after.gap, after.force)
    m = model.gap0.size
    if slip.size and (acts(now.force, m, now.force.size) or acts(after.force, m, after.force.size)):
        slide(model, now, after, slip)
        for i in range(slip.size):
            e[FRICTION] -= 0.5 * (now.force[m + i] + after.force[m + i]) * slip[i]
    spent = e[DAMPING] + e[CONTACT_DAMPING] + e[FRICTION]
    e[SCHEME] = e[EXTERNAL] + e[INITIAL] - (e[KINETIC] + e[STRAIN] + e[CONTACT]) - spent


@numba.njit(cache=True)
def start_books(model, laws, x):  # type: ignore[no-untyped-def]
    """Take the energy of the first instant as given."""
    boundary(model, x)
    kinetic, strain, _ = modal_energies(model, x, x)
    more_kinetic, more_strain = carried(model, x)
    fill(x.energy, 0.0)
    x.energy[KINETIC], x.energy[STRAIN] = kinetic + more_kinetic, strain + more_strain
    x.energy[CONTACT] = in_channels(model, laws, x.gap)
    x.energy[INITIAL] = x.energy[0] + x.energy[1] + x.energy[2]


@numba.njit(cache=True)
def write(out, row, time, x):  # type: ignore[no-untyped-def]
    """One row of the table."""
    to = out.table[row]
    to[0] = time
    at = put(to, 1, x.gap)
    at = put(to, at, x.force)
    at = put(to, at, x.sliding)
    for i in range(SCHEME + 1):
        to[at + i] = x.energy[i]


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
