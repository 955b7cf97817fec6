"""Roughness after P. Daniel and R. Weber, Psychoacoustical roughness: implementation of an optimized model,
Acta Acustica 83 (1997) 113-123."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.sound.at_48k import at_48k
from creak.sound.roughness_tables import AURES, CHANNELS, CRITICAL, EAR, MODULATION, THRESHOLD
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE

WINDOW = 0.2
"""s, what the model looks at at once (Blackman); the windows overlap by half."""
SIZE = round(WINDOW * RATE)
LOWEST, HIGHEST = round(20.0 * WINDOW), round(20e3 * WINDOW)
"""Lines of the spectrum that can be heard."""
SLOWEST, FASTEST = 2, round(645.0 * WINDOW)
"""Lines of the envelope that can be rough."""
DEEPEST = 125.0
"""Hz: of a sound that ends below, the model takes the wave itself for its modulation."""
BELOW = 27.0
"""dB/Bark of excitation towards lower bands (Terhardt 1979)."""
LOUDEST = 120.0
"""dB of a component at which excitation no longer falls towards higher bands (+ 1150 / f)."""
BESIDE = 0.5
"""Bark to either side of a channel's middle in which components pass whole."""
APART = 2
"""Channels whose envelopes are compared: one Bark apart."""
ASPER = 0.2484
"""asper: makes a tone of 1 kHz and 60 dB, modulated to 100 % at 70 Hz, one asper; Daniel and Weber give .25."""
FINER = 8
"""Samples per period of the highest component, of which the envelope is taken."""


def roughness(pressure: ArrayLike, rate: float) -> tuple[FloatArray, FloatArray] | None:
    """Middles of the windows (n,) in s and roughness (n,) in asper, every 100 ms; 0 where nothing is heard, NaN where
    nothing is heard from 125 Hz up, the lowest tone that it was validated with.

    Components above the threshold in quiet excite 47 channels of one Bark. m is the RMS of each channel's envelope,
    weighted by the modulation's frequency, over the mean of the envelope, 1 at most; k the correlation of envelopes
    one Bark apart:

    R = .25 sum_i g_i (m_i k_i k_{i-2})^2

    Validated by its authors for modulated tones and noise of 40 to 80 dB. None where it ends: a record shorter than 200
    ms, or a component of more than 120 dB + 1150 Hz / f.

    Parameters
    ----------
    pressure : (n,) Pa. rate : Hz; other than 48 kHz is resampled.

    Raises
    ------
    InputError : as `at_48k`.
    """
    x = at_48k(pressure, rate)
    starts = window_starts(x.size)
    found = roughness_at(x, starts) if starts.size else None
    return None if found is None else ((starts + SIZE / 2) / RATE, found)


def window_starts(size: int) -> IntArray:
    """First samples of the windows in a record of `size` samples at 48 kHz; none where it is too short."""
    return np.arange(0, size - SIZE + 1, SIZE // 2, dtype=np.int64)


def roughness_at(x: FloatArray, starts: IntArray) -> FloatArray | None:
    """(n,) asper, as `roughness`, of the windows of x at 48 kHz that begin at samples `starts` (n,).

    None: one is too loud for the model.
    """
    shape = np.blackman(SIZE + 1)[:SIZE]
    shape *= np.sqrt(2.0) / (shape.sum() * REFERENCE_PRESSURE)  # a line's amplitude is then its level
    found = np.zeros(starts.size)
    for k, start in enumerate(starts.tolist()):
        value = _of_window(rfft(x[start : start + SIZE] * shape)[LOWEST : HIGHEST + 1])
        if value is None:
            return None
        found[k] = value
    return found


FREQ: FloatArray = np.arange(LOWEST, HIGHEST + 1) / WINDOW
RATES: FloatArray = np.interp(FREQ, CRITICAL, 0.5 * np.arange(CRITICAL.size))
"""Bark of the lines."""
GAIN: FloatArray = 10.0 ** (0.05 * np.interp(RATES, EAR[:, 0], EAR[:, 1]))
QUIET: FloatArray = np.interp(RATES, THRESHOLD[:, 0], THRESHOLD[:, 1])
"""dB of the lines' threshold."""
SINGLE = np.float32
ZERO = SINGLE(0.0)
EDGES: NDArray[np.float32] = np.stack([CHANNELS - BESIDE, CHANNELS + BESIDE]).astype(SINGLE)
AT_EDGES: NDArray[np.float32] = np.interp(EDGES, THRESHOLD[:, 0], THRESHOLD[:, 1]).astype(SINGLE)
"""(2, 47) dB of the threshold at the channels' lower and upper edges."""
WEIGHTS: FloatArray = np.zeros((CHANNELS.size, FASTEST + 1))
for _first, _curve in MODULATION:
    WEIGHTS[_first:, SLOWEST:] = np.interp(np.arange(SLOWEST, FASTEST + 1) / WINDOW, _curve[:, 0], _curve[:, 1])
DEPTHS: FloatArray = np.interp(CHANNELS, np.arange(AURES.size), AURES)


def _of_window(lines: ComplexArray) -> float | None:
    """Roughness of the lines of a window, in 20 uPa; None: beyond the model."""
    lines = lines * GAIN
    level = 20.0 * np.log10(np.maximum(np.abs(lines), 1e-30))
    heard = np.flatnonzero(level > QUIET)
    if not heard.size:
        return 0.0
    if FREQ[heard[-1]] < DEEPEST:
        return np.nan
    level, bark = level[heard], RATES[heard]
    above = 24.0 + 230.0 / FREQ[heard] - 0.2 * level
    if (above <= 0.0).any():
        return None
    # How far each component lies below the lower edge of each channel (47, n), and above the upper one. Single
    # precision is twice as fast and leaves 1e-5 of the roughness.
    near = bark.astype(SINGLE)
    under, over = np.maximum(EDGES[0][:, None] - near, ZERO), np.maximum(near - EDGES[1][:, None], ZERO)
    fall = above.astype(SINGLE) * under + SINGLE(BELOW) * over
    edge = np.where(under > ZERO, AT_EDGES[0][:, None], AT_EDGES[1][:, None])
    passes = (fall == ZERO) | (level.astype(SINGLE) - fall > edge)
    gain = np.where(passes, np.exp(SINGLE(-np.log(10.0) / 20.0) * fall), ZERO)
    # As many samples as the envelope needs: half of those of the window where all is below 3 kHz.
    highest = int(heard[-1]) + LOWEST
    size = min(SIZE, next_fast_len(max(FINER * highest, 4 * FASTEST), real=True))
    spectrum = np.zeros((CHANNELS.size, size // 2 + 1), dtype=np.complex64)
    spectrum[:, heard + LOWEST] = gain * lines[heard].astype(np.complex64)
    envelope = np.abs(irfft(spectrum, size, axis=1))
    steady = envelope.mean(axis=1)
    waves = WEIGHTS * rfft(envelope - steady[:, None], axis=1)[:, : FASTEST + 1] * (2.0 / size)
    power = 0.5 * (np.abs(waves) ** 2).sum(axis=1)
    depth = np.minimum(np.sqrt(power) / np.where(steady > 0.0, steady, 1.0), 1.0)
    shared = 0.5 * (waves[:-APART] * waves[APART:].conj()).sum(axis=1).real
    scale = np.sqrt(power[:-APART] * power[APART:])
    alike = np.where(scale > 0.0, shared / np.where(scale > 0.0, scale, 1.0), 0.0)
    none = np.ones(APART)
    both = np.concatenate([alike, none]) * np.concatenate([none, alike])
    return float(ASPER * (DEPTHS * (depth * both) ** 2).sum())
