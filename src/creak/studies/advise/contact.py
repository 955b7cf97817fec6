"""How long a channel stays closed on its penalty, and what a step makes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.condensed import response, step_limited_stiffness
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import StepFactor

SAMPLE = 48
"""Channels whose local mass is measured, spread evenly."""
STEPS_PER_BOUNCE = 10
"""Steps that a bounce should have."""


@dataclass(frozen=True)
class Bounce:
    """Half a period of a channel's local mass on its contact stiffness."""

    shortest_s: float
    stiffness: float
    """Median, force / length."""
    mass: float
    """Median, the mass that a channel feels within a step."""


@dataclass(frozen=True)
class StepAdvice:
    """One step length and what it does to structure and contact."""

    step: float
    steps: int
    per_period: float
    """Steps per period of the excitation's highest frequency."""
    period_error: float
    """Relative, of a mode at that frequency."""
    damping: float
    """The scheme's own damping ratio there."""
    automatic: Bounce | None
    """Of the channels with automatic stiffness; None: there are none."""
    fixed: Bounce | None
    """Of the channels with a stiffness given in numbers."""
    reduced_s: float
    unreduced_s: float
    hht: str
    """What such a step left on the door."""


def period_error(scheme: Scheme, omega_h: float) -> float:
    """Relative lengthening of the period of a mode with omega h (undamped), from the scheme's amplification matrix.

    HHT to leading order: Omega^2 (1/12 - a/4 - 3 a^2/8).
    """
    return omega_h / abs(math.atan2(*_pole(scheme, omega_h))) - 1.0


def numerical_damping(scheme: Scheme, omega_h: float) -> float:
    """Damping ratio that the scheme gives a mode with omega h: -ln |pole| / |angle of the pole|."""
    y, x = _pole(scheme, omega_h)
    return -math.log(math.hypot(x, y)) / abs(math.atan2(y, x))


def _pole(scheme: Scheme, omega_h: float) -> tuple[float, float]:
    """(imaginary, real) part of the principal root of the amplification matrix of (u, h v, h^2 a)."""
    W, s = omega_h**2, scheme
    left = np.array([[1.0, 0.0, -s.beta], [0.0, 1.0, -s.gamma], [(1.0 - s.alpha_f) * W, 0.0, 1.0 - s.alpha_m]])
    right = np.array([[1.0, 1.0, 0.5 - s.beta], [0.0, 1.0, 1.0 - s.gamma], [-s.alpha_f * W, 0.0, -s.alpha_m]])
    roots = np.linalg.eigvals(np.linalg.solve(left, right))
    pole = max(roots, key=lambda z: (abs(z.imag) > 1e-12, abs(z)))
    return float(pole.imag), float(pole.real)


def bounces(
    system: System, gaps: GapOperator, positions: FloatArray, scheme: Scheme, h: float
) -> tuple[Bounce | None, Bounce | None]:
    """Of channels with automatic stiffness, limited to the step, and of those with a stiffness in numbers.

    A force on channel i moves it within a step by (1 - af) beta h^2 A_ii with A = G S^-1 G', so it feels the mass
    m_i = 1 / A_ii, and bounces on k_i for pi sqrt(m_i / k_i). The mass reached grows with the step; stiff channels,
    whose bounce is shorter than ten steps, are measured again at a tenth of it. Hard channels have no such time, and
    tables none that is known beforehand.
    """
    k = step_limited_stiffness(system, gaps, positions, scheme, h)
    acts = np.isfinite(k) & (k > 0.0)
    auto = _bounce(system, gaps, np.flatnonzero(acts & gaps.step_limited), k, scheme, h)
    given = np.flatnonzero(acts & ~gaps.step_limited)
    fixed = _bounce(system, gaps, given, k, scheme, h)
    if fixed is not None and fixed.shortest_s < STEPS_PER_BOUNCE * h:
        fixed = _bounce(system, gaps, given, k, scheme, fixed.shortest_s / STEPS_PER_BOUNCE)
    return auto, fixed


def _bounce(
    system: System, gaps: GapOperator, which: IntArray, k: FloatArray, scheme: Scheme, h: float
) -> Bounce | None:
    if not which.size:
        return None
    some = which[np.unique(np.linspace(0, which.size - 1, min(which.size, SAMPLE)).astype(np.int64))]
    A, _ = response(StepFactor(system, scheme, h), channel_matrices(system, gaps.select(some)).G, keep=False)
    moves = A.diagonal() > 0.0
    if not moves.any():
        return None
    mass, stiffness = 1.0 / A.diagonal()[moves], k[some][moves]
    time = np.pi * np.sqrt(mass / stiffness)
    return Bounce(float(time.min()), float(np.median(stiffness)), float(np.median(mass)))


def rounded_step(h: float) -> float:
    """The largest of 1, 2, 2.5, 4, 5 times a power of ten that is no longer than h."""
    power = 10.0 ** math.floor(math.log10(h * (1.0 + 1e-9)))
    return float(max(c for c in (1.0, 2.0, 2.5, 4.0, 5.0) if c * power <= h * (1.0 + 1e-9)) * power)


def substeps_for(step: float, bounce: Bounce | None) -> int:
    """Parts of a step near contact that give a bounce `STEPS_PER_BOUNCE` of them."""
    return 1 if bounce is None else max(1, math.ceil(STEPS_PER_BOUNCE * step / bounce.shortest_s * (1.0 - 1e-9)))
