"""Kicks of the channels in compiled code: forces at an instant, half of their impulse before it and half after.

Dampers act on the velocity that the kick itself leaves behind: on that in its middle and, so that nothing jitters,
`THETA` - 1/2 of what it has more than the kick before. Friction acts on the way of the step that it begins (`along`).
Forces of all channels that press are found together.
Where a channel has closed in the step before an instant, or opens in the step after it, the half of its kick on that
side gets the share that takes from the motion, or gives back, just what its spring then holds (with what the kick
itself holds, `held_by_kick`), up to `MOST`: else the kink of the law at zero would create or destroy up to
(omega_c h)^2 / 4 of the energy of a touch, at random. A spring's force grows from zero in that half step, a damper's is
there at once: it acts for the time since the touch.
"""

from __future__ import annotations

import math

from creak.contact.step_problem import Unpressed, solve_step, spring_energy, spring_force
from creak.dynamics.books import CONTACT_DAMPING, EXTERNAL, FRICTION, GIVEN
from creak.dynamics.flow.along import forget_touched, look_ahead, slide_on
from creak.dynamics.flow.model import DONE
from creak.dynamics.flow.motion import look_along, quiet
from creak.linalg.by_reference import by_value
from creak.linalg.compiled import inner, inner_fast, with_arrays
from creak.linalg.loops import acts, dot, fill, put

THETA = 0.6
"""Share of a kick that dampers see, less THETA - 1/2 of the kick before."""
RATE = 1e5
"""Rates of a kick over the displacements that stand for them in the problem of the channels, times h: so large that
these displacements do not stretch the springs."""
MOST = 2.0
"""Largest share of half a kick."""
SWEEPS = 3
"""Of the shares of channels that close or open together."""


@inner
def press(model, scheme, A, h, desk, now, after, watched):  # type: ignore[no-untyped-def]
    """Channel forces at an instant, and the first half of their kick; 0 or the code of the contact solver.

    A: None where only springs press, on coordinates with mass: then no solver is compiled. desk: with the loads from
    the instant on. watched: (m,) channels whose gaps are those of the motion; the others are open.
    """
    m, laws, W, gain, light, share = model.gap0.size, scheme.laws, scheme.W, scheme.gain, scheme.light, desk.share
    quiet(after)
    if not (model.presses and any_closed(after)):
        return DONE
    look_along(model, laws, watched, after)
    drifted(laws, W, h, now, share, after)
    if A is None:
        for i in range(m):
            if after.gap[i] < 0.0:
                after.force[i] = spring_force(laws, i, after.gap[i])
    else:
        if after.slip.size > 0:
            look_ahead(model, laws, scheme.P[-1], gain, desk.D, h, desk.steady, now, after, desk.later)
        code = solve_kick(model, laws, A, W, h, now, after, share, desk.factor)
        if code != DONE:
            return code
        slide_on(model, laws, A, RATE, h, after)
    if model.damped:
        book_slack(laws, -h, after, now, after.energy)
    if not acts(after.force, 0, after.force.size):
        return DONE
    closing = False
    for i in range(m):
        share[i] = 1.0
        closing = closing or (after.force[i] > 0.0 and now.gap[i] >= 0.0)
    if closing:
        share_out(laws, W, h, after, now.gap, -1.0, share)
        if model.damped:
            damp_from_touch(laws, h, now, after, share)
    force_on(model, laws, after.force, share, after.F)
    strike(model, gain, light, after)
    turn_rates(laws, W, 0.5 * h, after.force, share, after.rate)
    if A is not None:  # noqa: SIM102 (left out of what is compiled where it is None)
        if light:
            for j in range(after.force.size):
                for i in range(m):
                    after.gap[i] += A[i, j] * after.force[j]
    book_half(model, laws, W, -h, after, share, after.energy)
    if closing:
        if model.damped:
            book_touch(laws, W, h, now, after, share)
        forget_touched(laws, now, after)
        fill(share, 1.0)
        force_on(model, laws, after.force, share, after.F)
    return DONE


@inner
def any_closed(after):  # type: ignore[no-untyped-def]
    """Is any gap closed?"""
    closed = False
    for i in range(after.gap.size):
        closed = closed or after.gap[i] < 0.0
    return closed


@with_arrays
def solve_kick(model, laws, A, W, h, now, after, share, kept):  # type: ignore[no-untyped-def]
    """Forces of channels with dampers or friction, or on coordinates without mass; 0 or the code of their solver.

    What friction changes of the rates of gaps A holds whole, not `THETA` of it.
    """
    m = after.gap.size
    put(after.force, 0, now.force)
    put(after.stuck, 0, now.stuck)
    rate, slip = after.rate[:m].copy(), after.slip.copy()
    for j in range(now.force.size):
        if now.force[j] != 0.0:
            by = (0.5 - THETA if j < m else -0.5) * h * weight(laws, m, share, j) * now.force[j]
            for i in range(m):
                rate[i] += W[j, i] * by
    for i in range(slip.size):
        slip[i] -= model.give[i] * now.force[m + i]
    gap, stuck, force = after.gap.copy(), after.stuck, after.force
    free = Unpressed(gap, rate, slip, RATE / h, RATE, h)
    return solve_step(A, free, by_value(laws), stuck, force, by_value(kept))


@inner
def drifted(laws, W, h, now, share, after):  # type: ignore[no-untyped-def]
    """Change of the rates of closed gaps since the instant before; share: of the second half of a kick there.

    Where a gap was open then, by the mean of both rates: that of the step.
    """
    weigh(laws, share, now)
    for i in range(after.drift.size):
        if after.gap[i] < 0.0 and now.force[i] > 0.0:
            after.drift[i] = after.rate[i] - now.rate[i] - 0.5 * h * dot(W[i], now.weighed)
        elif after.gap[i] < 0.0:
            after.drift[i] = 2.0 * (after.rate[i] - (after.gap[i] - now.gap[i]) / h)
        else:
            after.drift[i] = 0.0


@inner
def settled(W, h, x):  # type: ignore[no-untyped-def]
    """The drift of gaps at rest: what their kicks undo."""
    fill(x.drift, 0.0)
    for j in range(x.force.size):
        if x.force[j] != 0.0:
            for i in range(x.drift.size):
                x.drift[i] -= h * W[j, i] * x.force[j]


@inner
def lessen(model, laws, W, h, now, after, share):  # type: ignore[no-untyped-def]
    """Shares of the second half of a kick where channels open in the step that it begins; True if there are any.

    `after`: the end of that step with the whole kick. The forces on the coordinates become those of the shares.
    """
    fill(share, 1.0)
    opening = False
    for i in range(now.gap.size):
        opening = opening or (now.force[i] > 0.0 and after.gap[i] > 0.0)
    if opening:
        share_out(laws, W, h, now, after.gap, 1.0, share)
        force_on(model, laws, now.force, share, now.F)
    return opening


@inner
def share_out(laws, W, h, x, other, sign, share):  # type: ignore[no-untyped-def]
    """Shares of half a kick of the channels that are open at the `other` end of the step, gaps (m,).

    sign: -1 for the first half, x.rate then being those before it; 1 for the second, those in its middle.
    """
    for _ in range(SWEEPS):
        for i in range(share.size):
            if x.force[i] <= 0.0 or other[i] <= 0.0:
                continue
            spring = spring_force(laws, i, x.gap[i])
            rate = x.rate[i] + 0.25 * h * felt(laws, W, i, x.force, share)
            holds = spring_energy(laws, i, x.gap[i]) - held_by_kick(laws, W, h, x, i)
            work = 0.5 * h * spring * abs(rate)
            if sign * rate > 0.0 and work > 0.0:  # none of a gap that is zero
                share[i] = min(max(holds, 0.0) / work, MOST)
            else:
                share[i] = 1.0


@inner
def since_touch(laws, h, i, now, after, rate):  # type: ignore[no-untyped-def]
    """Time for which the damper of channel i has acted in the half step before an instant, over h / 2; -1: none closed.

    rate: of the gap before its kick.
    """
    if after.force[i] <= 0.0 or now.gap[i] < 0.0 or laws.damping[i] == 0.0 or rate >= 0.0:
        return -1.0
    return min(2.0 * after.gap[i] / (h * rate), MOST)


@inner
def damp_from_touch(laws, h, now, after, share):  # type: ignore[no-untyped-def]
    """Shares of the springs become those of the whole forces, in which dampers act since the touch."""
    for i in range(share.size):
        closed = since_touch(laws, h, i, now, after, after.rate[i])
        if closed >= 0.0:
            spring = spring_force(laws, i, after.gap[i])
            share[i] = (share[i] * spring + closed * (after.force[i] - spring)) / after.force[i]


@inner
def book_touch(laws, W, h, now, after, share):  # type: ignore[no-untyped-def]
    """What dampers took since a touch beyond their part of the share that was booked (`book_half`)."""
    for i in range(share.size):
        turned = h * felt(laws, W, i, after.force, share)
        closed = since_touch(laws, h, i, now, after, after.rate[i] - 0.5 * turned)
        if closed >= 0.0:
            damper = after.force[i] - spring_force(laws, i, after.gap[i])
            more = 0.5 * h * (closed - share[i]) * damper
            after.energy[CONTACT_DAMPING] -= more * (after.rate[i] - 0.25 * turned)


@inner
def held_by_kick(laws, W, h, x, i):  # type: ignore[no-untyped-def]
    """h^2/8 p (W F + 2 a): what a kick holds in its middle of the energy of spring i, force p; a h is the drift.

    Springs and motion keep their sum but for it where a is constant.
    """
    pull = 2.0 * h * x.drift[i]
    for j in range(x.force.size):
        pull += h * h * W[i, j] * x.force[j]
    return 0.125 * pull * spring_force(laws, i, x.gap[i])


@inner
def weight(laws, m, share, j):  # type: ignore[no-untyped-def]
    """Share of channel force j: friction has that of its pressure."""
    return share[j] if j < m else share[laws.rubs[(j - m) // 2]]


@inner
def weigh(laws, share, x):  # type: ignore[no-untyped-def]
    """x.weighed = share x.force"""
    for j in range(x.force.size):
        x.weighed[j] = weight(laws, share.size, share, j) * x.force[j]


@inner
def felt(laws, W, i, force, share):  # type: ignore[no-untyped-def]
    """(W (share force))_i"""
    total = 0.0
    for j in range(force.size):
        if force[j] != 0.0:
            total += W[i, j] * weight(laws, share.size, share, j) * force[j]
    return total


@inner_fast
def force_on(model, laws, force, share, F):  # type: ignore[no-untyped-def]
    """F = push' (share force)"""
    fill(F, 0.0)
    for j in range(force.size):
        if force[j] != 0.0:
            p, push = weight(laws, share.size, share, j) * force[j], model.push[j]
            for i in range(F.size):
                F[i] += p * push[i]


@inner_fast
def strike(model, gain, light, after):  # type: ignore[no-untyped-def]
    """Half a kick on the coordinates; those without mass move at once."""
    F, z = after.F, after.x.reshape(after.x.size)[model.p0 : model.p1]
    for i in range(F.size):
        z[i] += gain[i] * F[i]
    if light:
        u = after.x[0]
        for i in range(F.size):
            if model.m[i] <= 0.0:
                u[i] += F[i] / model.k[i]


@inner
def turn_rates(laws, W, by, force, share, rate):  # type: ignore[no-untyped-def]
    """rate += by W (share force)"""
    for j in range(force.size):
        if force[j] != 0.0:
            p = by * weight(laws, share.size, share, j) * force[j]
            for i in range(rate.size):
                rate[i] += W[j, i] * p


@inner
def book_half(model, laws, W, h, x, share, energy):  # type: ignore[no-untyped-def]
    """What half a kick gives to modes, supports, dampers and friction; x.rate: in the middle of the whole kick.

    h: the step, negative for the half before the instant; the mean force then takes the half after it as a whole one.
    """
    m = x.gap.size
    weigh(laws, share, x)
    for j in range(x.force.size):
        if x.force[j] == 0.0:
            continue
        x.mean[j] = 0.5 * (x.weighed[j] + x.force[j]) if h < 0.0 else x.mean[j] + 0.5 * (x.weighed[j] - x.force[j])
        impulse = 0.5 * abs(h) * weight(laws, m, share, j)
        rate = x.rate[j] + 0.25 * h * dot(W[j], x.weighed)
        carried = 0.0
        for a in range(x.support.shape[1]):
            carried += model.rates_s[j, a] * x.support[1, a]
        energy[GIVEN] += impulse * x.force[j] * (rate - carried)
        energy[EXTERNAL] -= impulse * x.force[j] * carried
        if j >= m:
            if not x.stuck[(j - m) // 2]:
                energy[FRICTION] -= impulse * x.force[j] * rate
        elif model.damped:
            energy[CONTACT_DAMPING] -= impulse * (x.force[j] - spring_force(laws, j, x.gap[j])) * rate


@inner
def book_slack(laws, h, x, other, energy):  # type: ignore[no-untyped-def]
    """What a spring gives in half a step to its own damper where it unloads faster than that lets it go: no force.

    h: the step, negative for the half before the instant. other: the instant at the end of the step on that side; where
    the channel is open there, the spring gives all that it holds.
    """
    for i in range(x.gap.size):
        if x.force[i] == 0.0 and x.gap[i] < 0.0:
            if other.gap[i] > 0.0:
                energy[CONTACT_DAMPING] += math.copysign(spring_energy(laws, i, x.gap[i]), h)
            else:
                energy[CONTACT_DAMPING] += 0.5 * abs(h) * spring_force(laws, i, x.gap[i]) * x.rate[i]
