"""One step without contact, of high order: a real back-substitution and one or two complex ones (`collocation`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.flight.collocation import Collocation, radau_iia
from creak.dynamics.flight.course import Course
from creak.dynamics.instant import Instant
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.dynamics.step_matrix import PencilFactor
from creak.dynamics.vector_kernels import weighted
from creak.linalg.memory import free_bytes

RULES = ((5, 2.25), (3, 1.0))
"""Stages, and flight over output step, the best first: four or ten flights in a period of the excitation where it has
ten output steps. With two and a half, two clamped strips meet 17 times instead of 16."""
SMOOTH = 1e-3
"""Share of the loads that the polynomials through the stages of long flights may miss."""
NO_MORE = "; memory holds the factors of no higher order"
"""Said where a rule is taken for want of memory."""
WIDTH = 6
"""Samples that a polynomial of degree 5 goes through."""


def choose(
    loads: Loads, substeps: int, factor_bytes: float = 0.0, free: float | None = None
) -> tuple[Collocation, int, str]:
    """The best rule whose polynomials follow the loads and whose factors memory holds, its samples, and what to say.

    The last rule is taken where none fits: its factors are refused as they are made (`linalg.memory`).

    Parameters
    ----------
    factor_bytes : of a real factor. free : bytes for them; None: those that are free now.
    """
    free, short = free_bytes() if free is None else free, False
    for stages, long in RULES:
        rule, stride = radau_iia(stages), max(1, round(long * substeps))
        fits = rule.factors * factor_bytes <= free
        if (stages, long) == RULES[-1] or (fits and missed(loads, rule.c, stride) <= SMOOTH):
            break
        short = short or not fits
    return rule, stride, NO_MORE if short else ""


def missed(loads: Loads, c: FloatArray, stride: int) -> float:
    """What polynomials through the samples next to the stages leave of forces and accelerations, RMS over theirs."""
    nodes = np.unique(np.rint(c * stride).astype(np.int64))
    at = np.arange(stride + 1)
    through = np.power.outer(at / stride, np.arange(nodes.size)) @ np.linalg.inv(
        np.vander(nodes / stride, nodes.size, increasing=True)
    )
    most = 0.0
    for course in (*loads.support[2].T, *loads.force.T):
        count = (course.size - 1) // stride
        whole = course[: count * stride].reshape(count, stride)
        parts = np.hstack([whole, course[stride : count * stride + 1 : stride, None]])
        size = float(np.linalg.norm(parts))
        most = max(most, float(np.linalg.norm(parts - parts[:, nodes] @ through.T)) / size if size else 0.0)
    return most


class FlightStep:
    """Steps of `stride` samples of the loads."""

    def __init__(
        self, terms: LinearTerms, gaps: GapOperator, on: ChannelMatrices, rule: Collocation, stride: int
    ) -> None:
        self.terms, self.gaps, self.on, self.rule, self.stride = terms, gaps, on, rule, stride
        self.h = h = stride * terms.loads.step
        poles = (rule.real, *rule.pairs.tolist())
        self._into = (rule.into_real, *rule.into_pairs)
        self._factors = [PencilFactor(terms.system, 1.0 / pole, h, h * h * pole) for pole in poles]
        self._loads = StageLoads(going_on(terms.loads, stride), rule.c, stride)
        self.residual = 0.0

    def course(self, now: Instant) -> Course:
        """The motion from `now` on while no channel presses."""
        t, rule, h, x = self.terms, self.rule, self.h, now.x
        support, force = self._loads(now.row)
        driven = t.B @ force.T if t.forced else np.zeros((t.B.shape[0], rule.stages))
        outside = driven - t.M_qs @ support[2].T - t.C_qs @ support[1].T - t.K_qs @ support[0].T
        r = self.on.push(-(x.Cv + x.Ku), -self.gaps.resting)
        Y = np.empty((x.u.size, rule.stages))
        for j, (factor, into) in enumerate(zip(self._factors, self._into, strict=True)):
            b = weighted(r, x.Kv, into.sum(), h * into @ rule.c, np.empty(r.size, dtype=into.dtype))
            b[t.driven] += outside @ into
            y = factor.solve(b)
            if j == 0:
                Y[:, 0] = y
            else:
                Y[:, 2 * j - 1], Y[:, 2 * j] = y.real, y.imag
        return Course(t, self.gaps, self.on, rule, self.stride, now, Y, (support, force))

    def refresh(self, after: Instant) -> None:
        """Products of the motion anew, so that round-off does not pile up, and the residual there."""
        t, x = self.terms, after.x
        K, M = t.system.K, t.system.M
        x.Ku, x.Kv, x.Mv = np.asarray(K @ x.u), np.asarray(K @ x.v), np.asarray(M @ x.v)
        x.Cv = t.damped(x.v, x.Mv, x.Kv)
        outside = t.outside(after.row, after.support)
        heavy, inner = np.asarray(M @ x.a), x.Cv + x.Ku
        left = self.on.push(heavy + inner, self.gaps.resting)
        left[t.driven] -= outside.load - outside.inertia
        largest = max(float(np.linalg.norm(term)) for term in (heavy, inner, outside.load - outside.inertia))
        self.residual = max(self.residual, float(np.linalg.norm(left)) / largest if largest > 0.0 else 0.0)


def going_on(loads: Loads, more: int) -> Loads:
    """The same with `more` samples behind the last: forces as they are there, motion with the acceleration there.

    For the last step of a run, of which only the part before the end counts.
    """
    t = loads.step * np.arange(1, more + 1)[:, None]
    s, v, a = loads.support[:, -1]
    beyond = np.stack([s + t * v + 0.5 * t * t * a, v + t * a, np.broadcast_to(a, (more, a.size))])
    force = np.concatenate([loads.force, np.repeat(loads.force[-1:], more, axis=0)])
    time = np.concatenate([loads.time, loads.time[-1] + t[:, 0]])
    return replace(loads, time=time, support=np.concatenate([loads.support, beyond], axis=1), force=force)


class StageLoads:
    """Prescribed motion and forces at the stages of a step, by polynomials through the samples around each.

    Displacement, velocity and acceleration are interpolated each by itself, by polynomials of degree 5: a sine with ten
    samples a period is met to some 3e-4, with 50 to 2e-8.
    """

    def __init__(self, loads: Loads, c: FloatArray, stride: int) -> None:
        self._loads, self._at = loads, c * stride
        self._width = min(WIDTH, loads.time.size)
        self._known: dict[tuple[int, int], FloatArray] = {}

    def __call__(self, row: int) -> tuple[FloatArray, FloatArray]:
        """(3, n_stage, n_support) motion and (n_stage, n_force) forces of the step that begins at sample `row`."""
        motion, force = [], []
        for i, share in enumerate(self._at):
            first = int(np.clip(row + int(share) - self._width // 2 + 1, 0, self._loads.time.size - self._width))
            rows = slice(first, first + self._width)
            weights = self._weights(i, row - first + share)
            motion.append(np.einsum("j,djs->ds", weights, self._loads.support[:, rows]))
            force.append(weights @ self._loads.force[rows])
        return np.stack(motion, axis=1), np.stack(force)

    def _weights(self, stage: int, x: float) -> FloatArray:
        """Lagrange's polynomials through 0, 1 ... at x."""
        key = (stage, int(x))
        if key not in self._known:
            nodes = np.arange(self._width)
            others = [np.delete(nodes, j) for j in nodes]
            self._known[key] = np.array([np.prod((x - o) / (j - o)) for j, o in zip(nodes, others, strict=True)])
        return self._known[key]
