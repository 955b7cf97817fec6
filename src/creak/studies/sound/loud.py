"""The figures of one sound: loudness, level, third octaves, and what else it is ranked by; what is foretold beyond
third octaves that are known both by computation and by statistics."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.sound.loudness import FAINT, TIME_STEP, Loudness, added_loudness, loudness
from creak.sound.quality import QUIETEST, Quality, quality_of, within
from creak.sound.third_octave import LOWER_EDGES, SILENCE, a_weighted_level, a_weighted_sum, third_octave_levels
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE

UNTIED, LIKE = 5.0, 4.0
"""dB, standard deviation of a third octave that is tied to nothing, and as many of them as that is believed like. Real
parts are no flat plates of one thickness: those of a door and a cockpit that were computed are off by so much."""
FAR = 3.0
"""Times `UNTIED` beyond which a third octave is no more off: a part that stands still there is no plate yet."""
OCTAVE = 3.0
"""Third octaves over which the correlation of what two of them are off by falls to 1 / e."""


@dataclass(frozen=True)
class Tie:
    """How the statistical level of one sound stands to what was computed of it."""

    bands: int
    """Third octaves that both have; 0: it is tied to nothing."""
    offset: float
    """dB by which the statistics are corrected, mean over what lies beyond; 0 where nothing ties them."""
    scatter: float
    """dB, standard deviation of the level beyond: of the tie, and of one plate from the mean of all like it."""


@dataclass(frozen=True)
class Levels:
    """Third octaves by their numbers."""

    band: IntArray
    apart: FloatArray
    """dB of what was computed over the statistics."""
    scatter: FloatArray
    """dB, standard deviation of one plate from the mean of all like it."""


def tied(seen: Levels, further: IntArray, scatter: FloatArray, weight: FloatArray) -> tuple[Tie, FloatArray]:
    """The tie of levels beyond to those that were seen, and dB by which each of them is corrected.

    What third octaves are off by, dB, is a random function of their number b: normal, mean 0, covariance
    s^2 exp(-|b - b'| / OCTAVE). It is seen where both are known, with the scatter of one plate on it, and foretold
    beyond (kriging: Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, equations 2.23 and 2.24).
    What is seen tells s as well, beside `UNTIED` (inverse gamma of `LIKE`).

    Parameters
    ----------
    further, scatter : of the levels beyond, as `Levels` has them. weight : with which each counts, of any sum.
    """
    b, d, v = seen.band, np.clip(seen.apart, -FAR * UNTIED, FAR * UNTIED), seen.scatter**2

    def alike(one: IntArray, other: IntArray) -> FloatArray:
        return np.asarray(np.exp(-np.abs(one[:, None] - other) / OCTAVE))

    by_prior = alike(b, b) + np.diag(v / UNTIED**2)
    square = (LIKE * UNTIED**2 + float(d @ np.linalg.solve(by_prior, d))) / (LIKE + d.size)
    known, to = square * alike(b, b) + np.diag(v), square * alike(further, b)
    corrected = to @ np.linalg.solve(known, d)
    left = square * alike(further, further) - to @ np.linalg.solve(known, to.T) + np.diag(scatter**2)
    share = weight / max(float(weight.sum()), np.finfo(float).tiny)
    return Tie(d.size, float(share @ corrected), float(np.sqrt(share @ left @ share))), np.asarray(corrected)


MESH = 0.03
"""Share by which loudness that a mesh computes to its end, six elements per wave, is off in 95 of 100 struck plates."""


@dataclass(frozen=True)
class Heard:
    """One sound over the verification window."""

    n5: float | None
    """sone; None: it is beyond what ISO 532-1 covers."""
    n_max: float | None
    level: float
    """Equivalent continuous level, dB(A) re 20 uPa."""
    third_octaves: FloatArray
    """(28,) dB re 20 uPa, 25 Hz to 12.5 kHz."""
    energy: float
    """Mean square of the A-weighted pressure, Pa^2."""
    n5_added: float | None = None
    """sone that it adds to the study's background; None: there is none, or it is beyond the standard."""
    n_max_added: float | None = None
    quality: Quality = field(default_factory=Quality)
    """What else it is ranked by."""
    n5_modes: float | None = None
    """sone of what the modes of the reduction tell of it, the lower part of the band; None: they tell all."""
    n5_computed: float | None = None
    """sone of what modes and unreduced model tell of it; None: they tell all, no statistical energy is in it."""
    n5_direct: float | None = None
    """sone of what comes straight, without what the study's room sends back; None: it gives no room."""
    n5_bar: tuple[float, ...] = ()
    """sone, lowest and highest N5 by the scatter of its statistical part; none without."""
    n10_bar: tuple[float, ...] = ()
    """The same of N10."""
    tie: Tie | None = None
    """Of the statistical part to what was computed; None: there is no such part, or it is the sum of several."""

    @property
    def rank(self) -> tuple[float, float, float]:
        """What counts when sounds are ranked: N5, where equal Nmax, where equal level; beside a background, added.

        N5 below `FAINT` counts as 0: such a sound is heard in less than 5 % of the time.
        """
        beside = self.n5_added is not None
        n5, n_max = (self.n5_added, self.n_max_added) if beside else (self.n5, self.n_max)
        n5 = np.inf if n5 is None else n5 if n5 >= FAINT else 0.0
        return (n5, np.inf if n_max is None else n_max, self.level)


def heard_of(
    pressure: FloatArray,
    window: tuple[float, float],
    background: FloatArray | None,
    start: int = 0,
    highest: float = np.inf,
    sharp: float | None = None,
) -> Heard:
    """One pressure (n,) at 48 kHz over the window, sample `start` at t = 0, after silence; see `heard_with`."""
    shown = window[0] + start / RATE, window[1] + start / RATE
    return heard_with(pressure, loudness_of(pressure), shown, background, highest, sharp)


def with_bar(
    heard: Heard,
    computed: FloatArray,
    ends: Sequence[FloatArray],
    tie: Tie | None,
    window: tuple[float, float],
    start: int,
) -> Heard:
    """The same with what statistical energy does to it: N5 without it, N5 and N10 where it is fainter and louder, and
    what is computed by `MESH` as well."""
    shown = window[0] + start / RATE, window[1] + start / RATE
    below, *both = (loudness_of(x) for x in (computed, *ends))
    known = [f.total[within(f.time, shown)] for f in both if f is not None]
    by = 1.0 - MESH, 1.0 + MESH
    n5, n10 = (
        tuple(b * float(np.percentile(x, p)) for b, x in zip(by, known, strict=True)) if len(known) == 2 else ()
        for p in (95.0, 90.0)
    )
    alone = None if below is None else float(np.percentile(below.total[within(below.time, shown)], 95.0))
    return replace(heard, n5_computed=alone, n5_bar=n5, n10_bar=n10, tie=tie)


def bar_share(
    heard: Heard, ends: Sequence[FloatArray], window: tuple[float, float], background: FloatArray | None, start: int
) -> float:
    """Share of the loudness by which a sound is ranked that either end of its bar is off; nan: it is not known."""
    n5, n5s = heard.rank[0], list(heard.n5_bar)
    if background is not None:
        both = [_added(e, background) for e in ends] if n5s else []
        added = [x for x in both if x is not None]
        if len(added) < len(both):
            return float("nan")
        shown = window[0] + start / RATE, window[1] + start / RATE
        n5s = [
            float(np.percentile(x[within(np.arange(x.size, dtype=np.float64) * TIME_STEP, shown)], 95.0)) for x in added
        ]
    if not n5s or not np.isfinite(n5):
        return float("nan")
    more = 0.0 if background is None else MESH
    return max(abs(x - n5) for x in n5s) / n5 + more if n5 > 0.0 else 0.0


def loudness_of(pressure: FloatArray, rate: float = RATE) -> Loudness | None:
    """Loudness over time; None: it is beyond what ISO 532-1 covers."""
    with suppress(InputError):
        return loudness(pressure, rate)
    return None


def heard_with(
    pressure: FloatArray,
    found: Loudness | None,
    shown: tuple[float, float],
    background: FloatArray | None,
    highest: float = np.inf,
    sharp: float | None = None,
    *,
    silent: bool = True,
) -> Heard:
    """The same of a pressure whose loudness is `found`, over a stretch `shown`, s from its first sample.

    Nothing is above `highest`, Hz. Without `sharp`, acum above which time counts as sharp,
    its `quality` is not looked at. `silent`: so it was before the first sample.
    """
    levels, level = third_octave_levels(pressure, RATE, shown), a_weighted_level(pressure, RATE, shown)
    levels[highest <= LOWER_EDGES] = SILENCE  # what is left there is the skirt of the filter, not the sound
    energy = REFERENCE_PRESSURE**2 * 10.0 ** (0.1 * level) if pressure.any() else 0.0
    quality = Quality()
    if sharp is not None:
        steady = QUIETEST if background is None else a_weighted_sum(background)
        quality = quality_of(pressure, found, shown, sharp=sharp, steady=steady, silent=silent)
    if found is None:
        return Heard(None, None, level, levels, energy, quality=quality)
    inside = within(found.time, shown)
    added: tuple[float | None, float | None] = (None, None)
    if background is not None:
        beside = _added(pressure, background)
        added = added if beside is None else _n5_and_most(beside[inside])
    return Heard(*_n5_and_most(found.total[inside]), level, levels, energy, *added, quality)


def _added(pressure: FloatArray, background: FloatArray) -> FloatArray | None:
    """`added_loudness`; None: both together are beyond what ISO 532-1 covers."""
    with suppress(InputError):
        return added_loudness(pressure, RATE, background)
    return None


def _n5_and_most(total: FloatArray) -> tuple[float, float]:
    return float(np.percentile(total, 95.0)), float(total.max())
