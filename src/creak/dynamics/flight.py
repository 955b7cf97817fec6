"""Time integration of high order between contacts, of the second order with short steps in them."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.flight_step import FlightStep
from creak.dynamics.history import History
from creak.dynamics.instant import Instant
from creak.dynamics.loads import Loads
from creak.dynamics.scheme import Scheme
from creak.dynamics.simulate import CondensedStepper, Progress, march
from creak.dynamics.state import LinearTerms
from creak.dynamics.watch import Watched
from creak.errors import InputError


class FlightStepper:
    """A step is taken whole by collocation of order 5, and divided where contact could occur in it.

    That is where a channel presses at its beginning, or where the course of a gap, the quintic through its values,
    rates and accelerations at both ends, comes to zero within its error (`closes_in_flight`). A divided step is first
    tried in `graded` flights, if that is more than one; those of them in which contact could occur are taken sample by
    sample by `scheme` with the equations of the channels.

    A flight needs displacement and velocity alone, and its last stage fulfils the equation of motion, so a change of
    scheme carries no acceleration that does not belong to the forces: nothing has to wait for contact to fade.
    """

    def __init__(
        self, system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, substeps: int, graded: int = 1
    ) -> None:
        if graded < 1 or substeps % graded:
            raise InputError(
                f"a step of {substeps} samples in {graded} flights",
                expected="a number that divides the samples",
                where="graded",
                fix="Take 1, or a divisor of substeps.",
            )
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.substeps = scheme, gaps, loads, substeps
        self.on: ChannelMatrices = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self._strides = (substeps, substeps // graded) if graded > 1 else (substeps,)
        self._flights = [self._flight(0)]
        self._divided: CondensedStepper | None = None
        self.setup_s = clock.perf_counter() - started

    def _flight(self, level: int) -> FlightStep:
        return FlightStep(self.terms, self.gaps, self.on, self._strides[level])

    @property
    def residual(self) -> float:
        """The largest seen by any of the schemes."""
        parts = 0.0 if self._divided is None else self._divided.residual
        return max(parts, *(flight.residual for flight in self._flights))

    def start(self) -> Instant:
        """The first instant, as `CondensedStepper` has it."""
        return self._parts().start()

    def advance(self, now: Instant) -> Iterator[Instant]:
        """The instants up to the next output step."""
        yield from self._cover(now, 0)

    def _cover(self, now: Instant, level: int) -> Iterator[Instant]:
        """One step of this level: in flight, or by those of the level below."""
        if not now.p.any():
            if level == len(self._flights):
                self._flights.append(self._flight(level))
            after, closes = self._flights[level].step(now)
            if not closes:
                yield after
                return
        end = now.row + self._strides[level]
        while now.row < end:
            finer = level + 1 < len(self._strides)
            for after in self._cover(now, level + 1) if finer else self._pressed(now, end):
                yield after
                now = after

    def _pressed(self, now: Instant, end: int) -> Iterator[Instant]:
        """Sample by sample with contact."""
        K, M = self.terms.system.K, self.terms.system.M
        now = replace(now, x=replace(now.x, Ka=np.asarray(K @ now.x.a), Ma=np.asarray(M @ now.x.a)))
        while now.row < end:
            for after in self._parts().advance(now):
                yield after
                now = after

    def _parts(self) -> CondensedStepper:
        if self._divided is None:
            self._divided = CondensedStepper(self.terms.system, self.gaps, self.loads, self.scheme)
        return self._divided


def simulate_high_order(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    scheme: Scheme,
    *,
    observed: IntArray,
    output_every: int = 1,
    whole_at: IntArray | None = None,
    substeps: int = 1,
    graded: int = 1,
    progress: Progress | None = None,
    watched: Watched | None = None,
) -> History:
    """March the System through the loads: flights of `substeps` samples, contact at every sample (`FlightStepper`).

    Loads enter at the stages of a flight, interpolated between the samples (`StageLoads`).

    Parameters
    ----------
    scheme : of the steps with contact.
    others : as for `simulate`.
    graded : flights, dividing `substeps`, that a step near contact is first tried in.

    Raises
    ------
    NumericalError, Stopped : as `simulate`. InputError : `graded` does not divide `substeps`.
    """
    stepper = FlightStepper(system, gaps, loads, scheme, substeps, graded)
    return march(stepper, observed, output_every, progress, whole_at, watched)
