"""Friction of what slides in a long step of lasting contact, in compiled code.

At both points of Gauss the force tau of a sliding channel is mu(|v|) p against its speed v. The speed, and the force p
that presses it, are linear in the forces of all that slides; the other forces follow from these (`held.parts_of`). So
the unknowns are the lines tau = a + b x alone. Where a channel creeps, its own force decides where it goes: Newton on
the projected law (Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991), as in a kick (`contact.coulomb_newton`).
"""

from __future__ import annotations

import numpy as np

from creak.contact.laws.friction import against, coefficient, coefficient_slope
from creak.contact.small_systems import factor_general, solve_factored
from creak.dynamics.flow.held import GAUSS, parts_of
from creak.linalg.compiled import with_arrays
from creak.linalg.loops import dot

MOST_NEWTON = 12
SAME_FORCE = 1e-11
"""What the law lacks at the solution, over the largest force that presses."""


@with_arrays
def slide(laws, held, slot, h, now):  # type: ignore[no-untyped-def]
    """Forces of what slides into held.force, where it sees and is pressed as by no such forces; False: none found."""
    b, c = held.ends[1], held.ends[2]
    s = c - b
    tau = np.zeros(2 * s)
    for j in range(s):
        tau[j] = now.force[held.channel[b + j]]
    J, lack, order = np.empty((2 * s, 2 * s)), np.empty(2 * s), np.empty(2 * s, dtype=np.int64)
    for _ in range(MOST_NEWTON):
        top, worst = 0.0, 0.0
        for j in range(0, s, 2):
            for side in range(2):
                pressed = _law(laws, held, slot, h, tau, j, side, J, lack)
                top = max(top, pressed)
        for k in range(2 * s):
            worst = max(worst, abs(lack[k]))
        if worst <= SAME_FORCE * top:
            for j in range(s):
                held.force[b + j], held.force[c + b + j] = tau[j], tau[s + j]
            return True
        if not worst < np.inf or not factor_general(J, order):
            return False
        solve_factored(J, order, lack)
        for k in range(2 * s):
            tau[k] += lack[k]
    return False


@with_arrays
def _law(laws, held, slot, h, tau, j, side, J, lack):  # type: ignore[no-untyped-def]
    """Two rows of Newton at one point of Gauss, of the tangents j and j + 1; returns the force that presses there.

    lack = mu p z / |z| - tau with z = tau - v / w, w what a force does to its own speed; J = -d lack / d tau, the
    turning of z weighted with mu p / |z| cut at 1.
    """
    b, c = held.ends[1], held.ends[2]
    s = c - b
    to, by = parts_of(held, slot)
    x = GAUSS if side == 1 else -GAUSS
    p, f = held.presses[b + j], (held.channel[b + j] - laws.stiffness.size) // 2
    pressed = held.force[p] + dot(to[p], tau) + x * (held.force[c + p] + dot(to[b + p], tau))
    presses, pressed = pressed > 0.0, max(0.0, pressed)
    t1, t2 = tau[j] + x * tau[s + j], tau[j + 1] + x * tau[s + j + 1]
    v1, v2 = _speed(held, by, h, x, j, tau), _speed(held, by, h, x, j + 1, tau)
    w = 0.5 * (_moved(by, s, h, x, j, j) + _moved(by, s, h, x, j + 1, j + 1))
    turns = w > 0.0
    e1, e2, length, speed = against(t1, t2, v1, v2, w)
    mu = coefficient(speed, laws.mu_static[f], laws.mu_kinetic[f], laws.decay[f], False)
    slope = coefficient_slope(speed, laws.mu_static[f], laws.mu_kinetic[f], laws.decay[f]) * pressed
    turn = min(1.0, mu * pressed / length) if turns and length > 0.0 else 0.0
    q11, q12, q22 = turn * e2 * e2, -turn * e1 * e2, turn * e1 * e1
    k = side * s + j
    lack[k], lack[k + 1] = mu * pressed * e1 - t1, mu * pressed * e2 - t2
    for q in range(2 * s):
        d1, d2 = _moved(by, s, h, x, j, q), _moved(by, s, h, x, j + 1, q)
        weight = x if q >= s else 1.0
        own1, own2 = weight * (q % s == j), weight * (q % s == j + 1)
        z1, z2 = (own1 - d1 / w, own2 - d2 / w) if turns else (0.0, 0.0)
        along = slope * (e1 * d1 + e2 * d2) - (mu * (to[p, q] + x * to[b + p, q]) if presses else 0.0)
        J[k, q] = own1 - q11 * z1 - q12 * z2 + along * e1
        J[k + 1, q] = own2 - q12 * z1 - q22 * z2 + along * e2
    return pressed


@with_arrays
def _speed(held, by, h, x, j, tau):  # type: ignore[no-untyped-def]
    """Of the j-th tangent that slides, at x."""
    b, c = held.ends[1], held.ends[2]
    way = held.seen[b + j] + dot(by[j], tau)
    mean = held.seen[c + b + j] + dot(by[c - b + j], tau)
    return (way + 3.0 * x * (way - 2.0 * mean)) / h


@with_arrays
def _moved(by, s, h, x, j, q):  # type: ignore[no-untyped-def]
    """What the q-th of the forces of sliding does to the speed of tangent j at x."""
    return (by[j, q] + 3.0 * x * (by[j, q] - 2.0 * by[s + j, q])) / h
