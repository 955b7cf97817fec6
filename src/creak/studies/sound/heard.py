"""What a listener hears of a run: the sound of each place's own contact forces, and of all together."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray, IntArray
from creak.dynamics.diagonal import is_modal
from creak.errors import InputError
from creak.formats.wav import full_scale_for, full_scale_level
from creak.model.skin import skin_of
from creak.model.units import METRES
from creak.signals.spectra import low_pass
from creak.sound.forced import LOWEST, lead, without_clicks
from creak.sound.impulsiveness import QUIETEST
from creak.sound.loudness import Loudness, added_loudness, loudness
from creak.sound.quality import Quality, quality_of, within
from creak.sound.third_octave import (
    LOWER_EDGES,
    SILENCE,
    UPPER_EDGES,
    a_weighted_level,
    a_weighted_sum,
    third_octave_levels,
)
from creak.sound.zwicker_tables import RATE, REFERENCE_PRESSURE
from creak.studies.file.quantities import in_base
from creak.studies.run.compared import main_run
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run
from creak.studies.sound.background import NOTHING, background_of
from creak.studies.sound.band import Band, band_of
from creak.studies.sound.listeners import Listener, ear_off, listeners_of
from creak.studies.sound.parts import equivalent_levels, faces_of_parts, moved
from creak.studies.sound.radiation import LARGE, Ear, record_of
from creak.studies.sound.source import source_of

SHORTEST = 0.05
"""s, a window below which there is no loudness to speak of."""
SINGLE = np.float32
MOST_PARTS = 6
"""Of equivalent radiated power in the notes."""


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

    @property
    def rank(self) -> tuple[float, float, float]:
        """What counts when sounds are ranked: N5, where equal Nmax, where equal level; beside a background, added."""
        beside = self.n5_added is not None
        n5, n_max = (self.n5_added, self.n_max_added) if beside else (self.n5, self.n_max)
        return (np.inf if n5 is None else n5, np.inf if n_max is None else n_max, self.level)


@dataclass(frozen=True)
class Sound:
    """The sound of a run's contact at each listener."""

    run: str
    listeners: tuple[Listener, ...]
    band: Band
    pressure: NDArray[np.float32]
    """(n_listener, n_place + 1, n) Pa at 48 kHz from t = 0, faded in and out: each place by itself, the loudest to the
    first listener first, last all contact together."""
    heard: tuple[tuple[Heard, ...], ...]
    """Listener by listener, as `pressure`."""
    order: tuple[int, ...]
    """Of the places as they were given: that of the loudest first."""
    full_scale: float
    """Pa of full scale in every file made of it."""
    wall_s: float
    cpu_s: float
    """Without what is made once for a model and its listeners."""
    offline_cpu_s: float
    """That: rows of parts and listeners."""
    equivalent_power: Mapping[str, float]
    """Part -> dB re 1 pW of its mean equivalent radiated power over the window, loudest first."""
    compact: tuple[tuple[str, ...], ...]
    """Listener by listener, the parts that it hears as compact bodies at frequencies at which they are."""
    notes: tuple[str, ...]
    ear: Ear
    """Of the first listener."""

    @property
    def full_scale_level(self) -> float:
        """dB re 20 uPa of a full-scale sine."""
        return full_scale_level(self.full_scale)


def hear(result: StudyResult, places: Sequence[IntArray]) -> Sound | str:
    """The sound of the reduced run, or why there is none.

    Parameters
    ----------
    places : channels of each place.

    Raises
    ------
    InputError : of listeners and background that the study gives, as `listeners_of` and `background_of`.
    """
    wall, cpu = clock.perf_counter(), clock.process_time()
    run, setup = main_run(result.runs), result.setup
    c, where = setup.study.config, setup.study.places
    given, background = listeners_of(setup.model, c.listener, where), background_of(c.background, where)
    why_not = _why_not(result, run, bool(given), places)
    if why_not or run is None or result.reduced is None:
        return why_not
    metre, skin = METRES[c.model.units], skin_of(setup.model)
    source = source_of(run.system, result.gaps, run.history)
    offline = clock.process_time()
    faces = faces_of_parts(run.system, skin, metre)
    offline = clock.process_time() - offline
    band = band_of(setup.model, result.reduced, setup.band.f_max, run, skin, moved(source, faces, skin), metre)
    if band.high <= 2.0 * LOWEST:
        return f"none: nothing above {band.high:.0f} Hz can be believed ({band.limit})"
    levels = equivalent_levels(source, faces, band.high, result.window)
    listeners = given or tuple(ear_off(setup.model, skin, part, c.model.units) for part in [*levels][:1])
    if not listeners:
        return "none: no part with shells or solids moves"
    before = clock.process_time()
    ears = [Ear(listener, band.high, metre) for listener in listeners]
    to = [ear.hears(run.system) for ear in ears]
    offline += clock.process_time() - before
    groups = source.groups(places)
    record, start = np.stack([record_of(source, groups, one) for one in to]), lead(RATE, band.high)
    record[:, -1] = record.sum(axis=1)
    sharp = in_base(c.limit.sharpness_above)
    heard = [[heard_of(x, result.window, background, start, band.high, sharp) for x in of_one] for of_one in record]
    order = sorted(range(len(places)), key=lambda k: heard[0][k].rank, reverse=True)
    run_alone = record[:, [*order, len(places)], start : start + source.force.shape[0]]
    pressure = without_clicks(run_alone, RATE)
    power = {setup.model.parts[part].name: level for part, level in levels.items()}
    compact = tuple(tuple(setup.model.parts[b.part].name for b in one.bodies) for one in to)
    small = {setup.model.parts[b.part].name: b.highest for one in to for b in one.bodies}
    return Sound(
        run.name,
        tuple(listeners),
        band,
        pressure.astype(SINGLE),
        tuple(tuple(of_one[k] for k in (*order, len(places))) for of_one in heard),
        tuple(order),
        full_scale_for(pressure),
        clock.perf_counter() - wall,
        clock.process_time() - cpu - offline,
        offline,
        power,
        compact,
        tuple(_notes(listeners, band, heard, power, small, background)),
        ears[0],
    )


def _why_not(result: StudyResult, run: Run | None, given: bool, places: Sequence[IntArray]) -> str:
    if run is None or result.stopped is not None:
        return "none: the run ended early"
    if result.reduced is None or run.name != "reduced":
        return "none: only a reduced model carries sound"
    if not is_modal(run.system):
        return "none: damping couples the modes of the reduced model"
    if float(run.history.time[-1]) < SHORTEST:
        return f"none: the run is shorter than {SHORTEST:g} s"
    return "" if given or places else "none: nothing touches in the window"


def heard_of(
    pressure: FloatArray,
    window: tuple[float, float],
    background: FloatArray | None,
    start: int = 0,
    highest: float = np.inf,
    sharp: float | None = None,
    *,
    silent: bool = True,
) -> Heard:
    """One pressure (n,) at 48 kHz, over the window. Sample `start` is at t = 0; nothing is above `highest`, Hz.

    Without `sharp`, acum above which time counts as sharp, its `quality` is not looked at. `silent`: so it was before
    the first sample.
    """
    shown = window[0] + start / RATE, window[1] + start / RATE
    levels, level = third_octave_levels(pressure, RATE, shown), a_weighted_level(pressure, RATE, shown)
    levels[highest <= LOWER_EDGES] = SILENCE  # what is left there is the skirt of the filter, not the sound
    energy = REFERENCE_PRESSURE**2 * 10.0 ** (0.1 * level) if pressure.any() else 0.0
    found: Loudness | None = None
    with suppress(InputError):  # beyond ISO 532-1: its loudness is none
        found = loudness(pressure, RATE)
    quality = Quality()
    if sharp is not None:
        steady = QUIETEST if background is None else a_weighted_sum(background)
        quality = quality_of(pressure, found, shown, sharp=sharp, steady=steady, silent=silent)
    if found is None:
        return Heard(None, None, level, levels, energy, quality=quality)
    inside = within(found.time, shown)
    added: tuple[float | None, float | None] = (None, None)
    if background is not None:
        added = _n5_and_most(added_loudness(pressure, RATE, background)[inside])
    return Heard(*_n5_and_most(found.total[inside]), level, levels, energy, *added, quality)


THIRD = 2.0 / 3.0
"""Of the band that is left where its last third is taken away."""


def n5_of_less(sound: Sound, background: FloatArray | None, window: tuple[float, float]) -> list[float | None]:
    """N5 of each place to the first listener, as it is ranked, where the band ends a third earlier."""
    high = THIRD * sound.band.high
    less = [low_pass(x.astype(float), 1.0 / RATE, high) for x in sound.pressure[0][:-1]]
    return [heard_of(x, window, background, 0, high).rank[0] for x in less]


def _n5_and_most(total: FloatArray) -> tuple[float, float]:
    return float(np.percentile(total, 95.0)), float(total.max())


def _notes(
    listeners: Sequence[Listener],
    band: Band,
    heard: Sequence[Sequence[Heard]],
    power: Mapping[str, float],
    compact: Mapping[str, float],
    background: FloatArray | None,
) -> list[str]:
    said = []
    for listener in listeners:
        at = ", ".join(f"{x:.4g}" for x in listener.position)
        if not listener.given:
            said.append(
                f"sound: heard at ({at}), an ear 0.6 m off the loudest panel, as the study has no [listener]; "
                f"{', '.join(listener.parts)} radiate"
            )
    said.append(
        f"sound: believed from {band.low:.0f} to {band.high:.0f} Hz, ended by the {WHAT[band.limit]}; "
        "nothing outside is in it. Contact forces alone make it; panels count as set in a wall, none shadows another"
    )
    if power:
        levels = ", ".join(f"{name} {level:.0f} dB" for name, level in [*power.items()][:MOST_PARTS])
        said.append(f"sound: equivalent radiated power of contact, re 1 pW: {levels}")
    if compact:
        names = ", ".join(f"{name} compact below {freq:.0f} Hz" for name, freq in compact.items())
        said.append(
            f"sound: {names}: acceleration noise of the sphere of the same volume, without a wall; from there "
            f"to {LARGE:g} times as much it becomes that of faces set in a wall"
        )
    if background is not None:
        said.append(
            "sound: places are ranked by the loudness that they add to the study's [background], N of both less N of "
            "the background alone"
        )
        given = np.flatnonzero(background > NOTHING)
        low, high = (LOWER_EDGES[given[0]], UPPER_EDGES[given[-1]]) if given.size else (0.0, 0.0)
        if low > band.low or high < min(band.high, UPPER_EDGES[-1]):
            said.append(
                f"sound: the [background] has nothing outside {low:.0f} to {high:.0f} Hz; nothing is masked there"
            )
    if any(h.n5 is None for of_one in heard for h in of_one):
        said.append("sound: too loud at low frequency for ISO 532-1 (120 dB): no loudness of it")
    return said


WHAT = {"modes": "modes that the reduction kept", "mesh": "mesh", "step": "step in contact", "rate": "sampling rate"}
