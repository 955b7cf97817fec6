"""Static equilibrium of a System with contact: the channels condensed on K, the same laws as in a step.

With q_F = K^-1 (f - K_qs s) and A = R K^-1 R', R = [G; T] the rows of the channels,

    g = g0 + G q_F + G_s s + A (F - F_rest),    q = q_F + K^-1 R' (F - F_rest)

F_rest being what is balanced without the loads already (`GapOperator.resting`). With friction the path matters: loads
grow in steps, and as many as let the forces settle. What overlaps without load is taken out along with them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import Unpressed, contact_energy, solve_channels
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.errors import NumericalError
from creak.linalg.dense_product import symmetric
from creak.linalg.factor import Factor
from creak.model.mesh import Nodes, rigid_vectors

COLUMNS = 64
"""Right-hand sides solved at a time."""
INCREMENTS = 10
"""Of the loads, where channels rub."""
MOST_INCREMENTS = 640
SETTLED = 1e-3
"""Change of the channel forces, relative to the largest, by twice as many increments."""
BALANCED = 1e-6
"""Largest residual of equilibrium, relative to its largest term."""


@dataclass(frozen=True)
class Equilibrium:
    """A structure at rest under constant loads."""

    q: FloatArray
    """(n,)"""
    support: FloatArray
    """(n_support,)"""
    gap: FloatArray
    """(m,)"""
    force: FloatArray
    """(m,) >= 0, with what the channels carry without the loads."""
    held: FloatArray
    """(m, 2) friction forces."""
    increments: int
    residual: float
    """|K q + K_qs s - f - R' (F - F_rest)| over its largest term."""
    energy_error: float
    """Difference of twice the strain energy and the virtual work of all forces, relative to the work."""
    strain: float
    contact: float
    """Energy of the channels' springs."""
    free: FloatArray
    """(n,) coordinates under the same loads without the channels."""

    def on(self, gaps: GapOperator) -> GapOperator:
        """The channels as they are now: gaps from here, what they carry balanced by the loads that hold them here."""
        held = self.held if gaps.friction is not None else None
        return replace(gaps, gap0=self.gap, preload=self.force, held=held)


def equilibrium(system: System, stiffness: Factor, gaps: GapOperator, f: FloatArray, s: FloatArray) -> Equilibrium:
    """The rest of a System under forces f (n,) on its coordinates and supports moved by s (n_support,).

    Channels are taken in as they close; those that stay open cost nothing.

    Parameters
    ----------
    stiffness : a factor of K.

    Raises
    ------
    NumericalError : contact has no solution, or forces that do not balance.
    """
    free = stiffness.solve(f - to_dense(system.supports.K_qs) @ s)
    every = channel_matrices(system, gaps)
    linear = np.asarray(gaps.gap0 + every.G @ free + every.G_s @ s)
    inside = (linear < 0.0) | (gaps.gap0 < 0.0) | (gaps.resting[: gaps.m] > 0.0)
    inside &= gaps.can_press()
    while True:
        chosen = np.flatnonzero(inside)
        some = gaps.select(chosen)
        on = channel_matrices(system, some)
        force, count = _settled(some, on, _compliance(on, stiffness), free, s)
        push = np.asarray(on.rows.T @ (force - some.resting)) if chosen.size else np.zeros(system.n)
        q = free + stiffness.solve(push) if push.any() else free
        gap = np.asarray(gaps.gap0 + every.G @ q + every.G_s @ s)
        more = (gap < 0.0) & ~inside & gaps.can_press()
        if not more.any():
            break
        inside |= more
    gap[chosen] = _squeezed(some, gap[chosen], force[: some.m])
    whole, held = np.zeros(gaps.m), np.zeros((gaps.m, 2))
    whole[chosen] = force[: some.m]
    if some.friction is not None:
        held[chosen[some.friction.channels]] = force[some.m :].reshape(-1, 2)
    work = float((force - some.resting) @ np.asarray(on.rows @ q))
    residual, error, strain = _checked(system, q, s, f, push, work)
    springs = float(contact_energy(gaps.laws, gap))
    return Equilibrium(
        q=q,
        support=s,
        gap=gap,
        force=whole,
        held=held,
        increments=count,
        residual=residual,
        energy_error=error,
        strain=strain,
        contact=springs,
        free=free,
    )


def _compliance(on: ChannelMatrices, stiffness: Factor) -> FloatArray:
    """A = R K^-1 R', (m + 2 f, m + 2 f)."""
    rows = on.rows
    A = np.zeros((rows.shape[0], rows.shape[0]))
    for start in range(0, rows.shape[0], COLUMNS):
        block = slice(start, start + COLUMNS)
        A[:, block] = rows @ stiffness.solve(np.asfortranarray(to_dense(rows[block]).T))
    return np.ascontiguousarray(symmetric(A))


def _settled(
    gaps: GapOperator, on: ChannelMatrices, A: FloatArray, free: FloatArray, s: FloatArray
) -> tuple[FloatArray, int]:
    """Channel forces (m + 2 f,), and in how many increments of the loads."""
    if not gaps.m:
        return np.zeros(0), 1
    moved = np.asarray(on.rows @ free) + np.vstack([on.G_s, on.T_s]) @ s
    if not gaps.rubbing:
        return _loaded(gaps, A, moved, 1), 1
    count = INCREMENTS
    before = _loaded(gaps, A, moved, count)
    while count < MOST_INCREMENTS:
        count *= 2
        force = _loaded(gaps, A, moved, count)
        if np.abs(force - before).max() <= SETTLED * np.abs(force).max():
            return force, count
        before = force
    raise NumericalError(
        f"the static start does not settle: contact forces with friction still change by "
        f"{np.abs(force - before).max():.2g} with {count} increments of the loads"
    )


def _loaded(gaps: GapOperator, A: FloatArray, moved: FloatArray, count: int) -> FloatArray:
    """Channel forces (m + 2 f,) after `count` equal increments; moved (m + 2 f,): by the loads, without contact."""
    m, rest, laws = gaps.m, gaps.resting, gaps.laws
    laws = laws._replace(mu_kinetic=laws.mu_static.copy(), decay=np.zeros_like(laws.decay))
    overlap = np.where(rest[:m] > 0.0, 0.0, np.minimum(gaps.gap0, 0.0))
    stuck, force = np.ones(gaps.rubbing, dtype=np.bool_), rest.copy()
    for k in range(1, count + 1):
        share = k / count
        gap = gaps.gap0 - (1.0 - share) * overlap + share * moved[:m] - A[:m] @ rest
        slip = moved[m:] / count - A[m:] @ force
        solve_channels(A, Unpressed(gap, np.zeros(m), slip, 0.0, 1.0, 1.0), laws, stuck, force)
    return force


def _squeezed(gaps: GapOperator, gap: FloatArray, force: FloatArray) -> FloatArray:
    """Gaps of pressing channels from their law, without the round-off of the displacements."""
    straight = (force > 0.0) & (gaps.stiffness > 0.0)
    if gaps.curves is not None:
        straight &= gaps.curves.of < 0
    return np.where(straight, -force / np.where(straight, gaps.stiffness, 1.0), gap)


def _checked(
    system: System, q: FloatArray, s: FloatArray, f: FloatArray, push: FloatArray, pushed: float
) -> tuple[float, float, float]:
    """How far forces f and those of the channels are from balance, and their virtual work from that of the strain,
    shares; and the strain energy.

    Parameters
    ----------
    push : (n,) of the channels, and the work that they do (`pushed`).
    """
    sup = system.supports
    K_qs = to_dense(sup.K_qs)
    Kq, Ks = np.asarray(system.K @ q), K_qs @ s
    scale = max(float(np.linalg.norm(x)) for x in (Kq, Ks, f, push))
    residual = float(np.linalg.norm(Kq + Ks - f - push)) / scale if scale else 0.0
    if not residual <= BALANCED:
        raise NumericalError(
            f"the static start is not in equilibrium: forces are left over, {residual:.2g} of the largest"
        )
    at_supports = K_qs.T @ q + sup.K_ss @ s
    strain = 0.5 * float(q @ (Kq + Ks) + s @ at_supports)
    work = float(f @ q) + pushed + float(s @ at_supports)
    largest = max(abs(strain), abs(work))
    error = abs(2.0 * strain - work) / largest if largest else 0.0
    return residual, error, strain


def rigid_load(labels: IntArray, M: Matrix, nodes: Nodes, acceleration: FloatArray) -> FloatArray:
    """(k,) M r g: forces on dofs `labels` (k,) of mass M (k, k) in a uniform acceleration (3,)."""
    r = rigid_vectors(labels, nodes, np.zeros(3))[:, :3] @ acceleration
    return np.asarray((sp.csr_matrix(M) if sp.issparse(M) else M) @ r)
