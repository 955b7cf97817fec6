"""Motion between two kicks in compiled code: loads of a step, exact flow, what the channels see of it."""

from __future__ import annotations

import math

import numpy as np

from creak.dynamics.flow.model import CONSTANT, FORCE
from creak.dynamics.flow.propagator import MEAN, SINGLE
from creak.linalg.compiled import inner, inner_fast, with_arrays
from creak.linalg.loops import acts, dot, fill


@inner
def cubic_through(a, b, c, d, third, out):  # type: ignore[no-untyped-def]
    """Value and three derivatives at the first of four samples `third` apart."""
    out[0] = a
    out[1] = (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / (6.0 * third)
    out[2] = (2.0 * a - 5.0 * b + 4.0 * c - d) / (third * third)
    out[3] = (-a + 3.0 * b - 3.0 * c + d) / (third * third * third)


@inner
def quintic_through(s, first, last, T, out):  # type: ignore[no-untyped-def]
    """Value and five derivatives at sample `first` of the quintic that has displacement, velocity and acceleration
    s[:, sample] both there and at sample `last`, T later."""
    p0, v0, a0 = s[0, first], s[1, first], s[2, first]
    way = s[0, last] - p0 - T * (v0 + 0.5 * T * a0)
    turn = T * (s[1, last] - v0 - T * a0)
    bend = T * T * (s[2, last] - a0)
    out[0], out[1], out[2] = p0, v0, a0
    out[3] = 6.0 * (10.0 * way - 4.0 * turn + 0.5 * bend) / T**3
    out[4] = 24.0 * (-15.0 * way + 7.0 * turn - bend) / T**4
    out[5] = 120.0 * (6.0 * way - 3.0 * turn + 0.5 * bend) / T**5


@inner
def value(p, order, h):  # type: ignore[no-untyped-def]
    """Derivative `order` of a polynomial, h later; p: its value and derivatives now."""
    last = p.size - 1
    total = p[last]
    for j in range(last - 1, order - 1, -1):
        total = p[j] + h / (j - order + 1) * total
    return total


@inner
def shift(p, h):  # type: ignore[no-untyped-def]
    """Value and derivatives of a polynomial, h later, in place."""
    for order in range(p.size):
        p[order] = value(p, order, h)


@inner
def mean_value(p, h):  # type: ignore[no-untyped-def]
    """Mean of a polynomial over h."""
    last = p.size - 1
    total = p[last] / (last + 1)
    for j in range(last - 1, -1, -1):
        total = p[j] / (j + 1) + h / (j + 1) * total
    return total


@inner
def load_step(model, row, third, course, drive, D):  # type: ignore[no-untyped-def]
    """Quintics of supports (n_support, 6), cubics of load columns (n_x, 4) and loads (4, p1 - p0) over a flight step.

    Supports go on in displacement, velocity and acceleration from one flight step to the next: a wall whose velocity
    jumped would strike what rests on it.
    """
    for j in range(course.shape[0]):
        quintic_through(model.support[:, :, j], row, row + 3, 3.0 * third, course[j])
    fill(D[0], 0.0)
    fill(D[1], 0.0)
    fill(D[2], 0.0)
    fill(D[3], 0.0)
    for j in range(drive.shape[0]):
        if model.order[j] == CONSTANT:
            fill(drive[j], 0.0)
            drive[j, 0] = 1.0
        else:
            f = model.force if model.order[j] == FORCE else model.support[model.order[j]]
            q = model.column[j]
            cubic_through(f[row, q], f[row + 1, q], f[row + 2, q], f[row + 3, q], third, drive[j])
        if acts(drive[j], 0, 4):
            add_column(drive[j], model.load[j], D)


@inner_fast
def add_column(drive, column, D):  # type: ignore[no-untyped-def]
    """D += drive (4,) times column."""
    a, b, c, d = drive
    D0, D1, D2, D3 = D[0], D[1], D[2], D[3]
    for i in range(column.size):
        x = column[i]
        D0[i] += a * x
        D1[i] += b * x
        D2[i] += c * x
        D3[i] += d * x


@inner_fast
def shift_loads(D, h):  # type: ignore[no-untyped-def]
    """Loads, h later."""
    D0, D1, D2, D3 = D[0], D[1], D[2], D[3]
    half, sixth = 0.5 * h, h / 6.0
    for i in range(D0.size):
        d0, d1, d2, d3 = D0[i], D1[i], D2[i], D3[i]
        D0[i] = d0 + h * (d1 + h * (0.5 * d2 + sixth * d3))
        D1[i] = d1 + h * (d2 + half * d3)
        D2[i] = d2 + h * d3


@inner
def fly(P, gain, D, now, after, kicked):  # type: ignore[no-untyped-def]
    """z after the second half of a kick (force F on the coordinates) and the exact motion of a step."""
    if P.shape[0] == SINGLE:
        fly_single(P, gain, D, now, after, kicked)
    else:
        fly_pairs(P, gain, D, now, after, kicked)


@inner_fast
def fly_single(P, gain, D, now, after, kicked):  # type: ignore[no-untyped-def]
    """u, v of single modes."""
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


@inner_fast
def fly_pairs(P, gain, D, now, after, kicked):  # type: ignore[no-untyped-def]
    """Both members of pairs."""
    n, a0, b0, a1, b1, F = now.x.shape[1], now.x[0], now.x[1], after.x[0], after.x[1], now.F
    for i in range(n):
        a, b = a0[i], b0[i]
        if kicked:
            a += gain[i] * F[i]
            b += gain[n + i] * F[n + i]
        to_a = P[0, i] * a + P[1, i] * b
        to_b = P[2, i] * a + P[3, i] * b
        for r in range(4):
            da, db, q = D[r, i], D[r, n + i], 4 * (r + 1)
            to_a += P[q, i] * da + P[q + 1, i] * db
            to_b += P[q + 2, i] * da + P[q + 3, i] * db
        a1[i], b1[i] = to_a, to_b


@inner
def mean_of(P, D, now, out):  # type: ignore[no-untyped-def]
    """Mean of the displacements z[u0:u1] over a step without a kick."""
    if P.shape[0] == SINGLE:
        mean_single(P, D, now, out)
    else:
        mean_pairs(P, D, now, out)


@inner_fast
def mean_single(P, D, now, out):  # type: ignore[no-untyped-def]
    """Of u of single modes."""
    u0, v0, D0, D1, D2, D3 = now.x[0], now.x[1], D[0], D[1], D[2], D[3]
    uu, uv, q0, q1, q2, q3 = P[MEAN], P[MEAN + 1], P[MEAN + 2], P[MEAN + 3], P[MEAN + 4], P[MEAN + 5]
    for i in range(out.size):
        out[i] = uu[i] * u0[i] + uv[i] * v0[i] + q0[i] * D0[i] + q1[i] * D1[i] + q2[i] * D2[i] + q3[i] * D3[i]


@inner_fast
def mean_pairs(P, D, now, out):  # type: ignore[no-untyped-def]
    """Of both members of pairs."""
    n, a0, b0 = now.x.shape[1], now.x[0], now.x[1]
    for i in range(n):
        a, b = a0[i], b0[i]
        to_a = P[20, i] * a + P[21, i] * b
        to_b = P[22, i] * a + P[23, i] * b
        for r in range(4):
            da, db, q = D[r, i], D[r, n + i], 24 + 4 * r
            to_a += P[q, i] * da + P[q + 1, i] * db
            to_b += P[q + 2, i] * da + P[q + 3, i] * db
        out[i], out[n + i] = to_a, to_b


@inner
def settle_supports(course, h, after):  # type: ignore[no-untyped-def]
    """Motion of the supports at the end of a step."""
    for order in range(3):
        for j in range(course.shape[0]):
            after.support[order, j] = value(course[j], order, h)


@with_arrays
def times(A, x, out):  # type: ignore[no-untyped-def]
    """out = A x"""
    np.dot(A, x, out)


@inner
def look(model, after):  # type: ignore[no-untyped-def]
    """Gaps of a motion, and their rates."""
    look_gaps(model, after)
    look_rates(model, after)


@inner
def look_gaps(model, after):  # type: ignore[no-untyped-def]
    """Gaps of a motion."""
    m, z = after.gap.size, after.x.reshape(after.x.size)
    times(model.rows[:m], z[model.u0 : model.u1], after.gap)
    for i in range(m):
        after.gap[i] += model.gap0[i]
        for j in range(after.support.shape[1]):
            after.gap[i] += model.rows_s[i, j] * after.support[0, j]


@inner
def look_rates(model, after):  # type: ignore[no-untyped-def]
    """Rates of the gaps of a motion."""
    m, z = after.gap.size, after.x.reshape(after.x.size)
    times(model.rates[:m], z[model.v0 : model.v1], after.rate[:m])
    for i in range(m):
        after.rate[i] += dot(model.rates_s[i], after.support[1])


@inner
def look_closed(model, after):  # type: ignore[no-untyped-def]
    """Rates of the closed channels: all that a kick of springs is made from."""
    v = after.x.reshape(after.x.size)[model.v0 : model.v1]
    for i in range(after.gap.size):
        if after.gap[i] < 0.0:
            after.rate[i] = rate_of(model, i, v, after)


@inner
def look_along(model, laws, watched, after):  # type: ignore[no-untyped-def]
    """Rates along the rubbing channels of contacts that are watched (m,)."""
    m, v = after.gap.size, after.x.reshape(after.x.size)[model.v0 : model.v1]
    for i in range(m, after.rate.size):
        if watched[laws.rubs[(i - m) // 2]]:
            after.rate[i] = rate_of(model, i, v, after)


@inner
def gap_of(model, i, u, after):  # type: ignore[no-untyped-def]
    """Gap of a channel."""
    return place_of(model, i, u, after, model.gap0[i])


@inner
def place_of(model, i, u, x, begin):  # type: ignore[no-untyped-def]
    """Where a channel is, across its gap or along it, from `begin` on."""
    place = begin + dot(model.rows[i], u)
    for j in range(x.support.shape[1]):
        place += model.rows_s[i, j] * x.support[0, j]
    return place


@inner
def rate_of(model, i, v, after):  # type: ignore[no-untyped-def]
    """Its rate."""
    return dot(model.rates[i], v) + dot(model.rates_s[i], after.support[1])


@inner
def quiet(after):  # type: ignore[no-untyped-def]
    """No channel forces."""
    fill(after.force, 0.0)
    fill(after.mean, 0.0)
    fill(after.F, 0.0)
    fill(after.sliding, 0.0)
    fill(after.place, np.inf)
    fill(after.slip, 0.0)
    fill(after.slid, 0.0)
    fill(after.stuck, True)


@inner_fast
def band_energies(model, band, D, T, x, out):  # type: ignore[no-untyped-def]
    """sqrt(2 E) by band of the motion about the cubic p that the loads, cubics as well, make each pair follow.

    m p'' + c p' + k p = D, or p' = A p + D, from the third derivative down: what no cubic has is the free motion about
    p. The speed of a mode counts whole where that is more, since a part of it is not seen in the rates of gaps.
    T: 0, or the time in which gaps are held against a straight line; p bends as well then.
    """
    fill(out, 0.0)
    a, b, D0, D1, D2, D3, n = x.x[0], x.x[1], D[0], D[1], D[2], D[3], x.x.shape[1]
    if model.still.shape[0] == 0:
        m, c, k = model.m, model.c, model.k
        for i in range(n):
            if k[i] > 0.0 and m[i] > 0.0:
                p3 = D3[i] / k[i]
                p2 = (D2[i] - c[i] * p3) / k[i]
                p1 = (D1[i] - c[i] * p2 - m[i] * p3) / k[i]
                y = abs(a[i] - (D0[i] - c[i] * p1 - m[i] * p2) / k[i])
                w = max(abs(b[i]), abs(b[i] - p1))
                if T > 0.0:
                    y += (abs(p2) + T / 3.0 * abs(p3)) * model.slow[i]
                out[band[i]] += m[i] * w * w + k[i] * y * y
    else:
        R = model.still
        for i in range(n):
            p, q, bend = 0.0, 0.0, 0.0
            for r in range(3, -1, -1):
                da, db = D[r, i] - p, D[r, n + i] - q
                p, q = R[0, i] * da + R[1, i] * db, R[2, i] * da + R[3, i] * db
                if r > 1 and T > 0.0:
                    bend += (1.0 if r == 2 else T / 3.0) * math.hypot(p, q)
            moving = a[i] * a[i] + b[i] * b[i]
            free = math.hypot(a[i] - p, b[i] - q) + bend * model.slow[i]
            out[band[i]] += max(moving, free * free)
    for i in range(out.size):
        out[i] = math.sqrt(out[i])
