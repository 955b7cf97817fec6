"""Radau IIA of three stages: collocation of order 5, L-stable, for M u'' + C u' + K u = f.

In a step of length h the stage accelerations W_i obey the equation of motion at the times t0 + c_i h,

    M W_i + C V_i + K U_i = f_i,   V = v0 + h A W,   U = u0 + h c v0 + h^2 A^2 W,

(Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.5 table 5.6 and IV.8; Butcher, Math.
Comp. 18, 1964). A = T diag(lambda) T^-1 has one real pole and one complex pair, so that W = T w falls apart into a real
and a complex system of the size of M,

    (M / lambda + h C + h^2 lambda K) w = (T^-1 f - T^-1 1 (C v0 + K u0) - h T^-1 c K v0) / lambda.

It is the Pade approximation (2, 3) of the exact flow. At ten steps a period its period is 1.4e-6 too long and its
damping ratio 1.3e-5, at five 9e-5 and 4e-4: what the step resolves it keeps. What it does not resolve it damps out (at
two steps a period with a ratio of .02, at one with .12), while Gauss's scheme of order 6, Pade (3, 3), lets that ring
on with |R| = 1. The last stage is the end of the step: the equation of motion holds there, coordinates without mass are
at their static answer, and no acceleration is carried from step to step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from creak.arrays import FloatArray


@dataclass(frozen=True)
class Collocation:
    """A stiffly accurate scheme of three stages as real factors: W = P Y, Y = (w_real, Re w_complex, Im w_complex)."""

    A: FloatArray
    """(3, 3)"""
    c: FloatArray
    """(3,) times of the stages as shares of the step; the last is 1."""
    poles: tuple[float, complex]
    """lambda of the real and of the complex system."""
    P: FloatArray
    """(3, 3)"""
    into_real: FloatArray
    """(3,) row of T^-1 of the real pole, over that pole."""
    into_complex: FloatArray
    """(3,) the same of the complex pole."""

    @property
    def b(self) -> FloatArray:
        """(3,) weights of the step, and of work in it."""
        return np.asarray(self.A[2])


@cache
def radau_iia() -> Collocation:
    """Radau IIA of order 5 and its poles."""
    q = np.sqrt(6.0)
    A = np.array(
        [
            [(88 - 7 * q) / 360, (296 - 169 * q) / 1800, (-2 + 3 * q) / 225],
            [(296 + 169 * q) / 1800, (88 + 7 * q) / 360, (-2 - 3 * q) / 225],
            [(16 - q) / 36, (16 + q) / 36, 1 / 9],
        ]
    )
    poles, T = np.linalg.eig(A)
    r, z = int(np.argmin(np.abs(poles.imag))), int(np.argmax(poles.imag))
    inverse = np.linalg.inv(T)
    P = np.column_stack([(T[:, r]).real, 2.0 * T[:, z].real, -2.0 * T[:, z].imag])
    real, pair = float(poles[r].real), complex(poles[z])
    return Collocation(A, A.sum(axis=1), (real, pair), P, inverse[r].real / real, inverse[z] / pair)
