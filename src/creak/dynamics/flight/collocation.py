"""Radau IIA: collocation of order 2 s - 1 with s stages, L-stable, for M u'' + C u' + K u = f.

In a step of length h the stage accelerations W_i obey the equation of motion at the times t0 + c_i h,

    M W_i + C V_i + K U_i = f_i,   V = v0 + h A W,   U = u0 + h c v0 + h^2 A^2 W,

(Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.5 and IV.8; Butcher, Math. Comp. 18, 1964).
A = T diag(lambda) T^-1 has one real pole where s is odd and complex pairs, so that W = T w falls apart into systems of
the size of M, one a pole or pair,

    (M / lambda + h C + h^2 lambda K) w = (T^-1 f - T^-1 1 (C v0 + K u0) - h T^-1 c K v0) / lambda.

It is the Pade approximation (s - 1, s) of the exact flow. With three stages at ten steps a period the period is 1.4e-6
too long and the damping ratio 1.3e-5, at 3.3 steps 9e-4 and 2.6e-3; with five stages and steps twice as long 2e-9 and
2e-8, then 9e-5 and 2e-4, for five sixths of the work. What the step does not resolve it damps out, while Gauss's
schemes let that ring on with |R| = 1. The last stage is the end of the step: the equation of motion holds there,
coordinates without mass are at their static answer, and no acceleration is carried from step to step.

Within a step the motion is the polynomial whose acceleration goes through the stages, and through that of the beginning
where it is known: one degree more. The polynomial that vanishes at all stages is orthogonal to those of degree s - 2,
so the ends are those of the step either way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.polynomial import legendre

from creak.arrays import ComplexArray, FloatArray


@dataclass(frozen=True)
class Collocation:
    """A stiffly accurate scheme of s stages as real factors: W = P Y, Y = (w_real, Re w_pair, Im w_pair, ...)."""

    A: FloatArray
    """(s, s)"""
    c: FloatArray
    """(s,) times of the stages as shares of the step; the last is 1."""
    real: float
    """lambda of the real system."""
    pairs: ComplexArray
    """((s - 1) / 2,) those of the complex systems."""
    P: FloatArray
    """(s, s)"""
    into_real: FloatArray
    """(s,) row of T^-1 of the real pole, over that pole."""
    into_pairs: ComplexArray
    """((s - 1) / 2, s) the same of the complex poles."""

    @property
    def stages(self) -> int:
        return int(self.c.size)

    @property
    def order(self) -> int:
        return 2 * self.stages - 1

    @property
    def factors(self) -> int:
        """What its factors take, in real ones."""
        return self.stages

    def within(self, x: FloatArray, known: bool) -> FloatArray:
        """(3, k, s + 1) weights of (a0, W) in a, v / h and u / h^2 at shares x (k,) of the step, from rest.

        known : a0, the acceleration at the beginning, counts.
        """
        return _within(self.stages, tuple(x.tolist()), known)

    def work(self, x: float) -> FloatArray:
        """(s,) weights of the stages in an integral from the beginning to share x of the step, over h."""
        return np.asarray(self.within(np.array([x]), False)[1, 0, 1:])


@lru_cache(maxsize=1024)
def _within(stages: int, shares: tuple[float, ...], known: bool) -> FloatArray:
    """`Collocation.within`, kept: steps of a run ask for the same shares again and again."""
    c, x = radau_iia(stages).c, np.array(shares)
    nodes = np.concatenate([[0.0], c]) if known else c
    j = np.arange(nodes.size)
    of_node = np.linalg.inv(np.vander(nodes, nodes.size, increasing=True))
    powers = np.power.outer(x, j)
    once, twice = x[:, None] * powers / (j + 1), x[:, None] ** 2 * powers / ((j + 1) * (j + 2))
    found = np.zeros((3, x.size, stages + 1))
    found[:, :, stages + 1 - nodes.size :] = np.stack([powers, once, twice]) @ of_node
    found.flags.writeable = False
    return found


@cache
def radau_iia(stages: int) -> Collocation:
    """Radau IIA of an odd number of stages and its poles."""
    series = np.zeros(stages + 1)
    series[stages], series[stages - 1] = 1.0, -1.0
    c = 0.5 + 0.5 * np.sort(legendre.legroots(series).real)
    c[-1] = 1.0
    j = np.arange(stages)
    A = np.power.outer(c, j + 1) / (j + 1) @ np.linalg.inv(np.vander(c, stages, increasing=True))
    poles, T = np.linalg.eig(A)
    r = int(np.argmin(np.abs(poles.imag)))
    z = np.flatnonzero(poles.imag > 1e-9)
    inverse = np.linalg.inv(T)
    scale = T[0, r] / abs(T[0, r])
    columns = [(T[:, r] / scale).real]
    for k in z:
        columns += [2.0 * T[:, k].real, -2.0 * T[:, k].imag]
    real = float(poles[r].real)
    return Collocation(
        A, c, real, poles[z], np.column_stack(columns), (inverse[r] * scale).real / real, inverse[z] / poles[z, None]
    )
