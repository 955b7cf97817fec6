"""Compiled marches: chunks of steps in one call each, and what is kept, told and raised between them."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from creak.arrays import FloatArray
from creak.contact.step_problem import failure
from creak.dynamics.flow.model import DONE, NOT_FINITE, FlowState
from creak.dynamics.history import Diverged, History, Interrupted, Stopped
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import Output, Recorder
from creak.dynamics.simulate import Progress
from creak.linalg.memory import OutOfMemory
from creak.linalg.threads import one_blas_thread
from creak.progress import silent


class Chunk(NamedTuple):
    """What a call left behind."""

    code: int
    """`DONE`, `NOT_FINITE`, or that of the contact solver."""
    done: int
    """Whole steps from the start of the run."""
    used: int
    """Rows of the table that are taken."""
    kept: int
    """Motions kept."""
    swapped: bool
    """`after` holds the last instant."""
    time: float
    """s, of the last instant"""


class Chunked(Protocol):
    """A compiled stepper: `march_chunks` drives it as `simulate.march` drives a `Stepper`."""

    loads: Loads
    log: Recorder
    n_step: int
    started: float
    """When its setup began, `time.perf_counter`."""

    def start(self) -> FlowState:
        """The first instant, its books opened."""

    def empty(self) -> FlowState:
        """An instant to write into."""

    def kept(self, x: FlowState) -> FloatArray:
        """What the log keeps of a motion."""

    def rows(self, steps: int) -> int:
        """Rows of the table that so many whole steps may take at once."""

    def chunk(self, now: FlowState, after: FlowState, out: Output, begin: int, end: int) -> Chunk:
        """March from whole step `begin` towards `end`."""


def march_chunks(
    run: Chunked,
    progress: Progress | None,
    at: Sequence[int] = (),
    caught: Callable[[FlowState], object] | None = None,
) -> History:
    """The whole run.

    Parameters
    ----------
    at : sorted whole steps, at least 1; at the end of each `caught` is handed the state of the march.

    Raises
    ------
    Stopped : the motion is no longer finite (Diverged), contact has no solution, or Ctrl-C (Interrupted, at the end of
        a chunk); what was computed is in its `history`.
    """
    now, after, log, done = run.start(), run.empty(), run.log, 0
    log.first(run.loads.time[0], now, run.kept(now))
    log.setup_s = clock.perf_counter() - run.started
    told = silent if progress is None else progress
    told(0, run.n_step)
    try:
        while done < run.n_step:
            end = min(done + log.chunk, run.n_step, *(step for step in at if step > done))
            out = _room(log, run.rows(end - done))
            with one_blas_thread():
                left = run.chunk(now, after, out, done, end)
            log.take(left.used, left.kept, out)
            if left.code == NOT_FINITE:
                raise Diverged(float(left.time), log.history())
            if left.code != DONE:
                raise Stopped(f"at t = {left.time:.6g} s: {failure(left.code)}", log.history())
            now, after, done = (after, now, left.done) if left.swapped else (now, after, left.done)
            if caught is not None and done in at:
                caught(now)
            told(done, run.n_step)
    except KeyboardInterrupt as error:
        raise Interrupted(log.history()) from error
    return log.history()


def _room(log: Recorder, rows: int) -> Output:
    """Where the next rows go."""
    try:
        return log.room(rows)
    except OutOfMemory as error:
        history = log.history()
        raise Stopped(f"at t = {history.time[-1]:.6g} s: {error}", history) from error
