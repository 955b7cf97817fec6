"""The unreduced model near an event alone: what lies beyond follows the reduced one, as in a submodel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray, to_dense
from creak.dynamics.flight.contact_steps import IN_CONTACT
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import CondensedStepper, march
from creak.linalg.together import Solver
from creak.model.dofs import nodes_of
from creak.studies.models.alike import recovered_on
from creak.studies.models.reduced import BLOCKED, FACTOR
from creak.studies.spots.choose import Price, Span
from creak.studies.spots.ground import Ground, Prescribed, beside, restricted
from creak.studies.spots.handover import Begins, Handover
from creak.studies.spots.march import Checker, Marched, cut, watching, what_closes

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
