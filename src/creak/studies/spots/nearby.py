"""The unreduced model near an event alone: what lies beyond follows the reduced one, as in a submodel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix
from creak.assembly.damping import Damping
from creak.assembly.system import Supports, System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flight.contact_steps import IN_CONTACT
from creak.dynamics.loads import Loads
from creak.dynamics.simulate import CondensedStepper, march
from creak.linalg.memory import blocks_that_fit
from creak.linalg.sparse_product import BlockProduct
from creak.linalg.together import Solver
from creak.model.dofs import nodes_of
from creak.studies.models.alike import recovered_on
from creak.studies.models.reduced import FACTOR
from creak.studies.spots.choose import BLOCKED, Span
from creak.studies.spots.handover import COLUMNS, COPIES, Begins, Handover, LowModes
from creak.studies.spots.march import Checker, Marched, cut

Result = TypeVar("Result")
SHAPES = 1e-7
"""Of the largest singular value: shapes of the motion beyond that are left out."""
INSTANTS = 200
"""Of a stretch, most that these shapes are made of."""
AROUND = 16.0
"""Times the dofs that touch: of those that move by themselves, the fewest."""
NARROW = 0.25
"""Of these, how many of them do where it is looked at what the border changes."""
INDEPENDENT = 1e-8
"""Share of the mass of a mode: combinations of modes with less beyond the border are left out."""


class Nearby:
    """Marches through stretches by steps of one length, in which some dofs of the unreduced model move by themselves.

    They are those that lie nearest to the channels that touch, `Handover.nearby` or more. All others move as the lowest
    modes of the reduced model do, and besides as that model does when it is marched by the same steps from the same
    state: u = [u_o; T_b q(t) + Phi_b y]. The unreduced matrices are projected on u_o and y. So what moves otherwise
    near the event moves the rest, too, in these modes; higher ones come back from the border. How much that changes is
    told by marching with a quarter of the dofs, in shells with a border that is half as far away.
    """

    def __init__(self, of: Handover, parts: int, near: IntArray, stiffness: FloatArray) -> None:
        self._of, self._parts = of, parts
        gaps = of.gaps.select(near)
        hard = np.isinf(gaps.stiffness).any()
        self._near, self._gaps = near, gaps.with_stiffness(stiffness[near]) if hard else gaps
        self._follower: CondensedStepper | None = None

    def side_by_side(
        self, works: Sequence[Callable[[Solver | None], Result]], counted: Callable[[int], object] = int
    ) -> list[Result]:
        """Results of marches, one after the other: each has matrices of its own."""
        return [work(None) for work in works]

    def begins(self, q: FloatArray, v: FloatArray, first: int) -> Begins:
        """What a march takes over: the state of the reduced model as it is."""
        return q, v

    def through(self, s: Span, begins: Begins, channels: IntArray, solver: Solver | None = None) -> Marched:
        """The march from a state of the reduced model near the channels, and the same with a quarter of the dofs."""
        of, low = self._of, self._of.low
        assert low is not None
        loads, held = cut(of.loads, s, self._parts), of.held(s, self._near)
        q, starts, force = self._followed(loads, begins, held)
        shapes = _shapes(q, INSTANTS)
        n_s, r = loads.support.shape[2], shapes.shape[1]
        touching = np.unique(self._rows[self._pressing(s, channels)].indices)
        most = max(float(of.nearby or of.unreduced.n), AROUND * touching.size)
        sizes = [self._own(touching, share * most) for share in (1.0, NARROW)]
        kept = _beside(of.unreduced, sizes[0][0])
        u = self._recovered(
            np.column_stack([np.zeros((of.reduced.n, n_s)), shapes, *begins]),
            np.column_stack([np.eye(n_s), np.zeros((n_s, r)), *loads.support[:2, 0]]),
            kept,
        )
        weights = np.zeros((3, loads.time.size, r))
        weights[0], weights[:, 0] = q.T @ shapes, starts @ shapes
        in_shapes = low.shapes.T @ np.asarray(of.reduced.M @ shapes)
        moved, Phi = u[:, : n_s + r], np.ascontiguousarray(of.low_motion[:, kept].T)
        ground = Ground(_restricted(of.unreduced, kept), low, moved, Phi, in_shapes, loads.force_labels)
        both = list[Marched]()
        for own, acting in sizes:
            gaps, friction = self._gaps.select(acting), self._gaps.friction
            rubs = np.zeros(0, bool) if friction is None else np.repeat(np.isin(friction.channels, acting), 2)
            pressing = np.concatenate([force[:, acting], force[:, self._gaps.m :][:, rubs]], axis=1) - gaps.resting
            here = np.searchsorted(kept, own)
            given = np.concatenate([pressing, loads.force], axis=1)
            beside = np.zeros((3, *given.shape))
            beside[0] = given
            motion = Loads(
                loads.time, np.concatenate([loads.support, weights, beside], axis=2), np.zeros((given.shape[0], 0))
            )
            local = ground.cut_out(here, gaps)
            stepper = CondensedStepper(local, gaps, motion, IN_CONTACT)
            rest = np.zeros(local.n - here.size)
            begun = (*(np.concatenate([u[here, n_s + r + k], rest]) for k in (0, 1)), held[rubs])
            history = march(stepper.over(motion, begun), np.zeros(0, dtype=np.int64), max(1, motion.n_step))
            both.append(Marched(history, gaps, "", 0.0))
        whole, narrow = both
        some = (sizes[0][0].size + sizes[1][0].size) / of.unreduced.n
        return replace(whole, narrow=narrow, solves=some * (FACTOR + whole.gaps.m + s.steps) + BLOCKED * u.shape[1])

    @cached_property
    def _rows(self) -> Matrix:
        """(m, n) by which the coordinates act on each channel, in any direction."""
        on = channel_matrices(self._of.unreduced, self._gaps)
        return sp.csr_matrix(sum((abs(sp.csr_matrix(t)) for t, _ in on.tangents), abs(sp.csr_matrix(on.G))))

    def _pressing(self, s: Span, channels: IntArray) -> BoolArray:
        """(m,) which of the channels press in a stretch of the reduced run; where none does, all."""
        history, here = self._of.history, np.isin(self._near, channels)
        rows = slice(*np.searchsorted(history.time, s.time(self._of.ends)))
        press = here & (history.force[rows][:, self._near] > 0.0).any(axis=0)
        return press if press.any() else here

    def _own(self, touching: IntArray, dofs: float) -> tuple[IntArray, IntArray]:
        """So many coordinates that move by themselves, and which of the channels act on them: on no others.

        Parameters
        ----------
        touching : coordinates that they lie around.
        """
        from scipy.spatial import cKDTree

        node, of = nodes_of(self._of.unreduced.coordinates), self._of
        at = of.positions[node]
        distance = cKDTree(at[touching]).query(at)[0]
        own = np.isin(node, node[np.argsort(distance, kind="stable")[: int(dofs)]])
        acting = np.asarray(self._rows @ own.astype(float)).ravel() > 0.0
        own[np.unique(self._rows[acting].indices)] = True
        return np.flatnonzero(own), np.flatnonzero(acting)

    def _followed(self, loads: Loads, begins: Begins, held: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(n, n_step + 1) coordinates of the reduced model over the stretch; these, their velocity and acceleration at
        its start, (3, n); (n_step + 1, m + 2 f) forces of its channels."""
        if self._follower is None:
            self._follower = CondensedStepper(self._of.reduced, self._gaps, loads, IN_CONTACT)
        stepper = self._follower.over(loads, (*begins, held))
        every = np.arange(loads.n_step + 1)
        h = march(stepper, np.zeros(0, dtype=np.int64), max(1, loads.n_step), whole_at=every)
        start = np.array([*begins, stepper.start().x.a])
        return np.asarray(h.coordinates), start, np.concatenate([h.force, h.tangential], axis=1)

    def _recovered(self, q: FloatArray, s: FloatArray, kept: IntArray) -> FloatArray:
        """(n_kept, k) of the unreduced coordinates in motions (q, s) of the reduced model."""
        of, u = self._of, np.empty((kept.size, q.shape[1]))
        for some in blocks_that_fit(q.shape[1], of.unreduced.n, COPIES, COLUMNS, 1):
            u[:, some] = recovered_on(of.unreduced, of.reduced, q[:, some], s[:, some])[kept]
        return u


AnyChecker = Checker | Nearby


def checker_of(of: Handover, parts: int, near: IntArray, stiffness: FloatArray) -> AnyChecker:
    """What marches through stretches by steps of one length."""
    return (Checker if of.nearby is None else Nearby)(of, parts, near, stiffness)


def share(of: Handover) -> float | None:
    """Of the unknowns, those that move by themselves; None: all."""
    return None if of.nearby is None else (1.0 + NARROW) * of.nearby / of.unreduced.n


def once(of: Handover) -> float:
    """Back-substitutions that all checks together take beside those of each: factors of the parts, the lowest modes."""
    return 0.0 if of.low is None else FACTOR + BLOCKED * of.low.omega2.size


def _shapes(q: FloatArray, most: int) -> FloatArray:
    """Orthonormal shapes (n, r) that the motion q (n, k) is made of."""
    some = np.unique(np.linspace(0, q.shape[1] - 1, most).astype(int))
    U, size, _ = np.linalg.svd(q[:, some], full_matrices=False)
    return np.asarray(U[:, size > SHAPES * size[0]])


def _independent(mass: FloatArray) -> FloatArray:
    """(p, p') combinations of motions with that mass matrix that have mass 1 each, and none together."""
    size, Q = np.linalg.eigh(mass)
    kept = size > INDEPENDENT
    return np.asarray(Q[:, kept] / np.sqrt(size[kept]))


def _beside(system: System, own: IntArray) -> IntArray:
    """Coordinates and those that they are coupled with."""
    extra = system.damping.extra
    matrices = [system.K, system.M] if extra is None else [system.K, system.M, extra]
    return np.unique(np.concatenate([own, *(sp.csr_matrix(A[own]).indices for A in matrices)])).astype(np.int64)


def _restricted(whole: System, kept: IntArray) -> System:
    """Some coordinates of a System, as if the others stood still."""
    sup, d = whole.supports, whole.damping

    def block(A: Matrix) -> Matrix:
        return sp.csr_matrix(sp.csr_matrix(A[kept])[:, kept])

    def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
        A, A_s = whole.rows(labels)
        return sp.csr_matrix(A)[:, kept], A_s

    return replace(
        whole,
        M=block(whole.M),
        K=block(whole.K),
        damping=replace(d, extra=None if d.extra is None else block(d.extra)),
        rows=rows,
        supports=replace(sup, M_qs=sup.M_qs[kept], K_qs=sup.K_qs[kept], C_qs=sup.C_qs[kept], M_start=sup.M_start[kept]),
        coordinates=whole.coordinates[kept],
        velocity=whole.velocity[kept],
        whole=None,
        combine=None,
    )


@dataclass(frozen=True)
class _Cut:
    """Rows o of a matrix, times the modes and the motion that is prescribed, X = [Phi, moved]."""

    own: Matrix
    """A_oo"""
    near: IntArray
    """Rows that the rest acts on."""
    inner: FloatArray
    """A_oo X_o"""
    outer: FloatArray
    """A_ob X_b, its rows `near`."""
    all: FloatArray
    """A_o X"""


@dataclass(frozen=True)
class Ground:
    """Where some of the coordinates of the unreduced model may move by themselves."""

    system: System
    """Of these, and of all that they are coupled with."""
    low: LowModes
    moved: FloatArray
    """(n, n_support + r) motion with each support, and of the shapes that the reduced motion is made of."""
    Phi: FloatArray
    """(n, p) lowest modes."""
    in_shapes: FloatArray
    """(p, r) their weights in the shapes."""
    force_labels: tuple[IntArray, ...]

    def cut_out(self, own: IntArray, gaps: GapOperator) -> System:
        """Coordinates u_o and y of u = [u_o; T_b q + Phi_b y].

        For A = M, C, K with A_oy = A_ob Phi_b, its rows for y are A_oy' and

            A_yy = Phi' A Phi - Phi_o' A_oo Phi_o - Phi_o' A_oy - A_oy' Phi_o.

        What is prescribed are supports s, weights c of the shapes, forces f of channels and of the loads as they are in
        the reduced run. That fulfils the projection on Phi of the unreduced equations as a whole, so of a prescribed
        motion S only -A_oy' S_o - Phi_o' (A S)_o is left for y, and of a force at o Phi_o' f. Modal damping
        M Phi diag(d) Phi' M acts on the weight W' u_o + (1 - W' Phi_o) y + (c - W' S_o) of each mode, W = M_o Phi.
        Where few dofs are left beyond, y stands for combinations of the modes that differ there (`INDEPENDENT`).

        Parameters
        ----------
        own : (n_own,) of the coordinates, those that move by themselves.
        """
        ground, moved, low = self.system, self.moved, self.low
        sup, damping, n_s, (p, r) = ground.supports, ground.damping, ground.supports.count, self.in_shapes.shape
        beyond = np.setdiff1d(np.arange(ground.n), own)
        M = self._cut(ground.M, own, beyond)
        W = M.all[:, :p]
        half = self.Phi[own].T @ (W - 0.5 * M.inner[:, :p])
        Q = _independent(np.eye(p) - half - half.T)
        Phi, free = self.Phi[own] @ Q, self.Phi[beyond] @ Q

        def joined(A: _Cut, A_qs: Matrix, A_modes: FloatArray) -> tuple[Matrix, FloatArray]:
            A_oy = A.outer[:, :p] @ Q
            cross = A_oy.T @ Phi[A.near]
            corner = Q.T @ A_modes @ Q - Phi.T @ (A.inner[:, :p] @ Q) - cross - cross.T
            top = np.column_stack([to_dense(A_qs[own]), np.zeros((own.size, r))])
            low_side = -A_oy.T @ moved[own[A.near]] - Phi.T @ (top + A.all[:, p:])
            top[A.near] += A.outer[:, p:]
            spread = sp.csr_matrix((np.ones(A.near.size), (A.near, np.arange(A.near.size))), (own.size, A.near.size))
            side = spread @ sp.csr_matrix(A_oy)
            both = [[A.own, side], [side.T, sp.csr_matrix(0.5 * (corner + corner.T))]]
            return sp.csr_matrix(sp.bmat(both)), np.vstack([top, low_side])

        M_all, M_qs = joined(M, sup.M_qs, np.eye(p))
        K_all, K_qs = joined(self._cut(ground.K, own, beyond), sup.K_qs, np.diag(low.omega2))
        alpha, beta = (damping.alpha, damping.beta) if low.beta is None else (0.0, low.beta)
        extra, C_qs, some = None, np.zeros(M_qs.shape), low.damped != 0.0
        if damping.extra is not None:
            extra, C_qs = joined(self._cut(damping.extra, own, beyond), sup.C_qs, low.extra)
        d = low.damped[some]
        modal: tuple[FloatArray | None, FloatArray | None] = None, None
        if some.any():
            acts = np.ascontiguousarray(np.vstack([W, Q.T - Phi.T @ W])[:, some])
            weights = np.column_stack([np.zeros((d.size, n_s)), self.in_shapes[some]])
            C_qs = C_qs + (acts * d) @ (weights - W[:, some].T @ moved[own])
            C_qs[own.size :] -= (Q.T[:, some] * d) @ weights
            modal = acts, d
        forces = self._forces(own, Phi, gaps)
        none = np.zeros(forces.shape)
        M_qs = np.hstack([M_qs, none])
        sides = M_qs, np.hstack([K_qs, forces]), np.hstack([C_qs, -beta * forces])
        count = M_qs.shape[1]
        none = np.zeros((count, count))
        supports = Supports(tuple(f"given {k + 1}" for k in range(count)), *sides, none, none, none, M_qs)

        def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
            A, A_s = ground.rows(labels)
            A_b = A[:, beyond]
            fixed = np.column_stack([to_dense(A_s), np.zeros((labels.size, r))]) + A_b @ moved[beyond]
            return (
                sp.hstack([A[:, own], sp.csr_matrix(A_b @ free)], format="csr"),
                np.hstack([fixed, np.zeros((labels.size, forces.shape[1]))]),
            )

        coordinates = np.concatenate([ground.coordinates[own], np.full(Q.shape[1], -1, dtype=np.int64)])
        damped = Damping(alpha, beta, extra, *modal)
        return System(ground.name, M_all, K_all, damped, rows, supports, coordinates, np.zeros(coordinates.size))

    def _cut(self, A: Matrix, own: IntArray, beyond: IntArray) -> _Cut:
        A_o = sp.csr_matrix(A[own])
        A_oo, A_ob = A_o[:, own], A_o[:, beyond]
        near = np.flatnonzero(np.diff(A_ob.indptr))
        X = np.hstack([self.Phi, self.moved])
        inner = BlockProduct(A_oo)(X[own])
        outer = np.asarray(A_ob[near] @ X[beyond])
        every = inner.copy()
        every[near] += outer
        return _Cut(A_oo, near, inner, outer, every)

    def _forces(self, own: IntArray, Phi: FloatArray, gaps: GapOperator) -> FloatArray:
        """(n_own + p, k) what forces of the reduced run, of channels and of the loads, are on the side of K_qs.

        Parameters
        ----------
        Phi : (n_own, p) motion by y.
        """
        on = channel_matrices(self.system, gaps).rows[:, own]
        loads = np.zeros((len(self.force_labels), own.size))
        for j, labels in enumerate(self.force_labels):
            loads[j] = np.asarray(sp.csr_matrix(self.system.rows(labels)[0]).sum(axis=0)).ravel()[own]
        top = np.hstack([np.zeros((own.size, on.shape[0])), -loads.T])
        low = np.hstack([np.asarray(on @ Phi).T, Phi.T @ loads.T])
        return np.vstack([top, low])
