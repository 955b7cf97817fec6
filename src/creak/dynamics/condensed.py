"""Contact condensed to its channels: a few equations a step instead of a nonlinear system.

With gaps g = g0 + G u and channel forces p the step equation S a1 = r + (1 + alpha) G' p(g1) is solved by
elimination: a1 = a_free + (1 + alpha) W p with W = S^-1 G', which leaves g1 = g_free + A p(g1) with
A = (1 + alpha) beta h^2 G W, a piecewise-linear system in the few channels. No iteration touches the
structure, and the result is that of a converged Newton loop to round-off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, Matrix
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.contact.unilateral import solve_channels
from creak.dynamics.hht import HHT
from creak.dynamics.step_matrix import StepFactor

RESPONSE_MEMORY = 2_000_000_000
"""Bytes up to which W = S^-1 G' is kept, so that contact costs no second back-substitution."""
PATCH = 3.0
"""Radius of a contact patch, in node spacings, whose channels may press at the same time."""


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


def step_limited_stiffness(
    system: System, gaps: GapOperator, positions: FloatArray, scheme: HHT, h: float
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
    W = StepFactor(system, scheme, h).solve(np.asfortranarray(to_dense(G).T))
    A = (1.0 + scheme.alpha) * scheme.beta * h * h * np.asarray(G @ W)
    together = np.where(_neighbours(part, positions[limited]), np.abs(A), 0.0).sum(axis=1)
    stiffness = gaps.stiffness.copy()
    stiffness[limited] = stiffness[limited] / np.maximum(1.0, stiffness[limited] * together)
    return stiffness


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
