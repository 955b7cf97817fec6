"""The energies of a diagonal System, step by step, in compiled code."""

from __future__ import annotations

import numba

from creak.contact.step_problem import damper_work
from creak.dynamics.books import (
    CONTACT,
    CONTACT_DAMPING,
    DAMPING,
    EXTERNAL,
    FRICTION,
    KINETIC,
    STRAIN,
    balance,
    in_channels,
    open_book,
)
from creak.dynamics.modal.model import (
    ACCELERATION,
    CONSTANT,
    DISPLACEMENT,
    FAST,
    FORCE,
    VELOCITY,
    acts,
    fill,
    put,
    slide,
    two_dots,
)


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
def boundary(model, x):  # type: ignore[no-untyped-def]
    """Products of the load columns with the motion; damper forces, reactions and momenta at the supports."""
    for j in range(model.order.size):
        x.dots[0, j], x.dots[1, j] = two_dots(model.X[j], x.x[0], x.x[1])
    at_supports(model, x)


@numba.njit(cache=True)
def at_supports(model, x):  # type: ignore[no-untyped-def]
    """Damper forces, reactions and momenta at the supports from the products of the load columns with the motion."""
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
        elif model.order[j] == FORCE or (model.order[j] == CONSTANT and model.column[j] == 1):
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
    e[CONTACT] = in_channels(laws, model.preload, model.gap0, after.gap)
    e[DAMPING] += damping
    e[EXTERNAL] += external
    if model.damped:
        e[CONTACT_DAMPING] += damper_work(laws, now.gap, after.gap, after.force)
    m = model.gap0.size
    if slip.size and (acts(now.force, m, now.force.size) or acts(after.force, m, after.force.size)):
        slide(model, now, after, slip)
        for i in range(slip.size):
            e[FRICTION] -= 0.5 * (now.force[m + i] + after.force[m + i]) * slip[i]
    balance(e)


@numba.njit(cache=True)
def start_books(model, laws, x):  # type: ignore[no-untyped-def]
    """Take the energy of the first instant as given."""
    boundary(model, x)
    kinetic, strain, _ = modal_energies(model, x, x)
    more_kinetic, more_strain = carried(model, x)
    fill(x.energy, 0.0)
    x.energy[KINETIC], x.energy[STRAIN] = kinetic + more_kinetic, strain + more_strain
    x.energy[CONTACT] = in_channels(laws, model.preload, model.gap0, x.gap)
    open_book(x.energy)
