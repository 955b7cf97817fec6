"""What the unreduced model says of a run: by spot checks, and by its own run where there is one."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from creak.dynamics.flight.contact_steps import steps_in_contact
from creak.linalg.together import Solver
from creak.progress import Progress
from creak.studies.converge.settling import LEAST
from creak.studies.findings.places import Place
from creak.studies.models.reference import ReferenceModel
from creak.studies.run.integrate import flowing
from creak.studies.run.job import ReducedRun, StudyResult
from creak.studies.spots.check import FEWEST_EVENTS, check_rubs, check_spots
from creak.studies.spots.choose import Stretch, near_channels, stretch_of
from creak.studies.spots.handover import Handover, handed_over, ordered, states_at
from creak.studies.spots.march import Checker, Marched, figures_over
from creak.studies.warned import attempted
from creak.verify.matching import TIMES, change
from creak.verify.unreduced import MOVED, RubSpot, Structure

FAILED = Structure(why_not="they could not be made")
FALLS = 2.0
"""Times what half a contact step changes: all that smaller ones would."""
FLIGHT = 5e-3
"""What the flight steps between the touches of an event change, which are not halved: .4 to .7 % of the impulse of
blows of several touches (two strips)."""


def beside_unreduced(
    result: StudyResult, places: Sequence[Place], progress: Progress, notes: list[str]
) -> Structure | None:
    """What the unreduced model says of a run: by spot checks, and by its own run where there is one.

    None: nothing was reduced. A failure of the checks leaves them out and becomes a note that warns.

    Parameters
    ----------
    places : of the reduced run, numbered as they are told.
    """
    run = result.band
    if run is None:
        return None
    found = Structure(why_not='[reference] run = "none"')
    if result.setup.study.config.proof != "none":
        if result.stopped is not None:
            found = Structure(why_not="the run was stopped")
        else:
            bars = "reference" in result.runs
            found = attempted(
                "spot checks", lambda: _checked(result.reference, run, places, bars, progress, notes), FAILED, notes
            )
    samples = None if result.events is None else result.statistics
    return found.beside(result.events, samples)


def events_beside(run: ReducedRun, reference: ReferenceModel, progress: Progress, notes: list[str]) -> Structure:
    """Some of its events, marched through by the unreduced model."""
    started = clock.perf_counter()
    found = attempted("spot checks", lambda: _of_events(run, *handed_over(run, reference), progress), FAILED, notes)
    return replace(found, wall_s=clock.perf_counter() - started)


def _of_events(run: ReducedRun, of: Handover | None, why: str, progress: Progress) -> Structure:
    found = Structure(why_not=why) if of is None else check_spots(run, of, progress)
    return replace(found, complete=run.reduced.complete)


def _checked(
    reference: ReferenceModel,
    run: ReducedRun,
    places: Sequence[Place],
    bars: bool,
    progress: Progress,
    notes: list[str],
) -> Structure:
    """Events, where none were looked at yet, rubbing and `bars` of its own run by contact steps; each may fail."""
    started = clock.perf_counter()
    of, why = handed_over(run, reference)
    events = run.structure
    if events is None:
        events = attempted("spot checks", lambda: _of_events(run, of, why, progress), FAILED, notes)
    if of is None:
        return events
    nothing: tuple[tuple[RubSpot, ...], int] = (), 0
    of_steps: dict[str, float] = {}
    rubs, solves = attempted("spot checks of friction", lambda: check_rubs(run, places, of), nothing, notes)
    if bars:
        of_steps = attempted("bars of the unreduced run", lambda: bars_of_steps(run, of), of_steps, notes)
    wall_s = events.wall_s + clock.perf_counter() - started
    return replace(events, rubs=rubs, of_steps=of_steps, solves=events.solves + solves, wall_s=wall_s)


def bars_of_steps(run: ReducedRun, of: Handover) -> dict[str, float]:
    """How far events of the unreduced model's own run hang on its contact steps (`Structure.of_steps`).

    Hard events, of as many places as there are up to `FEWEST_EVENTS`, are marched through twice from the state of the
    reduced model: by the contact steps and springs of that run, and by those of half its step. An error that falls with
    the step, or faster, is at most twice (`FALLS`) what that changes. The largest of all events counts, with what no
    run sees (`settling.LEAST`), and what flight steps change.
    """
    if flowing(of.unreduced)[0] is not None:  # which has no contact steps
        return {}
    step, resolution = of.ends[1] - of.ends[0], run.marching.resolution
    parts, springs = steps_in_contact(of.unreduced, of.gaps, step, resolution)
    half, stiffer = steps_in_contact(of.unreduced, of.gaps, step, replace(resolution, stepped=0.5 / parts))
    if half != 2 * parts:
        return {}
    most = (of.ends.size - 1) * parts
    made = [stretch_of(e, why, of.ends, parts, most)[0] for e, why in ordered(run, of)[:FEWEST_EVENTS]]
    order = [s for s in made if s is not None]
    near = near_channels(of.history, of.gaps, order, of.ends)
    if not order:
        return {}
    states = states_at(run.marching, of, order)
    found: dict[str, float] = {}
    runs = [Checker(replace(of, gaps=g), n, near) for n, g in ((parts, springs), (half, stiffer))]
    stretches = order, [s.finer() for s in order]

    def march(checker: Checker, s: Stretch) -> Callable[[Solver], Marched]:
        return partial(checker.through, s, states.begins[s.first], of.channels(s.event))

    both = [
        checker.side_by_side([march(checker, s) for s in own]) for checker, own in zip(runs, stretches, strict=True)
    ]
    for s, *two in zip(order, *both, strict=True):
        lasts = s.event.t_end - s.event.t_start
        a, b = (figures_over(s.event, m.history, m.gaps, of) or {} for m in two)
        for name in () if any(m.problem for m in two) else a.keys() & b.keys():
            by = FALLS * abs(change(name, a[name], b[name])) / (lasts if name in TIMES else 1.0)
            found[name] = max(found.get(name, 0.0), by)
    inherited = found.get("impulse", 0.0)  # what an event gets wrong moves the later ones
    return {name: x + LEAST[name] + FLIGHT + (inherited if name in MOVED else 0.0) for name, x in found.items()}
