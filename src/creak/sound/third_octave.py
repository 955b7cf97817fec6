"""Third-octave bands of ISO 532-1: sixth-order filters at 48 kHz, their powers over time and over the whole record."""

from __future__ import annotations

import numba
import numpy as np

from creak.arrays import FloatArray
from creak.sound.at_48k import at_48k
from creak.sound.zwicker_tables import BANDS, FILTERS, LEVEL_RATE, RATE, REFERENCE_PRESSURE

STEP = RATE // LEVEL_RATE
"""Samples per band level."""
RINGING = 0.5
"""s of silence after a record, in which the filters give back what they hold."""
SLOWEST = 1000.0
"""Hz: centre frequency above which the smoothing stays as it is."""
NOTHING = 1e-140
"""Pa: state below which a filter is at rest; its square is still no denormal number, which would be slow."""
FLOOR = 1e-12
"""Pa^2, added before the logarithm."""


def third_octave_levels(pressure: FloatArray, rate: float) -> FloatArray:
    """Equivalent continuous levels of a whole record, (28,) dB re 20 uPa, bands of 25 Hz to 12.5 kHz (`BANDS`).

    10 lg of the band's energy over the record's length and (20 uPa)^2; what the filters still hold at the end counts.

    Parameters
    ----------
    pressure : (n,) Pa. rate : Hz.

    Raises
    ------
    InputError : as `at_48k`.
    """
    x = at_48k(pressure, rate)
    padded = np.concatenate([x, np.zeros(int(RINGING * RATE))])
    _, energy = band_powers(padded, FILTERS, smoothing(), STEP, 0)
    return as_level(energy / x.size)


def a_weighted_level(levels: FloatArray) -> float:
    """dB(A) of third-octave levels (28,), with the weights of IEC 61672-1 at the middle of each band."""
    f2 = BANDS**2
    gain = 12194.0**2 * f2**2 / ((f2 + 20.6**2) * np.sqrt((f2 + 107.7**2) * (f2 + 737.9**2)) * (f2 + 12194.0**2))
    return float(10.0 * np.log10(np.sum(10.0 ** (0.1 * levels) * gain**2)) + 2.0)


def as_level(power: FloatArray) -> FloatArray:
    """dB re 20 uPa of mean squares in Pa^2; silence is -26 dB."""
    return np.asarray(10.0 * np.log10((power + FLOOR) / REFERENCE_PRESSURE**2))


def smoothing() -> FloatArray:
    """(28,) factors of the three first-order low-passes of the squared bands, time constant 2 / (3 min(f, 1 kHz))."""
    return np.asarray(np.exp(-1.5 * np.minimum(BANDS, SLOWEST) / RATE))


@numba.njit(cache=True, nogil=True, error_model="numpy")
def band_powers(
    x: FloatArray, filters: FloatArray, factors: FloatArray, step: int, start: int
) -> tuple[FloatArray, FloatArray]:
    """Squares of the filtered x (n,): smoothed, every `step`-th sample (n_out, 28); summed from `start` on (28,).

    The bands are the inner loop: one sample of all of them fills the vector registers, where one band alone would wait
    for its own last value.
    """
    n, bands = x.size, factors.size
    out, energy = np.empty(((n + step - 1) // step, bands)), np.zeros(bands)
    gain = filters[:, 0].copy()
    a1, b1, c1 = 2.0 + filters[:, 1], 2.0 + filters[:, 3], 2.0 + filters[:, 5]
    a2, b2, c2 = filters[:, 2] - 1.0, filters[:, 4] - 1.0, filters[:, 6] - 1.0
    state = np.zeros((6, bands))
    p1, p2, q1, q2, r1, r2 = state[0], state[1], state[2], state[3], state[4], state[5]
    s1, s2, s3 = np.zeros(bands), np.zeros(bands), np.zeros(bands)
    for k in range(n):
        counted = 1.0 if k >= start else 0.0
        for i in range(bands):
            u = gain[i] * x[k]
            y = u + p1[i]
            p1[i] = 2.0 * u + a1[i] * y + p2[i]
            p2[i] = u + a2[i] * y
            u = y
            y = u + q1[i]
            q1[i] = b1[i] * y + q2[i]
            q2[i] = b2[i] * y - u
            u = y
            y = u + r1[i]
            r1[i] = c1[i] * y - 2.0 * u + r2[i]
            r2[i] = u + c2[i] * y
            square = y * y
            energy[i] += counted * square
            f = factors[i]
            s1[i] = square + f * (s1[i] - square)
            s2[i] = s1[i] + f * (s2[i] - s1[i])
            s3[i] = s2[i] + f * (s3[i] - s2[i])
        if k % step == 0:
            out[k // step] = s3
            for j in range(6):
                for i in range(bands):
                    if abs(state[j, i]) < NOTHING:
                        state[j, i] = 0.0
            for i in range(bands):
                if s1[i] < NOTHING:
                    s1[i] = 0.0
                if s2[i] < NOTHING:
                    s2[i] = 0.0
                if s3[i] < NOTHING:
                    s3[i] = 0.0
    return out, energy
