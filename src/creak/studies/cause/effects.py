"""What single changes do to a place: predicted on the reduced model, checked by full runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.modal_coefficients import is_modal
from creak.dynamics.stopped import Stopped
from creak.errors import CreakError
from creak.model.units import METRES
from creak.progress import Progress
from creak.studies.cause.changes import Change, Effect, candidates
from creak.studies.cause.decompose import Cause, marched
from creak.studies.cause.told import change_dict
from creak.studies.prepare.setup import Setup
from creak.studies.results.places import Place
from creak.studies.run.compared import main_run
from creak.studies.run.job import StudyResult, events_in, run_study
from creak.studies.sound.background import background_of
from creak.studies.sound.heard import Sound, heard_of
from creak.studies.sound.listeners import Listener
from creak.studies.sound.radiation import Radiation, pressure_of, radiation
from creak.studies.sound.source import source_of
from creak.verify.events import find_events

MOST_PLACES = 3
"""Places, the loudest, for which changes are looked for."""
KEPT = 3
"""Changes that are told of each."""


@dataclass(frozen=True)
class Ear:
    """The first listener of a run's sound."""

    listener: Listener
    band: float
    metre: float


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
    ear = ear_of(result, sound)
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


def ear_of(result: StudyResult, sound: Sound | str | None) -> Ear | None:
    """The first listener of the run's sound; None without sound."""
    if not isinstance(sound, Sound):
        return None
    return Ear(sound.listeners[0], sound.band.high, METRES[result.setup.study.config.model.units])


def try_changes(
    result: StudyResult, place: Place, cause: Cause, ear: Ear | None
) -> tuple[Effect, list[tuple[Change, Effect]]]:
    """The place as it is, and with each change that can be marched, on the reduced model."""
    run = main_run(result.runs)
    assert run is not None
    to = _radiation(run.system, ear)
    now = effect_of(result, place, run.system, result.gaps, run.history, to)
    tried = []
    for change in candidates(result.setup, result.gaps, place, cause, result.reference.system.stats.mass):
        effect = predicted(result, place, change, run.system, ear, to)
        if effect is not None:
            tried.append((change, effect))
    return now, tried


def predicted(
    result: StudyResult, place: Place, change: Change, system: System, ear: Ear | None, to: Radiation | None
) -> Effect | None:
    """On the reduced model; None where that cannot be marched."""
    gaps = change.of_gaps(result.gaps)
    changed = system if change.of_system is None else change.of_system(system)
    if not is_modal(changed):
        return None
    try:
        history = marched(result.setup, changed, gaps, result.setup.loads, np.zeros(0, dtype=np.int64))
    except Stopped:
        return None
    if not change.same_modes:
        to = _radiation(changed, ear)
    return effect_of(result, place, changed, gaps, history, to)


def _radiation(system: System, ear: Ear | None) -> Radiation | None:
    return None if ear is None else radiation(system, ear.listener, ear.metre, ear.band)


def checked_by_run(
    result: StudyResult, place: Place, change: Change, ear: Ear | None, progress: Progress
) -> Effect | str:
    """The effect in a run of the changed model, reduced anew; why there is none."""
    setup = change.of_setup(result.setup)
    c = setup.study.config
    setup = setup.with_tables(reference=c.reference.model_copy(update={"run": False}))
    try:
        again = run_study(setup, progress)
    except CreakError as error:
        return str(error)
    run = main_run(again.runs)
    if run is None or again.stopped is not None or not is_modal(run.system):
        return again.stopped or "damping couples the modes"
    to = _radiation(run.system, ear)
    return effect_of(again, place, run.system, again.gaps, run.history, to)


def effect_of(
    result: StudyResult,
    place: Place,
    system: System,
    gaps: GapOperator,
    history: History,
    to: Radiation | None,
) -> Effect:
    """What the channels of a place do in a run, found by their nodes."""
    setup, window = result.setup, result.window
    channels = np.flatnonzero(gaps.of_groups({place.contact}) & np.isin(gaps.nodes_idx, place.nodes_idx))
    inside = (history.time >= window[0]) & (history.time <= window[1])
    impulse = (history.weights * inside) @ history.force
    v, count = setup.study.config.verification, 0
    if channels.size:
        own = replace(history, gap=history.gap[:, channels], force=history.force[:, channels])
        count = len(events_in(find_events(own, gaps.select(channels), v.merge, v.f_max), window))
    heard: tuple[float | None, float | None] = (None, None)
    if to is not None:
        heard = _heard(setup, window, system, gaps, history, channels, to)
    return Effect(count, float(impulse[channels].sum()), float(impulse.sum()), *heard)


def _heard(
    setup: Setup,
    window: tuple[float, float],
    system: System,
    gaps: GapOperator,
    history: History,
    channels: np.ndarray,
    to: Radiation,
) -> tuple[float | None, float | None]:
    """N5 of the channels and of all, as places are ranked by it."""
    source = source_of(system, gaps, history)
    if not source.channel.size:
        return 0.0, 0.0
    own, rest = pressure_of(source, source.groups([channels]), to)
    background = background_of(setup.study)
    both = [heard_of(x, window, background) for x in (own, own + rest)]
    return tuple(h.n5 if background is None else h.n5_added for h in both)  # type: ignore[return-value]
