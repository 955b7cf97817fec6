"""The energies of a march by exact flow.

Between two kicks the motion is exact: its energy changes by the work of the loads, less what the dampers took. What
the scheme leaves over comes from the kicks alone: a channel of force p at the mean rate r of its kick takes h p r out
of the motion, and that is to be what springs store, dampers and friction take. For a linear spring the scheme keeps
T + V - h^2/8 p' (W F + 2 a) exactly, with the kicks F of all channels, W the inverse mass there, and a constant
acceleration a of the gaps between the kicks (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2006, I.1.4 and
XIII.5.3 for a = 0; with it the sum over the kicks is that of the trapezoidal rule): the last term is booked with the
contact. Damping between two kicks breaks that: what a kick gives to modes that are damped within a step they lose in
it, and the springs see nothing of it. The motion is right, h p r is not what the springs gave: `as_springs_saw` puts
their own motion, (g(t + h) - g(t - h)) / 2, in its place.
"""

from __future__ import annotations

import math

from creak.contact.step_problem import spring_force
from creak.dynamics.books import (
    CONTACT,
    CONTACT_DAMPING,
    DAMPING,
    EXTERNAL,
    GIVEN,
    KINETIC,
    STRAIN,
    balance,
    in_channels,
    open_book,
)
from creak.dynamics.flow.model import ACCELERATION, DISPLACEMENT, VELOCITY
from creak.linalg.by_reference import by_reference
from creak.linalg.compiled import inner, inner_fast, outer
from creak.linalg.loops import dot, fill

GAUSS = math.sqrt(0.6)
"""Place of the outer points of Gauss's rule with three, from the middle, in half steps."""


@inner_fast
def stored(model, x):  # type: ignore[no-untyped-def]
    """Kinetic and strain energy, and how much of it is strain of coordinates without mass.

    Of pairs none: these are n^2 products, which many instants share (`Recorder.take`).
    """
    kinetic = strain = light = 0.0
    if model.still.shape[0] == 0:
        u, v = x.x[0], x.x[1]
        for i in range(u.size):
            kinetic += model.m[i] * v[i] * v[i]
            strain += model.k[i] * u[i] * u[i]
        for i in model.massless:
            light += model.k[i] * u[i] * u[i]
    return 0.5 * kinetic, 0.5 * strain, 0.5 * light


@inner
def columns(model, x):  # type: ignore[no-untyped-def]
    """Products of the load columns with the motion."""
    z = x.x.reshape(x.x.size)
    for j in range(model.order.size):
        x.dots[0, j] = dot(model.load_u[j], z[model.u0 : model.u1])
        if model.order[j] == ACCELERATION:
            x.dots[1, j] = dot(model.load_v[j], z[model.v0 : model.v1])


@inner
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


@inner
def work_of_loads(model, drive, h, now, after, short, mean):  # type: ignore[no-untyped-def]
    """Integral of the load columns' amplitudes a (cubics) against their motion w, by parts: a w less that of a' w.

    w is the parabola through both ends that has its mean: what is far faster than the step is gone from that. In short
    steps it is a line. Dampers between modes and supports take from both what they push one of them by.
    """
    work = 0.0
    for j in range(drive.shape[0]):
        a0, a1, a2, a3 = drive[j]
        w0, w1 = now.dots[0, j], after.dots[0, j]
        middle, half = 0.5 * (w0 + w1) if short else dot(model.load_u[j], mean), 0.5 * (w1 - w0)
        bent = 0.75 * (w0 + w1 - 2.0 * middle)
        own = (a0 + h * (a1 + h * (0.5 * a2 + h / 6.0 * a3))) * w1 - a0 * w0
        for q in range(3):
            x = GAUSS * (q - 1)
            t = 0.5 * h * (1.0 + x)
            rate = a1 + t * (a2 + 0.5 * t * a3)
            own -= (4.0 if q == 1 else 2.5) / 9.0 * h * rate * (middle + half * x + bent * (x * x - 1.0 / 3.0))
        work += own if model.order[j] != VELOCITY else -own
    return work


@inner
def squared(s0, s1, a, b, h):  # type: ignore[no-untyped-def]
    """Integral of the product of two supports' velocities, by the trapezoidal rule with its correction at the ends."""
    v0, v1 = s0[1, a] * s0[1, b], s1[1, a] * s1[1, b]
    bend = s0[2, a] * s0[1, b] + s0[1, a] * s0[2, b] - s1[2, a] * s1[1, b] - s1[1, a] * s1[2, b]
    return 0.5 * h * (v0 + v1) + h * h / 12.0 * bend


@inner
def work_on_light(model, now, after):  # type: ignore[no-untyped-def]
    """Trapezoidal work of the loads on coordinates without mass."""
    work = 0.0
    for i in range(model.m.size):
        if model.m[i] <= 0.0:
            load = 0.0
            for j in range(model.order.size):
                load += model.load[j, i] * (now.amplitude[j] + after.amplitude[j])
            work += 0.5 * load * (after.x[0, i] - now.x[0, i])
    return work


@inner
def book_flow(model, drive, h, now, after, short, mean):  # type: ignore[no-untyped-def]
    """Works of a step on the way from now to after; `drive`: amplitudes of the load columns as cubics from its start.

    mean: (u1 - u0,) of z[u0:u1] over the step; in short ones it is not known.

    Those of its kicks were booked with them (`flow.kicks.book_half`).
    """
    e = after.energy
    columns(model, after)
    loads = work_of_loads(model, drive, h, now, after, short, mean)
    k0, s0 = carried(model, now)
    k1, s1 = carried(model, after)
    external = k1 + s1 - k0 - s0 + loads
    for i in range(now.gap.size):
        external += model.preload[i] * (after.gap[i] - now.gap[i])
    given = loads
    for a in range(now.support.shape[1]):
        for b in range(now.support.shape[1]):
            moved = model.C_ss[a, b] * squared(now.support, after.support, a, b, h)
            given += moved
            external += moved
    if model.massless.size > 0:
        given -= work_on_light(model, now, after)
    e[GIVEN] += given
    e[EXTERNAL] += external


@inner
def as_springs_saw(laws, h, steady, now, after):  # type: ignore[no-untyped-def]
    """What the kicks at `now` gave by the motion of springs and dampers, of channels closed before and after it.

    steady: (m + 2 f,) forces that go on between the kicks.
    """
    for i in range(now.gap.size):
        if now.force[i] > 0.0 and now.before[i] < 0.0 and after.gap[i] < 0.0:
            more = 0.5 * (after.gap[i] - now.before[i]) - h * now.rate[i]
            after.energy[GIVEN] += (now.force[i] - steady[i]) * more
            after.energy[CONTACT_DAMPING] -= (now.force[i] - spring_force(laws, i, now.gap[i])) * more


@inner
def complete(model, laws, W, h, steady, x):  # type: ignore[no-untyped-def]
    """The energy columns of an instant from the works so far; h: the step near contact; steady: as for `in_contact`."""
    e = x.energy
    kinetic, strain, light = stored(model, x)
    more_kinetic, more_strain = carried(model, x)
    e[KINETIC], e[STRAIN] = kinetic + more_kinetic, strain + more_strain
    e[CONTACT] = in_contact(model, laws, W, h, x, steady)
    e[DAMPING] = e[GIVEN] - (kinetic + strain - light)
    balance(e)


@inner
def in_contact(model, laws, W, h, x, steady):  # type: ignore[no-untyped-def]
    """Energy of the springs in the middle of a kick; steady: (m + 2 f,) forces that go on between the kicks (`steady`).

    For these c the scheme keeps T + V - h^2/8 (p - c)' (W (F - c) + 2 a), with a of the motion that c acts on too.
    """
    energy = in_channels(laws, model.preload, model.gap0, x.gap)
    for i in range(x.gap.size):
        if x.force[i] != 0.0 or steady[i] != 0.0:
            pull = 2.0 * h * x.drift[i]
            for j in range(x.force.size):
                pull += h * h * W[i, j] * (x.force[j] + steady[j])
            energy -= 0.125 * pull * (spring_force(laws, i, x.gap[i]) - steady[i])
    return energy


@outer
def begin_books(model, laws, W, h, steady, x):  # type: ignore[no-untyped-def]
    """Take the energy of the first instant as given; steady: as for `in_contact`."""
    model, laws, x = by_reference(model), by_reference(laws), by_reference(x)
    columns(model, x)
    kinetic, strain, light = stored(model, x)
    more_kinetic, more_strain = carried(model, x)
    e = x.energy
    fill(e, 0.0)
    e[KINETIC], e[STRAIN] = kinetic + more_kinetic, strain + more_strain
    e[CONTACT] = in_contact(model, laws, W, h, x, steady)
    e[GIVEN] = kinetic + strain - light
    open_book(e)
