"""Sound at the ears of a head: a rigid sphere, or one whose ears were measured.

A head is told by how long sound takes to an ear, and by what it makes of it on the way: H(direction, f), a sum of
gains over frequency with a weight of each direction. So what many points send is filtered once for each gain.
All is divided by H of a source ahead, as an artificial head is that is equalised for sound from the front: what
ISO 532-1 takes the pressure for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray
from creak.sound.rayleigh import AIR

RADIUS = 0.0875
"""m, of the mean head."""
NEAR, FAR = 1.05, 0.95
"""1 + alpha_min / 2 and 1 - alpha_min / 2 with alpha_min = .1."""
DARKEST = 150.0 / 180.0
"""Of half a turn, the angle off an ear at which it gets least."""


class Head(ABC):
    """A head, and the one of its ears that listens. Offsets are (n, 3) m of points from its middle, outside of it."""

    @abstractmethod
    def path(self, offset: FloatArray) -> FloatArray:
        """(n,) m from points to the ear, as late as sound comes."""

    @abstractmethod
    def weights(self, offset: FloatArray) -> FloatArray:
        """(n, k) of each gain."""

    @property
    @abstractmethod
    def gains(self) -> tuple[Callable[[FloatArray], ComplexArray], ...]:
        """k functions of frequency, Hz."""

    def gain(self, freq: FloatArray, offset: FloatArray) -> ComplexArray:
        """H (n,) from a point at offset (3,)."""
        weights = self.weights(offset[None])[0]
        return np.asarray(sum(w * gain(freq) for w, gain in zip(weights, self.gains, strict=True)))

    def at_ear(self, x: FloatArray, rate: float, offset: FloatArray) -> FloatArray:
        """(n,) pressure at the ear of a point at offset (3,) m that sends x (n,) to the middle of the head.

        x is silent at its beginning and end, for as long as sound takes around the head.
        """
        return self._through(x, rate, offset, lambda freq: self.gain(freq, offset))

    def delayed(self, x: FloatArray, rate: float, offset: FloatArray) -> FloatArray:
        """The same without the shade: as late as it is at the ear, or as early."""
        return self._through(x, rate, offset, lambda freq: np.ones(freq.size, dtype=complex))

    def _through(
        self, x: FloatArray, rate: float, offset: FloatArray, gain: Callable[[FloatArray], ComplexArray]
    ) -> FloatArray:
        late = (float(self.path(offset[None])[0]) - float(np.linalg.norm(offset))) / AIR.speed
        size = next_fast_len(x.size + int(0.01 * rate), real=True)
        freq = np.arange(size // 2 + 1) * (rate / size)
        return np.asarray(irfft(rfft(x, size) * gain(freq) * np.exp(-2j * np.pi * freq * late), size)[: x.size])


@dataclass(frozen=True)
class Sphere(Head):
    """A rigid sphere of radius a, by the model of Brown and Duda.

    A point at the distance d from its middle, theta off the direction of an ear, is heard there after the way around
    the sphere, straight to an ear that it sees and else along the tangent and the surface. Long waves pass the head; of
    short ones an ear gets alpha times what there is without it:

        H = (1 + alpha(theta) s) / (1 + s),    s = i omega a / (2 c),    alpha = 1.05 + .95 cos(1.2 theta).

    Source: C. P. Brown and R. O. Duda, A structural model for binaural sound synthesis, IEEE Trans. Speech Audio
    Process. 6, 1998, equations 3 to 6; the delay is that of Woodworth.
    """

    ear: FloatArray
    """(3,) direction from the middle of the head to the ear, of length 1; square to where the head looks."""
    radius: float = RADIUS
    """m"""

    def path(self, offset: FloatArray) -> FloatArray:
        """(n,) m: straight, or around the sphere."""
        d, a = np.linalg.norm(offset, axis=1), self.radius
        theta, last = self._off(offset), np.arccos(np.minimum(a / d, 1.0))
        straight = np.sqrt(np.maximum(a**2 + d**2 - 2.0 * a * d * np.cos(theta), 0.0))
        around = np.sqrt(np.maximum(d**2 - a**2, 0.0)) + a * (theta - last)
        return np.asarray(np.where(theta <= last, straight, around))

    def weights(self, offset: FloatArray) -> FloatArray:
        """(n, 2): 1, and alpha."""
        alpha = NEAR + FAR * np.cos(self._off(offset) / DARKEST)
        return np.stack([np.ones(len(offset)), alpha], axis=1)

    @property
    def gains(self) -> tuple[Callable[[FloatArray], ComplexArray], ...]:
        """What passes the head, and what it shades, over H of a source ahead."""
        return self._low, self._high

    def _low(self, freq: FloatArray) -> ComplexArray:
        return np.asarray(1.0 / (1.0 + _AHEAD * self._s(freq)))

    def _high(self, freq: FloatArray) -> ComplexArray:
        s = self._s(freq)
        return np.asarray(s / (1.0 + _AHEAD * s))

    def _s(self, freq: FloatArray) -> ComplexArray:
        return np.asarray(1j * np.pi * self.radius / AIR.speed * freq)

    def _off(self, offset: FloatArray) -> FloatArray:
        cosine = offset @ self.ear / np.linalg.norm(offset, axis=1)
        return np.arccos(np.clip(cosine, -1.0, 1.0))


_AHEAD = float(NEAR + FAR * np.cos(0.5 * np.pi / DARKEST))
"""alpha of a source ahead, a right angle off both ears."""
