"""Time integration of diagonal Systems by exact flow, with contact resolved in its own time scale."""

from __future__ import annotations

import copy
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import Unpressed, solve_channels
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.chunks import Chunk, march_chunks
from creak.dynamics.diagonal import is_modal, modal_matrices
from creak.dynamics.flow.along import GIVE
from creak.dynamics.flow.block import FEWEST, STEPS, Block, new_block
from creak.dynamics.flow.books import begin_books
from creak.dynamics.flow.coupled import can_couple, coupled_modes
from creak.dynamics.flow.kernel import FULL, Scheme, march, new_desk
from creak.dynamics.flow.kicks import RATE, THETA
from creak.dynamics.flow.lasting import SHORTEST, STIFF, Lasting
from creak.dynamics.flow.model import (
    DONE,
    FlowForm,
    FlowState,
    amplitudes,
    at_start,
    filtered,
    moved_by,
    resting,
    single_modes,
)
from creak.dynamics.flow.resolution import (
    SETTLED,
    FlowSteps,
    Resolution,
    below_parabola,
    flow_steps,
    seen_through,
    steepest,
    straight,
    with_hard,
)
from creak.dynamics.flow.rows import new_cone
from creak.dynamics.flow.steady import NEW, NONE
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import Output, OutputRequest, Recorder
from creak.dynamics.simulate import Progress
from creak.dynamics.state import LinearTerms
from creak.errors import InputError
from creak.linalg.dense_product import symmetric
from creak.linalg.threads import one_blas_thread

SAMPLES = 3
"""Samples of the loads in a flight step: a cubic goes through them and the next."""
ROWS = 4_096
"""Rows of the table that a chunk has room for beside those of its flight steps."""


def simulate_flow(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    asked: OutputRequest,
    *,
    resolution: Resolution = SETTLED,
    progress: Progress | None = None,
    solver: bool = False,
) -> History:
    """March a System with diagonal M, C, K by exact flow between contacts; contact by kick, exact motion, kick.

    A flight step is `SAMPLES` samples of the loads long, which follow a cubic over it. It is halved, and its halves,
    where a gap may close, by a bound that misses nothing between the samples, down to steps that resolve the contact
    springs (`flow.resolution`). Laws are used as they are; hard contact is a spring that is stiff against the structure
    behind its channel (`flow.hard`).

    Parameters
    ----------
    asked : what of the motion is kept; its steps are flight steps.
    resolution : of contact in time.
    solver : take the kernel with the solver of channels that rub or have dampers, as other runs beside this one do,
        also where none is here; each of both kernels is compiled once.

    Raises
    ------
    InputError : the System is not diagonal; the loads are no whole number of flight steps; contact too stiff to be
        resolved; friction or a damper on coordinates without mass; a damper without a spring.
    Stopped : the motion is no longer finite (Diverged), contact has no solution, or Ctrl-C (Interrupted, at the end of
        a chunk of steps); what was computed is in its `history`.
    """
    run = FlowRun(system, gaps, loads, asked, resolution, solver)
    return march_chunks(run, progress)


@dataclass(frozen=True)
class FlowStates:
    """A run of exact flow at some of its instants."""

    coordinates: FloatArray
    """(n, k) of the System."""
    velocities: FloatArray
    """(n, k)"""


def flow_states(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    at: Sequence[int],
    *,
    resolution: Resolution = SETTLED,
    solver: bool = False,
) -> FlowStates:
    """The run of `simulate_flow` at the ends of the sorted flight steps `at`; step 0 is the start.

    It is marched again, as far as the last of them.
    """
    end = SAMPLES * min(loads.n_step // SAMPLES, max(at, default=0) + 1) + 1
    loads = replace(loads, time=loads.time[:end], support=loads.support[:, :end], force=loads.force[:end])
    nothing = np.zeros(0, dtype=np.int64)
    asked = OutputRequest(nothing, max(1, loads.n_step // SAMPLES))
    run = FlowRun(system, gaps, loads, asked, resolution, solver)
    found = [run.form.motion(run.start())] if 0 in at else []
    march_chunks(run, None, at, lambda x: found.append(run.form.motion(x)))
    q, v = (np.array([pair[j] for pair in found]).reshape(len(found), system.n).T for j in (0, 1))
    return FlowStates(q, v)


def with_springs(system: System, gaps: GapOperator, loads: Loads, resolution: Resolution) -> GapOperator:
    """Hard channels with the springs that stand for them in the march of a diagonal System (`flow.hard`)."""
    if not np.isinf(gaps.stiffness).any():
        return gaps
    form = form_of(system, channel_matrices(system, gaps), LinearTerms(system, loads), gaps)
    return gaps.with_stiffness(with_hard(form, gaps.laws, SAMPLES * loads.step, resolution.hard).stiffness)


SHARED = ("stiffness", "damping", "curve", "start", "x", "y", "scale", "rubs")
"""Of the laws: what the resolution of contact hangs on. Friction coefficients are not among them."""


class FlowRun:
    """Arrays of one run, as `simulate_flow`; `again` makes others of the same channels, which share them."""

    def __init__(
        self,
        system: System,
        gaps: GapOperator,
        loads: Loads,
        asked: OutputRequest,
        resolution: Resolution,
        solver: bool = False,
    ) -> None:
        self.started = clock.perf_counter()
        if loads.n_step % SAMPLES:
            raise InputError(
                f"{loads.n_step} samples of the loads are no whole number of flight steps",
                expected=f"a multiple of {SAMPLES}",
            )
        self.system, self.gaps, self.loads = system, gaps, loads
        self._asked, self._resolution, self._solver = asked, resolution, solver
        self.n_step, self.H = loads.n_step // SAMPLES, SAMPLES * loads.step
        self.on, self.terms = channel_matrices(system, gaps), LinearTerms(system, loads)
        self.form = form_of(system, self.on, self.terms, gaps)
        self._resolve()
        self._open_log()

    def again(self, gaps: GapOperator, loads: Loads, system: System | None = None) -> FlowRun:
        """A run of the same System with other numbers of the same channels, and other loads at the same instants.

        What these do not touch is shared, nothing is written to: runs may go side by side.
        """
        before = self.gaps
        same = np.array_equal(gaps.resting, before.resting) and gaps.presses == before.presses
        same = same and gaps.moves_as(before)
        same = same and gaps.has_dampers == before.has_dampers and np.array_equal(gaps.laws.rubs, before.laws.rubs)
        if not same or system is not None or loads.time.size != self.loads.time.size:
            return FlowRun(system or self.system, gaps, loads, self._asked, self._resolution, self._solver)
        other = copy.copy(self)
        other.started = clock.perf_counter()
        other.gaps, other.loads, other.terms = gaps, loads, LinearTerms(self.system, loads)
        given: dict[str, Any] = {
            "gap0": gaps.gap0.astype(float),
            "support": np.ascontiguousarray(loads.support, dtype=float),
            "force": np.ascontiguousarray(loads.force, dtype=float),
        }
        other.form = replace(self.form, model=self.form.model._replace(**given))
        if all(np.array_equal(getattr(gaps.laws, key), getattr(before.laws, key)) for key in SHARED):
            friction = {key: getattr(gaps.laws, key) for key in ("mu_static", "mu_kinetic", "decay")}
            other.steps = replace(self.steps, laws=self.steps.laws._replace(**friction))
            other.scheme = self.scheme._replace(laws=other.steps.laws)
            if gaps.preload is not None:
                given["gap0"] = gaps.with_stiffness(other.steps.laws.stiffness).gap0
            other.model = self.model._replace(**given)
        else:
            other._resolve()
        other._own_work()
        other.log = self.log.again()
        return other

    def _open_log(self) -> None:
        self._own_work()
        between = partial(below_parabola, self.form, self.H) if self.model.presses else None
        self.log = Recorder(
            self.system, self.on, self.gaps, self.loads, SAMPLES, self._asked, self.form.pairs, between=between
        )

    def _own_work(self) -> None:
        """What a run writes to while it goes on."""
        self.block = self._block()
        self.cone = new_cone(2 * self.gaps.m + 2 * (self.model.rows.shape[0] - self.gaps.m))
        self.desk = new_desk(
            self.model, self.loads, self.steps.reach.shape[1], self.steps.levels, self.scheme.lasting.tried
        )

    def _resolve(self) -> None:
        """Steps near contact, and what channels do within one."""
        gaps, resolution = self.gaps, self._resolution
        self.steps: FlowSteps = flow_steps(self.form, gaps.laws, self.H, resolution)
        self.model = filtered(self.form, self.steps.mollifier, self.steps.h, gaps.resting)
        if gaps.preload is not None:
            self.model = self.model._replace(gap0=gaps.with_stiffness(self.steps.laws.stiffness).gap0)
        h, m, k = self.steps.h, self.model.m, self.model.k
        heavy = m > 0.0
        gain = np.where(heavy, 0.5 * h / np.where(heavy, m, 1.0), 0.0)
        if self.form.pairs is not None:
            gain = np.full(2 * m.size, 0.5 * h)
        n = self.model.rows.shape[0] if self.model.presses else 0  # nothing presses: no compliance
        rows, rates, push = self.model.rows[:n], self.model.rates[:n], self.model.push[:n]
        W = symmetric((push * (2.0 / h * gain)) @ rates.T)
        P = np.stack([self.form.flow(self.steps.H / 2**level) for level in range(self.steps.levels + 1)])
        light = not heavy.all()
        static = np.zeros_like(W)
        if light:
            give = np.where(heavy, 0.0, 1.0 / np.where(heavy, 1.0, k))
            normal = rows[: gaps.m]
            light = bool(np.any(normal**2 @ give > 1e-12 * (normal**2 @ (2.0 * h * gain))))
            static[: gaps.m, : gaps.m] = symmetric((normal * give) @ normal.T)
        self._check_light(light)
        self._check_dampers()
        self.solver = bool(self._solver or self.model.damped or self.gaps.rubbing or light)
        self.A = static + h * h / RATE * THETA * W
        along = moved_by(P[-1], 2.0 * gain * push) @ rows[gaps.m :].T / RATE
        self.A[gaps.m :], self.A[: gaps.m, gaps.m :] = along.T, along[: gaps.m]
        own = slice(gaps.m, None)
        give = GIVE * np.diag(self.A)[own]
        self.A[own, own] = symmetric(self.A[own, own]) + np.diag(give)
        self.model = self.model._replace(give=np.ascontiguousarray(RATE * give))
        steps = self.steps
        self.scheme = Scheme(
            steps.H,
            steps.laws,
            steepest(steps.laws),
            P,
            W,
            gain,
            steps.band,
            steps.reach,
            self._lasting(resolution, light),
            light,
        )

    def _block(self) -> Block:
        """Blocks of contact: none where coordinates without mass move at once."""
        steps, levels = self.steps, self.steps.levels
        few = self.gaps.m < FEWEST or self.scheme.light or not self.model.presses
        lengths = [n for n in STEPS if n <= 2**levels]
        width = np.linalg.norm(seen_through(self.form, steps.mollifier), axis=1)
        none = few or not lengths
        off = np.stack([straight(self.form, steps, n * steps.h) for n in lengths or STEPS])
        return new_block(0 if none else lengths[0], off, width)

    def _lasting(self, resolution: Resolution, light: bool) -> Lasting:
        """Long steps, their forces closer than those of kicks, off by (omega_c h)^2 / 24."""
        steps, levels = self.steps, self.steps.levels
        first = next((n for n in range(levels) if steps.fastest * self.H / 2**n <= STIFF), levels)
        last = levels - max(1, round(math.log2(SHORTEST / resolution.contact)))
        tried = self.model.presses and not light and first <= last
        return Lasting(tried, first, last, 0.01 * resolution.contact**2)

    def _check_dampers(self) -> None:
        laws = self.gaps.laws
        alone = np.flatnonzero((laws.damping > 0.0) & (laws.stiffness == 0.0) & (laws.curve < 0))
        if alone.size:
            raise InputError(
                f"channel {alone[0]} has a damper of {laws.damping[alone[0]]:g} and no spring",
                where=self.system.name,
                expected="a stiffness or a curve: a damper acts while its spring presses",
                fix="Give the channel a stiffness, or take its damper away.",
            )

    def _check_light(self, light: bool) -> None:
        if light and (self.gaps.rubbing or self.model.damped):
            raise InputError(
                "friction or a damper acts on coordinates without mass",
                where=self.system.name,
                expected="contact nodes that have mass",
                fix='Reduce by "craig-bampton".',
            )

    def rows(self, steps: int) -> int:
        return max(steps, ROWS) + 2 ** (self.steps.levels + 1)

    def kept(self, x: FlowState) -> FloatArray:
        return np.asarray(x.x.ravel()[self.model.u0 : self.model.u1])

    def empty(self) -> FlowState:
        return resting(self.model, self.loads)

    def chunk(self, now: FlowState, after: FlowState, out: Output, begin: int, end: int) -> Chunk:
        code, *others = march(
            self.model,
            self.scheme,
            self.A if self.solver else None,
            self.block,
            self.cone,
            self.desk,
            now,
            after,
            out,
            begin,
            end,
            self.log.used,
        )
        return Chunk(DONE if code == FULL else code, *others)

    def start(self) -> FlowState:
        x = self._start()
        steady = self.desk.steady
        if self.model.preload.any() and not self.scheme.light:
            steady.force[:], steady.mark[:] = x.force, NEW if x.force.any() else NONE
        begin_books(self.model, self.steps.laws, self.scheme.W, self.steps.h, steady.force, x)
        return x

    def _start(self) -> FlowState:
        """u = 0, the System's initial velocity, and the channel forces that go with them."""
        model, terms = self.model, self.terms
        x = resting(model, self.loads)
        x.support[:] = self.loads.support[:, 0]
        x.amplitude[:] = amplitudes(model, slice(0, 1))[:, 0]
        x.x[:] = at_start(self.form, model, terms)
        m, z, h = self.gaps.m, x.x.ravel(), self.steps.h
        x.gap[:] = model.gap0 + model.rows[:m] @ z[model.u0 : model.u1] + model.rows_s[:m] @ x.support[0]
        x.rate[:] = model.rates @ z[model.v0 : model.v1] + model.rates_s @ x.support[1]
        rest = self.gaps.resting
        still = np.array_equal(x.gap, model.gap0) and not np.any((x.gap < 0.0) & (rest[:m] <= 0.0))
        if model.presses and rest.any() and still:
            x.force[:] = rest
            x.F[:] = x.force @ model.push
            x.drift[:] = -h * (self.scheme.W[:m] @ rest)
        elif model.presses and x.gap.min(initial=0.0) < 0.0:
            slip, rate = h * x.rate[m:], x.rate[:m].copy()
            free = Unpressed(x.gap.copy(), rate, slip, RATE / h, RATE, h)
            with one_blas_thread():
                solve_channels(self.A, free, self.steps.laws, x.stuck, x.force)
            x.F[:] = x.force @ model.push
            if model.massless.size:
                x.x[0, model.massless] += x.F[model.massless] / model.k[model.massless]
            if self.scheme.light:
                x.gap[:] += self.A[:m] @ x.force
        x.mean[:] = x.force
        return x


def flows(system: System) -> bool:
    """Is the System in modes, single or in pairs, that exact flow can carry?"""
    return is_modal(system) or can_couple(system)


def form_of(system: System, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator) -> FlowForm:
    """Single modes where damping leaves them so, pairs of complex modes where it couples them.

    Raises
    ------
    InputError : M or K is not diagonal, damping acts on coordinates without mass, or it couples too many modes.
    """
    if is_modal(system) or not can_couple(system):
        return single_modes(*modal_matrices(system), on, terms, gaps)
    return coupled_modes(system, on, terms, gaps)
