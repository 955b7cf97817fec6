"""Contact condensed to its channels: a few equations a step instead of a nonlinear system.

With gaps g = g0 + G u, tangential motion w = T u and channel forces f = (p, tau) the step equation
S a1 = r + (1 - af) [G; T]' f is solved by elimination: a1 = a_free + (1 - af) W f with W = S^-1 [G; T]', which leaves
g1 = g_free + A f, A = (1 - af) beta h^2 [G; T] W: equations in the few channels (`contact.step_problem`). No
iteration touches the structure, and the result is that of a converged Newton loop to round-off.
"""

from __future__ import annotations

import copy

import numpy as np

from creak.arrays import BoolArray, FloatArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import Unpressed, solve_channels
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import StepFactor
from creak.dynamics.vector_kernels import combination
from creak.linalg.dense_product import symmetric
from creak.linalg.together import Solver

RESPONSE_MEMORY = 2_000_000_000
"""Bytes up to which W = S^-1 [G; T]' is kept, so that contact costs no second back-substitution."""
COLUMNS = 64
"""Channels whose response is solved for at a time."""
PATCH = 3.0
"""Radius of a contact patch, in node spacings, whose channels may press at the same time."""


def step_limited_stiffness(
    system: System, gaps: GapOperator, positions: FloatArray, scheme: Scheme, h: float
) -> FloatArray:
    """(m,) penalties that the time step can follow: 1/k_i >= sum_j |A_ij| over the neighbours of channel i.

    A is the compliance of one step; neighbours are the channels of the same pair within `PATCH` node spacings.
    For a contact patch of that size the eigenvalues of diag(k) A then stay below 1 (Gershgorin): contact builds
    up over a few steps, and HHT neither chatters nor creates energy. A stiffer penalty throws a node back within
    the step that it arrives in, on average with more energy than it had (docs/numerics.md). As h falls the limit
    rises and the penalty of the parent shells is reached. Only channels with `step_limited` are lowered. Call it
    with the unreduced System, so that full and reduced runs share the numbers.

    Parameters
    ----------
    positions : (m, 3) of the secondary nodes.
    """
    limited = np.flatnonzero(gaps.step_limited)
    if not limited.size:
        return gaps.stiffness
    part = gaps.select(limited)
    G = channel_matrices(system, part).G
    A, _ = response(StepFactor(system, scheme, h), G, keep=False)
    A *= (1.0 - scheme.alpha_f) * scheme.beta * h * h
    together = np.where(_neighbours(part, positions[limited]), np.abs(A), 0.0).sum(axis=1)
    stiffness = gaps.stiffness.copy()
    stiffness[limited] = stiffness[limited] / np.maximum(1.0, stiffness[limited] * together)
    return stiffness


def response(solver: StepFactor, rows: Matrix, *, keep: bool) -> tuple[FloatArray, FloatArray | None]:
    """rows S^-1 rows' (k, k), and W = S^-1 rows' (n, k) if asked for and no larger than `RESPONSE_MEMORY`.

    Solved `COLUMNS` at a time, so that memory does not grow with the channels where W is not kept.
    """
    k, n = rows.shape
    A = np.empty((k, k))
    W = np.empty((n, k), order="F") if keep and 8 * n * k <= RESPONSE_MEMORY else None
    for start in range(0, k, COLUMNS):
        here = slice(start, min(start + COLUMNS, k))
        X = solver.solve(np.asfortranarray(to_dense(rows[here]).T))
        A[:, here] = rows @ X
        if W is not None:
            W[:, here] = X
    return A, W


def _neighbours(gaps: GapOperator, positions: FloatArray) -> BoolArray:
    """(m, m) True for channels of the same pair within `PATCH` times the median node spacing."""
    group = np.array(gaps.group)
    near = np.eye(gaps.m, dtype=bool)
    for name in dict.fromkeys(gaps.group):
        mine = np.flatnonzero(group == name)
        distance = np.linalg.norm(positions[mine][:, None] - positions[mine][None], axis=2)
        if mine.size > 1:
            spacing = np.median(np.sort(distance, axis=1)[:, 1])
            near[np.ix_(mine, mine)] |= distance <= PATCH * spacing
    return near


class CondensedContact:
    """Channels of a run at one step length: compliance, forces at the end of a step, their effect on the motion."""

    def __init__(self, gaps: GapOperator, on: ChannelMatrices, solver: StepFactor, scheme: Scheme, h: float) -> None:
        self.gaps, self.on, self.laws = gaps, on, gaps.laws
        self._solver: Solver = solver
        self._weight, self._h = 1.0 - scheme.alpha_f, h
        self._rate_gain, self._slip_gain = scheme.gamma / (scheme.beta * h), scheme.gamma / scheme.beta
        self._rows = on.rows
        compliance, self._W = response(solver, self._rows, keep=True)
        compliance *= self._weight * scheme.beta * h * h
        self.compliance = np.ascontiguousarray(symmetric(compliance))

    def by(self, solver: Solver) -> CondensedContact:
        """The same that solves with another solver of the same matrix."""
        other = copy.copy(self)
        other._solver = solver
        return other

    def forces(
        self, gap_free: FloatArray, rate_free: FloatArray, slip_free: FloatArray, stuck: BoolArray, before: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """(m + 2 f,) forces at the end of the step, and which rubbing channels stick then."""
        force, stuck = before.copy(), stuck.copy()
        free = Unpressed(gap_free, rate_free, slip_free, self._rate_gain, self._slip_gain, self._h)
        solve_channels(self.compliance, free, self.laws, stuck, force)
        return force, stuck

    def gaps_after(self, gap_free: FloatArray, force: FloatArray) -> FloatArray:
        """g = g_free + A f, (m,)."""
        return np.asarray(gap_free + self.compliance[: self.gaps.m] @ force)

    def sliding_after(self, slip_free: FloatArray, force: FloatArray) -> FloatArray:
        """(2 f,) slip velocity at the end of the step."""
        return np.asarray((slip_free + self._slip_gain * (self.compliance[self.gaps.m :] @ force)) / self._h)

    def acceleration(self, force: FloatArray) -> FloatArray:
        """(1 - af) S^-1 [G; T]' f."""
        active = np.flatnonzero(force)
        if self._W is not None:
            return np.asarray(combination(self._W.T, active, self._weight * force[active]))
        return self._solver.solve(self.on.push(np.zeros(self._rows.shape[1]), force, self._weight))
