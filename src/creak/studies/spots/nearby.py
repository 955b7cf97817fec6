"""The unreduced model near an event alone: what lies beyond follows the reduced one, as in a submodel.

Near the event a part of the model moves by itself; the rest moves in a few modes, and as is prescribed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, to_dense
from creak.assembly.damping import Damping
from creak.assembly.system import Supports, System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flight.contact_steps import IN_CONTACT
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import CondensedStepper, march
from creak.linalg.sparse_product import BlockProduct
from creak.linalg.together import Solver
from creak.model.dofs import nodes_of
from creak.studies.models.reduced import BLOCKED, FACTOR
from creak.studies.spots.choose import Price, Span
from creak.studies.spots.handover import Begins, Handover, LowModes, recovered_on
from creak.studies.spots.march import Checker, Marched, cut, watching, what_closes

INDEPENDENT = 1e-8
"""Share of the mass of a mode: combinations of modes with less beyond the border are left out."""


@dataclass(frozen=True)
class Prescribed:
    """What a march near an event has of the reduced run beside it."""

    own: Loads
    """Of the study."""
    weights: FloatArray
    """(3, n_time, r) of the shapes, their velocity and acceleration at the start alone: the scheme finds the others."""
    force: FloatArray
    """(n_time, m + 2 f) of the channels."""
    held: FloatArray
    """(2 f,) friction forces at the start."""

    def loads(self, acting: IntArray, rubs: BoolArray, gaps: GapOperator) -> Loads:
        """All of it as motion of supports, in the order of `Ground.cut_out`.

        Parameters
        ----------
        acting : channels that take part. rubs : (2 f,) which of the friction forces do. gaps : these channels.
        """
        m = self.force.shape[1] - rubs.size
        pressing = np.hstack([self.force[:, acting], self.force[:, m:][:, rubs]]) - gaps.resting
        given = np.zeros((3, self.own.time.size, pressing.shape[1] + self.own.force.shape[1]))
        given[0] = np.hstack([pressing, self.own.force])
        motion = np.concatenate([self.own.support, self.weights, given], axis=2)
        return Loads(self.own.time, motion, np.zeros((self.own.time.size, 0)))


@dataclass(frozen=True)
class _Cut:
    """Rows o of a matrix, times the modes and the motion that is prescribed, X = [Phi, moved]."""

    own: Matrix
    """A_oo"""
    near: IntArray
    """Rows that the rest acts on."""
    modes: FloatArray
    """A_oo Phi_o"""
    outer: FloatArray
    """A_ob X_b, its rows `near`."""

    def on_near(self, rows: FloatArray) -> Matrix:
        """(n_own, k) with these rows `near`, else 0."""
        at = np.ones(self.near.size), (self.near, np.arange(self.near.size))
        return sp.csr_matrix(sp.csr_matrix(at, (self.own.shape[0], self.near.size)) @ sp.csr_matrix(rows))


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
        Phi_o, moved_o = self.Phi[own], moved[own]
        M = self._cut(ground.M, own, beyond)
        W = M.modes.copy()
        W[M.near] += M.outer[:, :p]
        half = Phi_o.T @ (W - 0.5 * M.modes)
        Q = _independent(np.eye(p) - half - half.T)
        Phi = Phi_o @ Q

        def joined(A: _Cut, A_qs: Matrix, A_modes: FloatArray) -> tuple[Matrix, Matrix]:
            A_oy, A_os, at_near = A.outer[:, :p] @ Q, A.outer[:, p:], Phi[A.near]
            cross = A_oy.T @ at_near
            corner = Q.T @ (A_modes - Phi_o.T @ A.modes) @ Q - cross - cross.T
            held = sp.csr_matrix(A_qs)[own]
            low_side = -A_oy.T @ moved_o[A.near] - Q.T @ (A.modes.T @ moved_o) - at_near.T @ A_os
            low_side[:, :n_s] -= (held.T @ Phi).T
            side = A.on_near(A_oy)
            both = [[A.own, side], [side.T, sp.csr_matrix(0.5 * (corner + corner.T))]]
            top = sp.hstack([held, sp.csr_matrix((own.size, r))], format="csr") + A.on_near(A_os)
            return sp.csr_matrix(sp.bmat(both)), sp.vstack([top, low_side], format="csr")

        M_all, M_qs = joined(M, sup.M_qs, np.eye(p))
        K_all, K_qs = joined(self._cut(ground.K, own, beyond), sup.K_qs, np.diag(low.omega2))
        alpha, beta = (damping.alpha, damping.beta) if low.beta is None else (0.0, low.beta)
        extra, C_qs, some = None, sp.csr_matrix(M_qs.shape), low.damped != 0.0
        if damping.extra is not None:
            extra, C_qs = joined(self._cut(damping.extra, own, beyond), sup.C_qs, low.extra)
        d = low.damped[some]
        modal: tuple[FloatArray | None, FloatArray | None] = None, None
        if some.any():
            acts = np.ascontiguousarray(np.vstack([W, Q.T - Phi.T @ W])[:, some])
            weights = np.column_stack([np.zeros((d.size, n_s)), self.in_shapes[some]])
            by_modes = (acts * d) @ (weights - W[:, some].T @ moved_o)
            by_modes[own.size :] -= (Q.T[:, some] * d) @ weights
            C_qs = C_qs + sp.csr_matrix(by_modes)
            modal = acts, d
        forces = self._forces(own, Phi, gaps)
        M_qs = sp.hstack([M_qs, sp.csr_matrix(forces.shape)], format="csr")
        K_qs = sp.hstack([K_qs, forces], format="csr")
        C_qs = sp.hstack([C_qs, -beta * forces], format="csr")
        count = M_qs.shape[1]
        none = np.zeros((count, count))
        supports = Supports(tuple(f"given {k + 1}" for k in range(count)), M_qs, K_qs, C_qs, none, none, none, M_qs)

        def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
            A, A_s = ground.rows(labels)
            A_b = self._times(A[:, beyond], beyond)
            fixed = np.column_stack([to_dense(A_s), np.zeros((labels.size, r))]) + A_b[:, p:]
            return (
                sp.hstack([A[:, own], sp.csr_matrix(A_b[:, :p] @ Q)], format="csr"),
                np.hstack([fixed, np.zeros((labels.size, forces.shape[1]))]),
            )

        coordinates = np.concatenate([ground.coordinates[own], np.full(Q.shape[1], -1, dtype=np.int64)])
        damped = Damping(alpha, beta, extra, *modal)
        return System(ground.name, M_all, K_all, damped, rows, supports, coordinates, np.zeros(coordinates.size))

    def _cut(self, A: Matrix, own: IntArray, beyond: IntArray) -> _Cut:
        A_o = sp.csr_matrix(A[own])
        A_oo, A_ob = A_o[:, own], A_o[:, beyond]
        near = np.flatnonzero(np.diff(A_ob.indptr))
        return _Cut(A_oo, near, BlockProduct(A_oo)(self.Phi[own]), self._times(A_ob[near], beyond))

    def _times(self, A_b: Matrix, beyond: IntArray) -> FloatArray:
        """A_b X_b, of few of the columns `beyond`."""
        A_b = sp.csc_matrix(A_b)
        some = np.flatnonzero(np.diff(A_b.indptr))
        at = beyond[some]
        return np.asarray(A_b[:, some] @ np.hstack([self.Phi[at], self.moved[at]]))

    def _forces(self, own: IntArray, Phi: FloatArray, gaps: GapOperator) -> Matrix:
        """(n_own + p, k) what forces of the reduced run, of channels and of the loads, are on the side of K_qs.

        Parameters
        ----------
        Phi : (n_own, p) motion by y.
        """
        on = sp.csr_matrix(channel_matrices(self.system, gaps).rows)[:, own]
        acting = [sp.csr_matrix(sp.csr_matrix(self.system.rows(labels)[0]).sum(axis=0)) for labels in self.force_labels]
        loads = sp.csr_matrix(sp.vstack([sp.csr_matrix((0, self.system.n)), *acting]))[:, own]
        top = sp.hstack([sp.csr_matrix((own.size, on.shape[0])), -loads.T])
        return sp.vstack([top, np.hstack([(on @ Phi).T, (loads @ Phi).T])], format="csr")


def _independent(mass: FloatArray) -> FloatArray:
    """(p, p') combinations of motions with that mass matrix that have mass 1 each, and none together."""
    size, Q = np.linalg.eigh(mass)
    kept = size > INDEPENDENT
    return np.asarray(Q[:, kept] / np.sqrt(size[kept]))


def beside(system: System, own: IntArray) -> IntArray:
    """Coordinates and those that they are coupled with."""
    extra = system.damping.extra
    matrices = [system.K, system.M] if extra is None else [system.K, system.M, extra]
    return np.unique(np.concatenate([own, *(sp.csr_matrix(A[own]).indices for A in matrices)])).astype(np.int64)


def restricted(whole: System, kept: IntArray) -> System:
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


Result = TypeVar("Result")
SHAPES = 1e-7
"""Of the largest singular value: shapes of the motion beyond that are left out."""
RECOVERED = 100
"""Shapes that the reduced motion of a stretch is made of, or fewer."""
INSTANTS = 200
"""Of a stretch, most that these shapes are made of."""
AROUND = 16.0
"""Times the dofs that touch: of those that move by themselves, the fewest."""
NARROW = 0.25
"""Of these, how many of them do where it is looked at what the border changes."""


class Nearby:
    """Marches through stretches by steps of one length, in which some dofs of the unreduced model move by themselves.

    They are those that lie nearest to the channels that touch, `Handover.nearby` or more. All others move as the lowest
    modes of the reduced model do, and besides as that model does when it is marched by the same steps from the same
    state: u = [u_o; T_b q(t) + Phi_b y]. The unreduced matrices are projected on u_o and y. So what moves otherwise
    near the event moves the rest, too, in these modes; higher ones come back from the border. How much that changes is
    told by marching with a quarter of the dofs, in shells with a border that is half as far away.
    """

    def __init__(self, of: Handover, parts: int, near: IntArray) -> None:
        self._of, self._parts = of, parts
        self._near, self._gaps = near, of.gaps.select(near)
        self._follower: CondensedStepper | None = None

    def side_by_side(
        self, works: Sequence[Callable[[Solver | None], Result]], counted: Callable[[int], object] = int
    ) -> list[Result]:
        """Results of marches, one after the other: each has matrices of its own."""
        return [work(None) for work in works]

    def through(self, s: Span, begins: Begins, channels: IntArray, solver: Solver | None = None) -> Marched:
        """The march from a state of the reduced model near the channels, and the same with a quarter of the dofs."""
        of = self._of
        touching = np.unique(self._of.acts[self._near[self._pressing(s, channels)]].indices)
        most = max(float(of.nearby or of.unreduced.n), AROUND * touching.size)
        sizes = [self._own(touching, part * most) for part in (1.0, NARROW)]
        kept = beside(of.unreduced, sizes[0][0])
        ground, prescribed, (u, v) = self._ground(s, begins, kept)
        both = list[Marched]()
        for own, acting in sizes:
            gaps, friction, here = self._gaps.select(acting), self._gaps.friction, np.searchsorted(kept, own)
            rubs = np.zeros(0, bool) if friction is None else np.repeat(np.isin(friction.channels, acting), 2)
            local = ground.cut_out(here, gaps)
            loads = prescribed.loads(acting, rubs, gaps)
            still = np.zeros(local.n - here.size)
            begun = np.concatenate([u[here], still]), np.concatenate([v[here], still]), prescribed.held[rubs]
            stepper = CondensedStepper(local, gaps, loads, IN_CONTACT).over(loads, begun)
            watched = watching(of.gaps.select(self._silent(own)))
            none = np.zeros(0, dtype=np.int64)
            history = march(stepper, OutputRequest(none, max(1, loads.n_step), watched=watched))
            both.append(Marched(history, gaps, self._near[acting], what_closes(history), 0.0))
        whole, narrow = both
        some = (sizes[0][0].size + sizes[1][0].size) / of.unreduced.n
        solves = _solves(of, some, whole.gaps.m + s.steps, ground.moved.shape[1] + 2)
        return replace(whole, narrow=narrow, solves=solves)

    def _ground(self, s: Span, begins: Begins, kept: IntArray) -> tuple[Ground, Prescribed, Begins]:
        """Where the stretch is marched, what is prescribed there, and how it begins."""
        of, low = self._of, self._of.low
        assert low is not None
        loads, held = cut(of.loads, s, self._parts), of.held(s, self._near)
        q, starts, force = self._followed(loads, begins, held)
        # Orthonormal shapes (n, r) that the motion q (n, k) is made of.
        some = np.unique(np.linspace(0, q.shape[1] - 1, INSTANTS).astype(int))
        U, size, _ = np.linalg.svd(q[:, some], full_matrices=False)
        shapes = np.asarray(U[:, size > SHAPES * size[0]])
        n_s, r = loads.support.shape[2], shapes.shape[1]
        u = recovered_on(
            of.unreduced,
            of.reduced,
            np.column_stack([np.zeros((of.reduced.n, n_s)), shapes, *begins]),
            np.column_stack([np.eye(n_s), np.zeros((n_s, r)), *loads.support[:2, 0]]),
            kept,
        )
        weights = np.zeros((3, loads.time.size, r))
        weights[0], weights[:, 0] = q.T @ shapes, starts @ shapes
        in_shapes = low.shapes.T @ np.asarray(of.reduced.M @ shapes)
        Phi = np.ascontiguousarray(of.low_motion[:, kept].T)
        ground = Ground(restricted(of.unreduced, kept), low, u[:, :-2], Phi, in_shapes, loads.force_labels)
        return ground, Prescribed(loads, weights, force, held), (u[:, -2], u[:, -1])

    def _silent(self, own: IntArray) -> IntArray:
        """Channels that were left out, and hang on nothing but these coordinates."""
        rest = np.ones(self._of.unreduced.n)
        rest[own] = 0.0
        inside = np.flatnonzero((np.asarray(self._of.acts @ rest).ravel() == 0.0) & (np.diff(self._of.acts.indptr) > 0))
        return np.setdiff1d(inside, self._near)

    def _pressing(self, s: Span, channels: IntArray) -> BoolArray:
        """Which of the channels `near` it is about press in a stretch of the reduced run; where none does, all."""
        history, here = self._of.history, np.isin(self._near, channels)
        rows = slice(*np.searchsorted(history.time, s.time(self._of.ends)))
        press = here & (history.force[rows][:, self._near] > 0.0).any(axis=0)
        return press if press.any() else here

    def _own(self, touching: IntArray, dofs: float) -> tuple[IntArray, IntArray]:
        """So many coordinates that move by themselves, and which of the channels `near` act on them: on no others.

        Parameters
        ----------
        touching : coordinates that they lie around.
        """
        from scipy.spatial import cKDTree

        node, of = nodes_of(self._of.unreduced.coordinates), self._of
        at = of.positions[node]
        distance = cKDTree(at[touching]).query(at)[0]
        own = np.isin(node, node[np.argsort(distance, kind="stable")[: int(dofs)]])
        acting = np.asarray(self._of.acts[self._near] @ own.astype(float)).ravel() > 0.0
        own[np.unique(self._of.acts[self._near[acting]].indices)] = True
        return np.flatnonzero(own), np.flatnonzero(acting)

    def _followed(self, loads: Loads, begins: Begins, held: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(n, n_step + 1) coordinates of the reduced model over the stretch; these, their velocity and acceleration at
        its start, (3, n); (n_step + 1, m + 2 f) forces of its channels."""
        if self._follower is None:
            small = self._of.reduced
            if small.damping.extra is not None:  # dashpots couple its modes
                small = replace(small, M=to_dense(small.M), K=to_dense(small.K))
            self._follower = CondensedStepper(small, self._gaps, loads, IN_CONTACT)
        stepper = self._follower.over(loads, (*begins, held))
        every = np.arange(loads.n_step + 1)
        h = march(stepper, OutputRequest(np.zeros(0, dtype=np.int64), max(1, loads.n_step), every))
        start = np.array([*begins, stepper.start().x.a])
        return np.asarray(h.coordinates), start, np.concatenate([h.force, h.tangential], axis=1)


AnyChecker = Checker | Nearby


def checker_of(of: Handover, parts: int, near: IntArray) -> AnyChecker:
    """What marches through stretches by steps of one length."""
    return (Checker if of.nearby is None else Nearby)(of, parts, near)


def price_of(of: Handover, rows: int) -> Price:
    """What checks take by `checker_of`, of channels with so many directions of contact and friction, `rows`."""
    if of.low is None or of.nearby is None:
        return Price(0.0, FACTOR + rows, 0.0, 1.0)  # a factor, and the compliance of the channels
    share = (1.0 + NARROW) * of.nearby / of.unreduced.n
    return Price(FACTOR + BLOCKED * of.low.omega2.size, 0.0, _solves(of, share, rows, RECOVERED), share)


def _solves(of: Handover, share: float, solved: int, recovered: int) -> float:
    """Back-substitutions of the whole that a march near an event takes: a factor and so many solved for on a share of
    the unknowns, and motions that are recovered before it."""
    return share * (FACTOR + solved) + BLOCKED * recovered + (FACTOR if of.by_parts else 0.0)
