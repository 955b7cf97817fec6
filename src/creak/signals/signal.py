"""What every signal is: values over time, and motion of which these are the displacement, velocity or acceleration.

A new signal is a class of `Curve`, where derivatives and integrals from rest tell its motion; of `Lines`, where it goes
on for ever and has to be faded in; or of `Signal` itself, where it is neither.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from creak.arrays import FloatArray

RAMP = 0.1
"""Random phases that prescribe motion are faded in over this part of their period."""


@dataclass(frozen=True)
class Motion:
    """Prescribed displacement, velocity and acceleration at the steps, each (n_time,)."""

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


class Signal(ABC):
    """A function of time."""

    sudden: ClassVar[bool] = False
    """Whether it may change within less than a step; a step itself does so at t = 0 alone."""

    @abstractmethod
    def values(self, t: FloatArray) -> FloatArray:
        """(n_time,) at times t (n_time,) >= 0, s: a force, for instance."""

    @abstractmethod
    def motion(self, t: FloatArray, order: int) -> Motion:
        """The motion whose derivative of order 0 (displacement), 1 (velocity) or 2 (acceleration) it is."""


class Curve(Signal):
    """A function with derivatives, and integrals that start at zero at t = 0: motion from rest."""

    @abstractmethod
    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """d^order/dt^order at t (n_time,) >= 0, -2 <= order <= 2; negative orders are integrals."""

    def values(self, t: FloatArray) -> FloatArray:
        return self.derivative(t, 0)

    def motion(self, t: FloatArray, order: int) -> Motion:
        return Motion(*(self.derivative(t, k - order) for k in range(3)))


class Lines(Signal):
    """A periodic sum of lines of random phase, without a mean. It does not start at zero: its motion is faded in."""

    period: float
    """s"""

    @abstractmethod
    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """d^order/dt^order at t (n_time,); negative orders are the zero-mean integrals (omega arithmetic)."""

    def values(self, t: FloatArray) -> FloatArray:
        return self.derivative(t, 0)

    def motion(self, t: FloatArray, order: int) -> Motion:
        return faded_in(Motion(*(self.derivative(t, k - order) for k in range(3))), t, RAMP * self.period)


def faded_in(motion: Motion, t: FloatArray, duration: float) -> Motion:
    """The motion times a window w that rises smoothly from 0 to 1 over `duration` s.

    A random-phase signal does not start at zero; without the window the supports would jump at t = 0. With
    w = 10 x^3 - 15 x^4 + 6 x^5, x = t / duration, displacement, velocity and acceleration start at zero.
    """
    return windowed(motion, t / duration, 1.0 / duration)


def windowed(motion: Motion, x: FloatArray, rate: float) -> Motion:
    """`faded_in` by x and its rate in time."""
    x = np.clip(x, 0.0, 1.0)
    w = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    dw = 30.0 * x**2 * (1.0 - x) ** 2 * rate
    ddw = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) * rate**2
    u, v, a = motion.displacement, motion.velocity, motion.acceleration
    return Motion(w * u, w * v + dw * u, w * a + 2.0 * dw * v + ddw * u)
