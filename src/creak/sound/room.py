"""Sound of a room: the diffuse field that a source feeds and absorption takes.

With V the volume, P the power of the source and T the reverberation time, the mean square of the diffuse pressure obeys

    d<p^2>/dt = rho c^2 (1 - alpha) P / V - (6 ln 10 / T) <p^2>,     S alpha = 24 ln 10 V / (c T),

whose steady state is 4 rho c P (1 - alpha) / (S alpha): Sabine's room, whose sound falls by 60 dB in T. Kuttruff, Room
Acoustics, chapter 5. It holds where many modes of the room overlap, above Schroeder's frequency 2000 sqrt(T / V).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from creak.arrays import FloatArray, IntArray
from creak.sound.carriers import EASE, ForceLines, band_power, stored
from creak.sound.rayleigh import AIR
from creak.sound.zwicker_tables import BANDS, RATE

DECAY = 6.0 * math.log(10.0)
"""Of energy in a reverberation time: 60 dB."""
WALLS = 6.0
"""Surface of a cube over its volume to 2/3."""
SCHROEDER = 2000.0
"""Hz m^1.5 s^-.5"""
APART = 3.0
"""Radii of a head: way between its ears in long waves (Kuhn, J. Acoust. Soc. Am. 62, 1977)."""


@dataclass(frozen=True)
class Room:
    """A room with diffuse sound."""

    volume: float
    """m^3"""
    reverberation: FloatArray
    """(28,) s, of the third octaves of 25 Hz to 12.5 kHz."""

    @property
    def absorption(self) -> FloatArray:
        """(28,) m^2, S alpha by Sabine."""
        return 4.0 * DECAY * self.volume / (AIR.speed * self.reverberation)

    @property
    def absorbed(self) -> FloatArray:
        """(28,) alpha, the mean of walls as large as those of a cube of this volume."""
        return self.absorption / (WALLS * self.volume ** (2.0 / 3.0))

    @property
    def schroeder(self) -> float:
        """Hz from which its modes overlap; inf: nowhere."""
        limit = SCHROEDER * np.sqrt(self.reverberation / self.volume)
        return float(limit[np.argmax(limit <= BANDS)]) if (limit <= BANDS).any() else math.inf


def diffuse_squares(room: Room, direct: FloatArray, spread: float, bands: IntArray) -> list[FloatArray]:
    """(n,) Pa^2 over time of the diffuse field in each of some bands, which a direct sound (n,) at 48 kHz tells.

    The source sends P = 2 pi p^2 / (rho c spread) into the half space before it. Nothing is heard of the room before
    the direct sound arrives.

    Parameters
    ----------
    direct : Pa, silent before and after. spread : 1/m^2, mean of 1 / r^2 of the source. bands : rows of `BANDS`.
    """
    lines = ForceLines(size := next_fast_len(direct.size + int(EASE * RATE), real=True), 0, rfft(direct, size)[:, None])
    at, found = np.arange(direct.size) / RATE, []
    for band in bands.tolist():
        time, square = band_power(lines, *lines.of(band), np.ones((1, 1)))
        fed = 2.0 * math.pi * AIR.speed * (1.0 - room.absorbed[band]) / (room.volume * spread) * square
        found.append(np.interp(at, time, stored(time, fed, DECAY / float(room.reverberation[band]))))
    return found


def ear_noise(noise: FloatArray, bands: IntArray, radius: float, side: int) -> FloatArray:
    """(n_band, size) noise of a diffuse field at one ear, of noise of each band that goes round.

    Two ears have the coherence sin(kd) / (kd) of two points d = 3 a apart, a the radius of the head.

    Parameters
    ----------
    side : 1 or -1, one ear or the other; 0: the middle, which is `noise` itself.
    """
    if not side:
        return noise
    coherence = np.sinc(2.0 * APART * radius / AIR.speed * BANDS[bands])[:, None]
    other = np.roll(noise, noise.shape[1] // 2, axis=1)
    return np.asarray(np.sqrt(0.5 + 0.5 * coherence) * noise + side * np.sqrt(0.5 - 0.5 * coherence) * other)
