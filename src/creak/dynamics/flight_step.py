"""One step without contact, of high order: two back-substitutions, one of them complex (`collocation`)."""

from __future__ import annotations

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.closing import closes_in_flight
from creak.dynamics.collocation import Collocation, radau_iia
from creak.dynamics.instant import Instant, Works
from creak.dynamics.simulate import REFRESH
from creak.dynamics.stage_loads import StageLoads
from creak.dynamics.state import LinearTerms, State
from creak.dynamics.step_matrix import PencilFactor
from creak.dynamics.vector_kernels import right_sides, stage_powers, stages, times_four

UNKNOWN: FloatArray = np.zeros(0)
"""Products with the acceleration, which flight does without."""


class FlightStep:
    """Steps of `stride` samples of the loads."""

    def __init__(self, terms: LinearTerms, gaps: GapOperator, on: ChannelMatrices, stride: int) -> None:
        self.terms, self.gaps, self.on, self.stride = terms, gaps, on, stride
        self.rule: Collocation = radau_iia()
        rule, (real, pair) = self.rule, self.rule.poles
        self.h = h = stride * terms.loads.step
        system: System = terms.system
        self._real = PencilFactor(system, 1.0 / real, h, h * h * real)
        self._complex = PencilFactor(system, 1.0 / pair, h, h * h * pair)
        self._loads = StageLoads(terms.loads, rule.c, stride)
        self._damped = not system.damping.is_rayleigh or system.damping.alpha != 0.0 or system.damping.beta != 0.0
        self._starts = (
            float(rule.into_real.sum()),
            float(h * rule.into_real @ rule.c),
            complex(rule.into_complex.sum()),
            complex(h * rule.into_complex @ rule.c),
        )
        self._in_v = h * rule.A @ rule.P
        self._in_u = h * rule.A @ self._in_v
        self._preload = np.zeros(on.G_s.shape[1]) if gaps.preload is None else on.G_s.T @ gaps.preload
        self.residual = 0.0

    def step(self, now: Instant) -> tuple[Instant, bool]:
        """The instant at the end if no channel presses, and whether one may on the way."""
        t, rule, h, x = self.terms, self.rule, self.h, now.x
        support, force = self._loads(now.row)
        driven = t.B @ force.T if t.forced else np.zeros((t.driven.size, 3))
        outside = driven - t.M_qs @ support[2].T - t.C_qs @ support[1].T - t.K_qs @ support[0].T
        r = self.on.push(-(x.Cv + x.Ku), -self.gaps.resting)
        b_real, b_complex = right_sides(r, x.Kv, *self._starts)
        b_real[t.driven] += outside @ rule.into_real
        b_complex[t.driven] += outside @ rule.into_complex
        Y = self._real.solve(b_real), self._complex.solve(b_complex)
        X, a = stages(x.u, x.v, *Y, h, self._in_u[2], self._in_v, rule.P[2])
        end, powers = self._state(X, a)
        works = self._works(now, Y, X, powers, support, force)
        after = self._instant(now, end, support[:, 2], works)
        if after.row // (REFRESH * self.stride) != now.row // (REFRESH * self.stride):
            self._check(end, outside[:, 2])
        return after, self.gaps.presses and self._closes(now, Y, support, after)

    def _state(self, X: FloatArray, a: FloatArray) -> tuple[State, FloatArray]:
        """The end, and V' C V of all stages (3,)."""
        t = self.terms
        KX, MX = times_four(t.system.K, X), times_four(t.system.M, X)
        CX = t.damped(X, MX, KX) if self._damped else np.zeros_like(X)
        v, u, Kv, Ku, Mv, Cv = (
            np.ascontiguousarray(A[:, k]) for A, k in ((X, 2), (X, 3), (KX, 2), (KX, 3), (MX, 2), (CX, 2))
        )
        return State(u, v, a, Ku, Kv, UNKNOWN, Mv, UNKNOWN, Cv), stage_powers(X, CX)

    def _instant(self, now: Instant, end: State, support: FloatArray, works: Works) -> Instant:
        on, m, f = self.on, self.gaps.m, self.gaps.rubbing
        gap = self.gaps.gap0 + on.G @ end.u + on.G_s @ support[0]
        rate = on.G @ end.v + on.G_s @ support[1]
        return Instant(
            now.row + self.stride,
            end,
            support,
            np.asarray(gap),
            np.asarray(rate),
            np.zeros(m + 2 * f),
            np.zeros(2 * f),
            np.ones(f, dtype=bool),
            works=works,
        )

    def _closes(self, now: Instant, Y: tuple[FloatArray, ComplexArray], support: FloatArray, after: Instant) -> bool:
        """Whether any gap may close before the end of the step."""
        on, h, c = self.on, self.h, self.rule.c
        Gv = np.asarray(on.G @ now.x.v)
        GY = np.column_stack((on.G @ Y[0], on.G @ Y[1].real, on.G @ Y[1].imag))
        start = now.gap - on.G_s @ now.support[0]
        inner = [start + c[k] * h * Gv + GY @ self._in_u[k] + on.G_s @ support[0, k] for k in range(2)]
        a0, a1 = (np.asarray(on.G @ i.x.a + on.G_s @ i.support[2]) for i in (now, after))
        rate0 = Gv + on.G_s @ now.support[1]
        known = now.works is not None
        return bool(closes_in_flight(np.stack([now.gap, *inner, after.gap]), rate0, after.rate, a0, a1, known, c, h))

    def _works(
        self,
        now: Instant,
        Y: tuple[FloatArray, ComplexArray],
        X: FloatArray,
        powers: FloatArray,
        support: FloatArray,
        force: FloatArray,
    ) -> Works:
        """Work of dampers and of the outside, by the quadrature of the scheme.

        The balance then holds exactly but for the scheme's own dissipation, h^2 / 2 sum (W' M W + V' K V) of the third
        differences of the stages, which is never negative, and for prescribed motion that no polynomial follows.
        """
        t, h, sup = self.terms, self.h, self.terms.system.supports
        some = t.driven
        y = np.column_stack((Y[0][some], Y[1][some].real, Y[1][some].imag))
        v, w = X[some, :3], y @ self.rule.P.T
        u = now.x.u[some, None] + h * now.x.v[some, None] * self.rule.c + y @ self._in_u.T
        s, s_dot, s_dots = (x.T for x in support)
        damper = t.C_qs.T @ v + t.C_ss @ s_dot
        reaction = t.M_qs.T @ w + sup.M_ss @ s_dots + damper + t.K_qs.T @ u + sup.K_ss @ s + self._preload[:, None]
        external = (reaction * s_dot).sum(axis=0)
        if t.forced:
            external += ((t.B.T @ v) * force.T).sum(axis=0)
        damping = powers + ((t.C_qs @ s_dot) * v).sum(axis=0) + (damper * s_dot).sum(axis=0)
        weights = h * self.rule.b
        return Works(float(weights @ damping), float(weights @ external))

    def _check(self, end: State, outside: FloatArray) -> None:
        """Residual of the equation of motion at the end, as a fraction of its largest term."""
        heavy, inner = np.asarray(self.terms.system.M @ end.a), end.Cv + end.Ku
        left = self.on.push(heavy + inner, self.gaps.resting)
        left[self.terms.driven] -= outside
        largest = max(float(np.linalg.norm(term)) for term in (heavy, inner, outside))
        self.residual = max(self.residual, float(np.linalg.norm(left)) / largest if largest > 0.0 else 0.0)
