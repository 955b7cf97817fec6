"""What drives a run: prescribed motion and forces, sampled at the steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray, brief
from creak.dynamics.scheme import Scheme


@dataclass(frozen=True)
class Loads:
    """Samples at every instant a run may step to."""

    __repr__ = brief

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


def refined(loads: Loads, parts: int) -> Loads:
    """The same with `parts` samples for each, on a cubic spline through them (lines through fewer than four)."""
    from scipy.interpolate import make_interp_spline  # see `signals.spectra.low_pass`

    own = loads.time - loads.time[0]
    time = loads.step / parts * np.arange(loads.n_step * parts + 1)
    kind = 3 if own.size > 3 else 1

    def through(x: FloatArray, axis: int) -> FloatArray:
        if not x.size:
            return np.zeros([time.size if k == axis else n for k, n in enumerate(x.shape)])
        return np.asarray(make_interp_spline(own, x, k=kind, axis=axis)(np.minimum(time, own[-1])))

    return Loads(time + loads.time[0], through(loads.support, 1), through(loads.force, 0), loads.force_labels)


def follow(before: FloatArray, displacement: FloatArray, scheme: Scheme, h: float) -> FloatArray:
    """(3, n_support) prescribed displacement, velocity and acceleration at the end of a step, by Newmark's rule.

    s1 = s0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1), v1 = v0 + h ((1 - gamma) a0 + gamma a1), solved for a1 and v1
    from the exact start. The prescribed dofs then obey the same difference equations as the free ones, so a change of
    basis that mixes them (Craig-Bampton, static modes) changes no result. With the exact derivatives instead, a full
    and a reduced model differ by the O(h^2) error of the scheme.
    """
    s, v, a = before
    a1 = ((displacement - s) / h - v) / (scheme.beta * h) - (0.5 / scheme.beta - 1.0) * a
    v1 = v + h * ((1.0 - scheme.gamma) * a + scheme.gamma * a1)
    return np.array([displacement, v1, a1])


def at_rest(time: FloatArray) -> Loads:
    """No loads: free motion from the initial velocity of the System."""
    return Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
