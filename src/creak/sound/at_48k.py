"""Pressure at the 48 kHz that the filters of ISO 532-1 and audio files are made for."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.given import number
from creak.sound.zwicker_tables import RATE

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
