"""What rubs, between kicks, in compiled code: where it comes to, and what friction so gives and takes.

Friction in a kick is found from where what it holds is to be a step later, as SHAKE finds the forces of constraints
(Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977): what sticks stays at its place, whatever throws the
structure to and fro between kicks. So it neither creeps, nor gives or takes energy. Of kicks on undamped modes the mean
way of the steps before and after one is h times the rate in its middle; of damped ones it is not.
"""

from __future__ import annotations

import numpy as np

from creak.dynamics.books import FRICTION, GIVEN
from creak.dynamics.flow.motion import place_of
from creak.dynamics.flow.propagator import SINGLE
from creak.dynamics.flow.steady import NONE
from creak.linalg.compiled import inner, inner_fast
from creak.linalg.loops import dot

GIVE = 1e-4
"""Sliding with which a channel that sticks takes up a change of its force, over what that force moves it in a step near
contact: one spring for all steps, far stiffer than any that they resolve. Without it the forces that hold more channels
than the filter leaves modes are not determined, and no solver finds them."""


@inner
def go_ahead(model, P, gain, D, steady, x, out):  # type: ignore[no-untyped-def]
    """z[u0:u1] at the end of a step from x, of which the forces that go on, and no kick, are part."""
    by = 1.0 if steady.mark[0] != NONE else 0.0
    if P.shape[0] == SINGLE:
        ahead_single(P, gain, D, steady.push, steady.lean, by, x, out)
    else:
        ahead_pairs(P, gain, D, steady.push, steady.lean, by, x, out)


@inner_fast
def ahead_single(P, gain, D, push, lean, by, x, out):  # type: ignore[no-untyped-def]
    """Of u of single modes."""
    u0, v0, D0, D1, D2, D3 = x.x[0], x.x[1], D[0], D[1], D[2], D[3]
    uu, uv, q1, q2, q3, q4 = P[0], P[1], P[5], P[6], P[7], P[8]
    for i in range(out.size):
        v, d0 = v0[i] - by * gain[i] * push[i], D0[i] + by * lean[i]
        out[i] = uu[i] * u0[i] + uv[i] * v + q1[i] * d0 + q2[i] * D1[i] + q3[i] * D2[i] + q4[i] * D3[i]


@inner_fast
def ahead_pairs(P, gain, D, push, lean, by, x, out):  # type: ignore[no-untyped-def]
    """Of both members of pairs."""
    n, a0, b0 = x.x.shape[1], x.x[0], x.x[1]
    for i in range(n):
        a, b = a0[i] - by * gain[i] * push[i], b0[i] - by * gain[n + i] * push[n + i]
        to_a, to_b = P[0, i] * a + P[1, i] * b, P[2, i] * a + P[3, i] * b
        for r in range(4):
            da, db, q = D[r, i], D[r, n + i], 4 * (r + 1)
            if r == 0:
                da += by * lean[i]
                db += by * lean[n + i]
            to_a += P[q, i] * da + P[q + 1, i] * db
            to_b += P[q + 2, i] * da + P[q + 3, i] * db
        out[i], out[n + i] = to_a, to_b


@inner
def look_ahead(model, laws, P, gain, D, h, steady, now, after, ahead):  # type: ignore[no-untyped-def]
    """Of what presses and rubs: its place, and how far the coming step takes it from there without a kick (`slip`)."""
    m, u = after.gap.size, after.x.reshape(after.x.size)[model.u0 : model.u1]
    go_ahead(model, P, gain, D, steady, after, ahead)
    for i in range(after.slip.size):
        if after.gap[laws.rubs[i // 2]] < 0.0:
            place = now.place[i] if now.place[i] < np.inf else place_of(model, m + i, u, after, 0.0)
            end = dot(model.rows[m + i], ahead)
            for j in range(after.support.shape[1]):
                s, v, a = after.support[0, j], after.support[1, j], after.support[2, j]
                end += model.rows_s[m + i, j] * (s + h * (v + 0.5 * h * a))
            after.place[i], after.slip[i], after.slid[i] = place, end - place, now.slip[i]


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
