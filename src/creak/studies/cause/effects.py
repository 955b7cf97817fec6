"""What single changes do to a place: predicted on the reduced model, checked by full runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
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
from creak.studies.models.reference import ReferenceModel, rejoined
from creak.studies.prepare.marching import Scope
from creak.studies.prepare.setup import Setup
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
    places: Sequence[Place],
    causes: Sequence[Cause],
    tried: Callable[[Place, Cause], tuple[Effect, list[tuple[Change, Effect]]]],
    check: Callable[[Place, Change], Effect | str] | None,
    progress: Progress,
) -> dict[int, list[dict[str, object]]]:
    """Number of each of the first places -> the `KEPT` changes that leave least of it, one of a kind, with effects.

    Parameters
    ----------
    tried : as `try_changes`. check : what a full run says of a change; None: none is made.
    """
    shown, out = list(zip(places, causes, strict=True))[:MOST_PLACES], {}
    for done, (place, cause) in enumerate(shown):
        progress("changes that would help", done, len(shown))
        now, every = tried(place, cause)
        every.sort(key=lambda t: (t[1].rank, t[1].impulse))
        helps = [t for t in every if t[1].rank < now.rank or t[1].impulse < now.impulse]
        best = [t for i, t in enumerate(helps) if t[0].kind not in {u[0].kind for u in helps[:i]}][:KEPT]
        out[place.number] = [change_dict(c, now, e, None if check is None else check(place, c)) for c, e in best]
    progress("changes that would help", len(shown), len(shown))
    return out


def try_changes(
    found: StudyResult, ear: Ear | None, place: Place, cause: Cause
) -> tuple[Effect, list[tuple[Change, Effect]]]:
    """The place as it is, and with each change that can be marched, on the reduced model."""
    setup, scope, run = found.setup, found.scope, found.main
    assert run is not None
    assert found.reduced is not None
    system, marching = run.system, setup.marching
    at_rest = run.gaps if setup.static is None else join(setup.static.before)
    of = setup.reduction, found.reference, found.reduced, run.gaps
    tried = []
    for change in candidates(place, cause, *of, at_rest):
        changed = system if change.of_system is None else change.of_system(system)
        if not is_modal(changed):
            continue
        try:
            gaps = change.of_gaps(run.gaps)
            if setup.static is not None:
                gaps = _in_equilibrium(change.of_setup(setup.unstarted()), found.reference, change, gaps.names)
            history = marched(marching, changed, gaps, marching.loads, np.zeros(0, dtype=np.int64))
        except (Stopped, CreakError):
            continue
        like = system if change.same_modes else None
        tried.append((change, effect_of(scope, place, changed, gaps, history, ear, like)))
    return effect_of(scope, place, system, run.gaps, run.history, ear), tried


def _in_equilibrium(setup: Setup, reference: ReferenceModel, change: Change, names: Sequence[str]) -> GapOperator:
    """These channels with a change, in equilibrium with the static loads."""
    if change.blocks:
        reference = rejoined(setup.structure, reference, [b.part for b in change.blocks])
    again = started(setup, reference, silent)
    every = join([again.contacts, again.connectors])
    row = {name: i for i, name in enumerate(every.names)}
    return every.select(np.array([row[name] for name in names], dtype=np.int64))


def checked_by_run(setup: Setup, ear: Ear | None, progress: Progress, place: Place, change: Change) -> Effect | str:
    """The effect in a run of the changed model, reduced anew; why there is none."""
    setup = change.of_setup(setup.unstarted())
    c = setup.study.config
    setup = setup.with_tables(reference=c.reference.model_copy(update={"run": "none"}))
    try:
        again = run_study(setup, progress)
    except CreakError as error:
        return str(error)
    run = again.main
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
    channels = channels_at([place], scope.model, gaps, history)[0]
    touched = np.flatnonzero((history.force > 0.0).any(axis=0))
    here, every = events_at([channels, touched], scope, gaps, history)
    heard: Sequence[float | None] = (None, None)
    if ear is not None:
        heard = n5_of(scope.window, system, gaps, history, [channels], ear, like)
    return Effect(len(here), sum(e.impulse for e in here), sum(e.impulse for e in every), *heard)


def causes_of(
    found: StudyResult, sound: Sound | str | None, progress: Progress, changes: str = "none"
) -> tuple[dict[int, dict[str, Any]], list[str]]:
    """Number of each place of the main run -> its cause, and notes.

    Parameters
    ----------
    changes : "none", "predicted" or "checked", as `creak.run` has it.
    """
    setup, run = found.setup, found.main
    places = [p for p in heard_places(found.scope, run, sound) if p.events]
    progress("what causes it", 0, 1)
    causes = find_causes(setup.marching, setup.reduction, None if found.stopped is not None else run, places)
    progress("what causes it", 1, 1)
    if isinstance(causes, str) or run is None:
        if not places:
            return {}, []
        text = f"no cause is told of the places: {causes}"
        return {}, [Warned(text) if changes != "none" else text]
    length = UNITS[setup.study.config.model.units].length
    out = {cause.place: cause_dict(cause, setup.loads, run.gaps, length) for cause in causes}
    if changes == "none":
        return out, []
    ear = replace(sound.ear, beyond=None, statistics=None) if isinstance(sound, Sound) else None  # not known of changes
    tried, check = partial(try_changes, found, ear), partial(checked_by_run, setup, ear, progress)
    told_of = [p for p in places if p.number in out]
    every = find_changes(told_of, causes, tried, check if changes == "checked" else None, progress)
    for number, some in every.items():
        out[number] |= {"changes": some, "changes_words": change_words(some, IMPULSE)}
    if isinstance(sound, Sound) and sound.band.high > (told := min(sound.band.modes, sound.band.computed)):
        return out, [f"what changes do to N5 is told of what the modes tell, up to {told:.0f} Hz"]
    return out, []
