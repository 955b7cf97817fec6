"""How long steps in contact may be where contact is condensed to the channels of an unreduced model.

Generalised-alpha with rho_inf = 0 takes out in one step what it does not resolve: a spring that is too stiff for it
stops what meets it, and what is thrown back is never faster than what came (a mass on its spring keeps .80, .66, .62,
.66 of its speed at omega h = 1, 2, 4, 8, at most .93; with HHT, alpha = 1 - sqrt(2), up to 1.08, 1.01, 1.79, 2.2). That
is right for a node in front of a structure, whose motion decides the event and is resolved. A mass that is all there is
behind its channel has to rebound from the spring itself: there omega h is at most `RESOLVED`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.condensed import response
from creak.dynamics.flow.resolution import HARD_CONTACT, steepest
from creak.dynamics.scheme import generalised_alpha
from creak.dynamics.step_matrix import Maker, StepFactor, on_cores

IN_CONTACT = generalised_alpha(0.0)
"""Of steps in contact."""
RESOLVED = 0.2
"""Most of omega h where a mass has to rebound: it keeps .99 of its speed, .95 of it at .4."""
LATER = 10
"""Steps after which is asked whether a channel moves more mass than in one: 1.3 to 5 times of a clamped strip (20 us),
twice at the edge of a door, as much of a block."""
ALONE = 1.2
"""Ratio of these masses up to which a mass counts as all that there is."""
FINEST = 16
"""Most parts that a step is divided into for that."""


def steps_in_contact(
    system: System, gaps: GapOperator, step: float, longest: float, maker: Maker = on_cores
) -> tuple[int, GapOperator]:
    """Parts of `step` (s), each at most `longest` (s), and the channels with springs in place of hard contact.

    A hard channel is a spring that turns the mass that it moves within `longest` round in `HARD_CONTACT`, as exact flow
    has it.
    """
    parts = fewest_parts(step, longest)
    can = np.flatnonzero(gaps.can_press())
    if not can.size:
        return parts, gaps
    h = step / parts
    some = gaps.select(can)
    now, later = (_give(system, some, t, maker) for t in (h, LATER * h))
    squared = (math.pi / HARD_CONTACT) ** 2
    hard = np.isinf(some.stiffness) & (np.array(some.laws.curve) < 0)
    springs = np.where(hard, squared / np.diagonal(now), steepest(some.laws))
    alone = np.diagonal(now) <= ALONE * np.diagonal(later)
    if alone.any():
        omega2 = float((np.abs(now[np.ix_(alone, alone)]) @ springs[alone]).max())
        parts *= min(FINEST, max(1, math.ceil(h * math.sqrt(omega2) / RESOLVED)))
    if not hard.any():
        return parts, gaps
    stiffness = gaps.stiffness.copy()
    stiffness[can[hard]] = springs[hard]
    limited = np.isinf(gaps.stiffness)
    return parts, replace(gaps.with_stiffness(stiffness), step_limited=limited)


def fewest_parts(step: float, longest: float) -> int:
    """Of `step` (s), each at most `longest` (s)."""
    return math.ceil(step / longest * (1.0 - 1e-9))


def _give(system: System, gaps: GapOperator, h: float, maker: Maker) -> FloatArray:
    """(m, m) what a force on one channel moves of the others within h, over h^2 / 2: the inverse of a mass."""
    rows = channel_matrices(system, gaps).G
    answers, _ = response(StepFactor(system, IN_CONTACT, h, maker), rows, keep=False)
    return np.asarray(2.0 * IN_CONTACT.beta * (1.0 - IN_CONTACT.alpha_f) * answers)
