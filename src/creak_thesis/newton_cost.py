"""What the usual way costs: steps of plain Newton with refactorisation, timed and scaled to a whole run.

Plain Newton is the twin of `simulate` for tests and the yardstick of benchmarks: iterations on the whole structure,
refactorised whenever the contact changes; the same scheme, and the same result to round-off. Beside its steps the
condensed ones on the same matrices.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak import GapOperator, Loads, NumericalError, Scheme, System
from creak.stepping import (
    CondensedStepper,
    Factor,
    Instant,
    LinearTerms,
    StepFactor,
    Stepper,
    begin,
    channel_matrices,
    factor,
    first_instant,
    one_blas_thread,
    step_matrix,
    to_dense,
)
from creak_thesis.arrays import FloatArray

MAX_ITERATIONS = 50


@dataclass(frozen=True)
class NewtonCost:
    """CPU time of plain Newton's steps on one model, and of condensed ones."""

    flight_s: float
    """A step without contact, s."""
    contact_s: float
    """A step with contact, s."""
    factorisations: float
    """Of a step, on average over all that were made with contact about."""
    condensed_flight_s: float
    condensed_contact_s: float
    steps: int
    """That were timed of each kind."""


def touching(gaps: GapOperator) -> GapOperator:
    """The same channels without clearance: they touch within a few steps."""
    return replace(gaps, gap0=np.zeros(gaps.m))


def newton_cost(system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, steps: int) -> NewtonCost:
    """Time `steps` steps in flight, and as many in contact on the same channels without clearance.

    Every iteration of a step factorises anew, as an implicit code without condensation does.
    """
    closed = touching(gaps)
    flight = _timed(PlainNewton(system, gaps.without_force(), loads, scheme), steps, pressed=False)
    newton = PlainNewton(system, closed, loads, scheme)
    contact = _timed(newton, steps, pressed=True)
    condensed = CondensedStepper(system, closed, loads, scheme)
    again = _timed(CondensedStepper(system, gaps.without_force(), loads, scheme), 5 * steps, pressed=False)
    return NewtonCost(
        flight, contact, newton.factorisations / newton.steps, again, _timed(condensed, 5 * steps, pressed=True), steps
    )


def _timed(stepper: Stepper, steps: int, *, pressed: bool) -> float:
    """Median CPU time of `steps` steps that end with or without contact."""
    now, seconds = stepper.start(), []
    with one_blas_thread():
        for _ in range(20 * steps):
            started = clock.process_time()
            for now in stepper.advance(now):  # noqa: B007, B020
                pass
            if bool(now.p.any()) == pressed:
                seconds.append(clock.process_time() - started)
            if len(seconds) == steps:
                break
    return float(np.median(seconds)) if seconds else float("nan")


class PlainNewton:
    """One step by Newton's method: (S + (1 - af) beta h^2 G' k G) da = residual, k the tangent of the channels.

    Normal laws with a tangent: penalty, damper, pressure curve. Exact contact and friction have none.
    """

    def __init__(self, system: System, gaps: GapOperator, loads: Loads, scheme: Scheme) -> None:
        if system.damping.modal_shapes is not None or gaps.rubbing or not np.isfinite(gaps.stiffness).all():
            raise ValueError("plain Newton handles neither modal damping nor friction nor exact contact")
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.h, self.substeps = scheme, gaps, loads, loads.step, 1
        S = step_matrix(system, scheme, self.h)
        self.S: Any = S if sp.issparse(S) else to_dense(S)
        self.on = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self.factorisations, self.steps, self.residual = 0, 0, 0.0
        self._start = StepFactor(system, scheme, self.h)
        self.setup_s = clock.perf_counter() - started

    def start(self) -> Instant:
        """As the condensed stepper starts."""
        return first_instant(self.terms, self._start, self.scheme, self.gaps, self.on)

    def advance(self, now: Instant) -> Iterator[Instant]:
        """One step."""
        self.steps += 1
        scheme, h, on, gaps = self.scheme, self.h, self.on, self.gaps
        begun = begin(self.terms, gaps, on, scheme, h, now)
        half, support = begun.half, begun.support
        base = gaps.gap0 + on.G @ half.u + on.G_s @ support[0]
        base_rate = on.G @ half.v + on.G_s @ support[1]
        a, gain = now.x.a, scheme.gamma / (scheme.beta * h)
        gap, rate = self._at(a, base, base_rate)
        p, tangent = _normal_law(gaps, gap, rate, gain)
        for _ in range(MAX_ITERATIONS):
            residual = begun.right_side + (1.0 - scheme.alpha_f) * np.asarray(on.G.T @ p) - self.S @ a
            a = a + self._tangent(tangent).solve(residual)
            before = tangent
            gap, rate = self._at(a, base, base_rate)
            p, tangent = _normal_law(gaps, gap, rate, gain)
            if np.array_equal(tangent, before):  # every channel stayed on its piece: the step is solved
                break
        else:
            raise NumericalError(f"Newton did not converge at t = {self.loads.time[begun.row]:.6g} s")
        x = self.terms.advance(half, a, scheme, h, begun.fresh)
        yield Instant(begun.row, x, support, gap, rate, p, np.zeros(0), np.zeros(0, dtype=bool))

    def _at(self, a: FloatArray, base: FloatArray, base_rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps and their rates for an acceleration."""
        h, G = self.h, self.on.G
        move = np.asarray(G @ a)
        return base + self.scheme.beta * h * h * move, base_rate + self.scheme.gamma * h * move

    def _tangent(self, k: FloatArray) -> Factor:
        """A factor of the step matrix with the channels' tangent stiffness k (m,)."""
        self.factorisations += 1
        k = (1.0 - self.scheme.alpha_f) * self.scheme.beta * self.h**2 * k
        G = self.on.G
        if sp.issparse(self.S):
            G = sp.csr_matrix(G)
            return factor(sp.csr_matrix(self.S + G.T @ sp.diags_array(k) @ G))
        G = to_dense(G)
        return factor(to_dense(self.S) + (G.T * k) @ G)


def _normal_law(
    gaps: GapOperator, gap: FloatArray, rate: FloatArray, rate_gain: float
) -> tuple[FloatArray, FloatArray]:
    """Forces (m,) and -dp/dg, with the damper's share by rate = rate_gain g + ..."""
    elastic, slope = gaps.stiffness * -gap, gaps.stiffness.copy()
    if gaps.curves is not None:
        for j in np.flatnonzero((gaps.curves.of >= 0) & (gap < 0.0)):
            x, y = gaps.curves.points[gaps.curves.of[j]].T
            k = int(np.clip(np.searchsorted(x, -gap[j], side="right") - 1, 0, x.size - 2))
            slope[j] = gaps.curves.scale[j] * (y[k + 1] - y[k]) / (x[k + 1] - x[k])
            elastic[j] = gaps.curves.scale[j] * y[k] + slope[j] * (-gap[j] - x[k])
    p = elastic - gaps.damping * rate
    pressing = (gap < 0.0) & (p > 0.0)
    return np.where(pressing, p, 0.0), np.where(pressing, slope + gaps.damping * rate_gain, 0.0)
