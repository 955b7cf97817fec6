"""What the usual way costs: steps of plain Newton with refactorisation, timed and scaled to a whole run."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.loads import Loads
from creak.dynamics.plain_newton import PlainNewton
from creak.dynamics.scheme import Scheme
from creak.linalg.threads import one_blas_thread


@dataclass(frozen=True)
class NewtonCost:
    """CPU time of plain Newton's steps on one model."""

    flight_s: float
    """A step without contact, s."""
    contact_s: float
    """A step with contact, s."""
    factorisations: float
    """Of a step with contact."""
    steps: int
    """That were timed of each kind."""

    def run_s(self, steps: int, contact_steps: int) -> float:
        """CPU time of a run with so many steps, some of them in contact."""
        return (steps - contact_steps) * self.flight_s + contact_steps * self.contact_s


def touching(gaps: GapOperator) -> GapOperator:
    """The same channels without clearance: they touch within a few steps."""
    return replace(gaps, gap0=np.zeros(gaps.m))


def newton_cost(system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, steps: int) -> NewtonCost:
    """Time `steps` steps in flight, and as many in contact on the same channels without clearance.

    Every iteration of a step factorises anew, as an implicit code without condensation does.
    """
    flight, _ = _timed(PlainNewton(system, gaps.without_force(), loads, scheme), steps, pressed=False)
    contact, factorisations = _timed(PlainNewton(system, touching(gaps), loads, scheme), steps, pressed=True)
    return NewtonCost(flight, contact, factorisations, steps)


def _timed(stepper: PlainNewton, steps: int, *, pressed: bool) -> tuple[float, float]:
    """Median CPU time and mean factorisations of `steps` steps that end with or without contact."""
    now, seconds, used = stepper.start(), [], []
    with one_blas_thread():
        for _ in range(20 * steps):
            started, before = time.process_time(), stepper.factorisations
            for now in stepper.advance(now):  # noqa: B007, B020
                pass
            if bool(now.p.any()) == pressed:
                seconds.append(time.process_time() - started)
                used.append(stepper.factorisations - before)
            if len(seconds) == steps:
                break
    return (float(np.median(seconds)), float(np.mean(used))) if seconds else (float("nan"), float("nan"))
