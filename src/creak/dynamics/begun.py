"""The first instant of a march, and a step before its acceleration is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.instant import Instant
from creak.dynamics.loads import follow
from creak.dynamics.scheme import Scheme
from creak.dynamics.state import LinearTerms, Outside, Predictor
from creak.linalg.together import Solver

REFRESH = 500
"""Steps after which the carried products are computed anew, so that round-off does not pile up."""


@dataclass
class Begun:
    """A step before its acceleration is known."""

    row: int
    """Row of the loads at its end."""
    support: FloatArray
    half: Predictor
    right_side: FloatArray
    ends: tuple[Outside, Outside]
    """What acts from outside at its beginning and end."""
    fresh: bool
    """Time to compute the carried products anew."""


def begin(terms: LinearTerms, gaps: GapOperator, on: ChannelMatrices, scheme: Scheme, h: float, now: Instant) -> Begun:
    """Loads and right side of the step from `now` that is h long."""
    stride = round(h / terms.loads.step)
    row = now.row + stride
    support = follow(now.support, terms.loads.support[0, row], scheme, h)
    ends = now.outside or terms.outside(now.row, now.support), terms.outside(row, support)
    half, r = terms.begin(now.x, scheme, h, ends)
    on.push(r, scheme.alpha_f * now.force - gaps.resting)
    return Begun(row, support, half, r, ends, row // (REFRESH * stride) != now.row // (REFRESH * stride))


def residual(
    terms: LinearTerms,
    gaps: GapOperator,
    on: ChannelMatrices,
    scheme: Scheme,
    now: Instant,
    after: Instant,
    begun: Begun,
) -> float:
    """|(1 - am) M a1 + am M a0 + (1 - af)(C v1 + K u1 - f1) + af (C v0 + K u0 - f0)| over the largest of its terms."""
    af, am = scheme.alpha_f, scheme.alpha_m
    total, largest = np.zeros(now.x.u.size), 0.0
    for instant, outside, w_f, w_m in ((now, begun.ends[0], af, am), (after, begun.ends[1], 1.0 - af, 1.0 - am)):
        x = instant.x
        inner, heavy = w_f * (x.Cv + x.Ku), w_m * x.Ma
        heavy[terms.driven] += w_m * outside.inertia
        outer = on.push(np.zeros(total.size), instant.force - gaps.resting, w_f)
        outer[terms.driven] += w_f * outside.load
        total += inner + heavy - outer
        largest = max(largest, *(float(np.linalg.norm(term)) for term in (inner, outer, heavy)))
    return float(np.linalg.norm(total)) / largest if largest > 0.0 else 0.0


def first_instant(
    terms: LinearTerms,
    solver: Solver,
    scheme: Scheme,
    gaps: GapOperator,
    on: ChannelMatrices,
    begins: tuple[FloatArray, FloatArray, FloatArray] | None = None,
) -> Instant:
    """State, gaps and forces where the loads begin. Exact contact that starts closed presses from the first step on.

    Parameters
    ----------
    begins : displacement and velocity (n,), and friction forces (2 f,), without which what sticks would be shaken;
        None: at rest, or with the System's initial velocity.
    """
    support = terms.loads.support[:, 0]
    f = gaps.rubbing
    u, v = begins[:2] if begins else terms.at_start()
    gap = np.asarray(gaps.gap0 + on.G @ u + on.G_s @ support[0])
    rate = np.asarray(on.G @ v + on.G_s @ support[1])
    force = gaps.at_start(gap, rate)
    if begins:
        force[gaps.m :] = begins[2]
    x = terms.start(solver, scheme, on.push(np.zeros(terms.system.n), force - gaps.resting), (u, v))
    return Instant(0, x, support, gap, rate, force, np.zeros(2 * f), np.ones(f, dtype=bool))
