"""Spot checks: some events of the reduced run, marched through again by the unreduced model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.flow.march import FlowStates
from creak.linalg.together import Solver
from creak.progress import Progress
from creak.studies.converge.settling import limit
from creak.studies.models.reduced import FACTOR
from creak.studies.run.job import ReducedRun
from creak.studies.spots.choose import Stretch, affordable, near_channels, stretch
from creak.studies.spots.handover import Handover, ordered, states_at, states_of
from creak.studies.spots.march import Checker, own_figures
from creak.verify.figures import change
from creak.verify.unreduced import Spot, Structure

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
    by these, once, where the rest of that holds it. Of a complete model, where they count for
    nothing (`Structure.complete`), they are not.
    """
    made = [stretch(e, why, of.ends, of.fewest) for e, why in ordered(found, of)]
    order = [s for s in made if s is not None]
    if not order:
        return Structure(why_not="there is no event to check")
    near = near_channels(of.history, of.gaps, order, of.ends)
    rows = near.size + 2 * of.gaps.select(near).rubbing
    taken = affordable(order, rows, of.budget, FEWEST_EVENTS)
    progress("spot checks", 0, 1)
    at = sorted({s.first for s in taken})
    states = states_at(found.setup.marching, of, at)
    spots, solves = _marched(of, taken, near, rows, states, at, progress)
    finer = [s.finer() for s in taken]
    wanted = not (found.reduced.complete or _is_resolved(spots[0]))
    if wanted and len(affordable(finer, rows, of.budget - solves, 0)) == len(finer):
        spots, more = _marched(of, finer, near, rows, states, at, progress)
        solves += more
    first_end = min(e.t_end for e in found.run.events)
    return Structure(tuple(spots), first_end=first_end, solves=solves)


def _marched(
    of: Handover,
    taken: list[Stretch],
    near: IntArray,
    rows: int,
    states: FlowStates,
    at: list[int],
    progress: Progress,
) -> tuple[list[Spot], int]:
    """Each stretch by its steps, finer ones first; the first one of all by half of its steps besides.

    Parameters
    ----------
    rows : right sides that the compliance of the channels `near` takes.
    """
    found: dict[int, tuple[Spot, Stretch]] = {}
    queue, solves, marched = list(enumerate(taken)), 0, 0
    begin = FACTOR + rows
    lengths = {s.parts for s in taken} | {2 * taken[0].parts}
    foreseen = sum(s.steps for s in taken) + 2 * taken[0].steps + len(lengths) * begin

    def counted(more: int) -> None:
        nonlocal marched
        marched += more
        progress("spot checks", min(marched, foreseen - 1), foreseen)

    def checker_of(parts: int) -> Checker:
        checker = Checker(of, parts, near, states.stiffness)
        counted(begin)
        return checker

    def march(checker: Checker, s: Stretch) -> Callable[[Solver], _Seen]:
        """Through it, from its state, which is recovered before: that solves, too, and no two may at once."""
        return partial(_compared, of, checker, s, states_of(of, states, at.index(s.first), s.first))

    while queue:
        parts = max(s.parts for _, s in queue)
        checker = checker_of(parts)
        solves += begin
        here, queue = [x for x in queue if x[1].parts == parts], [x for x in queue if x[1].parts != parts]
        every = checker.side_by_side([march(checker, s) for _, s in here], counted)
        for (k, s), seen in zip(here, every, strict=True):
            solves += seen.steps
            if seen.goes_on and (coarser := seen.stretch.coarser(of.ends.size - 1)) is not None:
                queue.append((k, coarser))
                continue
            unreduced = None if seen.problem else seen.unreduced
            found[k] = Spot(s.event, s.why, seen.reduced or {}, unreduced, None, seen.problem), seen.stretch
    first, s = found[0]
    if first.unreduced is not None:
        checker = checker_of(2 * s.parts)
        (seen,) = checker.side_by_side([march(checker, s.finer())], counted)
        solves += begin + seen.steps
        found[0] = replace(first, numerical=_halving(first, seen.unreduced)), s
    progress("spot checks", foreseen, foreseen)
    return [found[k][0] for k in range(len(taken))], solves


@dataclass(frozen=True)
class _Seen:
    """A march through a stretch."""

    stretch: Stretch
    """As long as it became."""
    unreduced: dict[str, float] | None
    reduced: dict[str, float] | None
    problem: str
    steps: int
    """Of all attempts."""

    @property
    def goes_on(self) -> bool:
        """Does the unreduced model still touch at its end?"""
        return self.unreduced is not None and "duration" not in self.unreduced


def _compared(
    of: Handover, checker: Checker, s: Stretch, begins: tuple[FloatArray, FloatArray], solver: Solver
) -> _Seen:
    """Figures of the event in both models; a stretch at whose end the unreduced one still touches is marched again,
    twice as long."""
    steps = 0
    while True:
        history, problem = checker.through(s, *begins, solver)
        own, steps = own_figures(of, s), steps + s.steps
        problem = problem or ("" if own else "the reduced run has no such event over the stretch alone")
        seen = _Seen(s, checker.figures(s, history), own, problem, steps)
        longer = s.longer(of.ends.size - 1)
        if not seen.goes_on or longer is None:
            return seen
        s = longer


def _is_resolved(spot: Spot) -> bool:
    """Does half the step change little of what the unreduced march finds? So where that was not looked at."""
    lasts = spot.event.t_end - spot.event.t_start
    return all(x <= RESOLVED * limit(name, lasts) for name, x in (spot.numerical or {}).items())


def _halving(spot: Spot, finer: dict[str, float] | None) -> dict[str, float] | None:
    """What half the step changes: s for times, shares else."""
    if spot.unreduced is None or finer is None:
        return None
    both = {name: change(name, x, finer.get(name)) for name, x in spot.unreduced.items()}
    return {name: abs(x) for name, x in both.items() if np.isfinite(x)}
