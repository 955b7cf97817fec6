"""Who hears the contact forces of a run, and of other runs of its model: by the modes of the reduction, and beyond."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.sound.forced import high_end, lead, without_lows
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.beyond import Beyond
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import heard_of
from creak.studies.sound.radiation import Radiation, radiation, record_of
from creak.studies.sound.source import Source, on_system, source_of
from creak.studies.sound.statistics import Statistics, Tie, statistical


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
    ties: tuple[Tie | None, ...] = ()
    """Of the statistics of each group."""


def records_of(source: Source, gaps: GapOperator, groups: Sequence[IntArray], ear: Ear, system: System) -> Records:
    """What an ear hears of each group of forces on the modes of a System.

    Where the gain of the modes falls from 1 to 0 at the end of their band, that of the unreduced model rises:
    P = g P_modes + (1 - g) P_unreduced, `sooner` with g^2. Beyond both is noise, which adds by its energy.
    """
    near, computed, sooner = _computed(source, gaps, groups, ear, system)
    if ear.statistics is None:
        return Records(near, computed, computed, sooner, computed, computed)
    more = statistical(ear.statistics, source, gaps, groups, ear.listener, computed, ear.start)
    with_it = (computed + more.mean, sooner + more.mean, computed + more.fainter, computed + more.louder)
    return Records(near, computed, *with_it, more.ties)


def _computed(
    source: Source, gaps: GapOperator, groups: Sequence[IntArray], ear: Ear, system: System
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """By the modes; with the unreduced model; where that takes over earlier."""
    near = record_of(source, groups, ear.hears(system))
    if ear.beyond is None:
        return near, near, near
    far = record_of(on_system(source, ear.beyond.system, gaps), groups, ear.hears(ear.beyond.system))
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


def n5_of(
    background: FloatArray | None,
    window: tuple[float, float],
    system: System,
    gaps: GapOperator,
    history: History,
    groups: Sequence[IntArray],
    ear: Ear,
    like: System | None = None,
) -> list[float | None]:
    """N5 of the forces of each group of channels by itself and, last, of all, as places are ranked by it.

    With a background it is what they add to it. None: beyond what ISO 532-1 covers.

    Parameters
    ----------
    like : a System with the same shapes, which the ear knows already.
    """
    source = source_of(system, gaps, history)
    if not source.channel.size:
        return [0.0] * (len(groups) + 1)
    record = records_of(source, gaps, source.groups(groups), ear, like or system).whole
    record[-1] = record.sum(axis=0)
    heard = [heard_of(x, window, background, ear.start) for x in record]
    return [h.n5 if background is None else h.n5_added for h in heard]
