"""Time integration of high order between contacts, of the second order with short steps in them."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.flight.collocation import radau_iia
from creak.dynamics.flight.step import Course, FlightStep, choose
from creak.dynamics.instant import REFRESH, FlightState, Instant, StepperState
from creak.dynamics.loads import Loads
from creak.dynamics.scheme import Scheme
from creak.dynamics.simulate import CondensedStepper
from creak.dynamics.state import LinearTerms

PIECES = 10
"""Of a flight, an output step: where a gap may close in one, the flight ends at its beginning."""

LEAD = 3
"""Short steps that come before contact at the least: they tell its closing speed."""


class FlightStepper:
    """Flights by collocation, each as far as no gap can close, and short steps of `scheme` from there on.

    The course of a gap in a flight is the polynomial of its stages (`Course`), less its error: where that comes to zero
    in a piece of the flight, the flight ends before that piece. From there `scheme` goes sample by sample with the
    equations of the channels, piece by piece until none of them presses, and a flight begins again. Output steps that
    a flight passes are read from its course.

    A flight needs displacement and velocity alone, and its last stage fulfils the equation of motion, so a change of
    scheme carries no acceleration that does not belong to the forces: nothing has to wait for contact to fade.

    Parameters
    ----------
    flight : samples of a flight of order 9. like : the rule of a run that is taken up. Neither: `flight.step.choose`.
    """

    def __init__(
        self,
        system: System,
        gaps: GapOperator,
        loads: Loads,
        scheme: Scheme,
        substeps: int,
        flight: int | None = None,
        like: StepperState | None = None,
    ) -> None:
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.substeps = scheme, gaps, loads, substeps
        self.on: ChannelMatrices = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self._parts = CondensedStepper(system, gaps, loads, scheme)
        if like is not None and like.flight is not None:
            self.rule = radau_iia(like.flight.stages)
            self.stride, self.because = like.flight.samples, like.flight.because
        elif flight is None:
            self.rule, self.stride, self.because = choose(loads, substeps, self._parts.memory)
        else:
            self.rule, self.stride, self.because = radau_iia(5), flight, ""
        self._flight = FlightStep(self.terms, gaps, self.on, self.rule, self.stride)
        pieces = math.ceil(PIECES * self.stride / substeps)
        self._ahead = np.unique(np.linspace(0, self.stride, pieces + 1).round().astype(np.int64))
        self._course: Course | None = None
        self._free = self._closed = 0
        self._flown_by = REFRESH - 1
        self.setup_s = clock.perf_counter() - started

    @property
    def residual(self) -> float:
        """The largest seen by either scheme."""
        return max(self._parts.residual, self._flight.residual)

    def start(self) -> Instant:
        """The first instant, as `CondensedStepper` has it."""
        return self._parts.start()

    def state(self, now: Instant) -> StepperState | None:
        """What it holds beside `now`; None in a flight."""
        if self._course is not None:
            return None
        flight = FlightState(self.rule.stages, self.stride, self.because, self._closed, self._flown_by)
        return StepperState(self.residual, flight)

    def resume(self, state: StepperState) -> None:
        """Go on where another one of the same rule was."""
        assert state.flight is not None
        self._parts.resume(state)
        self._closed, self._flown_by = state.flight.closed, state.flight.flown_by

    def advance(self, now: Instant) -> Iterator[Instant]:
        """The instants up to the next output step."""
        goal = (now.row // self.substeps + 1) * self.substeps
        while now.row < goal:
            if self._course is not None:
                now = self._flown(self._course, goal)
                yield now
            elif now.row < self._closed or now.p.any():
                for after in self._parts.advance(now):
                    now = after
                    if now.row >= self._closed and now.p.any():
                        self._closed = now.row + int(self._ahead[1])
                    yield now
            else:
                self._begin(now)

    def _begin(self, now: Instant) -> None:
        """A flight from `now`, as far as no gap can close; `_closed`: how far contact is looked for behind it."""
        course = self._flight.course(now)
        ahead = now.row + self._ahead
        ahead = ahead[: np.searchsorted(ahead, self.loads.n_step) + 1]
        ahead[-1] = min(ahead[-1], self.loads.n_step)
        pieces, last = course.opens_until(ahead - now.row), ahead.size - 1
        self._free = int(ahead[pieces]) - (LEAD if pieces < last else 0)
        self._closed = int(ahead[min(pieces + 1, last)])
        self._course = course if self._free > now.row else None

    def _flown(self, course: Course, goal: int) -> Instant:
        """The next instant of a flight: its end, or an output step before."""
        row = min(self._free, goal)
        if row < self._free:
            return course.at(row, False)
        self._course, self._flown_by = None, self._flown_by + 1
        after = course.at(row, True)
        if self._flown_by >= REFRESH and row == course.begun.row + course.stride:
            self._flight.refresh(after)
            self._flown_by = 0
        return after
