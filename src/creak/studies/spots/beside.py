"""What the unreduced model says of a run: by spot checks, and by its own run where there is one."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace

from creak.progress import Progress
from creak.studies.converge.structure import RubSpot, Structure
from creak.studies.findings.places import Place
from creak.studies.run.compared import event_statistics
from creak.studies.run.job import StudyResult
from creak.studies.spots.check import check_spots
from creak.studies.spots.handover import handed_over
from creak.studies.spots.rubs import check_rubs
from creak.studies.spots.steps import bars_of_steps
from creak.studies.warned import attempted

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
    if "reduced" not in result.runs:
        return None
    found = Structure(why_not='[reference] run = "none"')
    if result.setup.study.config.proof != "none":
        found = attempted("spot checks", lambda: _checked(result, places, progress, notes), FAILED, notes)
    samples = None if result.events is None else event_statistics(result)
    return found.beside(result.events, samples)


def _checked(result: StudyResult, places: Sequence[Place], progress: Progress, notes: list[str]) -> Structure:
    """By marches from the reduced model's states: events, rubbing, and contact steps of its own run; each may fail."""
    started = clock.perf_counter()
    of, why = handed_over(result)
    if of is None:
        return Structure(why_not=why)
    nothing: tuple[tuple[RubSpot, ...], int] = (), 0
    no_bars: dict[str, float] = {}
    found = attempted("spot checks", lambda: check_spots(result, of, progress), FAILED, notes)
    rubs, solves = attempted("spot checks of friction", lambda: check_rubs(result, places, of), nothing, notes)
    bars = no_bars
    if "reference" in result.runs:
        bars = attempted("bars of the unreduced run", lambda: bars_of_steps(result, of), no_bars, notes)
    wall_s = clock.perf_counter() - started
    return replace(found, rubs=rubs, of_steps=bars, solves=found.solves + solves, wall_s=wall_s)
