"""What the usual way costs: steps of plain Newton with refactorisation, timed and scaled to a whole run.

Beside them the condensed steps on the same matrices.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from creak import GapOperator, Loads, Scheme, System
from creak.stepping import CondensedStepper, Stepper, one_blas_thread
from creak_thesis.plain_newton import PlainNewton


@dataclass(frozen=True)
class NewtonCost:
    """CPU time of plain Newton's steps on one model, and of condensed ones."""

    flight_s: float
    """A step without contact, s."""
    contact_s: float
    """A step with contact, s."""
    factorisations: float
    """Of a step, on average over all that were made with contact about."""
    condensed_flight_s: float
    condensed_contact_s: float
    steps: int
    """That were timed of each kind."""


def touching(gaps: GapOperator) -> GapOperator:
    """The same channels without clearance: they touch within a few steps."""
    return replace(gaps, gap0=np.zeros(gaps.m))


def newton_cost(system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, steps: int) -> NewtonCost:
    """Time `steps` steps in flight, and as many in contact on the same channels without clearance.

    Every iteration of a step factorises anew, as an implicit code without condensation does.
    """
    closed = touching(gaps)
    flight = _timed(PlainNewton(system, gaps.without_force(), loads, scheme), steps, pressed=False)
    newton = PlainNewton(system, closed, loads, scheme)
    contact = _timed(newton, steps, pressed=True)
    condensed = CondensedStepper(system, closed, loads, scheme)
    again = _timed(CondensedStepper(system, gaps.without_force(), loads, scheme), 5 * steps, pressed=False)
    return NewtonCost(
        flight, contact, newton.factorisations / newton.steps, again, _timed(condensed, 5 * steps, pressed=True), steps
    )


def _timed(stepper: Stepper, steps: int, *, pressed: bool) -> float:
    """Median CPU time of `steps` steps that end with or without contact."""
    now, seconds = stepper.start(), []
    with one_blas_thread():
        for _ in range(20 * steps):
            started = time.process_time()
            for now in stepper.advance(now):  # noqa: B007, B020
                pass
            if bool(now.p.any()) == pressed:
                seconds.append(time.process_time() - started)
            if len(seconds) == steps:
                break
    return float(np.median(seconds)) if seconds else float("nan")
