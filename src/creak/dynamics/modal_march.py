"""Time integration of diagonal Systems in compiled code: the same runs as `simulate`, and the massless boundary."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import failure, law_arrays, solve_channels
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.history import ENERGIES, History, split_columns
from creak.dynamics.loads import Loads
from creak.dynamics.modal_coefficients import (
    MasslessBoundary,
    ModalStep,
    exact_step,
    modal_matrices,
    newmark_step,
)
from creak.dynamics.modal_kernel import (
    ACCELERATION,
    CONSTANT,
    DISPLACEMENT,
    DONE,
    FORCE,
    NOT_FINITE,
    VELOCITY,
    MarchState,
    ModalModel,
    Output,
    march_chunk,
    start_books,
)
from creak.dynamics.modal_massless import check_step
from creak.dynamics.scheme import Scheme
from creak.dynamics.state import LinearTerms
from creak.dynamics.stopped import Diverged, Interrupted, Stopped
from creak.errors import InputError
from creak.linalg.dense_product import symmetric
from creak.linalg.threads import one_blas_thread

CHUNK = 2_000
"""Output steps between two reports of progress."""
BUFFER_MEMORY = 64_000_000
"""Bytes of motion kept before it is turned into output."""

Progress = Callable[[int, int], None]


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
) -> History:
    """March a System with diagonal M, C, K: as `simulate`, with everything of a step in compiled code.

    With a Scheme the result is that of `simulate` up to round-off, with MasslessBoundary that of kick, exact rotation,
    kick (`modal_coefficients`), whose energies are exact in free flight; `scheme` then holds what the kicks of contact
    leave over, a bounded oscillation. Samples of the supports are followed by Newmark's rule with a Scheme and taken as
    they are, linear in between, by MasslessBoundary.

    Parameters
    ----------
    observed : (n_label,) physical dof labels whose displacement is kept every `output_every` steps.
    whole_at : sorted steps at which all coordinates are kept.
    substeps : a step is `substeps` samples of the loads long, and divided into as many near contact. For
        MasslessBoundary see `modal_massless.massless_substeps`.

    Raises
    ------
    InputError : the System is not diagonal; the loads are no whole number of steps; massless boundary: a channel
        without residual flexibility, or a step near contact that does not follow the contact springs.
    Stopped : the motion is no longer finite (Diverged), contact has no solution, or Ctrl-C (Interrupted, at the end of
        a chunk of steps); what was computed is in its `history`.
    """
    return _Run(system, gaps, loads, scheme, substeps, observed, output_every, whole_at).march(progress)


class _Run:
    """Arrays of one run."""

    def __init__(
        self, system: System, gaps: GapOperator, loads: Loads, scheme: Scheme | MasslessBoundary, substeps: int,
        observed: IntArray, output_every: int, whole_at: IntArray | None,
    ) -> None:  # fmt: skip
        self._started = clock.perf_counter()
        if loads.n_step % substeps:
            raise InputError(
                f"{loads.n_step} samples of the loads are no whole number of steps", where="[time] substeps",
                expected=f"a multiple of {substeps}",
            )  # fmt: skip
        self.system, self.gaps, self.loads, self.scheme, self.substeps = system, gaps, loads, scheme, substeps
        self.n_step, self.every = loads.n_step // substeps, output_every
        self.time = np.ascontiguousarray(loads.time, dtype=np.float64)
        m, c, k = modal_matrices(system)
        if isinstance(scheme, MasslessBoundary):
            c = np.where(m > 0.0, c, 0.0)  # coordinates without mass follow their forces at once
        self.on, self.terms, self.laws = channel_matrices(system, gaps), LinearTerms(system, loads), law_arrays(gaps)
        self.model = _model(m, c, k, self.on, self.terms, gaps)
        if isinstance(scheme, MasslessBoundary) and self.model.presses:
            check_step(system, gaps, loads.step)
        self.whole = _step(m, c, k, scheme, substeps * loads.step)
        self.part = self.whole if substeps == 1 else _step(m, c, k, scheme, loads.step)
        self.A_whole = _compliance(self.model, self.whole)
        self.A_part = self.A_whole if substeps == 1 else _compliance(self.model, self.part)
        self.log = _Log(system, self.on, gaps, loads, substeps, observed, output_every, whole_at)

    def march(self, progress: Progress | None) -> History:
        """The whole run, chunk by chunk."""
        now, after = self._start(), _empty_state(self.model, self.loads)
        start_books(self.model, self.laws, now)
        self.log.first(self.loads.time[0], now)
        self.log.setup_s = clock.perf_counter() - self._started
        try:
            self._march_on(now, after, progress)
        except KeyboardInterrupt as error:
            raise Interrupted(self.log.history()) from error
        return self.log.history()

    def _march_on(self, now: MarchState, after: MarchState, progress: Progress | None) -> None:
        done = 0
        while done < self.n_step:
            end = min(done + self.log.chunk, self.n_step)
            out = self.log.room((end - done) * self.substeps)
            with one_blas_thread():
                code, used, kept, swapped, time = march_chunk(
                    self.model, self.laws, self.whole, self.A_whole, self.part, self.A_part, now, after, out,
                    self.time, done, end, self.substeps, self.every, self.log.used,
                )  # fmt: skip
            self.log.take(used, kept, out)
            self._raise(code, float(time))
            now, after, done = (after, now, end) if swapped else (now, after, end)
            if progress is not None:
                progress(done, self.n_step)

    def _raise(self, code: int, time: float) -> None:
        if code == NOT_FINITE:
            raise Diverged(time, self.log.history())
        if code != DONE:
            raise Stopped(f"at t = {time:.6g} s: {failure(code)}", self.log.history())

    def _start(self) -> MarchState:
        """u = 0, the System's initial velocity, and forces and acceleration that go with them."""
        x, model, terms = _empty_state(self.model, self.loads), self.model, self.terms
        x.support[:] = self.loads.support[:, 0]
        for j, (order, column) in enumerate(zip(model.order, model.column, strict=True)):
            loads = {FORCE: self.loads.force[0], CONSTANT: np.ones(1)}
            x.amplitude[j] = loads[order][column] if order >= FORCE else x.support[order, column]
        x.x[0], x.x[1] = terms.inside_at_rest(0), self.system.velocity + terms.inside_at_rest(1)
        if isinstance(self.scheme, MasslessBoundary):
            self._rest_on_springs(x)
        else:
            self._press_at_once(x, self.scheme)
        return x

    def _press_at_once(self, x: MarchState, scheme: Scheme) -> None:
        """Springs and dampers of closed channels; S a = loads + channels - C v - K u."""
        model, gaps, m = self.model, self.gaps, self.gaps.m
        self._look(x)
        k = np.where(np.isfinite(gaps.stiffness), gaps.stiffness, 0.0)
        x.force[:m] = np.where(x.gap < 0.0, np.maximum(0.0, -k * x.gap - gaps.damping * x.rate), 0.0)
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
            solve_channels(A, x.gap.copy(), x.rate.copy(), 0.0, np.zeros(x.sliding.size), 1.0, step.h, self.laws,
                           x.stuck, x.force)  # fmt: skip
        x.F[:] = x.force @ model.rows
        x.x[0, light] += x.F[light] / model.k[light]
        x.gap[:] += A[: x.gap.size] @ x.force

    def _look(self, x: MarchState) -> None:
        m, model = self.gaps.m, self.model
        x.gap[:] = model.gap0 + model.rows[:m] @ x.x[0] + model.rows_s[:m] @ x.support[0]
        x.rate[:] = model.rows[:m] @ x.x[1] + model.rows_s[:m] @ x.support[1]


class _Log:
    """The table of all instants, the motion at output steps, and what they become."""

    def __init__(
        self, system: System, on: ChannelMatrices, gaps: GapOperator, loads: Loads, substeps: int,
        observed: IntArray, every: int, whole_at: IntArray | None,
    ) -> None:  # fmt: skip
        n_step = loads.n_step // substeps
        self._m, self._f2, self._every = gaps.m, on.T.shape[0], every
        self._width = 1 + 2 * gaps.m + 2 * self._f2 + len(ENERGIES)
        self._table, self.used = np.empty((n_step + 1, self._width)), 0
        self._rows = system.rows(observed)
        self._tangents = on.tangents if any(abs(A).max() > 0.0 for A, _ in on.tangents if A.size) else ()
        n_out = n_step // every + 1
        self._at, self._out = np.zeros(n_out, dtype=np.int64), 0
        self._displacement, self._slip = np.zeros((n_out, observed.size)), np.zeros((n_out, gaps.m))
        room = int(np.clip(BUFFER_MEMORY // (8 * max(system.n, 1)), 1, n_out))
        self.chunk = min(CHUNK, room * every)
        kept = self.chunk // every + 1
        self._u, self._s = np.zeros((kept, system.n)), np.zeros((kept, system.supports.count))
        self._whole_at = np.zeros(0, dtype=np.int64) if whole_at is None else np.asarray(whole_at, dtype=np.int64)
        self._whole_time = loads.time[self._whole_at * substeps]
        self._whole = np.zeros((self._whole_at.size, system.n))
        self.setup_s = 0.0

    def first(self, time: float, x: MarchState) -> None:
        """The instant that the run starts from."""
        self._table[0] = np.concatenate([[time], x.gap, x.force, x.sliding, x.energy[: len(ENERGIES)]])
        self.used = 1
        self._u[0], self._s[0] = x.x[0], x.support[0]
        self._flush(1)
        if self._whole_at.size and self._whole_at[0] == 0:
            self._whole[0] = x.x[0]

    def room(self, rows: int) -> Output:
        """Where the next instants go, at most `rows`."""
        if self.used + rows > self._table.shape[0]:
            self._table.resize((max(self.used + rows, 3 * self.used // 2), self._width), refcheck=False)
        at = np.zeros(self._u.shape[0], dtype=np.int64)
        return Output(self._table, at, self._u, self._s, self._whole_at, self._whole)

    def take(self, used: int, kept: int, out: Output) -> None:
        """Account for what a chunk left."""
        self.used = used
        self._at[self._out : self._out + kept] = out.at[:kept]
        self._flush(kept)

    def _flush(self, kept: int) -> None:
        here, Q, S = slice(self._out, self._out + kept), self._u[:kept].T, self._s[:kept].T
        self._displacement[here] = (self._rows[0] @ Q + self._rows[1] @ S).T
        if self._tangents:
            self._slip[here] = np.hypot(*(np.asarray(A @ Q + A_s @ S) for A, A_s in self._tangents)).T
        self._out = here.stop

    def history(self) -> History:
        """All that was kept so far."""
        time, gap, force, tangential, sliding, energy = split_columns(self._table[: self.used], self._m, self._f2)
        n = self._out
        reached = int(np.count_nonzero(self._whole_time <= time[-1]))
        steps = int(np.count_nonzero(force.any(axis=1)))
        return History(
            time, gap, force, self._slip[:n], self._at[:n], self._displacement[:n], energy, steps,
            self.setup_s, self._whole_at[:reached], self._whole[:reached].T, tangential, sliding,
        )  # fmt: skip


def _step(m: FloatArray, c: FloatArray, k: FloatArray, scheme: Scheme | MasslessBoundary, h: float) -> ModalStep:
    return exact_step(m, c, k, h) if isinstance(scheme, MasslessBoundary) else newmark_step(m, c, k, scheme, h)


def _compliance(model: ModalModel, step: ModalStep) -> FloatArray:
    """A (m + 2 f, m + 2 f): displacement of the channels at the end of a step per force there."""
    A = (model.rows * step.gain[0]) @ model.rows.T
    return np.ascontiguousarray(symmetric(A))


def _model(
    m: FloatArray, c: FloatArray, k: FloatArray, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator
) -> ModalModel:
    """Contiguous arrays for the kernel; load columns that are zero are left out."""
    sup, preload = terms.system.supports, np.zeros(gaps.m) if gaps.preload is None else gaps.preload
    blocks = [(ACCELERATION, terms.on_all(-terms.M_qs)), (VELOCITY, terms.on_all(-terms.C_qs)),
              (DISPLACEMENT, terms.on_all(-terms.K_qs)), (FORCE, terms.on_all(terms.B)),
              (CONSTANT, -np.asarray(on.G.T @ preload)[:, None])]  # fmt: skip
    columns = [(order, j, A[:, j]) for order, A in blocks for j in range(A.shape[1]) if A[:, j].any()]
    X = np.ascontiguousarray([x for _, _, x in columns]) if columns else np.zeros((0, m.size))
    rows = np.ascontiguousarray(np.vstack([to_dense(on.G), to_dense(on.T)]), dtype=np.float64)
    return ModalModel(
        m, c, k, rows, np.ascontiguousarray(np.vstack([on.G_s, on.T_s])), gaps.gap0.astype(float), preload,
        bool(gaps.presses), bool(gaps.damping.any()), X, np.array([o for o, _, _ in columns], dtype=np.int64),
        np.array([j for _, j, _ in columns], dtype=np.int64), *(np.ascontiguousarray(A, dtype=float) for A in (
            sup.M_ss, terms.C_ss, sup.K_ss, terms.loads.support, terms.loads.force)),
    )  # fmt: skip


def _empty_state(model: ModalModel, loads: Loads) -> MarchState:
    n, m, f2, n_s = model.m.size, model.gap0.size, model.rows.shape[0] - model.gap0.size, loads.support.shape[2]
    n_x = model.order.size
    return MarchState(
        np.zeros((3, n)), np.zeros(n), np.zeros(m + f2), np.zeros(m), np.zeros(m), np.zeros(f2),
        np.ones(f2 // 2, dtype=np.bool_), np.zeros((3, n_s)), np.zeros(n_x), np.zeros((2, n_x)), np.zeros(n_s),
        np.zeros(n_s), np.zeros(n_s), np.zeros(9), np.zeros(1, dtype=np.bool_),
    )  # fmt: skip

