"""Which events are checked, over which stretch of time, by which steps, and what that costs."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.studies.findings.places import Place
from creak.verify.events import Event

SHARE = 0.2
"""Of the cost of the reduction that the checks may take."""
FEWEST = 5e7
"""Back-substitutions times unknowns that they may take in any case: ten seconds or so."""
STEP = 2_500
"""Unknowns whose back-substitution takes as long as the rest of a contact step (0.3 ms)."""
EACH = 8
"""Most checks of each place, as far as the cost allows: the spread of eight is known to within a quarter."""
STEPS = 30
"""Of an event, the fewest: the impulse of a half sine is then within 3e-3, its duration within one step."""
ENOUGH = 64
"""Times STEPS: more in its longest touch are of no use."""
FINEST = 64
"""Most parts of a step of the default length."""
LEAD = 5
"""Steps before the event at the least."""
AFTER = 0.5
"""Of the duration of an event that is marched behind it."""
NEARLY = 0.5
"""Of what a gap changes in the run: channels that come as near in a stretch may touch in it."""
LONGEST = 60
"""Times STEPS: most steps of a stretch; longer contact is checked over a part of it."""
COARSEST = 16
"""Times the default length: longest steps by which an event is held within that."""


AnySpan = TypeVar("AnySpan", bound="Span")


@dataclass(frozen=True)
class Span:
    """A piece of a run, and the steps that go through it."""

    first: int
    """Flight step at whose end it begins."""
    parts: int
    """Of a flight step."""
    steps: int
    """Of that length."""

    def time(self, ends: FloatArray) -> tuple[float, float]:
        """Beginning and end, s; `ends` (n_step + 1,) of the flight steps."""
        begin, h = float(ends[self.first]), float(ends[1] - ends[0]) / self.parts
        return begin, begin + self.steps * h


@dataclass(frozen=True)
class Stretch(Span):
    """An event, and the steps of its check."""

    event: Event
    why: str

    def finer(self) -> Stretch:
        """The same by steps of half the length."""
        return replace(self, parts=2 * self.parts, steps=2 * self.steps)

    def longer(self, n_step: int) -> Stretch | None:
        """Twice as long, or as long as it may be in a run of so many flight steps; None: it is."""
        steps = min(2 * self.steps, LONGEST * STEPS, (n_step - self.first) * self.parts)
        return replace(self, steps=steps) if steps > self.steps else None

    def coarser(self, n_step: int) -> Stretch | None:
        """Four times as long by steps that are four times as long; None: the run ends before, or a step is a part."""
        parts = self.parts // 4
        steps = min(self.steps, (n_step - self.first) * parts)
        return replace(self, parts=parts, steps=steps) if steps * self.parts > self.steps * parts else None


def stretch(event: Event, why: str, ends: FloatArray, fewest: int) -> Stretch | None:
    """From a little before an event to half its length after it; None where the run begins with it.

    Parameters
    ----------
    ends : (n_step + 1,) of the flight steps, s. fewest : parts of a flight step by default.
    """
    H, lasts = ends[1] - ends[0], event.t_end - event.t_start
    longest = max((end - begin for begin, end in event.touches), default=lasts)
    parts = parts_through(lasts, H, fewest, STEPS)
    while parts > 1 and longest * parts > ENOUGH * STEPS * H:
        parts //= 2
    while True:
        made, wanted = stretch_of(event, why, ends, parts)
        if wanted <= LONGEST * STEPS or parts * COARSEST < 2 * fewest or parts < 2:
            return made
        parts //= 2


def parts_through(lasts: float, H: float, fewest: int, steps: int) -> int:
    """Parts of a flight step H (s) by which what lasts so long (s) takes so many steps: `FINEST` times the default,
    `fewest`, at the most."""
    parts = fewest
    while parts < FINEST * fewest and steps * H / parts > lasts:
        parts *= 2
    return parts


def stretch_of(
    event: Event, why: str, ends: FloatArray, parts: int, most: int = LONGEST * STEPS
) -> tuple[Stretch | None, int]:
    """The same by given parts of a flight step; and the steps that it would take, of which `most` may be taken."""
    H, lasts = ends[1] - ends[0], event.t_end - event.t_start
    first = int(np.searchsorted(ends, event.t_start - LEAD * H / parts, side="right")) - 1
    if first < 0:
        return None, 0
    wanted = math.ceil((event.t_end + AFTER * lasts - ends[first]) / H * parts)
    steps = min(wanted, most, (ends.size - 1 - first) * parts)
    return Stretch(first, parts, steps, event, why), wanted


def chosen(
    events: Sequence[Event], places: Sequence[Place], gaps: GapOperator, seed: int, each: int = EACH
) -> list[tuple[Event, str]]:
    """Events in the order in which they are checked: the hardest of each place, then others, drawn at random.

    An event is at the place of its hardest channel. Places are those of the verification window: what touches at none
    of them is taken by contact and side.
    """
    draw, rounds = np.random.default_rng(seed), list[list[tuple[Event, str]]]([[] for _ in range(each)])
    at = {(gaps.group[j], gaps.names[j]): p.number for p in places for j in p.channels.tolist()}
    groups: dict[Hashable, list[Event]] = {}
    for e in events:
        groups.setdefault(at.get((e.group, e.channel), (e.group, e.side)), []).append(e)
    for own in groups.values():
        by_force = sorted(own, key=lambda e: (-e.force_place, e.t_start))
        rounds[0].append((by_force[0], "hardest"))
        others = by_force[1:]
        for j, i in enumerate(draw.permutation(len(others))[: each - 1].tolist(), start=1):
            rounds[j].append((others[i], "drawn"))
    return [one for row in rounds for one in row]


def near_channels(history: History, gaps: GapOperator, stretches: Sequence[Span], ends: FloatArray) -> IntArray:
    """Channels that press in one of the stretches, or come near to it (`NEARLY`)."""
    low = np.full(gaps.m, np.inf)
    for s in stretches:
        rows = slice(*np.searchsorted(history.time, s.time(ends)))
        low = np.minimum(low, history.gap[rows].min(axis=0, initial=np.inf))
    return np.flatnonzero(low <= NEARLY * np.ptp(history.gap, axis=0)).astype(np.int64)


@dataclass(frozen=True)
class Price:
    """What checks take: back-substitutions of the whole model, or what costs as much."""

    once: float
    """All of them together, whatever they are."""
    length: float
    """Those by steps of one length."""
    span: float
    """Each."""
    step: float
    """Each step."""


def affordable(order: Sequence[AnySpan], price: Price, budget: float, least: int) -> list[AnySpan]:
    """As many, in order, as the budget holds beside what they cost once; `least` of them whatever they cost."""
    taken, lengths, spent = list[AnySpan](), set[int](), 0.0
    for s in order:
        more = price.span + price.step * s.steps + (0.0 if s.parts in lengths else price.length)
        if len(taken) >= least and spent + more > budget:
            continue
        taken.append(s)
        lengths.add(s.parts)
        spent += more
    return taken
