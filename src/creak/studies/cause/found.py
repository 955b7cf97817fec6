"""Causes of all places of a run, with the changes that would help, as summary.json has them."""

from __future__ import annotations

from typing import Any

from creak.progress import Progress
from creak.studies.cause.decompose import find_causes
from creak.studies.cause.effects import find_changes
from creak.studies.cause.told import cause_dict, change_words
from creak.studies.results.sound import heard_places
from creak.studies.run.compared import main_run
from creak.studies.run.job import StudyResult
from creak.studies.sound.heard import Sound
from creak.studies.warned import Warned

IMPULSE = "N s"


def causes_of(
    result: StudyResult, sound: Sound | str | None, progress: Progress, changes: str = "none"
) -> tuple[dict[int, dict[str, Any]], list[str]]:
    """Number of each place of the main run -> its cause, and notes.

    Parameters
    ----------
    changes : "none", "predicted" or "checked", as `creak.run` has it.
    """
    places = heard_places(result, main_run(result.runs), sound)
    progress("what causes it", 0, 1)
    found = find_causes(result, places)
    progress("what causes it", 1, 1)
    if isinstance(found, str):
        if not places:
            return {}, []
        text = f"no cause is told of the places: {found}"
        return {}, [Warned(text) if changes != "none" else text]
    out = {cause.place: cause_dict(cause, result.setup, result.gaps) for cause in found}
    if changes != "none":
        every = find_changes(result, sound, places, found, progress, check=changes == "checked")
        for number, some in every.items():
            out[number] |= {"changes": some, "changes_words": change_words(some, IMPULSE)}
    return out, []
