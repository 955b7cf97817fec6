"""Third-octave bands of ISO 532-1: pressure at the 48 kHz that its filters and audio files are made for, sixth-order
filters, their powers over time and over the whole record."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.errors import InputError
from creak.given import number
from creak.jit import njit
from creak.sound.zwicker_tables import BANDS, FILTERS, LEVEL_RATE, RATE, REFERENCE_PRESSURE

RATES = (1e3, 1e7)
"""Hz, sampling that is taken: below, nothing is left to hear."""
LARGEST_PRESSURE = 1e5
"""Pa: the air's own."""
LARGEST = 1000
"""Denominator of the ratio of rates; 1e-6 of the pitch at worst."""
HALF_WIDTH = 48
"""Samples of the slower rate to either side that the filter looks at: flat to .93 of its half."""
KAISER = 10.0
"""Shape of the window: 100 dB between what passes and what does not."""


def at_48k(pressure: ArrayLike, rate: float) -> FloatArray:
    """Pressure (n,) in Pa from `rate` Hz to 48 kHz; the record is silent before and after.

    Linear-phase resampling without delay, by a ratio of whole numbers within 1e-6 of the true one.

    Raises
    ------
    InputError : not one channel of numbers up to 1e5 Pa, none at all, a rate that is no number or outside 1 kHz to
        10 MHz.
    """
    x, rate = checked(pressure), number(rate, "sampling rate")
    if not RATES[0] <= rate <= RATES[1]:
        raise InputError(f"a sampling rate of {rate:g} Hz", expected=f"{RATES[0]:g} to {RATES[1]:g} Hz")
    ratio = Fraction(RATE / rate).limit_denominator(LARGEST)
    if ratio == 1:
        return x
    up, down = ratio.numerator, ratio.denominator
    larger = max(up, down)
    from scipy.signal import firwin, resample_poly  # see `signals.spectra.low_pass`

    taps = firwin(2 * HALF_WIDTH * larger + 1, 1.0 / larger, window=("kaiser", KAISER))
    return np.asarray(resample_poly(x, up, down, window=taps), dtype=np.float64)


def checked(pressure: ArrayLike) -> FloatArray:
    """The pressure as contiguous doubles.

    Raises
    ------
    InputError : not one channel of numbers up to 1e5 Pa, or none at all.
    """
    try:
        given = np.asarray(pressure)
        x = np.ascontiguousarray(given, dtype=None if np.iscomplexobj(given) else np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("pressure is no number", expected="samples (n,) in Pa") from error
    if x.ndim != 1 or x.size == 0 or x.dtype != np.float64:
        raise InputError(
            f"pressure of shape {x.shape} and type {x.dtype}",
            expected="samples of one channel, (n,), in Pa",
            fix="Give channels one by one.",
        )
    wrong = np.flatnonzero(~(np.abs(x) <= LARGEST_PRESSURE))
    if wrong.size:
        raise InputError(
            f"pressure is {x[wrong[0]]:g} at sample {wrong[0]}",
            expected=f"numbers in Pa, {LARGEST_PRESSURE:g} at most",
        )
    return x


Window = tuple[float, float]

STEP = RATE // LEVEL_RATE
"""Samples per band level."""
RINGING = 0.5
"""s of silence after a record, in which the filters give back what they hold."""
LATE = 3.337
"""Periods of its middle by which a band's filter delays the energy of a pulse."""
A_POLES = (20.598997, 107.65265, 737.86223, 12194.217)
"""Hz, poles of the A weighting; the first and the last are double (IEC 61672-1, annex E)."""
SLOWEST = 1000.0
"""Hz: centre frequency above which the smoothing stays as it is."""
NOTHING = 1e-140
"""Pa: state below which a filter is at rest; its square is still no denormal number, which would be slow."""
FLOOR = 1e-12
"""Pa^2, added before the logarithm."""
SILENCE = float(10.0 * np.log10(FLOOR / REFERENCE_PRESSURE**2))
"""dB re 20 uPa."""
LOWER_EDGES: FloatArray = BANDS * 10.0**-0.05
UPPER_EDGES: FloatArray = BANDS * 10.0**0.05
"""(28,) Hz."""


def across_third(count: int) -> FloatArray:
    """(count,) frequencies that share a third octave evenly, over that of its middle."""
    return np.asarray(10.0 ** (0.1 * ((np.arange(count) + 0.5) / count - 0.5)))


def third_octave_levels(pressure: FloatArray, rate: float, window: Window | None = None) -> FloatArray:
    """Equivalent continuous levels, (28,) dB re 20 uPa, bands of 25 Hz to 12.5 kHz (`BANDS`).

    10 lg of the band's energy over the record's length and (20 uPa)^2; what the filters still hold at the end counts.

    Parameters
    ----------
    pressure : (n,) Pa. rate : Hz.
    window : s from the first sample, the part of a longer record that counts, as late as each filter is. Nothing is cut
        at its ends, so that a tone that goes on through them is in its own band alone.

    Raises
    ------
    InputError : as `at_48k`.
    """
    x = at_48k(pressure, rate)
    if window is None:
        padded = np.concatenate([x, np.zeros(int(RINGING * RATE))])
        return as_level(band_powers(padded, FILTERS, smoothing(), STEP, *counted(0, padded.size))[1] / x.size)
    first, last = _within(window, x.size)
    late = np.rint(LATE * RATE / BANDS).astype(np.int64)
    return as_level(band_powers(x, FILTERS, smoothing(), STEP, first + late, last + late)[1] / (last - first))


def counted(first: int, last: int) -> tuple[IntArray, IntArray]:
    """First samples and ends of what counts, alike in all bands."""
    return np.full(BANDS.size, first, dtype=np.int64), np.full(BANDS.size, last, dtype=np.int64)


def a_weighted_level(pressure: FloatArray, rate: float, window: Window | None = None) -> float:
    """Equivalent continuous level in dB(A) re 20 uPa: the mean square of what the A weighting makes of the record.

    H = a s^4 / ((s + w1)^2 (s + w2) (s + w3) (s + w4)^2), 1 at 1 kHz, exact up to the end of the band at 48 kHz.

    Parameters
    ----------
    pressure, rate, window : as `third_octave_levels`.

    Raises
    ------
    InputError : as `at_48k`.
    """
    x = at_48k(pressure, rate)
    first, last = _within((0.0, np.inf) if window is None else window, x.size)
    weighted = a_weighted(x)[first : None if window is None else last]
    return float(as_level(np.array([weighted @ weighted / (last - first)]))[0])


def a_weighted_sum(levels: FloatArray) -> float:
    """dB(A) of third-octave levels (28,) in dB, with the weight of each band's middle."""
    gain = np.abs(_a_weighting(BANDS)) / abs(_a_weighting(np.array([1000.0]))[0])
    return float(10.0 * np.log10((10.0 ** (0.1 * levels) * gain**2).sum()))


def a_weighted(x: FloatArray) -> FloatArray:
    """What the A weighting makes of x (n,) at 48 kHz, silent before, and half a second of its ringing."""
    size = next_fast_len(x.size + int(RINGING * RATE), real=True)
    gain = _a_weighting(np.arange(size // 2 + 1) * (RATE / size)) / abs(_a_weighting(np.array([1000.0]))[0])
    return np.asarray(irfft(rfft(x, size) * gain, size))


def _within(window: Window, n: int) -> tuple[int, int]:
    """First sample and end of a window of a record of n."""
    first, last = (round(min(max(t * RATE, 0.0), n)) for t in window)
    return min(first, n - 1), max(last, min(first, n - 1) + 1)


def _a_weighting(freq: FloatArray) -> ComplexArray:
    s, (p1, p2, p3, p4) = 1j * freq, A_POLES
    return np.asarray(s**4 / ((s + p1) ** 2 * (s + p2) * (s + p3) * (s + p4) ** 2))


def as_level(power: FloatArray) -> FloatArray:
    """dB re 20 uPa of mean squares in Pa^2; silence is -26 dB."""
    return np.asarray(10.0 * np.log10((power + FLOOR) / REFERENCE_PRESSURE**2))


def smoothing() -> FloatArray:
    """(28,) factors of the three first-order low-passes of the squared bands, time constant 2 / (3 min(f, 1 kHz))."""
    return np.asarray(np.exp(-1.5 * np.minimum(BANDS, SLOWEST) / RATE))


@njit(nogil=True, error_model="numpy")
def band_powers(
    x: FloatArray, filters: FloatArray, factors: FloatArray, step: int, first: IntArray, last: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Squares of the filtered x (n,): smoothed, every `step`-th sample (n_out, 28); summed from sample `first` (28,) up
    to before `last` (28,).

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
            energy[i] += square if first[i] <= k < last[i] else 0.0
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
