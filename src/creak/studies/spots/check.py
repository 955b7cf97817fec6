"""Spot checks: some events of the reduced run, and pieces of its rubbing and lasting contact, marched through again by
the unreduced model."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.linalg.together import Solver
from creak.progress import Progress
from creak.studies.converge.auto_band import PROOF
from creak.studies.converge.settling import limit
from creak.studies.findings.places import Place, resting_places
from creak.studies.prepare.marching import Marching
from creak.studies.run.job import ReducedRun
from creak.studies.spots.choose import (
    LONGEST,
    STEPS,
    Price,
    Span,
    Stretch,
    affordable,
    near_channels,
    parts_through,
    stretch,
)
from creak.studies.spots.handover import SEED, Begins, Handover, ordered, states_at
from creak.studies.spots.march import Marched, figures_over, own_figures, within
from creak.studies.spots.nearby import AnyChecker, checker_of, price_of
from creak.verify.events import Event
from creak.verify.matching import FIGURES, change
from creak.verify.rubbing import STICK_SLIP, rub_of
from creak.verify.unreduced import RubSpot, Spot, Structure, surely

FEWEST_EVENTS = 3
"""Events that are checked whatever they cost."""
RESOLVED = 0.2
"""Of what the verdict lets a figure move by, that half a contact step may change."""


def check_spots(found: ReducedRun, of: Handover, progress: Progress) -> Structure:
    """March the unreduced model through the hardest event of each place of the reduced run and some drawn ones.

    It takes over displacement and velocity of the reduced model a little before the event, under the same loads, and
    goes through it in condensed contact steps of its own (generalised-alpha, rho_inf = 0), `choose.STEPS` to an event
    at the least, with the contact springs of the reduced run. What differs is the error of the reduction in that event.
    What earlier events had left in modes that the reduced model lacks is not in its state: that is what repeats with
    more modes tell. For the hardest event the steps are halved once: what that changes is the error of the unreduced
    march itself.

    As many are checked as cost a fifth of the reduction (`choose.SHARE`, `choose.FEWEST`), counted in
    back-substitutions, so that the same input makes the same checks; `FEWEST_EVENTS` at any cost. Where half the steps
    change the hardest event by more than a part (`RESOLVED`) of what the verdict lets it move by, all are marched again
    by these, once, where the rest of that holds it. Where what leaves the other events open is that so few were looked
    at (`_few_decide`), as many again are checked, once, for as much again. Of a complete model, where they count for
    nothing (`Structure.complete`), neither is done, and no more than `FEWEST_EVENTS` are checked.
    """
    made = [stretch(e, why, of.ends, of.fewest) for e, why in ordered(found, of)]
    order = [s for s in made if s is not None]
    if not order:
        return Structure(why_not="there is no event to check")
    near = near_channels(of.history, of.gaps, order, of.ends)
    price = price_of(of, near.size + 2 * of.gaps.select(near).rubbing)
    taken = affordable(order, price, of.budget - price.once, FEWEST_EVENTS)
    taken = taken[:FEWEST_EVENTS] if found.reduced.complete else taken
    marched = partial(_marched, of, found.marching, near, price, progress)
    spots, solves = marched(taken)
    solves += price.once
    if not found.reduced.complete:
        others, finer = [s for s in order if s not in taken], [s.finer() for s in taken]
        if not _is_resolved(spots[0]) and len(affordable(finer, price, of.budget - solves, 0)) == len(finer):
            spots, more = marched(finer)
            solves, others = solves + more, [s.finer() for s in others]
        again = affordable(others, price, of.budget, 0)[: len(taken)]
        if again and _few_decide(spots, [s.event for s in again]):
            further, more = marched(again, halved=False)
            spots, solves = [*spots, *further], solves + more
    first_end = min(e.t_end for e in found.run.events)
    return Structure(tuple(spots), first_end=first_end, solves=round(solves))


def _few_decide(spots: list[Spot], others: list[Event]) -> bool:
    """Does what the hardest of the events that were not looked at may be off by fill more than its part (`PROOF`) of
    what the verdict lets it, and would all of it do if they were, with differences that are alike?"""
    n = sum(not s.problem for s in spots)
    if n == 0:
        return False
    known, hardest = Structure(tuple(spots)), max(others, key=lambda e: e.force_place)
    filled = np.nanmax([known.spread(name, hardest) / limit(name, 1.0) for name in FIGURES])
    return bool(PROOF < filled <= surely(n) / surely(n + len(others)))


def _marched(
    of: Handover,
    marching: Marching,
    near: IntArray,
    price: Price,
    progress: Progress,
    taken: list[Stretch],
    *,
    halved: bool = True,
) -> tuple[list[Spot], float]:
    """Each stretch by its steps, finer ones first; the first one of all by half of its steps besides.

    Parameters
    ----------
    halved : whether the first one is.
    """
    progress("states before the events", 0, 1)
    states = states_at(marching, of, taken)
    progress("states before the events", 1, 1)
    found: dict[int, tuple[Spot, Stretch]] = {}
    queue, solves, marched = list(enumerate(taken)), 0.0, 0
    begin = round(price.length)
    ahead = [*taken, taken[0].finer()] if halved else taken
    foreseen = sum(s.steps for s in ahead) + len({s.parts for s in ahead}) * begin

    def counted(more: int) -> None:
        nonlocal marched
        marched += more
        progress("spot checks", min(marched, foreseen - 1), foreseen)

    def made(parts: int) -> AnyChecker:
        nonlocal solves
        checker = checker_of(of, parts, near)
        solves += begin
        counted(begin)
        return checker

    def march(checker: AnyChecker, s: Stretch) -> Callable[[Solver | None], _Seen]:
        """Through it, from its state."""

        def through(solver: Solver | None) -> _Seen:
            seen = _compared(of, checker, s, states.begins[s.first], solver)
            counted(s.steps if solver is None else 0)  # else who solves counts
            return seen

        return through

    while queue:
        parts = max(s.parts for _, s in queue)
        checker = made(parts)
        here, queue = [x for x in queue if x[1].parts == parts], [x for x in queue if x[1].parts != parts]
        every = checker.side_by_side([march(checker, s) for _, s in here], counted)
        for (k, s), seen in zip(here, every, strict=True):
            solves += seen.solves
            if seen.goes_on and (coarser := seen.stretch.coarser(of.ends.size - 1)) is not None:
                queue.append((k, coarser))
                continue
            unreduced = None if seen.problem else seen.unreduced
            border = _change(unreduced, seen.narrow)
            found[k] = Spot(s.event, s.why, seen.reduced or {}, unreduced, None, seen.problem, border), seen.stretch
    first, s = found[0]
    if halved and first.unreduced is not None:
        checker = made(2 * s.parts)
        (seen,) = checker.side_by_side([march(checker, s.finer())], counted)
        solves += seen.solves
        found[0] = replace(first, numerical=_change(first.unreduced, seen.unreduced)), s
    progress("spot checks", foreseen, foreseen)
    return [found[k][0] for k in range(len(taken))], solves


@dataclass(frozen=True)
class _Seen:
    """A march through a stretch."""

    stretch: Stretch
    """As long as it became."""
    unreduced: dict[str, float] | None
    narrow: dict[str, float] | None
    """The same where fewer dofs move by themselves."""
    reduced: dict[str, float] | None
    problem: str
    solves: float
    """Back-substitutions of all attempts."""

    @property
    def goes_on(self) -> bool:
        """Does the unreduced model still touch at its end?"""
        return self.unreduced is not None and "duration" not in self.unreduced


def _compared(of: Handover, checker: AnyChecker, s: Stretch, begins: Begins, solver: Solver | None) -> _Seen:
    """Figures of the event in both models; a stretch at whose end the unreduced one still touches is marched again,
    twice as long."""
    solves, channels = 0.0, of.channels(s.event)
    while True:
        marched = checker.through(s, begins, channels, solver)
        own, solves = own_figures(of, s), solves + marched.solves
        problem = marched.problem or ("" if own else "the reduced run has no such event over the stretch alone")
        figures = figures_over(s.event, marched.history, marched.gaps, of)
        narrow = None if (m := marched.narrow) is None else figures_over(s.event, m.history, m.gaps, of)
        seen = _Seen(s, figures, narrow, own, problem, solves)
        longer = s.longer(of.ends.size - 1)
        if not seen.goes_on or longer is None:
            return seen
        s = longer


def _is_resolved(spot: Spot) -> bool:
    """Does half the step change little of what the unreduced march finds? So where that was not looked at."""
    lasts = spot.event.t_end - spot.event.t_start
    return all(x <= RESOLVED * limit(name, lasts) for name, x in (spot.numerical or {}).items())


def _change(figures: dict[str, float] | None, other: dict[str, float] | None) -> dict[str, float] | None:
    """By how much others are off: s for times, shares else."""
    if figures is None or other is None:
        return None
    both = {name: change(name, x, other.get(name)) for name, x in figures.items()}
    return {name: abs(x) for name, x in both.items() if np.isfinite(x)}


SLIPS = 8
"""In a piece of stick-slip."""
TOUCH, CHATTER = 8.0, 0.05
"""Steps in a touch, and share of the time in contact that may go by in shorter ones."""
OF_SLIP = 2 * STEPS
"""Of a median slip, the fewest: its work is off by the first power of the step."""
STUCK = 4.0
"""Median slips of a long stick before and after them."""
ENOUGH = 100
"""Steps through steady sliding and resting contact."""
EACH = 3
"""Pieces of each place, as far as the cost allows."""


@dataclass(frozen=True)
class Piece(Span):
    """Of a place that rubs, or that something presses on for the whole time."""

    place: Place


def check_rubs(run: ReducedRun, places: Sequence[Place], of: Handover) -> tuple[tuple[RubSpot, ...], int]:
    """March the unreduced model through pieces of rubbing and of lasting contact, drawn by the stored seed.

    It takes over displacement, velocity and friction forces of the reduced model; what rubs begins as stuck, and slips
    from the first step on where the limit asks for it. A piece holds `SLIPS` slips, or as many as their steps allow, or
    an event; where nothing slips by turns nor hits it has `ENOUGH` steps of the default length. They may cost what
    events may (`Handover.budget`), the first of all at any cost; how many back-substitutions they took is told.

    Parameters
    ----------
    places : of the reduced run, numbered as they are told. Of a complete model one piece of each is marched.
    """
    window, places = run.scope.window, [p for p in (*places, *resting_places(run.scope, run.run)) if p.rub.figures]
    draw, order = np.random.default_rng(SEED), list[Piece]()
    for _ in range(1 if run.reduced.complete else EACH):
        order += [x for p in places if (x := _piece(p, of.ends, of.fewest, window, draw.random())) is not None]
    if not order:
        return (), 0
    near = near_channels(of.history, of.gaps, order, of.ends)
    price = price_of(of, near.size + 2 * of.gaps.select(near).rubbing)
    taken = affordable(order, price, of.budget - price.once, 1)
    states = states_at(run.marching, of, taken)
    checkers = {n: checker_of(of, n, near) for n in sorted({p.parts for p in taken})}

    def march(checker: AnyChecker, p: Piece) -> Callable[[Solver | None], Marched]:
        return partial(checker.through, p, states.begins[p.first], p.place.channels)

    marched: dict[int, Marched] = {}
    for parts, checker in checkers.items():
        own_pieces = [k for k, p in enumerate(taken) if p.parts == parts]
        several = checker.side_by_side([march(checker, taken[k]) for k in own_pieces])
        marched.update(zip(own_pieces, several, strict=True))
    found = []
    for k, p in enumerate(taken):
        reduced = within(of.history, p.time(of.ends))
        if reduced.time.size < 2:
            continue  # nothing happens in it
        window = float(reduced.time[0]), float(reduced.time[-1])  # between these all is known
        m = marched[k]
        here = np.flatnonzero(np.isin(m.channels, p.place.channels))
        own = rub_of(reduced, of.gaps, p.place.channels, window, of.f_max).figures
        other = rub_of(within(m.history, window), m.gaps, here, window, of.f_max).figures
        found.append(RubSpot(p.place.contact, p.place.number, window, own, other, m.problem))
    begin = price.once + len(checkers) * price.length
    return tuple(found), round(sum(m.solves for m in marched.values()) + begin)


def _piece(place: Place, ends: FloatArray, fewest: int, window: tuple[float, float], at: float) -> Piece | None:
    """The event, slips or stretch of time at the share `at` of all; None where the window does not hold it, or no steps
    follow it."""
    H, friction = float(ends[1] - ends[0]), place.rub.friction
    last, parts = min(window[1], float(ends[-1])), fewest
    squeaks = friction is not None and friction.state == STICK_SLIP
    if place.events and place.rub.force is None and not squeaks:
        s = stretch(place.events[int(at * len(place.events))], "", ends, fewest)
        return None if s is None else _of_event(s, H, place)
    if friction is not None and friction.rate is not None:
        parts = parts_through(float(np.median([end - begin for begin, end in friction.slips])), H, fewest, OF_SLIP)
        begin, end = _slips(friction.slips, (window[0], last), at, LONGEST * STEPS * H / parts)
        while parts > 1 and (end - begin) * parts > LONGEST * STEPS * H:
            parts //= 2
    else:
        lasts = ENOUGH * H / fewest
        begin = window[0] + at * (last - lasts - window[0])
        end = begin + lasts
    if begin < window[0]:
        return None
    first = max(0, int(np.searchsorted(ends, begin, side="right")) - 1)
    steps = min(LONGEST * STEPS, math.ceil((end - begin) / H * parts), (ends.size - 1 - first) * parts)
    return Piece(first, parts, steps, place)


def _of_event(s: Stretch, H: float, place: Place) -> Piece | None:
    """By half the steps that an event needs, or finer ones: its touches rub, and the steps are to follow them; H (s) of
    a flight step. Touches that chatter are held together by steps that do not, and rub for longer."""
    lasts = np.array([end - begin for begin, end in s.event.touches])
    s = s.finer()
    while lasts[lasts < TOUCH * H / s.parts].sum() > CHATTER * lasts.sum():
        if 2 * s.steps > LONGEST * STEPS:
            return None
        s = s.finer()
    return Piece(s.first, s.parts, s.steps, place)


def _slips(
    slips: Sequence[tuple[float, float]], window: tuple[float, float], at: float, longest: float
) -> tuple[float, float]:
    """From one stick to another, `SLIPS` slips later or as many as fit into `longest`.

    A slip that is cut tells more of when it begins than of what it takes. From long sticks `STUCK` slips are taken.
    """
    starts, ends = np.array(slips).T
    half = 0.5 * np.append(starts[1:] - ends[:-1], np.median(starts[1:] - ends[:-1]))
    stick = np.minimum(half, STUCK * np.median(ends - starts))
    begins = np.maximum(window[0], starts - np.append(stick[-1], stick[:-1]))
    stops = np.minimum(window[1], ends + stick)
    count, fits = min(SLIPS, len(slips)), np.arange(0)
    while fits.size == 0:
        lasts = stops[count - 1 :] - begins[: begins.size - count + 1]
        fits, count = np.flatnonzero((lasts <= longest) | (count == 1)), count - 1
    k = int(fits[int(at * fits.size)])
    return float(begins[k]), float(stops[k + count])
