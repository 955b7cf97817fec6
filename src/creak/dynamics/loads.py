"""What drives a run: prescribed motion and forces, sampled at the steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray


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

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])

    @property
    def n_step(self) -> int:
        return int(self.time.size) - 1


def at_rest(time: FloatArray) -> Loads:
    """No loads: free motion from the initial velocity of the System."""
    return Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
