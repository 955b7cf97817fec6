"""Time integration of any System: HHT-alpha with condensed contact."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.condensed import ChannelMatrices, CondensedContact, channel_matrices
from creak.dynamics.energy import EnergyAudit
from creak.dynamics.hht import HHT
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.recorder import Recorder
from creak.dynamics.state import LinearTerms, State
from creak.dynamics.step_matrix import StepFactor
from creak.errors import NumericalError
from creak.linalg.threads import one_blas_thread

Progress = Callable[[int, int], None]


@dataclass
class Instant:
    """State, gaps and channel forces at one time."""

    x: State
    gap: FloatArray
    p: FloatArray


class Stepper(Protocol):
    """What `march` drives: a rule that leads from one instant to the next."""

    gaps: GapOperator
    loads: Loads
    on: ChannelMatrices
    terms: LinearTerms
    setup_s: float

    def start(self) -> Instant: ...

    def step(self, n: int, now: Instant) -> Instant: ...


class CondensedHHT:
    """One step of HHT-alpha: a back-substitution, the channels, and their effect on the acceleration."""

    def __init__(self, system: System, gaps: GapOperator, loads: Loads, scheme: HHT) -> None:
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.h = scheme, gaps, loads, loads.step
        self.solver = StepFactor(system, scheme, self.h)
        self.on: ChannelMatrices = channel_matrices(system, gaps)
        self.contact = CondensedContact(gaps, self.on, self.solver, scheme, self.h)
        self.terms = LinearTerms(system, loads)
        self.setup_s = clock.perf_counter() - started

    def start(self) -> Instant:
        """The first instant: u = 0, the System's initial velocity, S a = f + G' p - C v - K u."""
        return first_instant(self.terms, self.solver, self.gaps, self.on)

    def step(self, n: int, now: Instant) -> Instant:
        """From step n - 1 to step n."""
        scheme, h, on = self.scheme, self.h, self.on
        half = self.terms.predict(now.x, scheme, h)
        a = self.solver.solve(self.terms.right_side(n, now.x, half, scheme, on, now.p))
        s, s_dot = self.loads.support[0, n], self.loads.support[1, n]
        gap = self.gaps.gap0 + on.G @ (half.u + scheme.beta * h * h * a) + on.G_s @ s
        p = self.contact.forces(gap, self._closing_rate(half.v + scheme.gamma * h * a, s_dot))
        if p.any():
            a = a + self.contact.acceleration(p)
            gap = gap + self.contact.compliance @ p
        return Instant(self.terms.advance(half, a, scheme, h, n), gap, p)

    def _closing_rate(self, v: FloatArray, s_dot: FloatArray) -> FloatArray:
        if not self.gaps.damping.any():
            return np.zeros(self.gaps.m)
        return np.asarray(self.on.G @ v + self.on.G_s @ s_dot)


def first_instant(terms: LinearTerms, solver: StepFactor, gaps: GapOperator, on: ChannelMatrices) -> Instant:
    """State, gaps and forces at t = 0."""
    s, s_dot = terms.loads.support[:2, 0]
    gap = gaps.gap0 + on.G @ terms.inside_at_rest(0) + on.G_s @ s
    rate = on.G @ (terms.system.velocity + terms.inside_at_rest(1)) + on.G_s @ s_dot
    p = np.where(gap < 0.0, np.maximum(0.0, -gaps.stiffness * gap - gaps.damping * rate), 0.0)
    return Instant(terms.start(solver, np.asarray(on.G.T @ p)), gap, p)


def simulate(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    scheme: HHT,
    *,
    observed: IntArray,
    output_every: int = 1,
    whole_at: IntArray | None = None,
    progress: Progress | None = None,
) -> History:
    """March the System through the loads with contact in the channels of `gaps`.

    Starts from rest, or the initial velocity of the System, with the acceleration that the step matrix gives
    (S a0 = f + G' p0 - C v0 - K u0, consistent to second order in h also where M is singular). Prescribed motion is
    made consistent with the scheme (`Loads.consistent_with`).

    Parameters
    ----------
    observed : (n_label,) physical dof labels whose displacement is kept every `output_every` steps.
    whole_at : sorted steps at which all coordinates are kept, to recover the motion of every node later.

    Raises
    ------
    NumericalError : the step matrix is singular, or the motion is no longer finite.
    """
    stepper = CondensedHHT(system, gaps, loads.consistent_with(scheme), scheme)
    return march(stepper, observed, output_every, progress, whole_at)


def march(
    stepper: Stepper, observed: IntArray, output_every: int = 1, progress: Progress | None = None,
    whole_at: IntArray | None = None,
) -> History:  # fmt: skip
    """Drive a stepper through its loads, keeping output and the energy balance."""
    loads, started = stepper.loads, clock.perf_counter()
    at = np.zeros(0, dtype=np.int64) if whole_at is None else whole_at
    recorder = Recorder(stepper.terms.system, stepper.on, observed, loads, output_every, at)
    audit = EnergyAudit(stepper.terms, stepper.gaps, stepper.on, loads)
    now = stepper.start()
    audit.start(now.x, now.gap, now.p)
    recorder.keep(0, now.gap, now.p, now.x.u)
    setup_s = stepper.setup_s + clock.perf_counter() - started
    contact_steps = 0
    with one_blas_thread():
        for n in range(1, loads.n_step + 1):
            before, now = now, stepper.step(n, now)
            stored = audit.step(n, before.x, now.x, now.gap, before.p, now.p)
            if not np.isfinite(stored):
                raise NumericalError(
                    f"the motion is no longer finite at t = {loads.time[n]:.6g} s (step {n}): "
                    "shorten the step or lower the contact stiffness"
                )
            contact_steps += bool(now.p.any())
            recorder.keep(n, now.gap, now.p, now.x.u)
            if progress is not None:
                progress(n, loads.n_step)
    displacement, slip = recorder.motion_kept()
    return History(
        loads.time, recorder.gap, recorder.force, slip, recorder.index, displacement, audit.table(),
        contact_steps, setup_s, at, recorder.coordinates,
    )  # fmt: skip
