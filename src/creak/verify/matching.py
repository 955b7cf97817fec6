"""Which events two runs share, and how far apart they are; what is followed of every event and every place from run to
run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.given import items_of, not_negative, table_of
from creak.verify.events import Event
from creak.verify.intervals import overlap

FIGURES: dict[str, Callable[[Event], float]] = {
    "start": lambda e: e.t_start,
    "duration": lambda e: e.t_end - e.t_start,
    "force": lambda e: e.force_place,
    "impulse": lambda e: e.impulse,
    "closing_speed": lambda e: e.closing_speed,
}
"""What is followed of every event: s, s, low-passed peak force of its place, force s, length/s."""
OF_PLACE = ("events", "impulse", "force", "closing_speed", "n5")
"""What is followed of every place, over the verification window, as summary.json names it."""
TIMES = ("start", "duration")
"""Figures whose changes are absolute, s; those of the others are shares."""
UNTIL_THE_END = ("duration", "impulse")
"""Figures that are not known of an event that has not ended when the run does."""


def figures_of(event: Event) -> dict[str, float]:
    """All of an event."""
    return {name: of(event) for name, of in FIGURES.items()}


def change(name: str, before: float | None, after: float | None, floor: float = 0.0) -> float:
    """after - before (times, s) or that over |after| (or a floor); inf: something becomes nothing; nan: unknown."""
    if before is None or after is None:
        return np.nan
    if name in TIMES or after == before:
        return after - before
    scale = max(abs(after), floor)
    return (after - before) / scale if scale else np.inf


@dataclass(frozen=True)
class Errors:
    """Differences of the common events, one by one."""

    each: FloatArray
    """(n,) with sign, reduced against reference."""

    @property
    def mean(self) -> float | None:
        """Mean size, without sign."""
        return float(np.abs(self.each).mean()) if self.each.size else None

    @property
    def bias(self) -> float | None:
        """Mean with sign."""
        return float(self.each.mean()) if self.each.size else None

    @property
    def percentile_95(self) -> float | None:
        """Size that 95 % of the events stay below."""
        return float(np.percentile(np.abs(self.each), 95.0)) if self.each.size else None


@dataclass(frozen=True)
class EventMatch:
    """Events of a reduced run against those of its reference, within a time window."""

    pairs: list[tuple[Event, Event]]
    """(reference, reduced)"""
    missed: list[Event]
    extra: list[Event]

    @property
    def precision(self) -> float | None:
        """Share of the reduced run's events that the reference has too."""
        return _share(len(self.pairs), len(self.extra))

    @property
    def recall(self) -> float | None:
        """Share of the reference's events that were found."""
        return _share(len(self.pairs), len(self.missed))

    @property
    def time_error(self) -> Errors:
        """Start times, s."""
        return Errors(np.array([b.t_start - a.t_start for a, b in self.pairs]))

    @property
    def force_error(self) -> Errors:
        """Low-passed peaks of the places, as fractions of the reference's."""
        return self._relative("force_place")

    @property
    def impulse_error(self) -> Errors:
        """Impulses, as fractions of the reference's."""
        return self._relative("impulse")

    @property
    def amplitude_ratio_mean(self) -> float | None:
        """Mean low-passed peak of the common events, reduced / reference (thesis 3.7.3).

        The channels of a place together: how they share it hangs on their springs.
        """
        return self._ratio("force_place")

    @property
    def impulse_ratio_mean(self) -> float | None:
        """Mean impulse of the common events, reduced / reference."""
        return self._ratio("impulse")

    @property
    def within_5_percent(self) -> int:
        """Common events whose low-passed peaks differ by at most 5 %."""
        return sum(abs(b.force_place / a.force_place - 1.0) <= 0.05 for a, b in self.pairs if a.force_place > 0.0)

    def _ratio(self, name: str) -> float | None:
        reference = sum(getattr(a, name) for a, _ in self.pairs)
        return sum(getattr(b, name) for _, b in self.pairs) / reference if reference > 0.0 else None

    def _relative(self, name: str) -> Errors:
        values = [(getattr(a, name), getattr(b, name)) for a, b in self.pairs]
        return Errors(np.array([b / a - 1.0 for a, b in values if a > 0.0]))


def _share(common: int, alone: int) -> float | None:
    return common / (common + alone) if common + alone else None


SOME_EVENTS = "a list of Event, as creak.find_events makes one"


def match_events(
    reference: Sequence[Event], reduced: Sequence[Event], tolerance: float, window: tuple[float, float]
) -> EventMatch:
    """Match one to one by start time within `tolerance` s, nearest first, on the same side of the same group.

    Only events that count in `window` (`events_in`) are, but their partners may lie just outside it.

    Raises
    ------
    InputError : no lists of events, a tolerance below zero, a window that is no two times.
    """
    reference, reduced = (
        items_of(x, Event, name, SOME_EVENTS) for x, name in ((reference, "reference"), (reduced, "reduced"))
    )
    tolerance = not_negative(tolerance, "tolerance", "seconds, zero or more")
    if (begin_end := table_of(window, "window")).shape != (2,) or not begin_end[0] <= begin_end[1]:
        raise InputError(f"window = {window!r}", expected="(begin, end), s")
    candidates = sorted(
        (abs(a.t_start - b.t_start), i, j)
        for i, a in enumerate(reference)
        for j, b in enumerate(reduced)
        if (a.group, a.side) == (b.group, b.side) and abs(a.t_start - b.t_start) <= tolerance
    )
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for _, i, j in candidates:
        if i not in partner and j not in taken:
            partner[i] = j
            taken.add(j)

    def inside(e: Event) -> bool:
        return overlap(e.t_start, e.t_end, window)

    pairs = [(reference[i], reduced[j]) for i, j in sorted(partner.items()) if inside(reference[i])]
    missed = [e for i, e in enumerate(reference) if i not in partner and inside(e)]
    extra = [e for j, e in enumerate(reduced) if j not in taken and inside(e)]
    return EventMatch(pairs, missed, extra)
