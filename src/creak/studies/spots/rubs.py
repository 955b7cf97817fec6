"""Pieces of rubbing and of lasting contact, marched through again by the unreduced model."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.linalg.together import Solver
from creak.studies.findings.places import Place, resting_places
from creak.studies.run.job import ReducedRun
from creak.studies.spots.choose import LONGEST, STEPS, Span, Stretch, affordable, near_channels, parts_through, stretch
from creak.studies.spots.handover import SEED, Handover, states_at
from creak.studies.spots.march import Marched, within
from creak.studies.spots.nearby import AnyChecker, checker_of, price_of
from creak.verify.rubbing import STICK_SLIP, rub_of
from creak.verify.unreduced import RubSpot

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
