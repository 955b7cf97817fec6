"""Sound at the ears of a head: a rigid sphere, or one whose ears were measured.

A head is told by how long sound takes to an ear, and by what it makes of it on the way: H(direction, f), a sum of gains
over frequency with a weight of each direction. So what many points send is filtered once for each gain. All is divided
by H of a source ahead, as an artificial head is that is equalised for sound from the front: what ISO 532-1 takes the
pressure for.

Each response that was measured is taken for a delay and a filter of least phase (Kulkarni, Isabelle and Colburn, J.
Acoust. Soc. Am. 105, 1999). The filters of all directions are sums of a few, their principal components (Kistler and
Wightman, J. Acoust. Soc. Am. 91, 1992). Between directions both are linear in the triangle of the three nearest ones.
It holds for sound from as far as was measured: points nearer to the head come from the direction that its middle
sees."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import across_third

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


EXPLAINED = 0.995
"""Of the energy of all filters, where each pitch counts alike, what is kept of them."""
FAINT = 1e-3
"""Amplitude over the largest of a response, below which nothing was measured: a loudspeaker sends nothing at 0 Hz."""
PADDED = 4
"""Lengths of a response that its transform is made of: a filter of least phase must ring out in it."""
FINE = 16
"""Parts of a sample to which a delay is found."""
PER_THIRD = 8
"""Frequencies of a third octave over which the response ahead is taken together."""
INSIDE = 0.1
"""Of the way from the middle of the head to a direction that was measured, at which its triangle is looked up."""


@dataclass(frozen=True)
class Filters:
    """Delays and filters of both ears."""

    late: FloatArray
    """(2, m) m by which sound comes later than to the middle of the head, were that not there."""
    weight: FloatArray
    """(2, m, k)"""
    freq: FloatArray
    """(f,) Hz"""
    gains: ComplexArray
    """(k, f)"""


@dataclass(frozen=True)
class Ears:
    """What was measured at both ears, in the axes of the head: where it looks, its left, its top."""

    around: Any
    """Of the middle of the head, point 0, and all directions that were measured: as `surrounding` gives it."""
    responses: FloatArray
    """(m, 2, n) impulse responses of the left and the right ear."""
    rate: float
    """Hz"""
    delay: FloatArray
    """(m, 2) s that a response begins later than its first sample."""

    @cached_property
    def filters(self) -> Filters:
        """Made where they are first asked for."""
        m, _, n = self.responses.shape
        size = next_fast_len(PADDED * n, real=True)
        freq = np.arange(size // 2 + 1) * (self.rate / size)
        seen = rfft(self.responses, size, axis=2)
        ahead = int(np.argmax(self.around.points[1:, 0]))
        faint = FAINT * float(np.abs(seen).max())
        front = np.sqrt(np.mean(np.abs(seen[ahead]) ** 2, axis=0))
        front = np.sqrt(np.mean([np.interp(freq * f, freq, front) ** 2 for f in across_third(PER_THIRD)], axis=0))
        ratio = np.sqrt((np.abs(seen) ** 2 + faint**2) / (front**2 + faint**2))
        late = AIR.speed * (self.delay + _delays(seen, size, faint) / self.rate)
        filters = rfft(_least_phase(ratio, size), size, axis=2)
        loud = np.sqrt(np.mean(np.abs(filters) ** 2, axis=(0, 1)) * np.maximum(freq, self.rate / n))
        rows = (filters / loud).reshape(2 * m, -1)
        both = np.hstack([rows.real, rows.imag])
        energy, basis = np.linalg.eigh(both.T @ both)
        energy, basis = energy[::-1], basis[:, ::-1].T
        k = int(np.searchsorted(np.cumsum(energy), EXPLAINED * float(energy.sum()))) + 1
        weight = (both @ basis[:k].T).reshape(m, 2, k).transpose(1, 0, 2)
        gains = loud * (basis[:k, : freq.size] + 1j * basis[:k, freq.size :])
        return Filters((late - late[ahead].mean()).T, weight, freq, gains)

    def head(self, looks: FloatArray, left: FloatArray, side: int) -> MeasuredHead:
        """The ear at a side, 1 left and -1 right, of a head in the axes of the model."""
        return MeasuredHead(np.stack([looks, left, np.cross(looks, left)]), self, 0 if side > 0 else 1)


@dataclass(frozen=True)
class MeasuredHead(Head):
    """One ear of a measured head, in the axes of the model."""

    axes: FloatArray
    """(3, 3), rows: where the head looks, its left, and its top."""
    of: Ears
    ear: int
    """0 left, 1 right."""

    def path(self, offset: FloatArray) -> FloatArray:
        """(n,) m: the distance, and by how much the ear was measured later."""
        return np.asarray(
            np.linalg.norm(offset, axis=1) + self._between(offset, self.of.filters.late[self.ear, :, None])[:, 0]
        )

    def weights(self, offset: FloatArray) -> FloatArray:
        """(n, k) of the principal components."""
        return self._between(offset, self.of.filters.weight[self.ear])

    @property
    def gains(self) -> tuple[Callable[[FloatArray], ComplexArray], ...]:
        """The principal components."""
        return tuple(partial(self._row, k) for k in range(len(self.of.filters.gains)))

    def _row(self, k: int, freq: FloatArray) -> ComplexArray:
        row, known = self.of.filters.gains[k], self.of.filters.freq
        return np.asarray(np.interp(freq, known, row.real) + 1j * np.interp(freq, known, row.imag))

    def _between(self, offset: FloatArray, x: FloatArray) -> FloatArray:
        """(n, k) of x (m, k) in the directions of offsets."""
        seen = offset @ self.axes.T
        point = INSIDE * seen / np.linalg.norm(seen, axis=1)[:, None]
        around = self.of.around
        cell = around.find_simplex(point)
        change = around.transform[cell]
        first = np.einsum("nij,nj->ni", change[:, :3], point - change[:, 3])
        share = np.concatenate([first, 1.0 - first.sum(axis=1, keepdims=True)], axis=1)
        corner = around.simplices[cell]
        share = np.where(corner == 0, 0.0, np.maximum(share, 0.0))
        share /= share.sum(axis=1, keepdims=True)
        return np.asarray(np.einsum("nc,nck->nk", share, x[np.maximum(corner - 1, 0)]))


def surrounding(directions: FloatArray) -> Any | None:
    """A `Delaunay` of the middle of a head and directions (m, 3) of length 1; None: they do not go around it."""
    from scipy.spatial import Delaunay, QhullError  # see `signals.spectra.low_pass`

    try:
        found = Delaunay(np.vstack([np.zeros(3), directions]))
    except QhullError:
        return None
    return None if np.isin(0, found.convex_hull) else found


def _least_phase(amplitude: FloatArray, size: int) -> FloatArray:
    """(..., size) impulse response of least phase with an amplitude over frequency (Oppenheim and Schafer, 13.3)."""
    cepstrum = irfft(np.log(amplitude), size)
    fold = np.zeros(size)
    fold[0], fold[1 : (size + 1) // 2] = 1.0, 2.0
    if size % 2 == 0:
        fold[size // 2] = 1.0
    return np.asarray(irfft(np.exp(rfft(fold * cepstrum, size)), size))


def _delays(seen: ComplexArray, size: int, faint: float) -> FloatArray:
    """(m, 2) samples by which responses come later than those of least phase with their amplitude.

    Where the two correlate best (Nam, Abel and Smith, AES 125, 2008).
    """
    found = np.zeros(seen.shape[:2])
    for late, own in zip(found, seen, strict=True):  # one by one: the fine correlation takes 16 times their memory
        least = rfft(_least_phase(np.maximum(np.abs(own), faint), size), size)
        at = np.argmax(irfft(own * least.conj(), FINE * size), axis=1)
        late[:] = np.where(at > FINE * size // 2, at - FINE * size, at) / FINE
    return found
