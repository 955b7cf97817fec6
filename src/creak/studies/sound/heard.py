"""What a listener hears of a run: the sound of each place's own contact forces, and of all together."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray, IntArray
from creak.dynamics.flow.march import flows
from creak.formats.wav import full_scale_for, full_scale_level
from creak.model.skin import skin_of
from creak.reduction.modal import one_share
from creak.signals.spectra import low_pass
from creak.sound.carriers import Noise, Span
from creak.sound.forced import LOWEST, without_clicks
from creak.sound.third_octave import a_weighted_sum
from creak.sound.zwicker_tables import RATE
from creak.studies.file.case import Listening
from creak.studies.file.quantities import in_base
from creak.studies.models.reduced import ReducedModel
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.marching import Marching
from creak.studies.prepare.reduction import Reduction
from creak.studies.run.one_run import Run
from creak.studies.sound.band import SoundBase, band_of
from creak.studies.sound.beyond import SHARE, WORTH, beyond_modes, losses_of
from creak.studies.sound.cabin import background_of, cabin_of, room_of
from creak.studies.sound.ear import Ear, Records, figures_of, records_of, scatter_of, together
from creak.studies.sound.listeners import Listener, ear_off, listeners_of
from creak.studies.sound.loud import Heard, heard_of
from creak.studies.sound.notes import Reach, notes_of
from creak.studies.sound.radiation import equivalent_levels, faces_of_parts, moved, source_of
from creak.studies.sound.road import road_levels, sum_of_levels
from creak.studies.sound.statistics import END, statistics_of

SHORTEST = 0.05
"""s, a window below which there is no loudness to speak of."""
SINGLE = np.float32
THIRD = 2.0 / 3.0
"""Of the band that is left where its last third is taken away."""


NO_MODES = "none: the reduced model is too large for its modes, which carry the sound"


@dataclass(frozen=True)
class Sound(SoundBase):
    """The sound of a run's contact at each listener."""

    listeners: tuple[Listener, ...]
    pressure: NDArray[np.float32]
    """(n_listener, n_place + 1, n) Pa at 48 kHz from t = 0, faded in and out: each place by itself, the loudest to the
    first listener first, last all contact together."""
    heard: tuple[tuple[Heard, ...], ...]
    """Listener by listener, as `pressure`."""
    order: tuple[int, ...]
    """Of the places as they were given: that of the loudest first."""
    equivalent_power: Mapping[str, float]
    """Part -> dB re 1 pW of its mean equivalent radiated power over the window, loudest first."""
    compact: tuple[tuple[str, ...], ...]
    """Listener by listener, the parts that it hears as compact bodies at frequencies at which they are."""
    notes: tuple[str, ...]
    ear: Ear
    """Of the first listener."""
    ways: tuple[float, ...] = ()
    """Share of N5 of each place, to the first listener, that changes where the unreduced model takes over earlier from
    the modes; none where it does not."""
    scatter: tuple[float, ...] = ()
    """Share of the same that the scatter of the statistical part may change; none without such a part."""
    other: Mapping[int, NDArray[np.float32]] = field(default_factory=dict)
    """Row of a listener with a head -> (n_place + 1, n) Pa at its other ear, as `pressure`, which is at the ear that
    hears all contact louder."""
    backgrounds: tuple[FloatArray | None, ...] = ()
    """(28,) dB re 20 uPa of the third octaves that each listener hears besides."""

    @property
    def full_scale_level(self) -> float:
        """dB re 20 uPa of a full-scale sine."""
        return full_scale_level(self.full_scale)


def hear(
    listening: Listening,
    marching: Marching,
    reduction: Reduction,
    reference: ReferenceModel,
    reduced: ReducedModel | None,
    run: Run | None,
    places: Sequence[IntArray],
) -> Sound | str:
    """The sound of the reduced run, or why there is none.

    Parameters
    ----------
    run : None: it ended early. places : channels of each place.

    Raises
    ------
    InputError : of listeners and background that the study gives, as `listeners_of` and `background_of`.
    """
    wall, cpu = clock.perf_counter(), clock.process_time()
    model, metre, window = reduction.structure.model, listening.metre, marching.window
    skin, given = skin_of(model), listeners_of(model, listening.listeners, listening.places, metre)
    background = background_of(listening.background, listening.places)
    room = room_of(listening.room, listening.places)
    if run is None:
        return "none: the run ended early"
    if reduced is None or run.name != "reduced":
        return "none: only a reduced model carries sound"
    if not flows(run.system):
        return NO_MODES
    if float(run.history.time[-1]) < SHORTEST:
        return f"none: the run is shorter than {SHORTEST:g} s"
    if not given and not places:
        return "none: nothing touches in the window"
    source = source_of(run.system, run.gaps, run.history)
    offline = clock.process_time()
    faces = faces_of_parts(run.system, skin, metre)
    offline = clock.process_time() - offline
    band = band_of(model, reduced, reduction.band.f_max, run, skin, moved(source, faces, skin), metre)
    if band.high <= 2.0 * LOWEST:
        return f"none: nothing above {band.high:.0f} Hz can be believed ({band.limit})"
    levels = equivalent_levels(source, faces, band.high, window)
    listeners = given or tuple(ear_off(model, skin, part, listening.units) for part in [*levels][:1])
    if not listeners:
        return "none: no part with shells or solids moves"
    before = clock.process_time()
    near, zeta, reach = band.computed, one_share(reduction.structure.modal), Reach(band)
    ends = band.modes, replace(band, modes=np.inf).computed
    if source.channel.size and ends[1] >= WORTH * ends[0]:
        most = SHARE * reduced.solves
        reach = reach.by_unreduced(beyond_modes(reference, zeta, source, listeners, metre, ends, most))
    if source.channel.size:
        losses, ends = losses_of(reference.system.damping, zeta), (reach.band.computed, min(END, band.step))
        reach = reach.by_plates(statistics_of(model, skin, source.gaps, source.row, losses, ends, metre))
    band = reach.band
    noise = Noise(Span(LOWEST, band.high))

    def ear_of(one: Listener) -> Ear:
        cabin = None if room is None else cabin_of(room, one, levels, metre, noise)
        plain = Ear(replace(one, side=0), near, metre, reach.beyond, reach.statistics)
        ear = replace(plain, listener=one, cabin=cabin, background=background, known={})
        ear = ear if cabin is None or one.head is None else replace(ear, middle=plain)
        if listening.background is None or not listening.background.linear:
            return ear
        road = road_levels(run.system, marching.loads, ear, window, marching.course.repeats)
        return replace(ear, background=sum_of_levels(background, road), road=a_weighted_sum(road))

    both = [[ear_of(one) for one in listener.ears] for listener in listeners]
    to = [[ear.hears(run.system) for ear in ears] for ears in both]
    if reach.beyond is not None:
        to += [[ear.hears(reach.beyond.system) for ear in ears] for ears in both]
    offline += clock.process_time() - before
    groups, sharp = source.groups(places), in_base(listening.sharp)

    def at(ears: Sequence[Ear]) -> list[tuple[Ear, Records, list[Heard]]]:
        to_all, middle = (source, groups), ears[0].middle
        fed = None if middle is None else records_of(*to_all, middle, run.system, alike=True)
        found = [(ear, together(records_of(*to_all, ear, run.system, fed=fed))) for ear in ears]
        figures = [(ear, r, figures_of(r, ear, window, band.high, sharp)) for ear, r in found]
        return sorted(figures, key=lambda one: one[2][-1].rank, reverse=True)

    every = [at(ears) for ears in both]
    louder, heard = [one[0] for one in every], [one[0][2] for one in every]
    ear, records, figures = louder[0]
    ways: tuple[float, ...] = ()
    if reach.beyond is not None:
        sooner = [heard_of(x, window, ear.background, ear.start, band.high).rank[0] for x in records.sooner]
        ways = tuple(share_apart(h.rank[0], n5) for h, n5 in zip(figures, sooner, strict=True))
    scatter = scatter_of(figures, records, ear, window)
    order = sorted(range(len(places)), key=lambda k: figures[k].rank, reverse=True)

    def told(records: Records) -> FloatArray:
        run_alone = records.whole[[*order, len(places)], ear.start : ear.start + source.force.shape[0]]
        return without_clicks(run_alone, RATE)

    pressure = np.stack([told(records) for _, records, _ in louder])
    other = {k: told(one[1][1]) for k, one in enumerate(every) if len(one) > 1}
    largest = max(float(np.abs(x).max(initial=0.0)) for x in [pressure, *other.values()])
    power = {model.parts[part].name: level for part, level in levels.items()}
    compact = tuple(tuple(model.parts[b.part].name for b in one[0].bodies) for one in to[: len(both)])
    small = {model.parts[b.part].name: b.highest for ears in to for one in ears for b in one.bodies}
    ears = [one[0] for one in louder]
    return Sound(
        listeners=tuple(one.listener for one in ears),
        pressure=pressure.astype(SINGLE),
        heard=tuple(tuple(of_one[k] for k in (*order, len(places))) for of_one in heard),
        order=tuple(order),
        equivalent_power=power,
        compact=compact,
        notes=tuple(notes_of(ears, heard, reach, power, small, model.parts)),
        ear=ear,
        ways=tuple(ways[k] for k in order) if ways else (),
        scatter=tuple(scatter[k] for k in order) if scatter else (),
        other={k: x.astype(SINGLE) for k, x in other.items()},
        backgrounds=tuple(one.background for one in ears),
        run=run.name,
        band=band,
        full_scale=full_scale_for(np.array([largest])),
        wall_s=clock.perf_counter() - wall,
        cpu_s=clock.process_time() - cpu - offline,
        offline_cpu_s=offline,
        room=room,
    )


def share_apart(n5: float | None, other: float | None) -> float:
    """Difference of two loudnesses as a share of the first; nan where one is not known."""
    if n5 is None or other is None or not np.isfinite([n5, other]).all():
        return float("nan")
    return abs(n5 - other) / n5 if n5 > 0.0 else 0.0


def n5_of_less(sound: Sound, window: tuple[float, float]) -> list[float | None]:
    """N5 of each place to the first listener, as it is ranked, where the band ends a third earlier."""
    high = THIRD * sound.band.high
    less = [low_pass(x.astype(float), 1.0 / RATE, high) for x in sound.pressure[0][:-1]]
    return [heard_of(x, window, sound.ear.background, 0, high).rank[0] for x in less]
