"""Who hears the contact forces of a run, and of other runs of its model: by the modes of the reduction, and beyond."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.sound.forced import high_end, lead, without_lows
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.beyond import Beyond
from creak.studies.sound.cabin import Cabin
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import Heard, Tie, bar_share, heard_of, with_bar
from creak.studies.sound.radiation import Radiation, Source, on_system, radiation, record_of, source_of
from creak.studies.sound.statistics import Statistics, statistical

RECORDS = ("modes", "computed", "whole", "sooner", "fainter", "louder")
"""Of `Records` those that a room adds to."""


@dataclass(frozen=True)
class Ear:
    """A listener, and the end of the band in which it hears."""

    listener: Listener
    band: float
    """Hz, of the modes."""
    metre: float
    """Of the model's length."""
    beyond: Beyond | None = None
    """What the unreduced model sends from there on; None: nothing is heard there."""
    statistics: Statistics | None = None
    """What is heard where the others end; None: nothing is heard there."""
    cabin: Cabin | None = None
    """What sends back all that; None: nothing does."""
    middle: Ear | None = None
    """At the middle of its head, were that not there: what is heard there feeds the cabin. None: it has no head."""
    background: FloatArray | None = None
    """(28,) dB re 20 uPa of the third octaves that it hears besides; None: nothing."""
    road: float | None = None
    """dB(A) that the excitation sends without contact, where that is part of the background."""
    known: dict[int, tuple[System, Radiation]] = field(default_factory=dict, compare=False, repr=False)
    """By the System's id: what was made before."""

    @property
    def start(self) -> int:
        """Sample of a record that is at t = 0."""
        return lead(RATE, self.band)

    def hears(self, system: System) -> Radiation:
        """What it hears of the modes of a System; made once for each."""
        if id(system) not in self.known:
            far = self.beyond is not None and system is self.beyond.system
            band = self.beyond.high if far and self.beyond is not None else self.band
            self.known[id(system)] = system, radiation(system, self.listener, self.metre, band)
        return self.known[id(system)][1]


@dataclass(frozen=True)
class Records:
    """Pressures (n_group, n) at 48 kHz with the lead before and what rings on behind."""

    modes: FloatArray
    """By the modes of the reduction alone."""
    computed: FloatArray
    """With the unreduced model beyond them."""
    whole: FloatArray
    """With statistical energy beyond both."""
    sooner: FloatArray
    """The same where the unreduced model takes over earlier in its overlap with the modes: equal to `whole` as far as
    they agree there."""
    fainter: FloatArray
    louder: FloatArray
    """`whole` where the statistical part is off by its bar."""
    direct: FloatArray
    """`whole` without what a room sends back."""
    ties: tuple[Tie | None, ...] = ()
    """Of the statistics of each group."""


def records_of(
    source: Source,
    groups: Sequence[IntArray],
    ear: Ear,
    system: System,
    in_room: Sequence[str] = RECORDS,
    fed: Records | None = None,
    *,
    alike: bool = False,
) -> Records:
    """What an ear hears of each group of forces on the modes of a System.

    Where the gain of the modes falls from 1 to 0 at the end of their band, that of the unreduced model rises:
    P = g P_modes + (1 - g) P_unreduced, `sooner` with g^2. Beyond both is noise, which adds by its energy. A room adds
    its own to each of those that are named; it takes longest.

    Parameters
    ----------
    fed : what `ear.middle` hears, of plates that send alike to all sides, where that is known.
    alike : plates beyond the mesh send alike to all sides, and so tell their whole power: what feeds a room.
    """
    near, computed, sooner = _computed(source, groups, ear, system)

    def with_statistics(*, alike: bool) -> Records:
        if ear.statistics is None:
            return Records(near, computed, computed, sooner, computed, computed, computed)
        to = ear.listener, computed, ear.start
        more = statistical(ear.statistics, source, groups, *to, alike=alike)
        whole = computed + more.mean
        later = whole if sooner is computed else sooner + more.mean
        return Records(near, computed, whole, later, computed + more.fainter, computed + more.louder, whole, more.ties)

    found = with_statistics(alike=alike)
    if ear.cabin is None:
        return found
    if ear.middle is None:
        fed = with_statistics(alike=True)
    elif fed is None:
        fed = records_of(source, groups, ear.middle, system, alike=True)
    return _in_room(found, fed, ear.cabin, in_room)


def _in_room(records: Records, fed: Records, cabin: Cabin, names: Sequence[str]) -> Records:
    every = {id(x): x for x in (getattr(fed, name) for name in names)}
    back = {key: cabin.adds(x) for key, x in every.items()}
    return replace(records, **{name: getattr(records, name) + back[id(getattr(fed, name))] for name in names})


def _computed(
    source: Source, groups: Sequence[IntArray], ear: Ear, system: System
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """By the modes; with the unreduced model; where that takes over earlier."""
    near = record_of(source, groups, ear.hears(system))
    if ear.beyond is None:
        return near, near, near
    far = record_of(on_system(source, ear.beyond.system), groups, ear.hears(ear.beyond.system))
    far = np.pad(far, ((0, 0), (ear.start - lead(RATE, ear.beyond.high), 0)))

    def modes(freq: FloatArray) -> FloatArray:
        return high_end(freq, ear.band)

    def above(freq: FloatArray) -> FloatArray:
        return 1.0 - modes(freq)

    def above_sooner(freq: FloatArray) -> FloatArray:
        return 1.0 - modes(freq) ** 2

    def through(record: FloatArray, gain: Callable[[FloatArray], FloatArray]) -> FloatArray:
        return np.stack([without_lows(x, RATE, gain) for x in record])

    return near, near + through(far, above), through(near, modes) + through(far, above_sooner)


def together(records: Records) -> Records:
    """With all contact in the place of what touches elsewhere."""
    sums = {name: getattr(records, name) for name in (*RECORDS, "direct")}
    sums = {name: np.vstack([x[:-1], x.sum(axis=0)]) for name, x in sums.items()}
    return replace(records, **sums, ties=(*records.ties[:-1], None))


def figures_of(records: Records, ear: Ear, window: tuple[float, float], high: float, sharp: float) -> list[Heard]:
    """What an ear hears of each record over a window, s.

    Parameters
    ----------
    high : Hz, above which there is nothing. sharp : acum above which time counts as sharp.
    """
    start = ear.start
    heard = [heard_of(x, window, ear.background, start, high, sharp) for x in records.whole]
    if ear.beyond is not None:
        lower = [heard_of(x, window, None, start, ear.band).n5 for x in records.modes]
        heard = [replace(h, n5_modes=n5) for h, n5 in zip(heard, lower, strict=True)]
    if ear.cabin is not None:
        straight = [heard_of(x, window, None, start, high).n5 for x in records.direct]
        heard = [replace(h, n5_direct=n5) for h, n5 in zip(heard, straight, strict=True)]
    if ear.statistics is not None:
        each = zip(heard, records.computed, records.fainter, records.louder, records.ties, strict=True)
        heard = [with_bar(h, x, ends, tie, window, start) for h, x, *ends, tie in each]
    return heard


def scatter_of(heard: Sequence[Heard], records: Records, ear: Ear, window: tuple[float, float]) -> tuple[float, ...]:
    """Share of each loudness that its statistical part may change; none without such a part."""
    if ear.statistics is None:
        return ()
    ends = zip(heard, records.fainter, records.louder, strict=True)
    return tuple(bar_share(h, (a, b), window, ear.background, ear.start) for h, a, b in ends)


def n5_of(
    window: tuple[float, float],
    system: System,
    gaps: GapOperator,
    history: History,
    groups: Sequence[IntArray],
    ear: Ear,
    like: System | None = None,
) -> list[float | None]:
    """N5 of the forces of each group of channels by itself and, last, of all, as places are ranked by it.

    Beside a background it is what they add to it. None: beyond what ISO 532-1 covers.

    Parameters
    ----------
    like : a System with the same shapes, which the ear knows already.
    """
    source = source_of(system, gaps, history)
    if not source.channel.size:
        return [0.0] * (len(groups) + 1)
    record = records_of(source, source.groups(groups), ear, like or system, in_room=("whole",)).whole
    record[-1] = record.sum(axis=0)
    heard = [heard_of(x, window, ear.background, ear.start) for x in record]
    return [h.n5 if ear.background is None else h.n5_added for h in heard]
