"""Time integration of any System with condensed contact: HHT-alpha and generalised-alpha."""

from __future__ import annotations

import copy
import time as clock
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.closing import closes_between
from creak.dynamics.condensed import CondensedContact
from creak.dynamics.energy import EnergyAudit
from creak.dynamics.history import Diverged, History, Interrupted, Stopped
from creak.dynamics.instant import Begun, Instant, Keeper, Saved, StepperState, begin, first_instant, residual
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest, Recorder
from creak.dynamics.scheme import Scheme
from creak.dynamics.state import LinearTerms
from creak.dynamics.step_matrix import StepFactor
from creak.errors import InputError, NumericalError
from creak.linalg.threads import one_blas_thread
from creak.linalg.together import Solver

Progress = Callable[[int, int], None]


class Stepper(Protocol):
    """What `march` drives: a rule that leads from one output step to the next, in one step or several."""

    gaps: GapOperator
    loads: Loads
    on: ChannelMatrices
    terms: LinearTerms
    substeps: int
    setup_s: float

    @property
    def residual(self) -> float: ...

    def start(self) -> Instant: ...

    def advance(self, now: Instant) -> Iterator[Instant]: ...


@runtime_checkable
class Resumable(Protocol):
    """What a stepper has besides where its marches can be taken up."""

    def state(self, now: Instant) -> StepperState | None:
        """What it holds beside `now`; None where `advance` cannot begin there."""
        ...

    def resume(self, state: StepperState) -> None:
        """Go on where another one was."""
        ...


@dataclass
class _Trial:
    """The end of a step if no channel pressed."""

    begun: Begun
    a: FloatArray
    gap: FloatArray
    rate: FloatArray
    slip: FloatArray
    """(2 f,) sliding of the step, length."""


class _Gear:
    """Everything that depends on the step length."""

    def __init__(self, system: System, gaps: GapOperator, on: ChannelMatrices, scheme: Scheme, h: float) -> None:
        self.h = h
        factor = StepFactor(system, scheme, h)
        self.solver: Solver = factor
        self.memory = factor.memory
        self.contact = CondensedContact(gaps, on, factor, scheme, h) if gaps.presses else None

    def by(self, solver: Solver) -> _Gear:
        """The same that solves with another solver of the same matrix."""
        other = copy.copy(self)
        other.solver, other.contact = solver, None if self.contact is None else self.contact.by(solver)
        return other


class CondensedStepper:
    """A step is a back-substitution, the equations of the channels, and their effect on the acceleration.

    With `substeps` > 1 a step is divided as soon as contact could occur in it: a channel presses at its start or
    pressed in the step before (else a long step would carry on with an acceleration that still has a contact force in
    it), or a gap reaches zero at its end or, by the cubic through gaps and gap rates at both ends, in its course.
    """

    def __init__(self, system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, substeps: int = 1) -> None:
        started = clock.perf_counter()
        if loads.n_step % substeps:
            raise InputError(
                f"{loads.n_step} samples of the loads are no whole number of steps",
                where="[time] substeps",
                expected=f"a multiple of {substeps}",
            )
        self.scheme, self.gaps, self.loads, self.substeps = scheme, gaps, loads, substeps
        self.on: ChannelMatrices = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self._begins: tuple[FloatArray, FloatArray, FloatArray] | None = None
        watched = gaps.without_force() if substeps > 1 else gaps
        self._whole = _Gear(system, watched, self.on, scheme, substeps * loads.step)
        self._divided = self._whole if substeps == 1 else None
        self._rated = gaps.has_dampers or substeps > 1
        self.residual = 0.0
        self.setup_s = clock.perf_counter() - started

    @property
    def memory(self) -> float:
        """Bytes that the factor of a whole step holds."""
        return self._whole.memory

    @property
    def solver(self) -> Solver:
        """The factor of a whole step."""
        return self._whole.solver

    def over(
        self, loads: Loads, begins: tuple[FloatArray, FloatArray, FloatArray], solver: Solver | None = None
    ) -> CondensedStepper:
        """The same with other loads of the same step, from a displacement and velocity (n,) and friction forces (2 f,)
        on; factors are shared.

        solver: in place of the factor of a whole step, of a stepper that divides none.
        """
        other = copy.copy(self)
        other.loads, other.terms, other._begins, other.residual = loads, self.terms.under(loads), begins, 0.0
        if solver is not None:
            assert self._divided is self._whole, "steps are divided"
            other._whole = other._divided = self._whole.by(solver)
        return other

    def start(self) -> Instant:
        """The first instant: u = 0, the System's initial velocity, S a = f + G' p - C v - K u."""
        return first_instant(self.terms, self._whole.solver, self.scheme, self.gaps, self.on, self._begins)

    def state(self, now: Instant) -> StepperState | None:
        """What it holds beside `now`; None within an output step."""
        return None if now.row % self.substeps else StepperState(self.residual)

    def resume(self, state: StepperState) -> None:
        """Go on where another one was."""
        self.residual = state.residual

    def advance(self, now: Instant) -> Iterator[Instant]:
        """The instants up to the next output step."""
        if self.substeps == 1:
            yield self._finished(self._whole, now, self._trial(self._whole, now))
            return
        if not (now.recent or now.p.any()):
            trial = self._trial(self._whole, now)
            closes = self.gaps.presses and closes_between(now.gap, now.rate, trial.gap, trial.rate, self._whole.h)
            if not closes:
                yield self._finished(self._whole, now, trial)
                return
        pressed = False
        for part in range(self.substeps):
            now = self._finished(self._gear(), now, self._trial(self._gear(), now))
            pressed = pressed or bool(now.p.any())
            now.recent = pressed and part == self.substeps - 1
            yield now

    def _gear(self) -> _Gear:
        if self._divided is None:
            system = self.terms.system
            self._divided = _Gear(system, self.gaps, self.on, self.scheme, self.loads.step)
        return self._divided

    def _trial(self, gear: _Gear, now: Instant) -> _Trial:
        scheme, h, on = self.scheme, gear.h, self.on
        begun = begin(self.terms, self.gaps, on, scheme, h, now)
        a = gear.solver.solve(begun.right_side)
        half, support = begun.half, begun.support
        c_u, c_v = scheme.beta * h * h, scheme.gamma * h
        rate, slip = np.zeros(self.gaps.m), np.zeros(on.T.shape[0])
        gap = self.gaps.gap0 + on.G @ (half.u + c_u * a) + on.G_s @ support[0]
        if self._rated or slip.size:
            v = half.v + c_v * a
            rate = on.G @ v + on.G_s @ support[1] if self._rated else rate
            slip = h * (on.T @ v + on.T_s @ support[1])
        return _Trial(begun, a, np.asarray(gap), np.asarray(rate), np.asarray(slip))

    def _finished(self, gear: _Gear, now: Instant, trial: _Trial) -> Instant:
        """The step's end with its channel forces."""
        after = self._pressed(gear, now, trial)
        self._check(now, after, trial.begun)
        return after

    def _pressed(self, gear: _Gear, now: Instant, trial: _Trial) -> Instant:
        contact = gear.contact
        if contact is None or not trial.gap.min(initial=0.0) < 0.0:
            return self._open(gear, trial)
        force, stuck = contact.forces(trial.gap, trial.rate, trial.slip, now.stuck, now.force)
        if not force.any():
            return self._open(gear, trial)
        trial.a += contact.acceleration(force)
        self.on.push(trial.begun.right_side, force, 1.0 - self.scheme.alpha_f)
        after = self._open(gear, trial)
        m = self.gaps.m
        after.gap = contact.gaps_after(trial.gap, force)
        if self._rated:
            after.rate = trial.rate + (after.gap - trial.gap) * self.scheme.gamma / (self.scheme.beta * gear.h)
        after.force, after.stuck = force, stuck
        if after.sliding.size:
            slides = (force[:m][self._rubs] > 0.0) & ~stuck
            after.sliding = np.where(np.repeat(slides, 2), contact.sliding_after(trial.slip, force), 0.0)
        return after

    @property
    def _rubs(self) -> IntArray:
        assert self.gaps.friction is not None
        return self.gaps.friction.channels

    def _open(self, gear: _Gear, trial: _Trial) -> Instant:
        """The step's end with the acceleration of the trial; channel forces are not entered yet."""
        begun, f = trial.begun, self.gaps.rubbing
        x = self.terms.advance(begun.half, trial.a, self.scheme, gear.h, begun.fresh, begun.right_side)
        none = np.zeros(self.gaps.m + 2 * f)
        return Instant(
            begun.row,
            x,
            begun.support,
            trial.gap,
            trial.rate,
            none,
            np.zeros(2 * f),
            np.ones(f, dtype=bool),
            outside=begun.ends[1],
        )

    def _check(self, now: Instant, after: Instant, begun: Begun) -> None:
        """Residual of the equations of motion, from products computed anew."""
        if begun.fresh:
            self.residual = max(self.residual, residual(self.terms, self.gaps, self.on, self.scheme, now, after, begun))


def simulate(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    scheme: Scheme,
    asked: OutputRequest,
    *,
    substeps: int = 1,
    progress: Progress | None = None,
) -> History:
    """March the System through the loads with contact in the channels of `gaps`.

    Starts from rest, or the initial velocity of the System, with the acceleration that the step matrix gives
    (S a0 = f + G' p0 - C v0 - K u0, consistent to second order in h also where M is singular). Prescribed motion
    follows the scheme (`loads.follow`).

    Parameters
    ----------
    asked : what of the motion is kept.
    substeps : a step is `substeps` samples of the loads long, and divided into as many near contact.

    Raises
    ------
    InputError : the loads are no whole number of steps.
    NumericalError : the step matrix is singular.
    Stopped : the motion is no longer finite (Diverged), contact has no solution, or Ctrl-C (Interrupted); what was
        computed is in its `history`.
    """
    return march(CondensedStepper(system, gaps, loads, scheme, substeps), asked, progress)


def march(
    stepper: Stepper,
    asked: OutputRequest,
    progress: Progress | None = None,
    keeper: Keeper | None = None,
) -> History:
    """Drive a stepper through its loads, keeping output and the energy balance.

    Parameters
    ----------
    keeper : of a stepper that is `Resumable`: where to go on from, and what is handed the state now and then.
    """
    started = clock.perf_counter()
    gaps, loads, terms, substeps = stepper.gaps, stepper.loads, stepper.terms, stepper.substeps
    n_step = loads.n_step // substeps
    recorder = Recorder(terms.system, stepper.on, gaps, loads, substeps, asked, lean=True)
    audit = EnergyAudit(terms, gaps, stepper.on)
    if keeper is None or keeper.saved is None:
        now = stepper.start()
        recorder.keep(loads.time[0], now, audit.start(now), 0)
    else:
        now = _resumed(keeper.saved, stepper, audit, recorder)
    recorder.setup_s = stepper.setup_s + clock.perf_counter() - started
    try:
        # A motion that leaves the range of numbers is told once, by `Diverged`.
        with (
            one_blas_thread(),
            np.errstate(over="ignore", invalid="ignore"),
            nullcontext() if keeper is None else keeper.heeding(),
        ):
            for n in range(now.row // substeps + 1, n_step + 1):
                for after in stepper.advance(now):
                    energy = audit.step(now, after)
                    if not np.isfinite(energy).all():
                        at, forced = float(loads.time[after.row]), isinstance(stepper, CondensedStepper)
                        raise Diverged(at, recorder.history(stepper.residual), forced=forced)
                    now = after
                    ends = now.row == n * substeps
                    recorder.keep(loads.time[now.row], now, energy, n if ends else None)
                    if keeper is not None and keeper.wanted(now.row == n_step * substeps):
                        _hand_over(keeper, now, stepper, audit, recorder)
                if progress is not None:
                    progress(n, n_step)
    except KeyboardInterrupt as error:
        raise Interrupted(recorder.history(stepper.residual)) from error
    except Stopped:
        raise
    except NumericalError as error:
        why = f"at t = {loads.time[now.row]:.6g} s: {error}"
        raise Stopped(why, recorder.history(stepper.residual)) from error
    return recorder.history(stepper.residual)


def _resumed(saved: Saved, stepper: Stepper, audit: EnergyAudit, recorder: Recorder) -> Instant:
    """Everything as it was; the instant to go on from."""
    assert isinstance(stepper, Resumable)
    stepper.resume(saved.stepper)
    audit.resume(saved.audit)
    recorder.resume(saved.log)
    return saved.now


def _hand_over(keeper: Keeper, now: Instant, stepper: Stepper, audit: EnergyAudit, recorder: Recorder) -> None:
    """Keep the march as it is at `now`, where it can go on from there."""
    state = stepper.state(now) if isinstance(stepper, Resumable) else None
    if state is not None and np.isfinite(audit.state.book).all():
        keeper.keep(Saved(now, state, audit.state, recorder.state))
