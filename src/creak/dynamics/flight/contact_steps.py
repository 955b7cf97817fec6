"""How long steps in contact may be where contact is condensed to the channels of an unreduced model.

Generalised-alpha with rho_inf = 0 takes out in one step what it does not resolve: a spring that is too stiff for it
stops what meets it, and what is thrown back is never faster than what came (a mass on its spring keeps .80, .66, .62,
.66 of its speed at omega h = 1, 2, 4, 8, at most .93; with HHT, alpha = 1 - sqrt(2), up to 1.08, 1.01, 1.79, 2.2). That
is right for a node in front of a structure, whose motion decides the event and is resolved. A mass that is all there is
behind its channel has to rebound from the spring itself: there omega h is at most `RESOLVED`, and with a damper in the
channel h c / m at most `DAMPED`.

No time is known beforehand: what a constant force moves in n steps, over its square, is the inverse of the mass that
it reaches by then. A mass alone is the same in one step and in ten. That of a structure grows, as waves run into it,
and of one that nothing holds it stands still once they have come back: a blow lasts as long, and is to have
`SHORTEST` steps.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from creak.arrays import BoolArray, FloatArray, Matrix
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.condensed import response
from creak.dynamics.flow.resolution import Resolution, steepest
from creak.dynamics.scheme import generalised_alpha
from creak.dynamics.step_matrix import StepFactor

IN_CONTACT = generalised_alpha(0.0)
"""Of steps in contact."""
RESOLVED = 0.05
"""Most of omega h where a mass has to rebound: it keeps .9995 of its speed, .998 of it at .1."""
DAMPED = 0.005
"""Most of h c / m there: the force of a damper sets in at once, somewhere within a step, and half of this share of the
speed that is left is what that costs."""
LATER = 10
"""Steps after which is asked whether a channel moves more mass than in one: 1.3 to 5 times of a clamped strip (20 us),
twice at the edge of a door, as much of a block."""
ALONE = 1.2
"""Ratio of these masses up to which a mass counts as all that there is."""
SHORTEST = 1000
"""Steps of a blow; its impulse is then within .5 %. A mass that does not grow by `GROWS` from then to `AFTER` times as
long has been reached in whole (waves: 4, bending: 2, a structure that is held: 16)."""
AFTER, GROWS = 4, 1.5
QUICK = 0.01
"""omega h of a spring against that mass up to which the blow is the spring's, which is resolved."""
FINEST = 64
"""Most parts that a step is divided into for that, and for a mass that rebounds."""
REBOUND = 40
"""Of these for a hard contact of a mass: it lasts 3 % of a flight step."""


def steps_in_contact(system: System, gaps: GapOperator, step: float, resolution: Resolution) -> tuple[int, GapOperator]:
    """Parts of `step` (s), each at most the share `resolution.stepped` of it, and the channels with springs for hard
    contact.

    A hard channel is a spring that the step just carries against the mass that it moves within one: omega h = 1, and
    `resolution.hard` times as stiff. Where a mass rebounds, no spring is stiffer than omega h = `RESOLVED`, and h c / m
    is `DAMPED` at most.
    """
    parts = fewest = fewest_parts(resolution.stepped)
    can = np.flatnonzero(gaps.can_press())
    if not can.size:
        return parts, gaps
    some = gaps.select(can)
    given: FloatArray = np.where(
        np.isinf(some.stiffness) & (np.array(some.laws.curve) < 0), np.inf, steepest(some.laws)
    )
    rows = channel_matrices(system, some).G

    @cache
    def give(h: float) -> FloatArray:
        return _give(system, rows, h)

    def short(h: float) -> BoolArray:
        whole, later = (np.diagonal(give(t)) for t in (SHORTEST * h, AFTER * SHORTEST * h))
        return (whole < GROWS * later) & (given * whole * h * h > QUICK**2)

    def alone(h: float) -> BoolArray:
        return np.diagonal(give(h)) <= ALONE * np.diagonal(give(LATER * h))

    brief = short(step / parts)
    while parts < FINEST * fewest and short(step / parts).any():
        parts *= 2
    if alone(step / parts)[brief].all():  # no wave has been seen
        parts = fewest
    h = step / parts
    springs = np.where(np.isinf(given), resolution.hard / (h * h * np.diagonal(give(h))), given)
    block = np.flatnonzero(alone(h))
    if block.size:
        reach = np.abs(give(h)[np.ix_(block, block)])
        omega2 = float((reach @ np.where(np.isinf(given[block]), 0.0, given[block])).max())
        rate = float((reach @ some.damping[block]).max())
        finer = math.ceil(h * max(math.sqrt(omega2) / RESOLVED, rate / DAMPED))
        finer = max(1, finer, REBOUND * fewest // parts if np.isinf(given[block]).any() else 1)
        parts *= min(finer, max(1, FINEST * fewest // parts))
        springs[block] = np.minimum(given[block], (RESOLVED * parts / step) ** 2 / reach.sum(axis=1))
    if np.array_equal(springs, given):
        return parts, gaps
    stiffness = gaps.stiffness.copy()
    other = springs != given
    stiffness[can[other]] = springs[other]
    limited = np.zeros(gaps.m, dtype=bool)
    limited[can[other]] = True
    return parts, replace(gaps.with_stiffness(stiffness), step_limited=limited)


def fewest_parts(longest: float) -> int:
    """Of a step, each at most the share `longest` of it."""
    return math.ceil((1.0 - 1e-9) / longest)


def _give(system: System, rows: Matrix, h: float) -> FloatArray:
    """(m, m) what a force on one channel moves of the others within h, over h^2 / 2: the inverse of a mass."""
    answers, _ = response(StepFactor(system, IN_CONTACT, h), rows, keep=False)
    return np.asarray(2.0 * IN_CONTACT.beta * (1.0 - IN_CONTACT.alpha_f) * answers)
