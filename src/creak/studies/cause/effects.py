"""What single changes do to a place, predicted on the reduced model and checked by full runs; its causes in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.flow.march import flows
from creak.dynamics.history import History, Stopped
from creak.dynamics.loads import Loads
from creak.errors import CreakError
from creak.model.units import UNITS
from creak.progress import Progress, silent
from creak.studies.cause.changes import Change, Effect, candidates
from creak.studies.cause.decompose import CARRIED, CONTACT, EXCITATION, REST, Cause, find_causes, marched
from creak.studies.findings.places import Place, channels_at, events_at
from creak.studies.findings.sound import heard_places
from creak.studies.findings.spots import judged_by
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
MODES = 8
"""Modes told one by one."""
TOLD = 3
"""Modes in a sentence."""
COINCIDES = -20.0
"""dB of the excitation's spectrum at a mode from which they coincide."""
LINES = 1.5
"""Lines of the spectrum to both sides of a mode that count as at it, where its half bandwidth is less."""
BY = {EXCITATION: "excitation", CONTACT: "earlier contact"}
"""Kind of a source -> its word."""
ACCELERATION = 2
NOTHING = 1e-3
"""Share of the largest source's closing from which another one is told, and of the largest mode's from which that with
the supports is."""


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
        if not flows(changed):
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
    setup = change.of_setup(setup.unstarted()).unproven
    try:
        again = run_study(setup, progress)
    except CreakError as error:
        return str(error)
    run = again.main
    if run is None or again.stopped is not None or not flows(run.system):
        return again.stopped or "the reduced model is too large for its modes"
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
    units = UNITS[setup.study.config.model.units]
    out = {cause.place: cause_dict(cause, setup.loads, run.gaps, units.length) for cause in causes}
    if changes == "none":
        return out, []
    ear = replace(sound.ear, beyond=None, statistics=None) if isinstance(sound, Sound) else None  # not known of changes
    tried, check = partial(try_changes, found, ear), partial(checked_by_run, setup, ear, progress)
    told_of = [p for p in places if p.number in out]
    every = find_changes(told_of, causes, tried, check if changes == "checked" else None, progress)
    for number, some in every.items():
        out[number] |= {"changes": some, "changes_words": change_words(some, units.impulse)}
    if isinstance(sound, Sound) and sound.band.high > (told := min(sound.band.modes, sound.band.computed)):
        return out, [f"what changes do to N5 is told of what the modes tell, up to {told:.0f} Hz"]
    return out, []


def cause_dict(cause: Cause, loads: Loads, gaps: GapOperator, length: str) -> dict[str, Any]:
    """Closing displacements (positive towards contact) by source, mode and part.

    Those of the sources sum to gap0 - gap; those of the modes, and of the parts, do so with what the supports carry.
    """
    order = np.argsort(-np.abs(cause.modes))[:MODES]
    level = driven_level(loads, cause.frequencies[order], cause.damping[order])
    modes: list[dict[str, Any]] = [
        {
            "frequency": float(cause.frequencies[i]),
            "damping": float(cause.damping[i]),
            "closing": -float(cause.modes[i]),
            "of": {s.name: -float(s.modes[i]) for s in cause.sources},
            "excitation_db": float(db),
            "coincides": bool(db >= COINCIDES),
        }
        for i, db in zip(order.tolist(), level.tolist(), strict=True)
    ]
    direct = -sum(s.direct for s in cause.sources)
    found: dict[str, Any] = {
        "time": cause.time,
        "channel": gaps.names[cause.channel],
        "gap0": cause.gap0,
        "gap": cause.gap,
        "closing": cause.gap0 - cause.gap,
        "sources": [{"kind": s.kind, "name": s.name, "closing": -s.total} for s in cause.sources],
        "modes": modes,
        "other_modes": -float(cause.modes.sum()) - sum(m["closing"] for m in modes),
        "with_supports": direct,
        "parts": [{"name": name, "closing": 0.0 - moved} for name, moved in cause.parts if name != CARRIED],
    }
    return found | {"words": cause_words(found, length)}


def cause_words(cause: dict[str, Any], length: str) -> str:
    """The same as a sentence."""

    def moved(value: float) -> str:
        return f"{value:.3g} {length}"

    by = sorted((s for s in cause["sources"] if s["kind"] != REST), key=lambda s: -abs(s["closing"]))
    by = [s for s in by if abs(s["closing"]) >= NOTHING * abs(by[0]["closing"])]
    sources = ", ".join(f"{moved(s['closing'])} by {BY.get(s['kind'], s['kind'])} {s['name']}" for s in by[:4])
    drifts = [m["closing"] for m in cause["modes"] if not m["frequency"]]
    swings = [m for m in cause["modes"] if m["frequency"]][: TOLD - bool(drifts)]
    modes = ", ".join(
        [f"0 Hz ({moved(sum(drifts))}, rigid-body motion)"] * bool(drifts)
        + [
            f"{m['frequency']:.4g} Hz ({moved(m['closing'])}{', excited' if m['coincides'] else ', not excited'})"
            for m in swings
        ]
    )
    parts = ", ".join(f"{p['name']} {moved(p['closing'])}" for p in cause["parts"])
    carried, largest = cause["with_supports"], max(abs(m["closing"]) for m in cause["modes"])
    along = f"; {moved(carried)} is {CARRIED}, beyond which" if abs(carried) > NOTHING * largest else ";"
    return (
        f"at {cause['time']:.4g} s the gap of {moved(cause['gap0'])} had closed by {moved(cause['closing'])}: "
        f"{sources}; most through the modes at {modes}{along} parts move {parts}"
    )


def change_dict(change: Change, now: Effect, predicted: Effect, checked: Effect | str | None) -> dict[str, Any]:
    """One change with its effect on the reduced model and, where it was looked at, in a full run."""
    return {
        "change": change.kind,
        "words": change.words,
        "now": vars(now).copy(),
        "predicted": vars(predicted).copy(),
        "checked": checked if checked is None or isinstance(checked, str) else vars(checked).copy(),
    }


def change_words(changes: Sequence[dict[str, Any]], impulse: str) -> list[str]:
    """A sentence for each change."""
    return [f"{c['words']}: {_effect(c, impulse)}" for c in changes]


def _effect(change: dict[str, Any], impulse: str) -> str:
    key = judged_by(change)
    what, unit = ("N5", "sone") if key == "n5" else ("impulse", impulse)

    def shown(effect: dict[str, Any]) -> str:
        return "-" if effect[key] is None else f"{effect[key]:.3g}"

    text = f"{what} {shown(change['now'])} -> {shown(change['predicted'])} {unit}"
    total = f"total_{key}"
    text += f", of all places {_known(change['now'][total])} -> {_known(change['predicted'][total])}"
    checked = change["checked"]
    if isinstance(checked, str):
        return f"{text}; not checked: {checked}"
    return text if checked is None else f"{text}; full run {shown(checked)} ({_known(checked[total])})"


def _known(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def driven_level(loads: Loads, frequencies: FloatArray, damping: FloatArray) -> FloatArray:
    """(n,) dB: the excitation's spectrum at each mode, within its half bandwidth, under its highest line.

    Accelerations of supports and forces, the whole record under a Hann window, the largest of all excitations; -inf
    where there is none.
    """
    columns = np.hstack([loads.support[ACCELERATION], loads.force])
    n = loads.time.size
    spectrum = np.abs(np.fft.rfft(columns * np.hanning(n)[:, None], axis=0)) ** 2
    highest = spectrum.max(axis=0, initial=0.0)
    share = (spectrum[:, highest > 0.0] / highest[highest > 0.0]).max(axis=1, initial=0.0)
    line = 1.0 / (n * loads.step)
    half = np.maximum(np.nan_to_num(damping) * frequencies, LINES * line)
    freq, found = np.arange(share.size) * line, np.zeros(frequencies.size)
    for i, (low, high) in enumerate(zip(frequencies - half, frequencies + half, strict=True)):
        found[i] = share[np.searchsorted(freq, low) : np.searchsorted(freq, high) + 1].max(initial=0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(found))
