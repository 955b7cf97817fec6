"""What the unreduced model says of events of the reduced run: some that it marched through, all of its own run."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray
from creak.verify.events import Event
from creak.verify.matching import FIGURES, TIMES, EventMatch, figures_of
from creak.verify.statistics import EventStatistics

MOVED = {"start": 2.0, "closing_speed": 1.0}
"""Figures of an event that hang on what came before it, and how much of `inherited` they change by, as a share of the
event's duration and of the closing speed. Found by coverage (docs/trust.md)."""
RETURNS = 3.0
"""Times what a border half as far away changes: what a border may. Found beside all dofs of the unreduced model
(docs/trust.md)."""
SURE = 0.95
"""Of the events that were not looked at, those whose differences are to lie within `Structure.spread`."""


@dataclass(frozen=True)
class Spot:
    """One event of the reduced run and what the unreduced model makes of it."""

    event: Event
    """Of the reduced run."""
    why: str
    """hardest, or drawn by the stored seed; run: of the unreduced model's own run."""
    reduced: dict[str, float]
    """`FIGURES` of the reduced run over the same stretch of time; those that it does not hold are left out."""
    unreduced: dict[str, float] | None
    """The same of the unreduced model; None where it has no such event, or was not run through it."""
    numerical: dict[str, float] | None = None
    """What half the contact step changes of the unreduced figures: s, or shares; None: not looked at."""
    problem: str = ""
    """Why there is nothing to compare."""
    border: dict[str, float] | None = None
    """What it changes that only a quarter of the dofs move by themselves: s, or shares; None: all of the model do."""

    def difference(self, name: str) -> float | None:
        """Unreduced less reduced: s for times, a share of the unreduced figure else; nan where it has no such event,
        None where there is nothing to compare."""
        if self.problem:
            return None
        if self.unreduced is None:
            return float("nan")
        a, b = self.reduced.get(name), self.unreduced.get(name)
        if a is None or b is None:
            return None
        if name in TIMES or a == b:
            return b - a
        return (b - a) / abs(b) if b else float("inf")

    def error(self, name: str) -> float | None:
        """Size of the difference with what the unreduced march itself leaves open."""
        by = self.difference(name)
        if by is None:
            return None
        return abs(by) + (self.numerical or {}).get(name, 0.0) + RETURNS * (self.border or {}).get(name, 0.0)


@dataclass(frozen=True)
class RubSpot:
    """A piece of rubbing or lasting contact of the reduced run and what the unreduced model makes of it."""

    contact: str
    number: int
    """Of the place; 0: it rests."""
    time: tuple[float, float]
    """Beginning and end, s."""
    reduced: dict[str, float]
    """`verify.rubbing.FIGURES` of the place in that time."""
    unreduced: dict[str, float]
    problem: str = ""
    """Why there is nothing to compare."""


@dataclass(frozen=True)
class Structure:
    """The unreduced model beside a run."""

    spots: tuple[Spot, ...] = ()
    """Events that it marched through from the reduced model's state."""
    rubs: tuple[RubSpot, ...] = ()
    """Pieces of rubbing and of lasting contact that it marched through."""
    run: tuple[Spot, ...] = ()
    """Those of its own run that both have."""
    missed: int = 0
    """Events of its own run that the reduced one does not have."""
    extra: tuple[Event, ...] = ()
    """Events of the reduced run that its own does not have."""
    samples: EventStatistics | None = None
    """Events of both runs as samples; None: it was not run."""
    first_end: float = -np.inf
    """When the first event of the reduced run ends, s: those that begin before it have none before them."""
    complete: bool = False
    """The reduced model has all modes that there are, and is the unreduced one in other coordinates: what it differs by
    from spot checks is the error of their contact steps."""
    solves: int = 0
    """Back-substitutions that the spot checks of events and of rubbing took, each factor counted as so many
    (`models.reduced.FACTOR`)."""
    wall_s: float = 0.0
    why_not: str = ""
    """Why no event was marched through."""
    of_steps: dict[str, float] = field(default_factory=dict)
    """How far the unreduced model's own run hangs on its contact steps: of each figure of an event a share, of times a
    share of the event's duration; empty: not looked at, or it was not run."""

    @property
    def looked(self) -> bool:
        """Does it say anything?"""
        return self._ran or any(not s.problem for s in self.spots)

    @property
    def weighed(self) -> tuple[Spot, ...]:
        """Spot checks that count: none of a complete model."""
        return () if self.complete else self.spots

    @property
    def counts(self) -> bool:
        """Does it say anything of what the reduction left out?"""
        return self._ran or any(not s.problem for s in self.weighed)

    @property
    def _ran(self) -> bool:
        """Does its own run say anything?"""
        return bool(self.run or self.extra or self.missed)

    def of_rub(self, name: str, contact: str, number: int, floor: float) -> float | None:
        """What it changes of friction at a place, over all pieces of it together: a share; None: not looked at, or it
        does not count (`complete`).

        Single slips of two models part soon: sums over the pieces are compared, of what is no sum the means.
        """
        rubs = () if self.complete else self.rubs
        own = [s for s in rubs if (s.contact, s.number) == (contact, number) and not s.problem]
        pairs = [(s.reduced[name], s.unreduced[name]) for s in own if name in s.reduced and name in s.unreduced]
        if not pairs:
            return None
        a, b = np.sum(pairs, axis=0) / len(pairs)
        return abs(b - a) / max(abs(b), floor) if a != b else 0.0

    def beside(self, match: EventMatch | None, samples: EventStatistics | None) -> Structure:
        """The same with what its own run says."""
        if match is None:
            return self
        run = tuple(Spot(b, "run", figures_of(b), figures_of(a)) for a, b in match.pairs)
        return replace(self, run=run, missed=len(match.missed), extra=tuple(match.extra), samples=samples)

    def change(self, name: str, event: Event) -> float:
        """What it changes of a figure of an event, s or a share: as found where it looked, else `spread`.

        Where it looked at single events alone, start and closing speed hang on what came before, too (`inherited`).
        """
        unit = event.t_end - event.t_start if name in TIMES else 1.0
        more = 0.0 if self.begins_anew(event) or name not in MOVED else MOVED[name] * self.inherited(event) * unit
        found = [s.error(name) for s in (*self.weighed, *self.run) if s.event is event]
        known = [x for x in found if x is not None]
        if known:
            return float("inf") if np.isnan(known).any() else max(known) + more
        return self.spread(name, event) * unit + more

    def begins_anew(self, event: Event) -> bool:
        """Whether what was found of an event holds what came before it, or nothing did."""
        return bool(self.run) or event.t_start < self.first_end

    @property
    def of_impulses(self) -> float:
        """Largest error of an impulse that a spot check found, a share; infinite where the unreduced model has no such
        event."""
        found = [x for s in self.weighed if (x := s.error("impulse")) is not None]
        return float("inf") if np.isnan(found).any() else max(found, default=0.0)

    @property
    def impulse_error(self) -> float:
        """The largest of these errors as an impulse; infinite as there."""
        if not np.isfinite(self.of_impulses):
            return float("inf")
        return max((x * s.event.impulse for s in self.weighed if (x := s.error("impulse")) is not None), default=0.0)

    def inherited(self, event: Event) -> float:
        """What the error of earlier impulses moves of an event: the largest that a spot check found, as a share of the
        checked impulse, and no more than it is of the event's own.

        A check begins at the reduced model's state, which has these errors already.
        """
        most = self.of_impulses
        return min(most, self.impulse_error / event.impulse) if event.impulse > 0.0 else most

    def spread(self, name: str, event: Event) -> float:
        """Within this lies the difference of an event that was not looked at, by those that were.

        Their root mean square times Student's t: the interval that holds the next one of normal differences about zero
        in `SURE` of all cases. They are alike as shares of the figure, or in its own unit, those of times as a length:
        a faint tap that is off by a fifth says nothing of a blow then (`alike_in_size`). Of times as a share of the
        event's duration. nan: none was looked at; infinite: the unreduced model has no such event.
        """
        found = [(x, _size(name, s.event)) for s in (self.weighed or self.run) if (x := _share(s, name)) is not None]
        if not found:
            return float("nan")
        share, size = np.array(found).T
        if np.isnan(share).any():
            return float("inf")
        own = _size(name, event)
        if own > 0.0 and alike_in_size(share, size):
            share = share * size / own
        return float(np.sqrt(np.mean(share**2))) * surely(share.size)

    def of_sum(self, name: str) -> float:
        """What it changes of the sum of a figure over all events: the mean by those that were looked at, and what is
        left open of that mean."""
        pairs = [
            (s.reduced[name], 0.0 if s.unreduced is None else s.unreduced[name])
            for s in (self.run or self.weighed)
            if not s.problem and name in s.reduced and (s.unreduced is None or name in s.unreduced)
        ]
        if not pairs:
            return float("nan")
        a, b = np.array(pairs).T
        if not a.any():
            return 0.0
        mean = float((b - a).sum() / np.abs(a).sum())
        rest = (b - a) - mean * a
        open_of_it = surely(len(pairs)) * float(np.sqrt((rest**2).sum()) / np.abs(a).sum())
        return abs(mean) + (0.0 if self.run else open_of_it)


def surely(n: int) -> float:
    """Half width of that interval over the root mean square of n differences: Student's t of n degrees of freedom."""
    from scipy.stats import t

    return float(t.ppf(0.5 + 0.5 * SURE, n))


def alike_in_size(share: FloatArray, size: FloatArray) -> bool:
    """Whether differences (n,), shares of figures of that size, are alike in the unit of these rather than as shares.

    They are where normal differences of one width would be 1 / (1 - `SURE`) times as likely. Of shares that are alike
    that happens by chance in no more than 1 - `SURE` of all cases (a ratio of likelihoods has the mean 1).
    """
    if (size <= 0.0).any() or not np.isfinite(share).all() or not share.any():
        return False
    widths = np.sqrt(np.mean(share**2)), np.sqrt(np.mean((share * size) ** 2))
    return bool(share.size * np.log(widths[0] / widths[1]) + np.log(size).sum() > -np.log(1.0 - SURE))


def _size(name: str, event: Event) -> float:
    """Of what its differences are shares; of times the way that the gap would go, as what is off by a length is late
    by that over the speed."""
    lasts = event.t_end - event.t_start
    return lasts * abs(event.closing_speed) if name in TIMES else abs(FIGURES[name](event))


def _share(spot: Spot, name: str) -> float | None:
    by = spot.error(name)
    if by is None or name not in TIMES:
        return by
    lasts = spot.event.t_end - spot.event.t_start
    return by / lasts if lasts > 0.0 else None
