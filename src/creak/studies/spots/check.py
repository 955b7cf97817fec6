"""Spot checks: some events of the reduced run, marched through again by the unreduced model."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.flight.contact_steps import fewest_parts
from creak.dynamics.flow.march import FlowStates, flow_states
from creak.progress import Progress
from creak.studies.converge.figures import change
from creak.studies.converge.structure import Spot, Structure
from creak.studies.models.reduced import ReducedModel
from creak.studies.prepare.flight_steps import RESOLUTIONS
from creak.studies.results.places import find_places
from creak.studies.run.compared import event_statistics
from creak.studies.run.integrate import flowing, resolution_of
from creak.studies.run.job import StudyResult
from creak.studies.run.kernels import needs_solver
from creak.studies.spots.choose import (
    FACTOR,
    FEWEST,
    OF_A_MODE,
    SHARE,
    Stretch,
    affordable,
    chosen,
    near_channels,
    stretch,
)
from creak.studies.spots.march import Checker, Handover, own_figures, states_of
from creak.studies.warned import attempted

SEED = 1
"""Of the events that are drawn."""
LEAST = 3
"""Events that are checked whatever they cost."""


def beside_unreduced(result: StudyResult, progress: Progress, notes: list[str]) -> Structure | None:
    """What the unreduced model says of a run: by spot checks, and by its own run where there is one.

    None: nothing was reduced. A failure of the checks leaves them out and becomes a note that warns.
    """
    if "reduced" not in result.runs:
        return None
    found = Structure(why_not='[reference] run = "none"')
    if result.setup.study.config.proof != "none":
        failed = Structure(why_not="they could not be made")
        found = attempted("spot checks", lambda: check_spots(result, progress), failed, notes)
    samples = None if result.events is None else event_statistics(result)
    return found.beside(result.events, samples)


def check_spots(result: StudyResult, progress: Progress) -> Structure:
    """March the unreduced model through the hardest event of each place of the reduced run and some drawn ones.

    It takes over displacement and velocity of the reduced model a little before the event, under the same loads, and
    goes through it in condensed contact steps of its own (generalised-alpha, rho_inf = 0), `choose.STEPS` to an event
    at the least, with the contact springs of the reduced run. What differs is the error of the reduction in that event.
    What earlier events had left in modes that the reduced model lacks is not in its state: that is what repeats with
    more modes tell. For the hardest event the steps are halved once: what that changes is the error of the unreduced
    march itself.

    As many are checked as cost a fifth of the reduction (`choose.SHARE`, `choose.FEWEST`), counted in
    back-substitutions, so that the same input makes the same checks; `LEAST` at any cost.
    """
    started = clock.perf_counter()
    of, why = _handover(result)
    if of is None or result.reduced is None:
        return Structure(why_not=why)
    order = _stretches(result, of)
    if not order:
        return Structure(why_not="there is no event to check")
    near = near_channels(of.history, of.gaps, order, of.ends)
    rows = near.size + 2 * of.gaps.select(near).rubbing
    taken = affordable(order, rows, max(FEWEST, SHARE * _cost(result.reduced)), LEAST)
    progress("spot checks", 0, len(taken) + 1)
    at = sorted({s.first for s in taken})
    setup = result.setup
    states = flow_states(of.reduced, of.gaps, of.loads, at, resolution=resolution_of(setup), solver=needs_solver(setup))
    spots, solves = _marched(of, taken, near, states, at, progress)
    return Structure(tuple(spots), solves=solves, wall_s=clock.perf_counter() - started)


def _marched(
    of: Handover, taken: list[Stretch], near: IntArray, states: FlowStates, at: list[int], progress: Progress
) -> tuple[list[Spot], int]:
    """Each stretch by its steps, finer ones first; the first one of all by half of its steps besides."""
    found: dict[int, tuple[Spot, Stretch]] = {}
    queue, solves = list(enumerate(taken)), 0

    def through(checker: Checker, s: Stretch) -> _Seen:
        return _compared(of, checker, s, states_of(of, states, at.index(s.first), s.first))

    while queue:
        parts = max(s.parts for _, s in queue)
        checker = Checker(of, parts, near, states.stiffness)
        solves += FACTOR + checker.rows
        here, queue = [x for x in queue if x[1].parts == parts], [x for x in queue if x[1].parts != parts]
        for k, s in here:
            seen = through(checker, s)
            solves += seen.steps
            if seen.goes_on and (coarser := seen.stretch.coarser(of.ends.size - 1)) is not None:
                queue.append((k, coarser))
                continue
            unreduced = None if seen.problem else seen.unreduced
            found[k] = Spot(s.event, s.why, seen.reduced or {}, unreduced, None, seen.problem), seen.stretch
            progress("spot checks", len(found), len(taken) + 1)
    first, s = found[0]
    if first.unreduced is not None:
        checker = Checker(of, 2 * s.parts, near, states.stiffness)
        seen = through(checker, replace(s, parts=2 * s.parts, steps=2 * s.steps))
        solves += FACTOR + checker.rows + seen.steps
        found[0] = replace(first, numerical=_halving(first, seen.unreduced)), s
    progress("spot checks", len(taken) + 1, len(taken) + 1)
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


def _compared(of: Handover, checker: Checker, s: Stretch, begins: tuple[FloatArray, FloatArray]) -> _Seen:
    """Figures of the event in both models; a stretch at whose end the unreduced one still touches is marched again,
    twice as long."""
    steps = 0
    while True:
        history, problem = checker.through(s, *begins)
        own, steps = own_figures(of, s), steps + s.steps
        problem = problem or ("" if own else "the reduced run has no such event over the stretch alone")
        seen = _Seen(s, checker.figures(s, history), own, problem, steps)
        longer = s.longer(of.ends.size - 1)
        if not seen.goes_on or longer is None:
            return seen
        s = longer


def _halving(spot: Spot, finer: dict[str, float] | None) -> dict[str, float] | None:
    """What half the step changes: s for times, shares else."""
    if spot.unreduced is None or finer is None:
        return None
    both = {name: change(name, x, finer.get(name)) for name, x in spot.unreduced.items()}
    return {name: abs(x) for name, x in both.items() if np.isfinite(x)}


def _handover(result: StudyResult) -> tuple[Handover | None, str]:
    """What the checks need, or why there are none."""
    setup, run, reduced = result.setup, result.runs.get("reduced"), result.reduced
    c = setup.study.config
    if run is None or reduced is None:
        return None, "nothing was reduced"
    if not c.time.exact:
        return None, "a scheme was forced, which the unreduced model does not share"
    if run.stopped is not None or result.stopped is not None:
        return None, "the run was stopped"
    if result.reference.of_parts is not None:
        return None, "memory does not hold a factor of the whole model"
    system, why = flowing(reduced.system)
    if system is None:
        return None, f"the reduced model was not marched by exact flow{why}"
    v = c.verification
    unreduced = result.reference.system
    if np.any(unreduced.coordinates < 0):
        return None, "parts of the model are superelements from files, whose inside is not there"
    handover = Handover(unreduced, system, result.gaps, setup.loads, run.history, v.merge, v.f_max)
    return handover, ""


def _stretches(result: StudyResult, of: Handover) -> list[Stretch]:
    """Of the events of each place, in the order in which they are checked."""
    run = result.runs["reduced"]
    fewest = fewest_parts(RESOLUTIONS[result.setup.study.config.time.accuracy].stepped)
    order = chosen(run.events, find_places(result, run), of.gaps, SEED)
    made = [stretch(e, why, of.ends, fewest) for e, why in order]
    return [s for s in made if s is not None]


def _cost(reduced: ReducedModel) -> float:
    """Back-substitutions of the whole model that the reduction is worth."""
    return FACTOR + reduced.retained + OF_A_MODE * reduced.modes
