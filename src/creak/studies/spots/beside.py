"""What the unreduced model says of a run: by spot checks, and by its own run where there is one."""

from __future__ import annotations

from dataclasses import replace

from creak.progress import Progress
from creak.studies.converge.structure import RubSpot, Structure
from creak.studies.run.compared import event_statistics
from creak.studies.run.job import StudyResult
from creak.studies.spots.check import check_spots
from creak.studies.spots.rubs import rubs_beside
from creak.studies.spots.steps import bars_of_steps
from creak.studies.warned import attempted


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
        none: tuple[RubSpot, ...] = ()
        rubs = attempted("spot checks of friction", lambda: rubs_beside(result), none, notes)
        found = replace(found, rubs=rubs)
        if "reference" in result.runs:
            nothing: dict[str, float] = {}
            bars = attempted("bars of the unreduced run", lambda: bars_of_steps(result), nothing, notes)
            found = replace(found, of_steps=bars)
    samples = None if result.events is None else event_statistics(result)
    return found.beside(result.events, samples)
