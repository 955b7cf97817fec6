"""Loudness of a pressure signal after Zwicker, ISO 532-1:2017: of a steady sound, and over time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.given import not_negative
from creak.jit import njit
from creak.sound.core_loudness import INNER, core_loudness, decayed, low_pass
from creak.sound.third_octave import STEP, as_level, at_48k, band_powers, counted, smoothing
from creak.sound.zwicker_tables import (
    ACUM,
    BANDS,
    BARK,
    EDGES,
    FILTERS,
    LEVEL_RATE,
    RANGES,
    RATE,
    REFERENCE_PRESSURE,
    SHARPNESS,
    SLOPES,
)

EVERY = 4
"""Band levels per value that is given: one every 2 ms."""
TIME_STEP = EVERY / LEVEL_RATE
"""s between those."""
FAST, SLOW = (0.47, 0.0035), (0.53, 0.070)
"""Share and time constant in s of the two low-passes of total loudness."""
SETTLED = 0.2
"""s that the filters are given before a steady sound counts."""
FAINTEST = 3.0
"""phon, the lowest loudness level."""
BEFORE = 1.0
"""s of the background alone before a sound: its loudness has settled within 1e-6 by then."""
FAINT = 0.1
"""sone: softer sounds are given no sharpness."""
ON_THE_EDGE = 1e-6
"""Bark by which a point may lie beyond a piece and still be its last."""


@dataclass(frozen=True)
class Loudness:
    """Loudness over time. Percentiles are those of `total` over the record as it is, silence included."""

    time: FloatArray
    """(n,) s from the record's first sample, every 2 ms."""
    total: FloatArray
    """(n,) N(t), sone."""
    specific: FloatArray
    """(n, 240) N'(z, t), sone/Bark at .1, .2, ... 24 Bark, before the low-passes of N(t)."""
    instant: FloatArray
    """(n,) its integral, sone."""

    def exceeded(self, percent: float) -> float:
        """Loudness exceeded in `percent` of the time, sone: N5 is `exceeded(5)`."""
        if not 0.0 <= percent <= 100.0:
            raise InputError(f"loudness exceeded in {percent:g} % of the time", expected="0 to 100 %")
        return float(np.percentile(self.total, 100.0 - percent))

    @property
    def n5(self) -> float:
        """Loudness exceeded in 5 % of the time, sone."""
        return self.exceeded(5.0)

    @property
    def n10(self) -> float:
        """Loudness exceeded in 10 % of the time, sone."""
        return self.exceeded(10.0)

    @property
    def n_max(self) -> float:
        """Largest loudness, sone."""
        return float(self.total.max())

    @property
    def level(self) -> FloatArray:
        """(n,) loudness level, phon."""
        return loudness_level(self.total)

    @property
    def sharpness(self) -> FloatArray:
        """(n,) sharpness of N'(z, t) by DIN 45692, acum; 0 where there is nothing to hear."""
        return sharpness(self.specific, self.instant)


@dataclass(frozen=True)
class SteadyLoudness:
    """Loudness of a steady sound."""

    total: float
    """N, sone."""
    specific: FloatArray
    """(240,) N'(z), sone/Bark at .1, .2, ... 24 Bark."""

    @property
    def level(self) -> float:
        """Loudness level, phon."""
        return float(loudness_level(np.array([self.total]))[0])

    @property
    def sharpness(self) -> float:
        """Sharpness by DIN 45692, acum; 0 where there is nothing to hear."""
        return float(sharpness(self.specific[None], np.array([self.total]))[0])


def loudness(pressure: ArrayLike, rate: float, field: str = "free") -> Loudness:
    """Loudness over time of a pressure signal, ISO 532-1:2017, method for time-varying sounds.

    Valid for sounds at one ear's place from 25 Hz to 14 kHz; a band up to 250 Hz may have 120 dB at most.

    Parameters
    ----------
    pressure : (n,) Pa, silent before. rate : sampling, Hz; other than 48 kHz is resampled.
    field : "free", sound from the front, or "diffuse".

    Raises
    ------
    InputError : a pressure that is not one channel of numbers up to 1e5 Pa, a rate outside 1 kHz to 10 MHz, another
        field, a low band above 120 dB.
    """
    x = at_48k(pressure, rate)
    powers, _ = band_powers(x, FILTERS, smoothing(), STEP, *counted(0, 0))
    return _over_time(powers, field)


def added_loudness(pressure: ArrayLike, rate: float, background: ArrayLike) -> FloatArray:
    """(n,) sone that a sound adds to a steady background, every 2 ms: N(t) of both together less N of the background.

    Powers of both add up in each third octave before the ear masks one by the other. No partial loudness: what is left
    of the sound where its own loudness is told apart from the background's is a little more.

    Parameters
    ----------
    pressure, rate : as `loudness`, from the front. background : (28,) dB re 20 uPa, bands of 25 Hz to 12.5 kHz.

    Raises
    ------
    InputError : as `loudness` and `loudness_of_levels`.
    """
    steady = REFERENCE_PRESSURE**2 * 10.0 ** (0.1 * _checked_levels(background))
    powers, _ = band_powers(at_48k(pressure, rate), FILTERS, smoothing(), STEP, *counted(0, 0))
    lead = int(BEFORE * LEVEL_RATE)
    total = _over_time(np.vstack([np.zeros((lead, BANDS.size)), powers]) + steady, "free").total
    first = lead // EVERY
    return np.asarray(np.maximum(total[first:] - total[first - 1], 0.0))


def _over_time(powers: FloatArray, field: str) -> Loudness:
    """Of mean squares (n, 28) in the third octaves at `LEVEL_RATE`."""
    core = decayed(core_loudness(as_level(powers), field), LEVEL_RATE)
    instant, specific = with_slopes(core, EVERY)
    total: FloatArray = np.zeros(instant.size)
    for share, tau in (FAST, SLOW):
        total += share * np.asarray(low_pass(instant, math.exp(-1.0 / (LEVEL_RATE * INNER * tau)), INNER))
    time = np.arange(specific.shape[0], dtype=np.float64) * TIME_STEP
    return Loudness(time, total[::EVERY], specific, instant[::EVERY])


def steady_loudness(pressure: ArrayLike, rate: float, field: str = "free", *, skip: float = SETTLED) -> SteadyLoudness:
    """Loudness of a steady sound, ISO 532-1:2017, method for stationary sounds.

    Parameters
    ----------
    pressure, rate, field : as `loudness`. skip : s at the start that do not count: the filters settle.

    Raises
    ------
    InputError : as `loudness`; a record not longer than `skip`.
    """
    x = at_48k(pressure, rate)
    skip = not_negative(skip, "skip", "seconds, zero or more")
    start = round(min(skip * RATE, x.size))
    if start >= x.size:
        raise InputError(
            f"a record of {x.size / RATE:g} s, of which the first {skip:g} s do not count",
            expected="a longer record",
            fix="Give more of the sound, or a shorter skip.",
        )
    _, energy = band_powers(x, FILTERS, smoothing(), STEP, *counted(start, x.size))
    return loudness_of_levels(as_level(energy / (x.size - start)), field=field)


def loudness_of_levels(levels: ArrayLike, *, field: str = "free") -> SteadyLoudness:
    """Loudness of a steady sound from its third-octave levels.

    Parameters
    ----------
    levels : (28,) dB re 20 uPa, bands of 25 Hz to 12.5 kHz. field : as `loudness`.

    Raises
    ------
    InputError : another number of bands, no numbers, another field, a low band above 120 dB.
    """
    total, specific = with_slopes(core_loudness(_checked_levels(levels)[None], field))
    return SteadyLoudness(float(total[0]), specific[0])


def _checked_levels(levels: ArrayLike) -> FloatArray:
    given = np.asarray(levels, dtype=np.float64)
    if given.shape != BANDS.shape or not np.isfinite(given).all():
        raise InputError(
            f"third-octave levels of shape {given.shape}", expected="28 finite levels in dB, bands of 25 Hz to 12.5 kHz"
        )
    return given


def loudness_level(total: FloatArray) -> FloatArray:
    """Loudness level in phon of loudness in sone: 40 + 10 ld N, below one sone 40 (N + .0005)^.35, 3 at least."""
    quiet = 40.0 * (np.minimum(total, 1.0) + 5e-4) ** 0.35
    return np.asarray(
        np.where(total >= 1.0, 40.0 + 10.0 * np.log2(np.maximum(total, 1.0)), np.maximum(quiet, FAINTEST))
    )


def sharpness(specific: FloatArray, total: FloatArray) -> FloatArray:
    """.11 int N' g z dz / N of specific loudness (n, 240) and its integral (n,), (n,) acum.

    g = 1 up to 15.8 Bark and .15 exp(.42 (z - 15.8)) + .85 above. 0 where the loudness is below .1 sone.
    """
    heard = total >= FAINT
    return np.asarray(
        np.where(heard, ACUM * float(BARK[0]) * (specific @ SHARPNESS) / np.where(heard, total, 1.0), 0.0)
    )


def with_slopes(core: FloatArray, every: int = 1) -> tuple[FloatArray, FloatArray]:
    """Total loudness (n,) in sone and, of each `every`-th row, specific loudness (n_out, 240) in sone/Bark at `BARK`
    (ISO 532-1, 5.4).

    Parameters
    ----------
    core : (n, 20) sone/Bark of the critical bands.
    """
    total, specific = _with_slopes(core, every, EDGES, RANGES, SLOPES, BARK)
    return np.asarray(total), np.asarray(specific)


@njit(nogil=True)
def _with_slopes(
    core: FloatArray, every: int, edges: FloatArray, ranges: FloatArray, slopes: FloatArray, bark: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The pattern in straight pieces from low to high bands.

    A band louder than what spills over from below is flat; else that spill falls on, ever flatter the softer it is,
    down to the band's own loudness.
    """
    count, bands = core.shape
    total, specific = np.zeros(count), np.zeros(((count + every - 1) // every, bark.size))
    for k in range(count):
        z, n, point = 0.0, 0.0, 0
        for i in range(edges.size):
            own = core[k, i] if i < bands else 0.0
            while z < edges[i]:
                if n <= own:
                    n, steep, end, low = own, 0.0, edges[i], own
                else:
                    row = 0
                    while ranges[row] >= n:
                        row += 1
                    steep = slopes[row, min(i - 1, slopes.shape[1] - 1)]
                    low = max(ranges[row], own)
                    end = z + (n - low) / steep
                    if end > edges[i]:
                        end = edges[i]
                        low = n - (end - z) * steep
                total[k] += 0.5 * (end - z) * (n + low)
                if k % every == 0:
                    while point < bark.size and bark[point] <= end + ON_THE_EDGE:
                        specific[k // every, point] = max(n - (bark[point] - z) * steep, 0.0)
                        point += 1
                z, n = end, low
    return total, specific
