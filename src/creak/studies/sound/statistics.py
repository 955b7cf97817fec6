"""Beyond mesh and modes: what the statistical energy of the plates that contact forces push sends to a listener.

A sound of this part is noise. Its third octaves follow the energy that the forces put in and damping takes; no single
wave in it is known. It is tied to the last third octaves that were computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.fft import rfft
from scipy.special import j0

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.digest import digest
from creak.model.dofs import nodes_of
from creak.model.mesh import Model
from creak.model.skin import Skin
from creak.reduction.band_modes import Losses
from creak.sound.carriers import (
    ForceLines,
    Noise,
    Span,
    along,
    band_power,
    force_lines,
    lines_of,
    stored,
)
from creak.sound.directivity import FlatSheet, flat_sheet
from creak.sound.forced import FADE, LOWEST, without_lows
from creak.sound.plates import in_decibel, interference, radiation_efficiency, relative_variance
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import LOWER_EDGES, UPPER_EDGES
from creak.sound.zwicker_tables import BANDS, RATE
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import Levels, Tie, tied
from creak.studies.sound.plates_heard import PlateHeard, plate_heard, shells_of
from creak.studies.sound.radiation import Source
from creak.studies.sound.sheets import LEAST, PartPlates, Push, Sheets, pushes, sheets_of

END = 10_000.0
"""Hz up to which statistical energy goes."""
TIED = 6
"""Third octaves, the last ones that were computed, that it is tied to."""
BAR = 2.0
"""Standard deviations of a bar."""
WORTH = 1.1
"""End of the statistics over that of what was computed from which on they are asked."""
LOUD = 0.3
"""Power of an energy that its loudness goes with: by it bands count when their scatter is averaged."""
FAINT = 1e-3
"""Of the strongest combination of forces, below which one is left out."""
ENOUGH, MOST = 0.999, 64
"""Share of the squares of all changes of a place's forces that those which are looked at hold, and the most of them;
the others are believed to push like these."""
WIDTH = 10.0**0.05 - 10.0**-0.05
"""Of a third octave over its middle."""
GOLDEN = 0.6180339887
"""Of the length of the noise by which each place begins later than the one before: no two are alike."""


@dataclass(frozen=True)
class Statistics:
    """What statistical energy needs to know of a model."""

    sheets: Sheets
    losses: Losses
    noise: Noise
    """Of what lies beyond."""
    metre: float
    plates: tuple[int, ...]
    """Rows into `Model.parts` of those that contact pushes and that count as plates."""
    left_out: tuple[int, ...]
    """Of those that it pushes and that do not."""
    flat: dict[str, FlatSheet | None] = field(default_factory=dict, compare=False, repr=False)
    """Faces, by their digest, as sheets, made once for each; None: they are not flat."""
    beams: dict[tuple[str, int, bytes, float], float] = field(default_factory=dict, compare=False, repr=False)
    """Faces, a plate of their part, a point and a frequency -> share of that point, found before."""

    @property
    def span(self) -> Span:
        """What lies beyond."""
        return self.noise.span


@dataclass(frozen=True)
class Statistical:
    """Pressures (n_group, n) at 48 kHz."""

    mean: FloatArray
    fainter: FloatArray
    """By `BAR` standard deviations."""
    louder: FloatArray
    ties: tuple[Tie | None, ...]
    """Of each group; None: its forces bend no plate that is heard."""


@dataclass(frozen=True)
class _Envelope:
    """Mean square pressure of a third octave over time, of all parts."""

    band: int
    time: FloatArray
    square: FloatArray
    variance: float
    """Over its squared mean, of one of many like plates."""

    @property
    def energy(self) -> float:
        """Pa^2 s"""
        return float(self.square.sum() * (self.time[1] - self.time[0])) if self.time.size > 1 else 0.0


def statistics_of(
    model: Model,
    skin: Skin,
    gaps: GapOperator,
    row: IntArray,
    losses: Losses,
    ends: tuple[float, float],
    metre: float,
) -> Statistics | str:
    """Of a model that is computed up to `ends[0]`, Hz, and whose forces are believed up to `ends[1]`; or why not.

    Parameters
    ----------
    row : of the forces that are heard, as `pushes` has it.
    """
    low, high = ends
    if high < WORTH * low:
        return "contact forces are not known there"
    if losses.width(np.array([low]))[0] <= 0.0:
        return "nothing is damped"
    sheets = sheets_of(model, skin, metre)
    found = pushes(sheets, gaps, row)
    plates = tuple(p.part.part for p in found if p.part.density * WIDTH * low >= LEAST)
    if not plates:
        return "contact forces bend no part that has a mode in each third octave there"
    touched = np.unique(nodes_of(gaps.labels))
    pushed = [k for k, part in enumerate(model.parts) if np.isin(touched, part.nodes_idx).any()]
    left_out = tuple(k for k in pushed if k not in plates)
    return Statistics(sheets, losses, Noise(Span(low, high)), metre, plates, left_out)


def statistical(
    known: Statistics,
    source: Source,
    groups: Sequence[IntArray],
    listener: Listener,
    computed: FloatArray,
    start: int,
    *,
    alike: bool = False,
) -> Statistical:
    """What a listener hears of each group of forces beyond what was computed of it.

    Parameters
    ----------
    computed : (n_group, n) Pa, whose sample `start` is at t = 0.
    alike : plates send alike to all sides.
    """
    found = pushes(known.sheets, source.gaps, source.row)
    heard = [plate_heard(p, listener, known.metre) for p in found if p.part.part in known.plates]
    heard = [h for h in heard if h.spread > 0.0]
    if not alike:
        heard = [replace(h, beams=_beams(known, h.push.part, listener)) for h in heard]
    n = computed.shape[1]
    out = np.zeros((3, len(groups), n))
    ties: list[Tie | None] = []
    for g, columns in enumerate(groups):
        some, share = _strongest(source.force, columns)
        here = [h.of(some) for h in heard]
        here = [h for h in here if h.push.column.size]
        if not here:
            ties.append(None)
            continue
        lines = force_lines(source.force[:, some] * (known.metre / np.sqrt(share)), known.span.high)
        beyond = [_envelope(known, lines, here, int(b), cut=True) for b in known.span.bands]
        tie, corrected = _tie(known, lines, here, beyond, computed[g])
        time = (np.arange(n) - start) / RATE
        square = [
            10.0 ** (0.1 * by) * np.interp(time, e.time, e.square) for by, e in zip(corrected, beyond, strict=True)
        ]
        rows = along(known.noise.of(n), square, int(GOLDEN * g * n) % n).sum(axis=0)
        if listener.head is not None:
            nearest = max(here, key=lambda h: h.spread)
            rows = listener.head.delayed(rows, RATE, nearest.middle)
        rows = without_lows(rows, RATE, known.span.only)
        step = 10.0 ** (0.05 * BAR * tie.scatter)
        out[:, g] = rows, rows / step, rows * step
        ties.append(tie)
    return Statistical(out[0], out[1], out[2], tuple(ties))


def _strongest(force: FloatArray, columns: IntArray) -> tuple[IntArray, float]:
    """Those of some forces that change most, in order, and their share in the squares of all changes."""
    change = np.array([float(np.sum(np.diff(force[:, j]) ** 2)) for j in columns.tolist()])
    whole = float(change.sum())
    if whole <= 0.0:
        return columns[:0], 1.0
    order = np.argsort(-change, kind="stable")
    enough = int(np.searchsorted(np.cumsum(change[order]), ENOUGH * whole)) + 1
    kept = order[: min(enough, MOST)]
    return np.sort(columns[kept]), float(change[kept].sum()) / whole


def _envelope(known: Statistics, lines: ForceLines, heard: Sequence[PlateHeard], band: int, *, cut: bool) -> _Envelope:
    """Mean square pressure over time of a third octave, or of what of it lies in the span."""
    here, gain = lines.of(band)
    gain = gain * known.span.gain(lines.freq(here)) if cut else gain
    middle = np.array([BANDS[band]])
    width = float(known.losses.width(middle)[0])
    time, total = band_power(lines, here, gain, _straight(heard, lines.X.shape[1], float(middle[0])))
    straight, over, late, variance = float(total.sum()), middle * WIDTH / width, 0.0, 0.0
    for h in heard:
        _, power = band_power(lines, here, gain, _together(h.push, float(middle[0]), lines.X.shape[1]))
        per_energy = _sent(h, band) * h.reach(float(middle[0]))
        ringing = per_energy * stored(time, power, 2.0 * np.pi * width)
        rings, overlap = float(ringing.sum()), np.array([width * h.push.part.density])
        total = total + ringing
        late += h.away * (rings + straight / len(heard))
        variance += float(relative_variance(overlap, over)[0]) * rings**2
        variance += 2.0 * float(interference(over)[0]) * rings * straight
    whole = float(np.sum(total))
    if whole <= 0.0:
        return _Envelope(band, time, np.zeros(time.size), 0.0)
    return _Envelope(band, time + late / whole / AIR.speed, total, variance / whole**2)


def _together(push: Push, freq: float, n_force: int) -> FloatArray:
    """(n_force, k) combinations whose squares add up to the power that goes into a plate, W = sum F_i F_j Re Y_ij.

    Re Y_ij = Re Y J0(k r_ij): near forces push as one, far ones each for itself (infinite plate: Cremer, Heckl and
    Petersson, section 5.2).
    """
    plate = max(push.part.plates, key=lambda p: p.density)
    apart = np.linalg.norm(push.point[:, None] - push.point[None], axis=2)
    weight = push.across * np.sqrt(push.mobility)
    size, vectors = np.linalg.eigh(j0(plate.wavenumber(np.array([freq]))[0] * apart) * (weight[:, None] * weight[None]))
    keep = size > FAINT * size.max(initial=0.0)
    mix = np.zeros((n_force, int(keep.sum())))
    mix[push.column] = vectors[:, keep] * np.sqrt(size[keep])
    return mix


def _sent(heard: PlateHeard, band: int) -> float:
    """Pa^2 m^2 per unit of energy: rho c / (2 pi) times the power that its faces radiate to one side, as much of it as
    goes to the listener."""
    part, freq = heard.push.part, np.array([BANDS[band]])
    each = np.array([float(radiation_efficiency(p, freq)[0]) for p in part.plates]) * part.areas
    sigma = float(each.sum() if heard.beams is None else each @ heard.beams[:, band])
    short = 1.0 / max(float(p.wavenumber(freq)[0]) for p in part.plates)
    seen = heard.share * heard.at_edges(float(freq[0]), short)
    return seen * (AIR.density * AIR.speed) ** 2 * sigma / (2.0 * np.pi * part.mass)


def _beams(known: Statistics, part: PartPlates, listener: Listener) -> FloatArray | None:
    """`PlateHeard.beams` of a part: of the third octaves that are heard of it, and of those that may tie it."""
    own = shells_of(listener, part)
    faces = digest(own.nodes_idx)
    if faces not in known.flat:
        high = np.array([BANDS[-1]])
        shortest = min(AIR.speed / high[0], *(2.0 * np.pi / float(p.wavenumber(high)[0]) for p in part.plates))
        known.flat[faces] = flat_sheet(own.corners * known.metre, shortest)
    sheet = known.flat[faces]
    if sheet is None:
        return None
    point = listener.position * known.metre
    found = np.ones((len(part.plates), BANDS.size))
    bands = range(max(0, int(known.span.bands[0]) - TIED - 1), int(known.span.bands[-1]) + 1)
    for k, plate in enumerate(part.plates):
        for band in bands:
            freq = float(BANDS[band])
            key = faces, k, point.tobytes(), freq
            if key not in known.beams:
                known.beams[key] = sheet.share(point, freq, float(plate.wavenumber(np.array([freq]))[0]))
            found[k, band] = known.beams[key]
    return found


def _straight(heard: Sequence[PlateHeard], n_force: int, freq: float) -> ComplexArray:
    """(n_force, 1) what the forces send by themselves, of all parts together: a contact pushes two of them apart.

    rho F / (2 pi r m) / (1 - x), x = (f / f_c)^2 sin^4 of the angle off the normal at the force: the infinite plate
    (Cremer, Heckl and Petersson, section 6.5). What is above that at x near 1 is a wave, which its energy has.
    """
    mix = np.zeros((n_force, 1), dtype=np.complex128)
    for h in heard:
        push = h.push
        plate = max(push.part.plates, key=lambda p: p.density)
        x = (freq / plate.coincidence) ** 2 * h.sine**4
        late = np.exp(-2j * np.pi * freq / AIR.speed * h.far)
        way = h.side / h.far * late * np.sqrt(h.reach(freq) / h.spread) * h.around(freq)
        np.add.at(mix[:, 0], push.column, push.across * push.direct * way / np.maximum(x - 1.0, 1.0))
    return mix


def _tie(
    known: Statistics,
    lines: ForceLines,
    heard: Sequence[PlateHeard],
    beyond: Sequence[_Envelope],
    computed: FloatArray,
) -> tuple[Tie, FloatArray]:
    """By the third octaves below the span that were computed whole; and dB by which each of those beyond is off."""
    modes = max(h.push.part.density for h in heard) * WIDTH * BANDS
    whole = np.flatnonzero((FADE * known.span.low >= UPPER_EDGES) & (LOWER_EDGES >= LOWEST) & (modes >= LEAST))
    X = np.abs(rfft(computed)) ** 2
    band, apart, variance = list[int](), list[float](), list[float]()
    for k in whole[-TIED:].tolist():
        there = _envelope(known, lines, heard, k, cut=False)
        here, gain = lines_of(k, RATE / computed.size, X.size)
        energy = 2.0 * float(X[here] @ gain**2) / computed.size / RATE
        if energy > 0.0 and there.energy > 0.0:
            band.append(k)
            apart.append(float(10.0 * np.log10(energy / there.energy)))
            variance.append(there.variance)
    seen = Levels(np.array(band, dtype=np.int64), np.array(apart), in_decibel(np.array(variance)))
    own = in_decibel(np.array([e.variance for e in beyond]))
    loud = np.array([e.energy for e in beyond]) ** LOUD
    return tied(seen, np.array([e.band for e in beyond], dtype=np.int64), own, loud)
