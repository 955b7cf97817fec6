"""The energies of a march by exact flow.

Between two kicks the motion is exact: its energy changes by the work of the loads, less what the dampers took. What
the scheme leaves over comes from the kicks alone: a channel of force p at the rate r of the middle of its kick takes
h p r out of the motion, and that is to be what springs store, dampers and friction take. For a linear spring the scheme
keeps T + V - h^2/8 p' W p exactly, W the inverse mass at the channels (Hairer, Lubich, Wanner, Geometric Numerical
Integration, 2006, I.1.4 and XIII.5.3): the last term is booked with the contact.
"""

from __future__ import annotations

import math

import numba

from creak.contact.step_problem import spring_force
from creak.dynamics.modal_books import boundary, carried, forces_on_supports, in_channels, massless_work
from creak.dynamics.modal_model import (
    CONTACT,
    CONTACT_DAMPING,
    DAMPING,
    EXTERNAL,
    FAST,
    FRICTION,
    INITIAL,
    KINETIC,
    SCHEME,
    STRAIN,
    VELOCITY,
    put,
)

GAUSS = math.sqrt(0.6)
"""Place of the outer points of Gauss's rule with three, from the middle, in half steps."""


@numba.njit(cache=True, fastmath=FAST)
def in_motion(model, now, after, gain, kicked):  # type: ignore[no-untyped-def]
    """Energy that the modes with mass gained in a step between its two kicks, and that they have after it."""
    u0, v0, u1, v1, F = now.x[0], now.x[1], after.x[0], after.x[1], now.F
    gained = 0.0
    for i in range(u0.size):
        if model.m[i] > 0.0:
            v = v0[i] + gain[i] * F[i] if kicked else v0[i]
            gained += model.m[i] * (v1[i] * v1[i] - v * v) + model.k[i] * (u1[i] * u1[i] - u0[i] * u0[i])
    return 0.5 * gained


@numba.njit(cache=True, fastmath=FAST)
def stored(model, x):  # type: ignore[no-untyped-def]
    """Kinetic and strain energy of the modes."""
    kinetic = strain = 0.0
    u, v = x.x[0], x.x[1]
    for i in range(u.size):
        kinetic += model.m[i] * v[i] * v[i]
        strain += model.k[i] * u[i] * u[i]
    return 0.5 * kinetic, 0.5 * strain


@numba.njit(cache=True)
def work_of_loads(drive, h, now, after):  # type: ignore[no-untyped-def]
    """Integral of the load columns' amplitudes (cubics) against their motion (the cubic through both ends)."""
    work = 0.0
    for j in range(drive.shape[0]):
        w0, w1, r0, r1 = now.dots[0, j], after.dots[0, j], h * now.dots[1, j], h * after.dots[1, j]
        for q in range(3):
            x = 0.5 + 0.5 * GAUSS * (q - 1)
            t = x * h
            load = drive[j, 0] + t * (drive[j, 1] + t * (0.5 * drive[j, 2] + t / 6.0 * drive[j, 3]))
            rate = 6.0 * x * (1.0 - x) * (w1 - w0) + (1.0 - x) * (1.0 - 3.0 * x) * r0 + x * (3.0 * x - 2.0) * r1
            work += (4.0 if q == 1 else 2.5) / 9.0 * load * rate
    return work


@numba.njit(cache=True)
def at_kick(model, laws, h, after):  # type: ignore[no-untyped-def]
    """What the dampers of the channels and their friction take in a kick."""
    damper = friction = 0.0
    m = after.gap.size
    if model.damped:
        for i in range(m):
            if after.force[i] != 0.0 or after.gap[i] < 0.0:
                damper -= h * (after.force[i] - spring_force(laws, i, after.gap[i])) * after.rate[i]
    for i in range(after.sliding.size):
        friction -= h * after.force[m + i] * after.sliding[i]
    return damper, friction


@numba.njit(cache=True)
def held_by_kick(W, h, force, m):  # type: ignore[no-untyped-def]
    """h^2/8 p' W p: what a kick still holds in its middle. Springs and motion keep their sum but for it."""
    held = 0.0
    for i in range(m):
        if force[i] != 0.0:
            for j in range(m):
                held += force[i] * W[i, j] * force[j]
    return 0.125 * h * h * held


@numba.njit(cache=True)
def book_flow(model, laws, W, drive, h, now, after, gained, light):  # type: ignore[no-untyped-def]
    """The energy columns at the end of a step; `drive`: amplitudes of the load columns as cubics from its start."""
    e, e0 = after.energy, now.energy
    put(e, 0, e0)
    boundary(model, after)
    kinetic, strain = stored(model, after)
    k0, s0 = carried(model, now)
    k1, s1 = carried(model, after)
    loads = work_of_loads(drive, h, now, after)
    external = k1 + s1 - k0 - s0 + forces_on_supports(model, now, after)
    for i in range(now.gap.size):
        external += model.preload[i] * (after.gap[i] - now.gap[i])
    damping = loads - gained
    for a in range(now.support.shape[1]):
        ds = after.support[0, a] - now.support[0, a]
        for b in range(now.support.shape[1]):
            moved = 0.5 * (now.support[1, b] + after.support[1, b]) * model.C_ss[a, b] * ds
            damping += moved
            external += moved
        for j in range(model.order.size):
            if model.order[j] == VELOCITY and model.column[j] == a:
                moved = (now.dots[1, j] + after.dots[1, j]) * ds
                damping -= moved
                external -= moved
    if light:
        external += massless_work(model, now, after)
    damper, friction = at_kick(model, laws, h, after)
    e[KINETIC], e[STRAIN], e[CONTACT] = kinetic + k1, strain + s1, in_channels(model, laws, after.gap)
    e[CONTACT] -= held_by_kick(W, h, after.force, after.gap.size)
    e[DAMPING] += damping
    e[EXTERNAL] += external + loads
    e[CONTACT_DAMPING] += damper
    e[FRICTION] += friction
    spent = e[DAMPING] + e[CONTACT_DAMPING] + e[FRICTION]
    e[SCHEME] = e[EXTERNAL] + e[INITIAL] - (e[KINETIC] + e[STRAIN] + e[CONTACT]) - spent
