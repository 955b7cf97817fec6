"""What rubs, between kicks, in compiled code: where it comes to, and what friction so gives and takes.

Friction in a kick is found from where what it holds is to be a step later, as SHAKE finds the forces of constraints
(Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977): what sticks stays at its place, whatever throws the
structure to and fro between kicks. So it neither creeps, nor gives or takes energy. Of kicks on undamped modes the mean
way of the steps before and after one is h times the rate in its middle; of damped ones it is not.
"""

from __future__ import annotations

import numpy as np

from creak.dynamics.books import FRICTION, GIVEN
from creak.dynamics.flow.motion import fly, place_of
from creak.dynamics.flow.steady import NONE, add
from creak.linalg.compiled import inner
from creak.linalg.loops import dot, fill

GIVE = 1e-4
"""Sliding with which a channel that sticks takes up a change of its force, over what that force moves it in a step near
contact: one spring for all steps, far stiffer than any that they resolve. Without it the forces that hold more channels
than the filter leaves modes are not determined, and no solver finds them."""


@inner
def go_ahead(P, gain, D, steady, x, end):  # type: ignore[no-untyped-def]
    """z at the end of a step from x without a kick at x, but with the forces that go on; x.F, none yet, is used."""
    going = steady.mark[0] != NONE
    if going:
        add(x.F, -1.0, steady.push)
        add(D[0], 1.0, steady.lean)
    fly(P, gain, D, x, end, going)
    if going:
        add(D[0], -1.0, steady.lean)
        fill(x.F, 0.0)


@inner
def look_ahead(model, laws, P, gain, D, h, steady, now, after, later):  # type: ignore[no-untyped-def]
    """Of what presses and rubs: its place, and how far the coming step takes it from there without a kick (`slip`).

    After a step of another kind, which has no place for its end, the way in the step before is that of the structure.
    """
    m, u = after.gap.size, after.x.reshape(after.x.size)[model.u0 : model.u1]
    u_now = now.x.reshape(now.x.size)[model.u0 : model.u1]
    go_ahead(P, gain, D, steady, after, later)
    ahead = later.x.reshape(later.x.size)[model.u0 : model.u1]
    for i in range(after.slip.size):
        if after.gap[laws.rubs[i // 2]] < 0.0:
            place, slid = now.place[i], now.slip[i]
            if place == np.inf:
                place = place_of(model, m + i, u, after, 0.0)
                slid = place - place_of(model, m + i, u_now, now, 0.0)
            end = dot(model.rows[m + i], ahead)
            for j in range(after.support.shape[1]):
                s, v, a = after.support[0, j], after.support[1, j], after.support[2, j]
                end += model.rows_s[m + i, j] * (s + h * (v + 0.5 * h * a))
            after.place[i], after.slip[i], after.slid[i] = place, end - place, slid


@inner
def slide_on(model, laws, A, rate, h, after):  # type: ignore[no-untyped-def]
    """Sliding and place with the forces; rate: of sliding over what A (m + 2 f, m + 2 f) and forces give."""
    m = after.gap.size
    for i in range(after.slip.size):
        if after.force[laws.rubs[i // 2]] <= 0.0:
            after.place[i], after.slip[i] = np.inf, 0.0
            continue
        after.slip[i] += rate * dot(A[m + i], after.force) - model.give[i] * after.force[m + i]
        after.place[i] += after.slip[i]
        if after.stuck[i // 2]:
            after.slip[i] = 0.0
        else:
            after.sliding[i] = after.slip[i] / h


@inner
def forget_touched(laws, now, after):  # type: ignore[no-untyped-def]
    """What touched since the instant before has no place yet: with its share of a kick it goes another way."""
    for i in range(after.slip.size):
        if now.gap[laws.rubs[i // 2]] >= 0.0:
            after.place[i] = np.inf


@inner
def as_slides_went(laws, h, steady, now, after):  # type: ignore[no-untyped-def]
    """What the kicks at `now` gave, and friction took, by the ways of what rubs, closed before and after it.

    steady: (m + 2 f,) forces that go on between the kicks.
    """
    m = now.gap.size
    for i in range(now.slip.size):
        c = laws.rubs[i // 2]
        if now.force[c] > 0.0 and now.before[c] < 0.0 and after.gap[c] < 0.0:
            way, booked = 0.5 * (now.slid[i] + now.slip[i]), h * now.rate[m + i]
            kicked = now.force[m + i] - steady[m + i]
            after.energy[GIVEN] += kicked * (way - booked)
            after.energy[FRICTION] -= kicked * way + steady[m + i] * now.slip[i]
            if not now.stuck[i // 2]:
                after.energy[FRICTION] += now.force[m + i] * booked
