"""Time integration of diagonal Systems in compiled code: the same runs as `simulate`, and the massless boundary."""

from __future__ import annotations

import time as clock

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import solve_channels
from creak.dynamics.channels import channel_matrices
from creak.dynamics.chunks import Chunk, march_chunks
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.modal.books import start_books
from creak.dynamics.modal.coefficients import (
    MasslessBoundary,
    ModalStep,
    exact_step,
    modal_matrices,
    newmark_step,
)
from creak.dynamics.modal.kernel import march_chunk
from creak.dynamics.modal.massless import check_step
from creak.dynamics.modal.model import (
    CONSTANT,
    FORCE,
    MarchState,
    ModalModel,
    Output,
)
from creak.dynamics.modal.setup import empty_state, modal_model
from creak.dynamics.record.recorder import Recorder
from creak.dynamics.record.watch import Watched
from creak.dynamics.scheme import Scheme
from creak.dynamics.simulate import Progress
from creak.dynamics.state import LinearTerms
from creak.errors import InputError
from creak.linalg.dense_product import symmetric
from creak.linalg.threads import one_blas_thread


def simulate_modal(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    scheme: Scheme | MasslessBoundary,
    *,
    observed: IntArray,
    output_every: int = 1,
    whole_at: IntArray | None = None,
    progress: Progress | None = None,
    substeps: int = 1,
    watched: Watched | None = None,
) -> History:
    """March a System with diagonal M, C, K: as `simulate`, with everything of a step in compiled code.

    With a Scheme the result is that of `simulate` up to round-off, with MasslessBoundary that of kick, exact rotation,
    kick (`modal.coefficients`), whose energies are exact in free flight; `scheme` then holds what the kicks of contact
    leave over, a bounded oscillation. Samples of the supports are followed by Newmark's rule with a Scheme and taken as
    they are, linear in between, by MasslessBoundary.

    Parameters
    ----------
    observed : (n_label,) physical dof labels whose displacement is kept every `output_every` steps.
    whole_at : sorted steps at which all coordinates are kept. watched : what is looked at at every step's end.
    substeps : a step is `substeps` samples of the loads long, and divided into as many near contact. For
        MasslessBoundary see `modal.massless.massless_substeps`.

    Raises
    ------
    InputError : the System is not diagonal; the loads are no whole number of steps; massless boundary: a channel
        without residual flexibility, or a step near contact that does not follow the contact springs.
    Stopped : the motion is no longer finite (Diverged), contact has no solution, or Ctrl-C (Interrupted, at the end of
        a chunk of steps); what was computed is in its `history`.
    """
    run = _Run(system, gaps, loads, scheme, substeps, observed, output_every, whole_at, watched)
    return march_chunks(run, progress)


class _Run:
    """Arrays of one run."""

    def __init__(
        self,
        system: System,
        gaps: GapOperator,
        loads: Loads,
        scheme: Scheme | MasslessBoundary,
        substeps: int,
        observed: IntArray,
        output_every: int,
        whole_at: IntArray | None,
        watched: Watched | None,
    ) -> None:
        self.started = clock.perf_counter()
        if loads.n_step % substeps:
            raise InputError(
                f"{loads.n_step} samples of the loads are no whole number of steps",
                where="[time] substeps",
                expected=f"a multiple of {substeps}",
            )
        self.system, self.gaps, self.loads, self.scheme, self.substeps = system, gaps, loads, scheme, substeps
        self.n_step = loads.n_step // substeps
        self.time = np.ascontiguousarray(loads.time, dtype=np.float64)
        m, c, k = modal_matrices(system)
        if isinstance(scheme, MasslessBoundary):
            c = np.where(m > 0.0, c, 0.0)  # coordinates without mass follow their forces at once
        self.on, self.terms, self.laws = channel_matrices(system, gaps), LinearTerms(system, loads), gaps.laws
        self.model = modal_model(m, c, k, self.on, self.terms, gaps)
        if isinstance(scheme, MasslessBoundary) and self.model.presses:
            check_step(system, gaps, loads.step)
        self.whole = _step(m, c, k, scheme, substeps * loads.step)
        self.part = self.whole if substeps == 1 else _step(m, c, k, scheme, loads.step)
        self.A_whole = _compliance(self.model, self.whole)
        self.A_part = self.A_whole if substeps == 1 else _compliance(self.model, self.part)
        self.log = Recorder(system, self.on, gaps, loads, substeps, observed, output_every, whole_at, watched)

    def rows(self, steps: int) -> int:
        return steps * self.substeps

    def kept(self, x: MarchState) -> FloatArray:
        return np.asarray(x.x[0])

    def empty(self) -> MarchState:
        return empty_state(self.model, self.loads)

    def chunk(self, now: MarchState, after: MarchState, out: Output, begin: int, end: int) -> Chunk:
        code, *others = march_chunk(
            self.model,
            self.laws,
            self.whole,
            self.A_whole,
            self.part,
            self.A_part,
            now,
            after,
            out,
            self.time,
            begin,
            end,
            self.substeps,
            1,
            self.log.used,
        )
        return Chunk(code, end, *others)

    def start(self) -> MarchState:
        x = self._start()
        start_books(self.model, self.laws, x)
        return x

    def _start(self) -> MarchState:
        """u = 0, the System's initial velocity, and forces and acceleration that go with them."""
        x, model, terms = empty_state(self.model, self.loads), self.model, self.terms
        x.support[:] = self.loads.support[:, 0]
        for j, (order, column) in enumerate(zip(model.order, model.column, strict=True)):
            loads = {FORCE: self.loads.force[0], CONSTANT: np.ones(2)}
            x.amplitude[j] = loads[order][column] if order >= FORCE else x.support[order, column]
        x.x[0], x.x[1] = terms.inside_at_rest(0), self.system.velocity + terms.inside_at_rest(1)
        if isinstance(self.scheme, MasslessBoundary):
            self._rest_on_springs(x)
        else:
            self._press_at_once(x, self.scheme)
        return x

    def _press_at_once(self, x: MarchState, scheme: Scheme) -> None:
        """Springs and dampers of closed channels; S a = loads + channels - C v - K u."""
        model, gaps = self.model, self.gaps
        self._look(x)
        x.force[:] = gaps.at_start(x.gap, x.rate)
        x.F[:] = x.force @ model.rows
        pull = model.X.T @ x.amplitude + x.F - model.c * x.x[1] - model.k * x.x[0]
        x.x[2] = (1.0 - scheme.alpha_m) * self.whole.free[3] * pull

    def _rest_on_springs(self, x: MarchState) -> None:
        """Coordinates without mass in balance with the loads and with the channels that touch."""
        model, step, light = self.model, self.part, self.model.m <= 0.0
        x.x[1, light] = 0.0
        x.x[0, light] = (model.X.T @ x.amplitude)[light] / model.k[light]
        self._look(x)
        if not model.presses or x.gap.min() >= 0.0:
            return
        rows = model.rows[:, light]
        A = np.ascontiguousarray((rows / model.k[light]) @ rows.T)
        with one_blas_thread():
            solve_channels(
                A, x.gap.copy(), x.rate.copy(), 0.0, np.zeros(x.sliding.size), 1.0, step.h, self.laws, x.stuck, x.force
            )
        x.F[:] = x.force @ model.rows
        x.x[0, light] += x.F[light] / model.k[light]
        x.gap[:] += A[: x.gap.size] @ x.force

    def _look(self, x: MarchState) -> None:
        m, model = self.gaps.m, self.model
        x.gap[:] = model.gap0 + model.rows[:m] @ x.x[0] + model.rows_s[:m] @ x.support[0]
        x.rate[:] = model.rows[:m] @ x.x[1] + model.rows_s[:m] @ x.support[1]


def _step(m: FloatArray, c: FloatArray, k: FloatArray, scheme: Scheme | MasslessBoundary, h: float) -> ModalStep:
    return exact_step(m, c, k, h) if isinstance(scheme, MasslessBoundary) else newmark_step(m, c, k, scheme, h)


def _compliance(model: ModalModel, step: ModalStep) -> FloatArray:
    """A (m + 2 f, m + 2 f): displacement of the channels at the end of a step per force there; empty: none presses."""
    rows = model.rows if model.presses else model.rows[:0]
    A = (rows * step.gain[0]) @ rows.T
    return np.ascontiguousarray(symmetric(A))
