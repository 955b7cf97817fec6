"""One step without contact, of high order: a real back-substitution and one or two complex ones (`collocation`);
motion, gaps and energies at any sample in it."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.closing import first_closing
from creak.dynamics.flight.collocation import Collocation, radau_iia
from creak.dynamics.instant import Instant, Works
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms, State
from creak.dynamics.step_matrix import PencilFactor
from creak.dynamics.vector_kernels import times_few, weighted
from creak.linalg.memory import free_bytes

UNKNOWN: FloatArray = np.zeros(0)
"""Products that an instant within a step does without."""
RINGING = 3e-2
"""Energy that sets the course apart from the stages, over the kinetic: 2e-3 at 300 Hz with 2.5 ms, .1 at 600 Hz."""


@lru_cache(maxsize=1024)
def weights_at(
    stages: int, h: float, shares: tuple[float, ...], known: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(k, 3 + s) weights of u0, v0, a0 and Y in accelerations, velocities and displacements at k shares of a step h.

    Kept, since flights of a run ask for the same ones: not to be written to.
    """
    rule, x = radau_iia(stages), np.array(shares)
    inner = rule.within(x, known)
    inner = np.concatenate([inner[:, :, :1], inner[:, :, 1:] @ rule.P], axis=2)
    a, v, u = (np.hstack([np.zeros((x.size, 2)), part]) for part in (inner[0], h * inner[1], h * h * inner[2]))
    v[:, 1] = 1.0
    u[:, 0], u[:, 1] = 1.0, h * x
    for weights in (a, v, u):
        weights.flags.writeable = False
    return a, v, u


@lru_cache(maxsize=1024)
def through_stages(stages: int, h: float, share: float) -> tuple[FloatArray, FloatArray]:
    """(3 + s,) weights of velocities and displacements at a share of a step h, by the stages alone; kept as well."""
    rule = radau_iia(stages)
    stage = rule.within(np.array([share]), False)[0, 0, 1:]
    v, u = np.zeros((stages, 3 + stages)), np.zeros((stages, 3 + stages))
    v[:, 1], v[:, 3:] = 1.0, h * rule.A @ rule.P
    u[:, 0], u[:, 1], u[:, 3:] = 1.0, h * rule.c, h * h * rule.A @ rule.A @ rule.P
    return stage @ v, stage @ u


class Course:
    """From `now` on, `stride` samples long, of a Collocation with the solutions Y of its poles.

    Everything is a combination of u0, v0, a0 and Y, the columns of one matrix, and so are the products with K and M: an
    instant costs no solution and no product of its own, energies are quadratic forms of the weights.
    """

    def __init__(
        self,
        terms: LinearTerms,
        gaps: GapOperator,
        on: ChannelMatrices,
        rule: Collocation,
        stride: int,
        now: Instant,
        Y: FloatArray,
        loads: tuple[FloatArray, FloatArray],
    ) -> None:
        self.terms, self.gaps, self.on, self.rule, self.stride, self.begun = terms, gaps, on, rule, stride, now
        self._loads = loads
        self.h = stride * terms.loads.step
        self.Y, self._known = Y, now.works is not None
        self._basis = np.column_stack((now.x.u, now.x.v, now.x.a, Y))
        self._G = np.asarray(on.G @ self._basis)
        self._booked = np.zeros(2)

    # --- closing ------------------------------------------------------------------------------------------------------

    def opens_until(self, ahead: IntArray) -> int:
        """How many of the pieces between the samples `ahead` (k + 1,) of the step pass before a gap may close."""
        if not self.gaps.presses:
            return int(ahead.size) - 1
        x, h, row = ahead / self.stride, self.h, self.begun.row
        motion = self.terms.loads.support[:, row + ahead]
        _, v, u = self._weights(x, self._known)
        gap = self.gaps.gap0 + u @ self._G.T + motion[0] @ self.on.G_s.T
        rate = v @ self._G.T + motion[1] @ self.on.G_s.T
        # The displacement by the stage velocities is less accurate by a degree: the difference stands for the error.
        coarse = self._weights(x, False)[2].copy()
        coarse[:, 3:] = h * h * self.rule.within(x, False)[1][:, 1:] @ self.rule.A @ self.rule.P
        off = np.abs((u - coarse) @ self._G.T)
        pieces = int(first_closing(gap - off, rate, np.diff(ahead) * self.terms.loads.step))
        return pieces if pieces == ahead.size - 1 or self._resolved else 0

    # --- instants -----------------------------------------------------------------------------------------------------

    def at(self, row: int, whole: bool) -> Instant:
        """The instant at sample `row` of the loads; `whole`: with all that another step needs to go on from it."""
        t, ahead = self.terms, row - self.begun.row
        a, v, u = (w[0] for w in self._weights(np.array([ahead / self.stride]), self._known))
        support = t.loads.support[:, row]
        if not self._resolved:
            v, u = through_stages(self.rule.stages, self.h, ahead / self.stride)
        works = self._booked_until(ahead / self.stride, u, v)
        x = self._state(a, v, u) if whole else self._motion(v, u)
        m, f = self.gaps.m, self.gaps.rubbing
        return Instant(
            row,
            x,
            support,
            self.gaps.gap0 + self._G @ u + self.on.G_s @ support[0],
            self._G @ v + self.on.G_s @ support[1],
            np.zeros(m + 2 * f),
            np.zeros(2 * f),
            np.ones(f, dtype=bool),
            works=works,
        )

    def _weights(self, x: FloatArray, known: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
        """As `weights_at`."""
        return weights_at(self.rule.stages, self.h, tuple(x.tolist()), known)

    @cached_property
    def _resolved(self) -> bool:
        """Whether the course leads from the beginning to the stages without more energy than its own.

        What rings faster than a step resolves is gone at the stages, but not at the beginning: a polynomial through
        both would swing out between them. The motion before and behind the first stage is compared with that by the
        stages alone.
        """
        in_K, in_M = self._squares
        first, second = self.rule.c[:2]
        apart, scale = 0.0, float(in_M[0, 0])
        for x in (0.5 * first, 0.5 * (first + second)):
            _, v, u = (w[0] for w in self._weights(np.array([x]), self._known))
            by_stages = through_stages(self.rule.stages, self.h, float(x))
            dv, du = (a - b for a, b in zip((v, u), by_stages, strict=True))
            apart = max(apart, float(dv[1:] @ in_M @ dv[1:] + du @ in_K @ du))
        for v in self._weights(self.rule.c, False)[1]:
            scale = max(scale, float(v[1:] @ in_M @ v[1:]))
        return apart <= RINGING * scale

    def _motion(self, v: FloatArray, u: FloatArray) -> State:
        moved, rate = np.stack([u, v]) @ self._basis.T
        return State(moved, rate, *([UNKNOWN] * 7))

    def _state(self, a: FloatArray, v: FloatArray, u: FloatArray) -> State:
        weights = np.stack([u, v, a])
        KB, MB = self._with_products
        moved, rate, bend = weights @ self._basis.T
        Ku, Kv, Ka = weights @ KB.T
        Mv, Ma = weights[1:, 1:] @ MB.T
        return State(u=moved, v=rate, a=bend, Ku=Ku, Kv=Kv, Ka=Ka, Mv=Mv, Ma=Ma, Cv=self.terms.damped(rate, Mv, Kv))

    @cached_property
    def _with_products(self) -> tuple[FloatArray, FloatArray]:
        """K times the basis, (n, 3 + s), and M times all of it but the displacement."""
        x, system = self.begun.x, self.terms.system
        KY, MY = times_few(system.K, self.Y), times_few(system.M, self.Y)
        return np.column_stack((x.Ku, x.Kv, x.Ka, KY)), np.column_stack((x.Mv, x.Ma, MY))

    # --- books --------------------------------------------------------------------------------------------------------

    def _booked_until(self, share: float, u: FloatArray, v: FloatArray) -> Works:
        """Works since the instant before, by the quadrature of the stages, and what is stored at displacements u.

        The balance of a whole step then holds exactly but for the scheme's own dissipation, which is never negative,
        and for prescribed motion that no polynomial follows.
        """
        damping, external = self._powers
        weights = self.h * self.rule.work(share)
        done = np.array([weights @ damping, weights @ external])
        more, self._booked = done - self._booked, done
        in_K, in_M = self._squares
        return Works(float(more[0]), float(more[1]), 0.5 * float(v[1:] @ in_M @ v[1:]), 0.5 * float(u @ in_K @ u))

    @cached_property
    def _squares(self) -> tuple[FloatArray, FloatArray]:
        """Products of the basis with K times itself and, without the displacement, with M times itself."""
        KB, MB = self._with_products
        return self._basis.T @ KB, self._basis[:, 1:].T @ MB

    @cached_property
    def _powers(self) -> tuple[FloatArray, FloatArray]:
        """(s,) power of the dampers and of the outside at the stages."""
        t, sup, (support, force) = self.terms, self.terms.system.supports, self._loads
        a, v, u = self._weights(self.rule.c, False)
        in_K, in_M = self._squares
        d = t.system.damping
        powers = np.einsum("ki,ij,kj->k", v[:, 1:], d.alpha * in_M + d.beta * in_K[1:, 1:], v[:, 1:])
        if not d.is_rayleigh:
            V = self._basis @ v.T
            powers += (V * d.other(V)).sum(axis=0)
        some = self._basis[t.driven]
        w, rate, moved = some @ a.T, some @ v.T, some @ u.T
        s, s_dot, s_dots = (x.T for x in support)
        damper = t.C_qs.T @ rate + t.C_ss @ s_dot
        reaction = t.M_qs.T @ w + sup.M_ss @ s_dots + damper + t.K_qs.T @ moved + sup.K_ss @ s
        if self.gaps.preload is not None:
            reaction += (self.on.G_s.T @ self.gaps.preload)[:, None]
        external = (reaction * s_dot).sum(axis=0)
        if t.forced:
            external += ((t.B.T @ rate) * force.T).sum(axis=0)
        damping = powers + ((t.C_qs @ s_dot) * rate).sum(axis=0) + (damper * s_dot).sum(axis=0)
        return damping, external


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
