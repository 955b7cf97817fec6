"""HHT-alpha with condensed contact: one factorisation, one back-substitution a step.

With gaps g = g0 + G u and channel forces p the step equation S a1 = r + (1 + alpha) G' p(g1) is solved by
elimination: a1 = a_free + (1 + alpha) W p with W = S^-1 G', which leaves g1 = g_free + A p(g1) with
A = (1 + alpha) beta h^2 G W, a piecewise-linear system in the few channels.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.unilateral import solve_channels
from creak.dynamics.energy import EnergyAudit
from creak.dynamics.hht import HHT
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.dynamics.step_matrix import StepFactor
from creak.errors import NumericalError

RESPONSE_MEMORY = 2_000_000_000
"""Bytes up to which W = S^-1 G' is kept, so that contact costs no second back-substitution."""
BUFFER_MEMORY = 64_000_000
"""Bytes of motion kept before it is turned into output."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class ChannelMatrices:
    """The gap operator in the coordinates of a System."""

    G: Matrix
    G_s: FloatArray
    tangents: tuple[tuple[Matrix, FloatArray], ...]


def channel_matrices(system: System, gaps: GapOperator) -> ChannelMatrices:
    """G rows(labels): (m, n) on the coordinates and (m, n_support) on the prescribed motion."""
    R, R_s = system.rows(gaps.labels)

    def on(A: Matrix) -> tuple[Matrix, FloatArray]:
        B = A @ R
        return (sp.csr_matrix(B) if sp.issparse(B) else np.asarray(B)), np.asarray(A @ R_s)

    G, G_s = on(gaps.G)
    return ChannelMatrices(G, G_s, tuple(on(t) for t in gaps.tangents))


class CondensedContact:
    """Channels of a run: compliance, forces at the end of a step, and their effect on the acceleration."""

    def __init__(self, gaps: GapOperator, on: ChannelMatrices, solver: StepFactor, scheme: HHT, h: float) -> None:
        self.gaps, self.on = gaps, on
        self._solver, self._weight = solver, 1.0 + scheme.alpha
        self._presses = bool(gaps.m and gaps.stiffness.any())
        self._rate_gain = scheme.gamma / (scheme.beta * h)
        n = on.G.shape[1]
        columns = np.asarray(on.G.toarray() if sp.issparse(on.G) else on.G).T
        W = solver.solve(np.asfortranarray(columns)) if self._presses else np.zeros((n, gaps.m))
        self.compliance = (1.0 + scheme.alpha) * scheme.beta * h * h * np.asarray(on.G @ W)
        self.compliance = np.ascontiguousarray(0.5 * (self.compliance + self.compliance.T))
        self._W = np.asfortranarray(W) if W.nbytes <= RESPONSE_MEMORY else None

    def forces(self, gap_free: FloatArray, rate_free: FloatArray) -> FloatArray:
        """p (m,) at the end of the step."""
        if not self._presses or gap_free.min() >= 0.0:
            return np.zeros(self.gaps.m)
        g = self.gaps
        return solve_channels(self.compliance, gap_free, rate_free, self._rate_gain, g.stiffness, g.damping)

    def acceleration(self, p: FloatArray) -> FloatArray:
        """(1 + alpha) S^-1 G' p."""
        active = np.flatnonzero(p)
        if self._W is not None:
            return self._weight * (self._W[:, active] @ p[active])
        return self._weight * self._solver.solve(np.asarray(self.on.G.T @ p))


def simulate(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    scheme: HHT,
    *,
    observed: IntArray,
    output_every: int = 1,
    progress: Progress | None = None,
) -> History:
    """March the System through the loads with contact in the channels of `gaps`.

    Starts from u = 0 and the initial velocity of the System, with the acceleration that the step matrix gives
    (S a0 = f - C v0 - K u0, consistent to second order in h also where M is singular).

    Parameters
    ----------
    observed : (n_label,) physical dof labels whose displacement is kept every `output_every` steps.

    Raises
    ------
    NumericalError : the step matrix is singular, or the motion is no longer finite.
    """
    started = clock.perf_counter()
    h = loads.step
    solver = StepFactor(system, scheme, h)
    on = channel_matrices(system, gaps)
    contact = CondensedContact(gaps, on, solver, scheme, h)
    terms = LinearTerms(system, loads)
    recorder = _Recorder(system, on, observed, loads, output_every)
    state = terms.start(solver)
    gap = gaps.gap0 + on.G @ state.u + on.G_s @ loads.support[0, 0]
    p = gaps.stiffness * np.maximum(0.0, -gap)
    audit = EnergyAudit(terms, gaps, on, loads)
    audit.start(state, gap, p)
    recorder.contact(0, gap, p)
    recorder.motion(0, state.u)
    setup_s = clock.perf_counter() - started
    contact_steps = 0
    for step in range(1, loads.n_step + 1):
        half = terms.predict(state, scheme, h)
        rhs = terms.right_side(step, state, half, scheme, on, p)
        a = solver.solve(rhs)
        s, s_dot = loads.support[0, step], loads.support[1, step]
        gap_free = gaps.gap0 + on.G @ (half.u + scheme.beta * h * h * a) + on.G_s @ s
        rate_free = _closing_rate(gaps, on, half.v + scheme.gamma * h * a, s_dot)
        p_new = contact.forces(gap_free, rate_free)
        if p_new.any():
            a = a + contact.acceleration(p_new)
            gap = gap_free + contact.compliance @ p_new
            contact_steps += 1
        else:
            gap = gap_free
        previous, state = state, terms.advance(half, a, scheme, h, step)
        if not np.isfinite(state.u[0] if state.u.size else 0.0) or (step % 64 == 0 and not np.isfinite(state.u).all()):
            raise NumericalError(f"the motion is no longer finite at t = {loads.time[step]:.6g} s (step {step})")
        audit.step(step, previous, state, gap, p, p_new)
        p = p_new
        recorder.contact(step, gap, p)
        recorder.motion(step, state.u)
        if progress is not None:
            progress(step, loads.n_step)
    return recorder.history(audit, contact_steps, terms.residual(state, loads.n_step, on, p), setup_s)


def _closing_rate(gaps: GapOperator, on: ChannelMatrices, v: FloatArray, s_dot: FloatArray) -> FloatArray:
    if not gaps.damping.any():
        return np.zeros(gaps.m)
    return np.asarray(on.G @ v + on.G_s @ s_dot)


class _Recorder:
    """Keeps gaps and forces of every step and turns blocks of motion into output."""

    def __init__(
        self, system: System, on: ChannelMatrices, observed: IntArray, loads: Loads, output_every: int
    ) -> None:
        n_time, m = loads.time.size, on.G.shape[0]
        self._loads, self._on, self._every = loads, on, output_every
        self._R, self._R_s = system.rows(observed)
        self.gap, self.force = np.zeros((n_time, m)), np.zeros((n_time, m))
        self.index = np.arange(0, n_time, output_every, dtype=np.int64)
        self._displacement = np.zeros((self.index.size, observed.size))
        self._slip = np.zeros((self.index.size, m))
        width = int(np.clip(BUFFER_MEMORY // (8 * max(system.n, 1)), 1, self.index.size))
        self._buffer = np.zeros((system.n, width), order="F")
        self._filled = self._done = 0

    def contact(self, step: int, gap: FloatArray, p: FloatArray) -> None:
        self.gap[step], self.force[step] = gap, p

    def motion(self, step: int, u: FloatArray) -> None:
        if step % self._every:
            return
        self._buffer[:, self._filled] = u
        self._filled += 1
        if self._filled == self._buffer.shape[1]:
            self._flush()

    def _flush(self) -> None:
        here = slice(self._done, self._done + self._filled)
        Q = self._buffer[:, : self._filled]
        S = self._loads.support[0, self.index[here]].T
        self._displacement[here] = np.asarray(self._R @ Q + self._R_s @ S).T
        slips = [np.asarray(T @ Q + T_s @ S) for T, T_s in self._on.tangents]
        self._slip[here] = np.hypot(slips[0], slips[1]).T
        self._done, self._filled = here.stop, 0

    def history(self, audit: EnergyAudit, contact_steps: int, residual: float, setup_s: float) -> History:
        if self._filled:
            self._flush()
        return History(
            self._loads.time, self.gap, self.force, self._slip, self.index, self._displacement,
            audit.table(), contact_steps, residual, setup_s,
        )  # fmt: skip

