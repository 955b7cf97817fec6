"""The usual way: Newton iterations on the whole structure, refactorised whenever the contact changes.

Kept as the twin of `simulate` for tests and as the yardstick of benchmarks: same scheme, same result to
round-off, at the cost of a factorisation per iteration.
"""

from __future__ import annotations

import time as clock

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, IntArray, Matrix
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.condensed import channel_matrices
from creak.dynamics.hht import HHT
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.simulate import Instant, first_instant, march
from creak.dynamics.state import LinearTerms
from creak.dynamics.step_matrix import StepFactor, step_matrix
from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import Factor, factor

MAX_ITERATIONS = 50


class PlainNewtonHHT:
    """One step of HHT-alpha by Newton's method: (S + (1 + alpha) beta h^2 G_c' k G_c) da = residual."""

    def __init__(self, system: System, gaps: GapOperator, loads: Loads, scheme: HHT) -> None:
        if gaps.damping.any() or system.damping.modal_shapes is not None:
            raise ValueError("plain Newton handles neither channel dampers nor modal damping")
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.h = scheme, gaps, loads, loads.step
        S = step_matrix(system, scheme, self.h)
        self.S: Matrix = np.diag(S.diagonal()) if isinstance(S, Diagonal) else S
        self.on = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self.factorisations = 0
        self._start = StepFactor(system, scheme, self.h)
        self.setup_s = clock.perf_counter() - started

    def start(self) -> Instant:
        """As the condensed stepper starts."""
        return first_instant(self.terms, self._start, self.gaps, self.on)

    def step(self, n: int, now: Instant) -> Instant:
        """From step n - 1 to step n."""
        scheme, h, on = self.scheme, self.h, self.on
        half = self.terms.predict(now.x, scheme, h)
        rhs = self.terms.right_side(n, now.x, half, scheme, on, now.p)
        base = self.gaps.gap0 + on.G @ half.u + on.G_s @ self.loads.support[0, n]
        a, closed = now.x.a, now.gap < 0.0
        for _ in range(MAX_ITERATIONS):
            gap = base + scheme.beta * h * h * (on.G @ a)
            p = np.where(closed, -self.gaps.stiffness * gap, 0.0)
            residual = rhs + (1.0 + scheme.alpha) * np.asarray(on.G.T @ p) - self.S @ a
            a = a + self._tangent(closed).solve(residual)
            gap = base + scheme.beta * h * h * (on.G @ a)
            if np.array_equal(gap < 0.0, closed):
                p = self.gaps.stiffness * np.maximum(0.0, -gap)
                return Instant(self.terms.advance(half, a, scheme, h, n), gap, p)
            closed = gap < 0.0
        raise NumericalError(f"Newton did not converge at step {n}")

    def _tangent(self, closed: BoolArray) -> Factor:
        self.factorisations += 1
        weight = (1.0 + self.scheme.alpha) * self.scheme.beta * self.h**2
        k = weight * np.where(closed, self.gaps.stiffness, 0.0)
        G = self.on.G
        if sp.issparse(self.S):
            G = sp.csr_matrix(G)
            return factor(sp.csr_matrix(self.S + G.T @ sp.diags_array(k) @ G))
        G = to_dense(G)
        return factor(to_dense(self.S) + (G.T * k) @ G)


def simulate_plain_newton(
    system: System, gaps: GapOperator, loads: Loads, scheme: HHT, *, observed: IntArray, output_every: int = 1
) -> History:
    """As `simulate`, by plain Newton; channels without dampers only."""
    return march(PlainNewtonHHT(system, gaps, loads.consistent_with(scheme), scheme), observed, output_every)
