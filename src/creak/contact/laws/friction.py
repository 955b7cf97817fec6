"""Coulomb friction with two tangents: |tau| <= mu p; sliding d != 0 has tau = -mu p d / |d|, sticking has d = 0.

While sliding at the speed v = |d| / step

    mu(v) = kinetic + (static - kinetic) exp(-v / decay),     decay = 0: mu = kinetic,

and a channel that was stuck (or open) sticks up to static p. Once sliding it sticks again up to static p with a decay
and up to kinetic p without one, so that mu(v) has no jump. Source: Coulomb, exponential decay as in Bengisu and Akay,
J. Acoust. Soc. Am. 105, 1999, and Abaqus *FRICTION, EXPONENTIAL DECAY; projection form of Alart and Curnier, Comput.
Methods Appl. Mech. Eng. 92, 1991. Valid for isotropic dry friction, no memory beside stuck or sliding. A decay so
short that compliance x p x (static - kinetic) / (decay step) > 1 leaves several solutions of a step.
"""

from __future__ import annotations

import math

from creak.linalg.compiled import either


@either
def coefficient(speed, static, kinetic, decay, stuck):  # type: ignore[no-untyped-def]
    """mu at a sliding speed; at speed 0 the limit up to which the channel sticks."""
    if decay > 0.0:
        return kinetic + (static - kinetic) * math.exp(-speed / decay)
    return static if stuck else kinetic


@either
def coefficient_slope(speed, static, kinetic, decay):  # type: ignore[no-untyped-def]
    """d mu / d v, time / length, <= 0."""
    return -(static - kinetic) / decay * math.exp(-speed / decay) if decay > 0.0 else 0.0


@either
def against(tau1, tau2, d1, d2, compliance):  # type: ignore[no-untyped-def]
    """Direction and length of z = tau - d / compliance (of -d without one), and how far d goes against it, >= 0."""
    z1, z2 = (tau1 - d1 / compliance, tau2 - d2 / compliance) if compliance > 0.0 else (-d1, -d2)
    length = math.hypot(z1, z2)
    e1, e2 = (z1 / length, z2 / length) if length > 0.0 else (0.0, 0.0)
    return e1, e2, length, max(0.0, -(e1 * d1 + e2 * d2))


@either
def friction_violations(p, tau1, tau2, d1, d2, limit, mu, compliance):  # type: ignore[no-untyped-def]
    """Distances, in force, from sticking and from sliding; one is exactly 0 where Coulomb's law holds.

    limit: coefficient up to which the channel sticks; mu: while sliding at |d|. Sticking: |d| / compliance + excess
    over the cone. Sliding: |tau - P(tau - d / compliance)|, P onto the disk of radius mu p, well-conditioned also for
    tiny d.
    """
    stick = math.hypot(d1, d2) / compliance + max(0.0, math.hypot(tau1, tau2) - limit * p)
    z1, z2 = tau1 - d1 / compliance, tau2 - d2 / compliance
    size = math.hypot(z1, z2)
    inside = mu * p / size if size > mu * p else 1.0
    return stick, math.hypot(tau1 - inside * z1, tau2 - inside * z2)
