"""What drives a run: prescribed motion and forces, sampled at the steps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.hht import HHT


@dataclass(frozen=True)
class Loads:
    """Samples at every step, n_time = n_step + 1."""

    time: FloatArray
    """(n_time,) s, evenly spaced."""
    support: FloatArray
    """(3, n_time, n_support): displacement, velocity, acceleration of the prescribed coordinates."""
    force: FloatArray
    """(n_time, n_force)"""
    force_labels: tuple[IntArray, ...] = ()
    """Physical dof labels that each force acts on (each with its full value)."""

    def consistent_with(self, scheme: HHT) -> Loads:
        """The same prescribed displacement, with velocity and acceleration that follow Newmark's rule.

        s1 = s0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1), v1 = v0 + h ((1 - gamma) a0 + gamma a1), solved for
        a1 and v1 from the exact start. The prescribed dofs then obey the same difference equations as the
        free ones, so a change of basis that mixes them (Craig-Bampton, static modes) changes no result. With
        the exact derivatives instead, a full and a reduced model differ by the O(h^2) error of the scheme.
        """
        h, beta, gamma = self.step, scheme.beta, scheme.gamma
        s = self.support[0]
        v, a = np.empty_like(s), np.empty_like(s)
        v[0], a[0] = self.support[1, 0], self.support[2, 0]
        for n in range(self.n_step):
            a[n + 1] = ((s[n + 1] - s[n]) / h - v[n]) / (beta * h) - (0.5 / beta - 1.0) * a[n]
            v[n + 1] = v[n] + h * ((1.0 - gamma) * a[n] + gamma * a[n + 1])
        return replace(self, support=np.stack([s, v, a]))

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])

    @property
    def n_step(self) -> int:
        return int(self.time.size) - 1


def at_rest(time: FloatArray) -> Loads:
    """No loads: free motion from the initial velocity of the System."""
    return Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
