"""What the unreduced model says of a run: by spot checks, and by its own run where there is one."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace

from creak.progress import Progress
from creak.studies.findings.places import Place
from creak.studies.models.reference import ReferenceModel
from creak.studies.run.job import ReducedRun, StudyResult
from creak.studies.spots.check import check_spots
from creak.studies.spots.handover import Handover, handed_over
from creak.studies.spots.rubs import check_rubs
from creak.studies.spots.steps import bars_of_steps
from creak.studies.warned import attempted
from creak.verify.unreduced import RubSpot, Structure

FAILED = Structure(why_not="they could not be made")


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
