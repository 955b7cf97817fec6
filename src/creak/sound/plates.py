"""Statistical energy of a thin plate that point forces drive: power in, energy, what it radiates, and how far one
plate may be off the mean of all like it.

    W = <F^2> Re Y,   W = omega eta E,   <v^2> = E / m,   P = rho c S sigma <v^2>

Sources: Cremer, Heckl and Petersson, Structure-Borne Sound, 2005 (mobility); Leppington, Broadbent and Heron, Proc. R.
Soc. A 382, 1982, and EN 12354-1:2000, annex B (radiation efficiency); Langley and Brown, J. Sound Vib. 275, 2004, 847
(scatter). Valid where a band holds several modes; below, modes are to be computed (`creak.sound.forced`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import across_third

EDGE = 3.5
"""Mobility of a free edge over that of the inside of the same plate (Cremer, Heckl and Petersson, section 5.2)."""
FREE = 0.52
"""What a free edge radiates far below coincidence, over what a supported one does, times (f / f_c)^-2."""
POINT = 16.0
"""Supported edge that radiates like a point that is held, times the wavenumber."""
MOST = 2.0
"""Radiation efficiency at most, near coincidence (EN 12354-1)."""
POINTS = 9
"""Frequencies in a third octave over which it is averaged."""
DRIVEN, HEARD = 2.7, 2.0
"""<a^2> / <a>^2 over modes of what a point force puts into a mode, and of what a mode sends to one point: Langley and
Brown's value for plates, and that of any wave that comes from all over."""


@dataclass(frozen=True)
class Plate:
    """A plate set in a wall. Its mass may be in any unit; forces are then in that unit times m/s^2."""

    bending: float
    """D, N m."""
    mass: float
    """Per area, kg/m^2."""
    area: float
    """m^2."""
    perimeter: float
    """m of its edges that are held across, as simply supported ones are."""
    free: float = 0.0
    """m of edges that are free."""
    points: int = 0
    """At which it is held besides."""

    @property
    def coincidence(self) -> float:
        """Hz at which bending waves are as long as those in air: c^2 / (2 pi) sqrt(m / D)."""
        return AIR.speed**2 / (2.0 * math.pi) * math.sqrt(self.mass / self.bending)

    @property
    def mobility(self) -> float:
        """m/(N s), Re Y = 1 / (8 sqrt(D m)) at a point inside: the mean over all points and frequencies."""
        return 1.0 / (8.0 * math.sqrt(self.bending * self.mass))

    @property
    def density(self) -> float:
        """Modes per Hz: S / 2 sqrt(m / D)."""
        return 0.5 * self.area * math.sqrt(self.mass / self.bending)

    @property
    def direct(self) -> float:
        """Pa m/N: pressure times distance that a force sends by itself below coincidence, rho / (2 pi m) (section 6.5
        of the same book). What is damped well sends more of this than by its modes."""
        return AIR.density / (2.0 * math.pi * self.mass)

    def wavenumber(self, freq: FloatArray) -> FloatArray:
        """Of bending waves, rad/m."""
        return np.asarray(np.sqrt(2.0 * np.pi * freq) * (self.mass / self.bending) ** 0.25)


def radiation_efficiency(plate: Plate, freq: FloatArray) -> FloatArray:
    """sigma of one side of a baffled plate at each frequency, Hz, mean of a third octave around it, 2 at most.

    Below coincidence, with l = sqrt(f / f_c),

        sigma = U c / (S f_c) [(1 - l^2) ln((1 + l) / (1 - l)) + 2 l] / (4 pi^2 (1 - l^2)^1.5) + d_2,
        d_2 = 8 c^2 (1 - 2 l^2) / (f_c^2 pi^4 S l sqrt(1 - l^2)) below half of it, 4 S (f / c)^2 at most below the first
        mode; above 1 / sqrt(1 - f_c / f) (EN 12354-1, equations B.3). U is the perimeter where the edges are supported.
    All that holds a plate back radiates: a free edge by l^4 (.52 + .48 l^10) of a supported one (waves of all
    directions on half a plate, Poisson's ratio .3), and a point as 16 / k_b of supported edge (its force is v / Re Y,
    and sends rho / (2 pi m) of that). The corners' share d_2 is that of the supported edges.
    """
    each = freq[:, None] * across_third(POINTS)
    f_c, c = plate.coincidence, AIR.speed
    S, outline = plate.area, plate.perimeter + plate.free
    half = 0.5 * outline
    sides = max(half**2 - 2.0 * S, 2.0 * S)  # l1^2 + l2^2; a square is the least
    first = c**2 / (4.0 * f_c) * sides / S**2
    tiny = 1e-9
    below = np.clip(each / f_c, tiny, 1.0 - tiny)
    root = np.sqrt(below)
    edges = ((1.0 - below) * np.log((1.0 + root) / (1.0 - root)) + 2.0 * root) / (4.0 * np.pi**2 * (1.0 - below) ** 1.5)
    corners = 8.0 * c**2 * (1.0 - 2.0 * below) / (f_c**2 * np.pi**4 * S * root * np.sqrt(1.0 - below))
    small = 4.0 * S * (each / c) ** 2
    length = plate.perimeter + plate.free * below**2 * (FREE + (1.0 - FREE) * below**5)
    length = length + plate.points * POINT / plate.wavenumber(each)
    waves = length * c / (S * f_c) * edges + plate.perimeter / outline * np.where(below < 0.5, corners, 0.0)
    above = 1.0 / np.sqrt(1.0 - np.clip(f_c / each, tiny, 1.0 - tiny))
    short = np.sqrt(2.0 * np.pi * each * half / (16.0 * c))
    if first <= 0.5 * f_c:
        found = np.where(each >= f_c, above, np.where((each < first) & (waves > small), small, waves))
    else:
        low, high = (each < f_c) & (small < short), (each > f_c) & (above < short)
        found = np.where(low, small, np.where(high, above, short))
    return np.asarray(np.minimum(found, MOST).mean(axis=1))


def relative_variance(overlap: FloatArray, bandwidth: FloatArray, *, at_a_point: bool = True) -> FloatArray:
    """Variance over its squared mean of what one of many like plates has of a band: of its energy, or of what it sends
    to one point.

        r^2 = (a - 1) G / (pi M) + ln(1 + B^2) / (pi M B)^2,     G of `interference`

    Langley and Brown 2004, equation 40, for modes that keep apart as those of irregular plates do. At one point waves
    of all directions meet with any phase (Schroeder), which adds G however many modes there are.

    Parameters
    ----------
    overlap : M, width of a resonance times modes per Hz. bandwidth : B, width of the band over that of a resonance.
    """
    B, log, G = bandwidth, np.log1p(bandwidth**2), interference(bandwidth)
    spread = DRIVEN * HEARD if at_a_point else DRIVEN
    found = (spread - 1.0) * G / (np.pi * overlap) + log / (np.pi * overlap * B) ** 2
    return np.asarray(found + G if at_a_point else found)


def interference(bandwidth: FloatArray) -> FloatArray:
    """G = (2 B atan B - ln(1 + B^2)) / B^2: relative variance in a band of two waves that meet with any phase, B its
    width over that of a resonance."""
    B = bandwidth
    return np.asarray((2.0 * B * np.arctan(B) - np.log1p(B**2)) / B**2)


def in_decibel(variance: FloatArray) -> FloatArray:
    """Standard deviation in dB of an energy of this relative variance, lognormal."""
    return np.asarray(10.0 / math.log(10.0) * np.sqrt(np.log1p(variance)))
