"""Noise whose third octaves follow energies over time: the signal of what is known of a sound by its energy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.fft import fft, ifft, irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.sound.forced import FADE, high_end, smooth
from creak.sound.third_octave import LOWER_EDGES, UPPER_EDGES
from creak.sound.zwicker_tables import BANDS, RATE

SEED = 1
"""Of the noise: the same run sounds the same each time."""
SOFT = 0.02
"""Decades over which one third octave gives way to the next."""
FLATTER = 4
"""Times that the envelope of the noise is made flat, and its band restored (Kohlrausch et al., Acta Acustica 83, 1997,
659): what changes over time is then the energy that it is given."""
OVER = 2
"""Samples of an envelope over lines of its band's spectrum."""
LOW_SKIRT = 0.7
"""Of the lower end of a span, below which nothing of it is left."""
EASE = 0.2
"""s in which forces that do not begin or end with nothing come and go."""


@dataclass(frozen=True)
class Span:
    """What lies between two ends of a band, Hz: from 0 at the lower end over 1 to 0 at the upper one.

    At its lower end it takes over, in energy, what `forced.high_end` gives up there.
    """

    low: float
    high: float

    @property
    def bands(self) -> IntArray:
        """Rows of `BANDS` that have something in it."""
        return np.flatnonzero((FADE * self.low < UPPER_EDGES) & (self.high > LOWER_EDGES))

    def gain(self, freq: FloatArray) -> FloatArray:
        """Amplitude at each frequency, Hz."""
        return np.asarray(np.sqrt(1.0 - high_end(freq, self.low) ** 2) * high_end(freq, self.high))

    def only(self, freq: FloatArray) -> FloatArray:
        """1 where `gain` has something, falling to 0 beside it: envelopes that change fast spread what they are of."""
        return np.asarray(smooth((freq / self.low - LOW_SKIRT) / (FADE - LOW_SKIRT)) * high_end(freq, self.high))


def third_octave_gain(band: int, freq: FloatArray) -> FloatArray:
    """Amplitude of a row of `BANDS` at frequencies above 0, Hz; the squares of all bands add up to 1."""
    decades = np.log10(np.maximum(freq, 1e-3) / BANDS[band])
    rise, fall = (smooth((decades - edge) / SOFT + 0.5) for edge in (-0.05, 0.05))
    return np.asarray(np.sqrt(np.maximum(rise - fall, 0.0)))


def lines_of(band: int, apart: float, count: int) -> tuple[slice, FloatArray]:
    """Of spectral lines 0 .. count - 1 that lie `apart` Hz those of a row of `BANDS`, and their gains."""
    first = int(LOWER_EDGES[band] * 10.0**-SOFT / apart)
    last = min(count, int(UPPER_EDGES[band] * 10.0**SOFT / apart) + 2)
    here = slice(max(1, min(first, last)), max(1, last))
    return here, third_octave_gain(band, np.arange(here.start, here.stop, dtype=np.float64) * apart)


@dataclass(frozen=True)
class ForceLines:
    """Spectra of forces, with silence around them."""

    size: int
    front: int
    """Samples before t = 0."""
    X: ComplexArray
    """(n_line, n_force) up to the end of what is wanted."""

    def of(self, band: int) -> tuple[slice, FloatArray]:
        """Lines of a row of `BANDS`, and their gains."""
        return lines_of(band, RATE / self.size, self.X.shape[0])

    def freq(self, here: slice) -> FloatArray:
        """Of some lines, Hz."""
        return np.arange(here.start, here.stop) * (RATE / self.size)


def force_lines(force: FloatArray, high: float) -> ForceLines:
    """Of forces (n, n_force), means over the intervals of 48 kHz, up to `high`, Hz."""
    ease = int(EASE * RATE)
    size = next_fast_len(force.shape[0] + 4 * ease, real=True)
    rise = smooth((np.arange(ease) + 0.5) / ease)
    lines = 1 + int(high * size / RATE)
    X = np.empty((lines, force.shape[1]), dtype=complex)
    for j, f in enumerate(force.T):
        x = np.concatenate([f[0] * rise, f, f[-1] * rise[::-1]])
        X[:, j] = rfft(np.concatenate([np.zeros(ease), x]), size)[:lines]
    return ForceLines(size, 2 * ease, X / np.sinc(np.arange(lines) / size)[:, None])


def band_power(
    lines: ForceLines, here: slice, gain: FloatArray, mix: FloatArray | ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Times (k,) in s and mean squares (k,), over a period of the band, of all of X mix: of some lines, with a gain of
    each.

    Parameters
    ----------
    mix : (n_force, n_sum) combinations of the forces, whose squares add up.
    """
    count = next_fast_len(max(OVER * gain.size, 2))
    X = lines.X[here]
    Z = gain[:, None] * (X.real @ mix + 1j * (X.imag @ mix))
    z = ifft(Z, count, axis=0) * (2.0 * count / lines.size)
    power = 0.5 * (z.real**2 + z.imag**2).sum(axis=1)
    return (np.arange(count) * lines.size / count - lines.front) / RATE, np.asarray(power)


def stored(time: FloatArray, power: FloatArray, rate: float) -> FloatArray:
    """Energy (k,) over time of what is put in and lost, dE/dt = W - rate E: exact for W constant between times."""
    from scipy.signal import lfilter  # see `signals.spectra.low_pass`

    keep = np.exp(-rate * (time[1] - time[0])) if time.size > 1 else 0.0
    return np.asarray(lfilter([(1.0 - keep) / rate], [1.0, -keep], power))


def carriers(span: Span, bands: IntArray, size: int) -> FloatArray:
    """(n_band, size) noise at 48 kHz of each third octave in a span, of mean square 1; it goes round without a seam."""
    out = np.zeros((bands.size, size))
    for row, band in enumerate(bands.tolist()):
        here, gain = lines_of(band, RATE / size, size // 2 + 1)
        g = gain * span.gain(np.arange(here.start, here.stop) * (RATE / size))
        if not g.any():
            continue
        own, count = np.random.default_rng((SEED, band)), next_fast_len(OVER * g.size)
        Z = g * (own.standard_normal(g.size) + 1j * own.standard_normal(g.size))
        for _ in range(FLATTER):
            z = ifft(Z, count)
            Z = g * fft(z / np.maximum(np.abs(z), 1e-300))[: g.size]
        X = np.zeros(size // 2 + 1, dtype=complex)
        X[here] = Z
        x = irfft(X, size)
        out[row] = x / np.sqrt(np.mean(x**2))
    return out


@dataclass(frozen=True)
class Noise:
    """`carriers` of a span, each length made once."""

    span: Span
    known: dict[int, FloatArray] = field(default_factory=dict, compare=False, repr=False)

    def of(self, n: int) -> FloatArray:
        """(n_band, size) of the shortest length from n on whose transform is fast."""
        size = next_fast_len(n, real=True)
        if size not in self.known:
            self.known[size] = carriers(self.span, self.span.bands, size)
        return self.known[size]


def along(noise: FloatArray, envelopes: Sequence[FloatArray], shift: int) -> FloatArray:
    """(n_band, n) the noise of each band, begun `shift` samples later, with the mean squares (n,) of each."""
    n = envelopes[0].size if len(envelopes) else 0
    out = np.zeros((len(envelopes), n))
    for row, (x, square) in enumerate(zip(noise, envelopes, strict=True)):
        y = np.roll(x, -shift)[:n] * np.sqrt(square)
        whole, own = float(square.sum()), float(y @ y)
        out[row] = y * np.sqrt(whole / own) if own > 0.0 else 0.0
    return out
