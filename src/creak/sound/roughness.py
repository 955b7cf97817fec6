"""Roughness after P. Daniel and R. Weber, Psychoacoustical roughness: implementation of an optimized model, Acta
Acustica 83 (1997) 113-123.

The paper gives its curves (ear, threshold, critical-band rate, weights) as figures; the points are those that MoSQITo
(Apache-2.0) and SQAT (MIT) agree on, the ear's are those of MoSQITo."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.sound.third_octave import at_48k
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE

CHANNELS: FloatArray = 0.5 * np.arange(1.0, 48.0)
"""(47,) Bark, middles of the channels, each one Bark wide."""
CRITICAL: FloatArray = np.array(
    [
        *(0, 50, 100, 150, 200, 250, 300, 350, 400, 450, 510, 570, 630, 700, 770, 840, 920, 1000, 1080, 1170),
        *(1270, 1370, 1480, 1600, 1720, 1850, 2000, 2150, 2320, 2500, 2700, 2900, 3150, 3400, 3700, 4000),
        *(4400, 4800, 5300, 5800, 6400, 7000, 7700, 8500, 9500, 10500, 12000, 13500, 15500, 20000),
    ],
    dtype=np.float64,
)
"""(50,) Hz at 0, .5, ... 24.5 Bark (Zwicker and Fastl, table 6.1)."""
EAR: FloatArray = np.array(
    [
        *((0, 0), (10, 0), (12, 1.15), (13, 2.31), (14, 3.85), (15, 5.62), (16, 6.92), (16.5, 7.38), (17, 6.92)),
        *((18, 4.23), (18.5, 2.31), (19, 0), (20, -1.43), (21, -2.59), (21.5, -3.57), (22, -5.19), (22.5, -7.41)),
        *((23, -11.3), (23.5, -20), (24, -40), (25, -130)),
    ],
    dtype=np.float64,
)
"""Bark, dB that outer and middle ear add (Zwicker and Fastl, figure 8.18)."""
THRESHOLD: FloatArray = np.array(
    [
        *((0, 130), (0.01, 70), (0.17, 60), (0.8, 30), (1, 25), (1.5, 20), (2, 15), (3.3, 10), (4, 8.1), (5, 6.3)),
        *((6, 5), (8, 3.5), (10, 2.5), (12, 1.7), (13.3, 0), (15, -2.5), (16, -4), (17, -3.7), (18, -1.5), (19, 1.4)),
        *((20, 3.8), (21, 5), (22, 7.5), (23, 15), (24, 48), (24.5, 60), (25, 130)),
    ],
    dtype=np.float64,
)
"""Bark, dB of the threshold in quiet."""
AURES: FloatArray = np.array(
    [
        *(0.15, 0.26, 0.38, 0.47, 0.54, 0.65, 0.76, 0.83, 0.90, 0.98, 0.98, 0.90, 0.80, 0.70, 0.62, 0.54),
        *(0.49, 0.43, 0.39, 0.35, 0.30, 0.30, 0.30, 0.30, 0.30),
    ]
)
"""(25,) weight g of the squared depth at 0, 1, ... 24 Bark."""
_TOP = ((290, 0.4), (348, 0.3), (415, 0.2), (500, 0.1), (645, 0.0))
MODULATION: tuple[tuple[int, FloatArray], ...] = tuple(
    (first, np.array(curve, dtype=np.float64))
    for first, curve in (
        (
            0,
            (
                *((0, 0), (17, 0.8), (23, 0.95), (25, 0.975), (32, 1), (37, 0.975), (48, 0.9), (67, 0.8)),
                *((90, 0.7), (114, 0.6), (171, 0.4), (206, 0.3), (247, 0.2), (294, 0.1), (358, 0)),
            ),
        ),
        (
            4,
            (
                *((0, 0), (32, 0.8), (43, 0.95), (56, 1), (69, 0.975), (92, 0.9), (120, 0.8), (142, 0.7)),
                *((165, 0.6), (231, 0.4), (277, 0.3), (331, 0.2), (397, 0.1), (502, 0)),
            ),
        ),
        (
            15,
            (
                *((0, 0), (23.5, 0.4), (34, 0.6), (47, 0.8), (56, 0.9), (63, 0.95), (79, 1), (100, 0.975)),
                *((115, 0.95), (135, 0.9), (159, 0.85), (172, 0.8), (194, 0.7), (215, 0.6), (244, 0.5), *_TOP),
            ),
        ),
        (
            20,
            (
                *((0, 0), (19, 0.4), (44, 0.8), (52.5, 0.9), (58, 0.95), (75, 1), (101.5, 0.95), (114.5, 0.9)),
                *((132.5, 0.85), (143.5, 0.8), (165.5, 0.7), (197.5, 0.6), (241, 0.5), *_TOP),
            ),
        ),
        (
            41,
            (
                *((0, 0), (15, 0.4), (41, 0.8), (49, 0.9), (53, 0.965), (64, 0.99), (71, 1), (88, 0.95), (94, 0.9)),
                *((106, 0.85), (115, 0.8), (137, 0.7), (180, 0.6), (238, 0.5), *_TOP),
            ),
        ),
    )
)
"""First channel, and Hz of modulation and weight H from it up to the next (Daniel and Weber, figure 2)."""


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
