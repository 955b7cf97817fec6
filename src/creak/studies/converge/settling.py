"""What is followed of every event from run to run, and how far it has settled: records and their rule."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.verify.events import Event
from creak.verify.matching import FIGURES, TIMES, change
from creak.verify.rubbing import Rub
from creak.verify.statistics import EventStatistics
from creak.verify.unreduced import Structure

SETTLED = 0.05
"""Low-passed force, impulse and closing speed are settled when all that they hang on changes them together by no more
than this share: the 5 % within which the thesis calls an amplitude right (3.7.3)."""
ENOUGH = 0.95
"""Share of the events that are to be settled in every figure."""
OF_DURATION = 1.0 / 3.0
"""Start and duration are settled when all that they hang on moves them together by no more than this share of the
event's own duration: the last of several micro-contacts of an event comes and goes, the blow itself stays."""
BRIEF = 1.0 / 250.0
"""Of the time within which events count as the same (five periods of the low-pass of forces): a fiftieth of a period.
What moves start or duration by less is settled too: a blow so short is one at an instant, whatever holds it."""
BASE, HALF, QUARTER = "base", "h/2", "h/4"
TWICE, TENFOLD, MORE_MODES = "2 x stiffness", "10 x stiffness", "more modes"
FINER, SOFTER, STIFFER = "half the tolerance", "half the stiffness", "twice the stiffness"
YIELDING, HARDER = "half the spring of hard contact", "twice the spring of hard contact"
LAST_TWO = {
    "step": (HALF, QUARTER),
    "stiffness": (TWICE, TENFOLD),
    "tolerance": (BASE, FINER),
    "softer": (BASE, SOFTER),
    "stiffer": (BASE, STIFFER),
    "yielding": (BASE, YIELDING),
    "harder": (BASE, HARDER),
    "modes": (BASE, MORE_MODES),
}
"""Family -> the two runs whose difference tells how far it has settled; the first two are those of a forced step."""
IN_TIME = ("tolerance", "step")
"""Families that change the resolution in time alone."""
UNREDUCED, CHANCE, BAND, WAYS, SCATTER = "unreduced", "chance", "band", "ways", "scatter"
"""Sources of a change beside the families: the unreduced model; of sums over a chaotic run, chance; of loudness, where
the band ends, where the modes hand over to the unreduced model, and the scatter of its statistical part."""
REST = {"modes": 2.0, "tolerance": 4.0 / 3.0, "yielding": 1.0 / (2.0**0.5 - 1.0), "harder": 1.0 / (1.0 - 0.5**0.5)}
"""Family -> times what its run changes that all further refinement may. Half as many modes again: an error that falls
with the number of modes to the power 1.7 or faster, found by coverage (docs/trust.md). Steps of half the length: an
error of second order is 4/3 of the difference (Richardson). What the spring k in place of a rigid contact changes falls
with its own time, k^-1/2: chains of masses thrown at a wall (docs/trust.md)."""
COUNTS = ("events", "slips", "slip_rate")
"""Figures that are counted: finer steps move them by whole numbers."""
GOES_ON = "goes on when the run ends"
"""Why duration and impulse of an unfinished event are not known."""
SMALL = 2e-3
UNSEEN, LEAST = "unseen", {name: 5e-3 if name == "force" else SMALL for name in FIGURES}
"""Source of what no run sees, of each figure a share; of times a share of the event's duration. Found by coverage as
well: a low-passed force hangs on the even axis that it is laid on, too."""
OF_CONTACT = ("softer", "stiffer", "yielding", "harder", "stiffness")
"""Families that change how stiff contact is."""
SOURCES = {"time": IN_TIME, "stiffness": OF_CONTACT, "modes": ("modes",)}
"""What an answer hangs on -> the families that tell how much; of several the largest counts."""


def limit(name: str, lasts: float, tolerance: float = 0.0) -> float:
    """What the verdict lets a figure of an event that lasts so long move by: s, or a share.

    Parameters
    ----------
    tolerance : events that start this close are the same, s.
    """
    return max(OF_DURATION * lasts, BRIEF * tolerance) if name in TIMES else SETTLED


@dataclass(frozen=True)
class Repeat:
    """What one run takes differently."""

    name: str
    family: str
    """step, stiffness, modes; empty for the base run."""
    step: float
    """s"""
    refined: float = 1.0
    """How much finer than the accuracy says contact is resolved."""
    stiffness: float = 1.0
    """Factor on the stiffness of the contacts."""
    harder: float = 1.0
    """Factor on the springs that stand for hard contact."""
    f_max: float | None = None
    """Hz, of the reduction; None: the model is not reduced."""
    judged: bool = True
    """False: a figure that the study gives is varied; what that changes is told, and nothing is unsettled by it."""


@dataclass(frozen=True)
class Followed:
    """Places of the base run that are looked for in the repeated ones."""

    base: tuple[dict[str, float], ...] = ()
    """`OF_PLACE` of each in the base run; figures that are not known are left out."""
    of: Callable[[System, GapOperator, History], tuple[dict[str, float], ...]] = lambda *_: ()
    """The same in another run."""
    impulses: tuple[tuple[float, ...], ...] = ()
    """Those of the events of each in the base run, of all places."""
    band: tuple[float, ...] = ()
    """Share of the N5 of each that the last third of the band makes: half a band more may add as much."""
    ways: tuple[float, ...] = ()
    """Share of the same that changes where the unreduced model takes over earlier from the modes; none where it does
    not."""
    scatter: tuple[float, ...] = ()
    """Share of the same that the scatter of the statistical part may change; none without such a part."""
    band_ends: tuple[float, str] | None = None
    """Hz, and what ends it in words."""
    rub_names: tuple[tuple[str, int], ...] = ()
    """Contact and number of each place that is looked for as one that rubs; 0: it rests."""
    rubs: tuple[Rub, ...] = ()
    """Friction and lasting contact of each of them in the base run."""
    rubs_of: Callable[[GapOperator, History], tuple[Rub, ...]] = lambda *_: ()
    """The same in another run."""


ROUND_OFF = 1e-9
"""Share of an impulse below which it is the same."""


def is_moved(impulse: float, other: float) -> bool:
    """Whether a run with more modes, by its impulse, is not the same to round-off where something presses.

    Modes that neither loads nor channels excite leave it as it is, and say nothing of those above them.
    """
    return not impulse or abs(other - impulse) > ROUND_OFF * impulse


@dataclass(frozen=True)
class Outcome:
    """What a run found: its events and the figures of the whole run."""

    repeat: Repeat
    events: tuple[Event, ...]
    impulse: float
    """Of all channels over the whole run, force s."""
    energy_created: float
    """By the scheme, share of the external work."""
    dissipated: float
    """By the scheme, share of the external work."""
    steps: int
    end: float
    """Where the run ended, s."""
    wall_s: float
    stopped: str | None = None
    """Why it ended early; None: it did not."""
    places: tuple[dict[str, float], ...] = ()
    """Figures of each place of the base run that is followed."""
    modes: int = 0
    """That the reduced model had."""
    rubs: tuple[Rub, ...] = ()
    """Friction and lasting contact of each place of the base run, and of those that rest."""

    @property
    def force(self) -> float:
        """Largest low-passed force of all events, and of contact that lasts: its mean and amplitude."""
        lasting = (math.sqrt(2.0) * r.force.rms + r.force.mean for r in self.rubs if r.force is not None)
        return max([0.0, *(e.force_place for e in self.events), *lasting])


@dataclass(frozen=True)
class Settling:
    """One figure in every run, and how far it has settled."""

    name: str
    values: dict[str, float]
    """Run -> value, of those that have it."""
    changes: dict[str, float]
    """Family -> change by its last refinement: s for times, share of the last value for all others; nan where one of
    the two runs does not have the figure."""
    limit: float
    problem: str = ""
    """Why it cannot be settled; empty: the changes decide."""
    told: tuple[str, ...] = ()
    """Families that decide nothing."""
    beside: dict[str, float] = field(default_factory=dict)
    """What else changes it, as `changes`, sizes: `UNREDUCED`, `CHANCE`, `BAND`, where they were looked at."""
    floor: float = 0.0
    """What changes are shares of at least."""

    @cached_property
    def sources(self) -> dict[str, float]:
        """What each thing that decides changes of the figure, sizes: `SOURCES`, and what else does."""
        known = {k: abs(x) for k, x in self.changes.items() if k not in self.told}
        if "step" in known and np.isfinite(self.base_error):
            known["step"] = max(known["step"], abs(self.base_error))
        rest = {k: x * (1.0 if self.name in COUNTS and k in IN_TIME else REST.get(k, 1.0)) for k, x in known.items()}
        found = {name: [rest[k] for k in families if k in rest] for name, families in SOURCES.items()}
        sizes = {name: float(np.max(x)) for name, x in found.items() if x}
        of = self.limit / OF_DURATION if self.in_time else 1.0
        unseen = {UNSEEN: LEAST.get(self.name, SMALL) * of} if sizes and self.name not in COUNTS else {}
        return {**sizes, **self.beside, **unseen}

    @property
    def in_time(self) -> bool:
        """Is it a time, whose changes are s?"""
        return self.name in TIMES

    @property
    def settled_to(self) -> float:
        """Sum of the sources, which add (docs/trust.md); nan where one is not known, or where there is none, and of
        what goes on when the run ends."""
        return float(sum(self.sources.values())) if self.sources and self.problem != GOES_ON else np.nan

    @property
    def worst(self) -> str:
        """What of that which decides moves the figure most: a family, or what else does; empty: not known."""
        known = {k: abs(v) for k, v in self.changes.items() if not np.isnan(v) and k not in self.told}
        known |= {k: v for k, v in self.beside.items() if not np.isnan(v)}
        return max(known, key=known.__getitem__) if known else ""

    @property
    def settled(self) -> bool:
        """Do all sources together change it by no more than the limit?"""
        return not self.problem and self.settled_to <= self.limit

    @property
    def base_error(self) -> float:
        """Base run less the finest in time, as `changes`; nan where one of them does not have the figure."""
        return -change(self.name, self.values.get(BASE), self.values.get(FINER, self.values.get(QUARTER)), self.floor)


@dataclass(frozen=True)
class EventSettling:
    """One event of the base run."""

    event: Event
    problem: str
    """Which runs do not have it; empty: all have."""
    figures: dict[str, Settling]

    @property
    def torn(self) -> bool:
        """Could it as well be two, or one with its neighbour? Contact is lost for as long as decides, by the bar."""
        return self.event.margin <= self.figures["start"].settled_to

    @property
    def judged(self) -> bool:
        """Does it count for the verdict? Not where it goes on when the run ends."""
        return not self.event.unfinished

    @property
    def settled(self) -> bool:
        return self.judged and not self.torn and all(f.settled for f in self.figures.values())

    @property
    def moved_in_time(self) -> bool:
        """Is it another one with another resolution in time?"""
        return any(abs(f.changes.get(t, 0.0)) > f.limit for f in self.figures.values() for t in IN_TIME)


@dataclass(frozen=True)
class RubSettling:
    """Friction and lasting contact of one place of the base run."""

    contact: str
    number: int
    """Of the place; 0: it rests."""
    states: dict[str, str]
    """Run -> what friction does there most of the time: stick, stick-slip, sliding."""
    figures: dict[str, Settling]
    deciding: tuple[str, ...]
    """Figures that must settle."""
    turned: tuple[str, ...]
    """Families of those that decide in which the state changes."""
    parted: tuple[str, ...]
    """Families of those that decide in which single slips are others."""
    lasting: bool
    energy: float
    """Largest of all runs that friction took."""

    @property
    def open(self) -> tuple[str, ...]:
        """Figures that must settle and have not."""
        return tuple(name for name in self.deciding if not self.figures[name].settled)

    @property
    def causes(self) -> list[str]:
        """Families that move most what is open."""
        return [*self.turned, *(w for name in self.open if (w := self.figures[name].worst))]

    @property
    def settled(self) -> bool:
        """Single slips may be others."""
        return not (self.turned or self.open)


@dataclass(frozen=True)
class Convergence:
    """What the repeated runs tell of the base run."""

    model: str
    """The run that was repeated: reduced, or reference."""
    outcomes: dict[str, Outcome]
    """By name, the base run first."""
    families: dict[str, tuple[str, str]]
    """Those of `LAST_TWO` that were run."""
    window: tuple[float, float]
    """Events that start in it are compared, s."""
    events: tuple[EventSettling, ...]
    new: dict[str, tuple[Event, ...]]
    """Run -> events of it in the window that the base run does not have."""
    totals: dict[str, Settling]
    """Number of events, impulse and largest low-passed force of the whole run."""
    statistics: dict[str, EventStatistics]
    """Family -> events of its last two runs in the window as samples."""
    exact: bool
    """No scheme was forced: the runs differ from the base run, each in one thing."""
    chaotic: bool
    """So many events part from run to run that single ones need not be the same in two exact solutions."""
    notes: tuple[str, ...]
    places: tuple[dict[str, Settling], ...] = ()
    """Figures of the first places of the base run, as they are ranked, and how far they have settled."""
    structure: Structure | None = None
    """What the unreduced model says; None: nothing was reduced, or nobody asked it."""
    band_ends: tuple[float, str] | None = None
    """Hz up to which loudness is judged, and what ends it in words; None: there is no sound."""
    unlooked: tuple[str, ...] = ()
    """What the reduction may leave out and no repeated run looked at: nothing has settled with regard to it."""
    rubs: tuple[RubSettling, ...] = ()
    """Friction and lasting contact of all its places, as they are ranked, then of what rests."""
    fine: bool = False
    """The study asks for the finest accuracy already."""

    @property
    def complete(self) -> bool:
        """Has the base run all modes that there are? It is the unreduced model then."""
        more = self.outcomes.get(MORE_MODES)
        return more is not None and more.modes == self.outcomes[BASE].modes

    @property
    def finest(self) -> str:
        """The run that is finest in time."""
        return FINER if self.exact else QUARTER

    @cached_property
    def judged(self) -> tuple[EventSettling, ...]:
        """Events that have ended when the run does."""
        return tuple(e for e in self.events if e.judged)

    def settled_events(self, name: str) -> int:
        """How many of them have a figure settled."""
        return sum(e.figures[name].settled for e in self.judged)
