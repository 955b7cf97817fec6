"""What is known of a run at one time, and all that a march holds then, from which it can be taken up.

The first instant of a march, and a step before its acceleration is known, are made here. Each piece of a march tells
its `state` and takes it again by `resume`; what follows from the model, the channels and the loads is not among it. The
arrays may be those of the march itself: they are to be written before it goes on."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.loads import follow
from creak.dynamics.scheme import Scheme
from creak.dynamics.state import LinearTerms, Outside, Predictor, State
from creak.linalg.together import Solver


@dataclass(frozen=True)
class Works:
    """Work in the step that ends at an instant, and energy there, where the step knows them better than its ends do."""

    damping: float
    external: float
    kinetic: float
    """Of the coordinates alone."""
    strain: float


@dataclass
class Instant:
    """Motion, prescribed motion, gaps and channel forces at one time."""

    row: int
    """Row of the loads."""
    x: State
    support: FloatArray
    """(3, n_support) prescribed displacement, velocity, acceleration."""
    gap: FloatArray
    """(m,)"""
    rate: FloatArray
    """(m,) of the gaps; zero where nothing asks for it."""
    force: FloatArray
    """(m + 2 f,): p >= 0 of all channels, then both friction forces of each rubbing one."""
    sliding: FloatArray
    """(2 f,) slip velocity of the rubbing channels."""
    stuck: BoolArray
    """(f,) sticking, or open."""
    recent: bool = False
    """A channel pressed in the output step that ends here."""
    outside: Outside | None = None
    """What acts from outside, where it is known."""
    works: Works | None = None
    """None: to be told from both ends of the step."""

    @property
    def p(self) -> FloatArray:
        """(m,) normal forces."""
        return self.force[: self.gap.size]

    @property
    def tau(self) -> FloatArray:
        """(2 f,) friction forces."""
        return self.force[self.gap.size :]


Boundary = tuple[tuple[FloatArray, FloatArray], FloatArray, FloatArray, FloatArray]
"""Damper forces (of supports on q, all on s), reaction of the supports, its momentum, applied forces."""


@dataclass(frozen=True)
class FlightState:
    """Of a stepper between two flights."""

    stages: int
    """Of the rule of its flights."""
    samples: int
    """Of the loads in a flight."""
    because: str
    """What is said of that choice."""
    closed: int
    """Sample up to which contact is looked for."""
    flown_by: int
    """Flights since the products were computed anew."""


@dataclass(frozen=True)
class StepperState:
    """Of a stepper beside its instant."""

    residual: float
    flight: FlightState | None = None


@dataclass(frozen=True)
class AuditState:
    """Of the books."""

    book: FloatArray
    forces: Boundary
    """At the instant."""


@dataclass(frozen=True)
class WatchState:
    """Extremes so far with their times, and the last motions that the next ones are seen with."""

    slip: FloatArray
    slip_at: FloatArray
    gap: FloatArray
    gap_at: FloatArray
    least: FloatArray
    turn: FloatArray
    turn_at: FloatArray
    time: FloatArray
    slid: FloatArray
    last: FloatArray
    below: FloatArray


@dataclass(frozen=True)
class LogState:
    """What was recorded, and what waits to become output."""

    table: FloatArray
    """(used, width) all instants."""
    at: IntArray
    """(n_out,) rows of the table at output steps."""
    displacement: FloatArray
    """(n_out, n_observed)"""
    slip: FloatArray
    """(n_out, m)"""
    ends: IntArray
    """(k,) rows of the table at the whole steps that wait."""
    u: FloatArray
    """(k, width) their motion."""
    s: FloatArray
    """(k, n_support)"""
    whole: FloatArray
    """(n_reached, n) all coordinates at the steps that ask for them."""
    steps: int
    """Whole steps that have become output."""
    looked: int
    """Row of the table up to which the watch has seen."""
    spacing: float
    """As `History.spacing`."""
    watch: WatchState | None

    @property
    def done(self) -> int:
        """Whole steps behind."""
        return self.steps + int(self.ends.size)

    @property
    def time(self) -> float:
        """s, of the last instant."""
        return float(self.table[-1, 0])


@dataclass(frozen=True)
class Saved:
    """A march at an instant."""

    now: Instant
    stepper: StepperState
    audit: AuditState
    log: LogState


class Keeper(Protocol):
    """What a march hands its state to, and takes one from."""

    @property
    def saved(self) -> Saved | None:
        """Where an earlier march stopped; None: begin at the start."""
        ...

    def wanted(self, last: bool) -> bool:
        """Whether it is time; `last`: the march is at its end."""
        ...

    def keep(self, saved: Saved) -> None:
        """Keep it; raises KeyboardInterrupt where the run is to end here."""
        ...

    def heeding(self) -> AbstractContextManager[None]:
        """In it, a wish to end the run waits for `keep`."""
        ...


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
