"""What is followed of every event from run to run, and how far it has settled: records and their rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.studies.prepare.setup import Setup
from creak.verify.events import Event
from creak.verify.rubbing import Rub
from creak.verify.statistics import EventStatistics

SETTLED = 0.05
"""Low-passed force, impulse and closing speed are settled when the last refinement of every family changes them by no
more than this share: the 5 % within which the thesis calls an amplitude right (3.7.3)."""
ENOUGH = 0.95
"""Share of the events that are to be settled in every figure."""
TIME_SHARE = 0.1
"""Start and duration are settled when the last refinement of every family moves them by no more than this share of the
verification's `event_tolerance`, so that what is left cannot decide whether two events are the same one."""
OF_RESOLUTION = 0.1
"""Share of that by which the resolution of contact in time may move them; the rest is for stiffness and modes, which
the model sets: the last of several micro-contacts of an event is theirs."""
BASE, HALF, QUARTER = "base", "h/2", "h/4"
TWICE, TENFOLD, MORE_MODES = "2 x stiffness", "10 x stiffness", "1.5 x f_max"
FINER, SOFTER, STIFFER = "half the tolerance", "half the stiffness", "twice the stiffness"
LAST_TWO = {
    "step": (HALF, QUARTER),
    "stiffness": (TWICE, TENFOLD),
    "tolerance": (BASE, FINER),
    "softer": (BASE, SOFTER),
    "stiffer": (BASE, STIFFER),
    "modes": (BASE, MORE_MODES),
}
"""Family -> the two runs whose difference tells how far it has settled; the first two are those of a forced step."""
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
IN_TIME = ("tolerance", "step")
"""Families that change the resolution in time alone."""
TIMES = ("start", "duration")
"""Figures whose changes are absolute, s; those of the others are shares."""


@dataclass(frozen=True)
class Variant:
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
    f_max: float | None = None
    """Hz, of the reduction; None: the model is not reduced."""
    judged: bool = True
    """False: a figure that the study gives is varied; what that changes is told, and nothing is unsettled by it."""


@dataclass(frozen=True)
class Followed:
    """Places of the base run that are looked for in the repeated ones."""

    base: tuple[dict[str, float], ...] = ()
    """`OF_PLACE` of each in the base run; figures that are not known are left out."""
    of: Callable[[Setup, System, GapOperator, History], tuple[dict[str, float], ...]] = lambda *_: ()
    """The same in another run."""
    rub_names: tuple[tuple[str, int], ...] = ()
    """Contact and number of each place that is looked for as one that rubs; 0: it rests."""
    rubs: tuple[Rub, ...] = ()
    """Friction and lasting contact of each of them in the base run."""
    rubs_of: Callable[[Setup, GapOperator, History], tuple[Rub, ...]] = lambda *_: ()
    """The same in another run."""


@dataclass(frozen=True)
class Outcome:
    """What a run found: its events and the figures of the whole run."""

    variant: Variant
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
    rubs: tuple[Rub, ...] = ()
    """Friction and lasting contact of each place of the base run, and of those that rest."""

    @property
    def force(self) -> float:
        """Largest low-passed force of all events."""
        return max((e.force_place for e in self.events), default=0.0)


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
    floor: float = 0.0
    """What changes are shares of at least."""

    @property
    def settled_to(self) -> float:
        """Largest change of all families; nan where one of them is not known, or where there is none."""
        return float(np.max(np.abs(list(self.changes.values())))) if self.changes else np.nan

    @property
    def worst(self) -> str:
        """The family of those that decide that moves the figure most; empty where that is not known."""
        known = {k: abs(v) for k, v in self.changes.items() if not np.isnan(v) and k not in self.told}
        return max(known, key=known.__getitem__) if known else ""

    @property
    def settled(self) -> bool:
        """The last refinements agree, and so do the base run and the finest one."""
        changes = all(abs(x) <= self.limit_of(family) for family, x in self.changes.items() if family not in self.told)
        return not self.problem and bool(self.changes) and changes and not abs(self.base_error) > self.limit

    def limit_of(self, family: str) -> float:
        """What a family may move the figure by."""
        return OF_RESOLUTION * self.limit if self.name in TIMES and family == "tolerance" else self.limit

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
    def settled(self) -> bool:
        return all(f.settled for f in self.figures.values())

    @property
    def moved_in_time(self) -> bool:
        """Is it another one with another resolution in time?"""
        return any(abs(f.changes.get(t, 0.0)) > f.limit_of(t) for f in self.figures.values() for t in IN_TIME)


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
    new: dict[str, int]
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
    rubs: tuple[RubSettling, ...] = ()
    """Friction and lasting contact of all its places, as they are ranked, then of what rests."""

    @property
    def finest(self) -> str:
        """The run that is finest in time."""
        return FINER if self.exact else QUARTER

    def settled_events(self, name: str) -> int:
        """How many events have a figure settled."""
        return sum(e.figures[name].settled for e in self.events)


def change(name: str, before: float | None, after: float | None, floor: float = 0.0) -> float:
    """after - before (times, s) or that over |after| (or a floor); inf: something becomes nothing; nan: unknown."""
    if before is None or after is None:
        return np.nan
    if name in TIMES or after == before:
        return after - before
    scale = max(abs(after), floor)
    return (after - before) / scale if scale else np.inf
