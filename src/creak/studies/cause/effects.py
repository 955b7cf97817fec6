"""What single changes do to a place: predicted on the reduced model, checked by full runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.diagonal import is_modal
from creak.dynamics.history import History
from creak.dynamics.stopped import Stopped
from creak.errors import CreakError
from creak.model.units import UNITS
from creak.progress import Progress, silent
from creak.studies.cause.changes import Change, Effect, candidates
from creak.studies.cause.decompose import Cause, find_causes, marched
from creak.studies.cause.told import cause_dict, change_dict, change_words
from creak.studies.findings.places import Place, channels_at, events_at
from creak.studies.findings.sound import heard_places
from creak.studies.models.reference import rejoined
from creak.studies.prepare.marching import Scope
from creak.studies.run.compared import main_run
from creak.studies.run.job import StudyResult, run_study
from creak.studies.run.static_start import started
from creak.studies.sound.ear import Ear, n5_of
from creak.studies.sound.heard import Sound
from creak.studies.warned import Warned

MOST_PLACES = 3
"""Places, the loudest, for which changes are looked for."""
KEPT = 3
"""Changes that are told of each."""
IMPULSE = "N s"


def find_changes(
    result: StudyResult,
    sound: Sound | str | None,
    places: Sequence[Place],
    causes: Sequence[Cause],
    progress: Progress,
    *,
    check: bool = False,
) -> dict[int, list[dict[str, object]]]:
    """Number of each of the first places -> the `KEPT` changes that leave least of it, one of a kind, with effects.

    Parameters
    ----------
    check : make a full run, with a reduction of its own, of each change that is kept.
    """
    ear = (
        replace(sound.ear, beyond=None, statistics=None) if isinstance(sound, Sound) else None
    )  # that of a change is not known
    shown, out = list(zip(places, causes, strict=True))[:MOST_PLACES], {}
    for done, (place, cause) in enumerate(shown):
        progress("changes that would help", done, len(shown))
        now, tried = try_changes(result, place, cause, ear)
        tried.sort(key=lambda t: (t[1].rank, t[1].impulse))
        helps = [t for t in tried if t[1].rank < now.rank or t[1].impulse < now.impulse]
        best = [t for i, t in enumerate(helps) if t[0].kind not in {u[0].kind for u in helps[:i]}][:KEPT]
        out[place.number] = [
            change_dict(c, now, e, checked_by_run(result, place, c, ear, progress) if check else None) for c, e in best
        ]
    progress("changes that would help", len(shown), len(shown))
    return out


def try_changes(
    result: StudyResult, place: Place, cause: Cause, ear: Ear | None
) -> tuple[Effect, list[tuple[Change, Effect]]]:
    """The place as it is, and with each change that can be marched, on the reduced model."""
    run = main_run(result.runs)
    assert run is not None
    now = effect_of(result.scope, place, run.system, run.gaps, run.history, ear)
    tried = []
    for change in candidates(result, place, cause):
        effect = predicted(result, place, change, run.system, ear)
        if effect is not None:
            tried.append((change, effect))
    return now, tried


def predicted(result: StudyResult, place: Place, change: Change, system: System, ear: Ear | None) -> Effect | None:
    """On the reduced model; None where that cannot be marched."""
    changed = system if change.of_system is None else change.of_system(system)
    if not is_modal(changed):
        return None
    try:
        gaps = _gaps_with(result, change)
        history = marched(result.setup.marching, changed, gaps, result.setup.loads, np.zeros(0, dtype=np.int64))
    except (Stopped, CreakError):
        return None
    return effect_of(result.scope, place, changed, gaps, history, ear, system if change.same_modes else None)


def _gaps_with(result: StudyResult, change: Change) -> GapOperator:
    """The channels of a run with a change, in equilibrium with its static loads."""
    if result.setup.static is None:
        return change.of_gaps(result.gaps)
    setup = change.of_setup(result.setup.unstarted())
    reference = result.reference
    if change.blocks:
        reference = rejoined(setup.structure, reference, [b.part for b in change.blocks])
    again = started(setup, reference, silent)
    every = join([again.contacts, again.connectors])
    row = {name: i for i, name in enumerate(every.names)}
    return every.select(np.array([row[name] for name in result.gaps.names], dtype=np.int64))


def checked_by_run(
    result: StudyResult, place: Place, change: Change, ear: Ear | None, progress: Progress
) -> Effect | str:
    """The effect in a run of the changed model, reduced anew; why there is none."""
    setup = change.of_setup(result.setup.unstarted())
    c = setup.study.config
    setup = setup.with_tables(reference=c.reference.model_copy(update={"run": "none"}))
    try:
        again = run_study(setup, progress)
    except CreakError as error:
        return str(error)
    run = main_run(again.runs)
    if run is None or again.stopped is not None or not is_modal(run.system):
        return again.stopped or "damping couples the modes"
    return effect_of(again.scope, place, run.system, run.gaps, run.history, ear)


def effect_of(
    scope: Scope,
    place: Place,
    system: System,
    gaps: GapOperator,
    history: History,
    ear: Ear | None,
    like: System | None = None,
) -> Effect:
    """What the channels of a place do in a run, found by their nodes."""
    window, channels = scope.window, channels_at([place], scope.model, gaps, history)[0]
    inside = (history.time >= window[0]) & (history.time <= window[1])
    impulse = (history.weights * inside) @ history.force
    count = len(events_at([channels], scope, gaps, history)[0])
    heard: Sequence[float | None] = (None, None)
    if ear is not None:
        heard = n5_of(window, system, gaps, history, [channels], ear, like)
    return Effect(count, float(impulse[channels].sum()), float(impulse.sum()), *heard)


def causes_of(
    result: StudyResult, sound: Sound | str | None, progress: Progress, changes: str = "none"
) -> tuple[dict[int, dict[str, Any]], list[str]]:
    """Number of each place of the main run -> its cause, and notes.

    Parameters
    ----------
    changes : "none", "predicted" or "checked", as `creak.run` has it.
    """
    places = [p for p in heard_places(result.scope, main_run(result.runs), sound) if p.events]
    progress("what causes it", 0, 1)
    found = find_causes(result, places)
    progress("what causes it", 1, 1)
    if isinstance(found, str):
        if not places:
            return {}, []
        text = f"no cause is told of the places: {found}"
        return {}, [Warned(text) if changes != "none" else text]
    length = UNITS[result.setup.study.config.model.units].length
    out = {cause.place: cause_dict(cause, result.setup.loads, result.gaps, length) for cause in found}
    if changes != "none":
        told_of = [p for p in places if p.number in out]
        every = find_changes(result, sound, told_of, found, progress, check=changes == "checked")
        for number, some in every.items():
            out[number] |= {"changes": some, "changes_words": change_words(some, IMPULSE)}
        if isinstance(sound, Sound) and sound.band.high > (told := min(sound.band.modes, sound.band.computed)):
            return out, [f"what changes do to N5 is told of what the modes tell, up to {told:.0f} Hz"]
    return out, []
