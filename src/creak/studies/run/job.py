"""The main job: a study in, two runs and their comparison out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.record.thinning import spacing_words
from creak.dynamics.stopped import Stopped
from creak.formats.stored.run_identity import RunIdentity
from creak.model.dofs import node_dofs
from creak.progress import Progress, Sentence, Steps
from creak.studies.file.identity import new_identity
from creak.studies.models.reduced import ReducedModel, Stage, reduce_model
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.output_steps import field_steps, output_every, shown_window
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import never_closed
from creak.studies.prepare.watched import motion_warnings, watched
from creak.studies.run.agreement import ModeComparison, SpectraComparison, compare_modes, compare_spectra
from creak.studies.run.checkpoint import Checkpoints
from creak.studies.run.compared import compare_events, compared_setup, main_run
from creak.studies.run.costs import Cost, Meter
from creak.studies.run.elines import LineFindings, LineMotion, compare_lines, line_steps, measured
from creak.studies.run.forced_step import limited, step_warnings
from creak.studies.run.foretold import run_s, words
from creak.studies.run.integrate import flowing, integrate, output_times, resolution_of
from creak.studies.run.kernels import compile_for
from creak.studies.run.motion import NO_STEPS, Recording, at_steps, recorded, recorded_steps
from creak.studies.run.precheck import MOST_RUNS, ready, with_closed
from creak.studies.run.static_start import with_static
from creak.studies.unraised import none_ignored
from creak.studies.warned import Warned, attempted
from creak.verify.elines import PointMeasures
from creak.verify.events import Event, find_events
from creak.verify.matching import EventMatch
from creak.verify.reliability import UNRELIABLE, reasons_against
from creak.verify.slips import SlipEvent, Squeak, find_slips, find_squeaks

COMPILE = "compile kernels (first run: a minute)"
"""A phase of its own: slow once, then kept on disk."""

if TYPE_CHECKING:
    from creak.reduction.health import Health

ReferenceRun = Callable[[Setup, ReferenceModel, GapOperator, Progress], "Run"]


@dataclass(frozen=True)
class Run:
    """One time integration."""

    name: str
    system: System
    history: History
    events: list[Event]
    cost: Cost
    retained: int
    modes: int
    offline_cpu_s: float
    offline_wall_s: float
    slips: tuple[SlipEvent, ...] = ()
    """Stick-slip events of the pairs that rub."""
    integrator: str = ""
    """In a few words."""
    stopped: str | None = None
    """Why the run ended early; None: it did not."""
    recording: Recording | None = None
    """Motion around the hardest events; None where nobody asked for it."""
    lines: PointMeasures | None = None
    """At the points of the E-lines; None where nobody asked for them."""
    squeaks: tuple[Squeak, ...] = ()
    """Stick-slip of each pair that rubs, in the verification window."""
    line_motion: LineMotion | None = None
    """Over time, with `lines`."""
    notes: tuple[str, ...] = ()
    """What should be known of it: instants that were not kept, a run that was taken from another case."""
    places_known: dict[tuple[float, float], tuple[GapOperator, Any]] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )
    """Window -> channels and what `studies.results.places` found of them, so that it looks once."""


@dataclass(frozen=True)
class ReducedRun:
    """A reduced model with its run, and how its f_max was found."""

    setup: Setup
    """Raised as often as it took."""
    reduced: ReducedModel
    run: Run
    more: tuple[ReducedModel, Run] | None = None
    """The run with more modes that the last stage was compared with; None: there is none yet, or it has all modes."""
    stages: tuple[Stage, ...] = ()
    """All models that were run; none where f_max was given."""
    why: str = ""
    """Why no further stage was made although more modes change the answer, and what it would cost."""


March = Callable[[Setup, ReducedModel], Run]
Settle = Callable[[ReducedRun, ReferenceModel, GapOperator, March, Progress], ReducedRun]


@dataclass(frozen=True)
class StudyResult:
    """Everything that a study found."""

    setup: Setup
    gaps: GapOperator
    """Channels that were kept, contacts first, connectors after."""
    runs: dict[str, Run]
    reference: ReferenceModel
    reduced: ReducedModel | None
    modes: ModeComparison | None
    spectra: SpectraComparison | None
    events: EventMatch | None
    window: tuple[float, float]
    notes: list[str]
    health: dict[str, Health]
    """Of each superelement, by name."""
    identity: RunIdentity
    stopped: str | None = None
    """Why the study ended early; None: it did not."""
    closed_later: int = 0
    """Contact channels that the pre-check dropped and that were kept after all, as one closed in the run."""
    elines: LineFindings | None = None
    """Of the main run beside that without contact; None: there are no lines."""
    band: ReducedRun | None = None
    """How f_max was found; None: nothing was reduced."""


@none_ignored()
def run_study(
    setup: Setup,
    progress: Progress,
    store: Path | None = None,
    reference_run: ReferenceRun | None = None,
    *,
    record: bool = False,
    keep: bool = False,
    checkpoints: Checkpoints | None = None,
    settle: Settle | None = None,
) -> StudyResult:
    """Pre-check, reduction, both runs, verification.

    A run that stops early keeps what it has and ends the study: `StudyResult.stopped` says why.

    Parameters
    ----------
    store : folder of saved superelements; those that still fit are used instead of being made again.
    reference_run : makes the run of the unreduced model, or takes a saved one of the same model, channels and loads.
    record : keep the motion around the hardest events of the reduced run, or of the only one (`studies.motion`).
    keep : save superelements in the store for the runs to come.
    checkpoints : from which an unreduced run goes on, and which it writes.
    settle : raises f_max = "auto" from where it begins; None: it stays there.
    """
    c = setup.study.config
    progress(COMPILE, 0, 1)
    compile_for(setup)
    progress(COMPILE, 1, 1)
    setup, reference, gaps, notes = ready(setup, progress, store)
    runs: dict[str, Run] = {}
    kept = gaps.m
    reduced: ReducedModel | None = None
    band: ReducedRun | None = None
    stopped: str | None = None
    health: dict[str, Health] = {}
    if c.reduction.method != "none":
        gaps, band, more = _reduced_run(setup, reference, gaps, progress, store, record, keep, settle)
        setup, reduced, runs["reduced"] = band.setup, band.reduced, band.run
        from creak.studies.models.health import checked  # what comes after the run is not waited for before it

        notes += [*more, *reduced.notes]
        try:
            found_of = partial(checked, reduced, setup.model.nodes.coords, setup.band, progress, store)
            health = attempted("health of the superelements", found_of, health, notes, ctrl_c=False)
        except KeyboardInterrupt:
            stopped = "stopped while the superelements were checked"
        notes += [Warned(f"superelement {name}: {text}") for name, h in health.items() for text in h.findings.warnings]
    stopped = next((r.stopped for r in runs.values() if r.stopped), stopped)
    if stopped is None and (c.proof == "whole" or reduced is None):
        if reduced is None:
            gaps, runs["reference"], more = _only_run(
                setup, reference, gaps, progress, reference_run, record, checkpoints
            )
            notes += more
        else:
            make = reference_run or partial(unreduced_run, checkpoints=checkpoints)
            runs["reference"] = make(compared_setup(setup), reference, gaps, progress)
        stopped = runs["reference"].stopped
    notes += [] if checkpoints is None else checkpoints.notes
    if gaps.m == 0 and (setup.contacts.m or setup.connectors.m):
        notes.append("no channel can close under this load: both runs are linear")
    notes += run_warnings(setup, gaps, runs)
    notes += [f"{name} run: {text}" for name, run in runs.items() for text in run.notes]
    if runs and gaps.m and not any(run.history.force.any() for run in runs.values()):
        notes.append(never_closed(gaps, next(iter(runs.values())).history))
    window = shown_window(setup.study.course, output_times(setup))
    whole = {} if stopped else runs
    main, condensed = main_run(whole), None if reduced is None else reduced.system
    at_lines = None if main is None else (main.lines, main.history)
    lines = attempted(
        "E-lines", lambda: compare_lines(setup, reference, condensed, gaps, at_lines, progress), None, notes
    )
    modes = attempted("modes of both models", lambda: compare_modes(setup, reference, reduced, gaps), None, notes)
    spectra = attempted(
        "spectra of both runs", lambda: compare_spectra(setup, whole, window, (reference, reduced)), None, notes
    )
    return StudyResult(
        setup,
        gaps,
        runs,
        reference,
        reduced,
        modes,
        spectra,
        compare_events(whole, setup.study.config.verification.event_tolerance, window),
        window,
        [*setup.notes, *notes],
        health,
        new_identity(setup.study, setup.deck_sha256),
        stopped,
        gaps.m - kept,
        lines,
        band,
    )


def _reduced_run(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    store: Path | None,
    record: bool,
    keep: bool,
    settle: Settle | None,
) -> tuple[GapOperator, ReducedRun, list[str]]:
    """The reduced model and its run, again with those dropped channels that close in it."""
    notes: list[str] = []

    def march(setup: Setup, reduced: ReducedModel) -> Run:
        system = reduced.system
        if setup.raised == 0 and (said := foretold(setup, system, gaps, reference.linear_closed)):
            progress(Sentence(said), 1, 1)
        return march_run("reduced", setup, system, gaps, progress, reduced, record=record, watch=True, lines=True)

    for left in reversed(range(MOST_RUNS)):
        gaps, more = limited(setup, reference, gaps)
        reduced = reduce_model(setup, reference, gaps, progress, store, keep=keep)
        found = ReducedRun(setup, reduced, march(setup, reduced))
        closed = with_closed(setup, gaps, found.run.history) if left and found.run.stopped is None else None
        keeps_modes = setup.study.config.reduction.method != "guyan"
        if closed is None and setup.band.auto and keeps_modes and settle is not None and gaps.presses:
            found = settle(found, reference, gaps, march, progress)
            closed = with_closed(setup, gaps, found.run.history) if left and found.stages[1:] else None
        if closed is None:
            break
        gaps = closed[0]
        notes.append(closed[1])
    return gaps, found, [*notes, *more]


def foretold(setup: Setup, system: System, gaps: GapOperator, closed: FloatArray | None) -> str:
    """What a run of a reduced model will take, where that is long; empty of a forced step, whose progress tells it."""
    table = setup.study.config.time
    modal = flowing(system)[0] if table.exact and gaps.presses else None
    if modal is None:
        return ""
    seconds = run_s(modal, gaps, setup.loads, resolution_of(setup), closed)
    return words(seconds, table.accuracy != "quick", closed)


def _only_run(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    reference_run: ReferenceRun | None,
    record: bool,
    checkpoints: Checkpoints | None,
) -> tuple[GapOperator, Run, list[str]]:
    """The run of the unreduced model where there is no other, as `_reduced_run`."""
    notes: list[str] = []
    for left in reversed(range(MOST_RUNS)):
        gaps, more = limited(setup, reference, gaps)
        if record or reference_run is None:
            run = march_run(
                "reference",
                setup,
                reference.system,
                gaps,
                progress,
                None,
                record=record,
                watch=True,
                lines=True,
                checkpoints=checkpoints,
            )
        else:
            run = reference_run(compared_setup(setup), reference, gaps, progress)
        closed = with_closed(setup, gaps, run.history) if left and run.stopped is None else None
        if closed is None:
            break
        gaps = closed[0]
        notes.append(closed[1])
    return gaps, run, [*notes, *more]


def run_warnings(setup: Setup, gaps: GapOperator, runs: dict[str, Run]) -> list[Warned]:
    """What the user should know of each run; where it is the same of both, once."""
    said = {
        name: [
            *(f"{UNRELIABLE}: {reason}" for reason in reasons_against(run.history)),
            *motion_warnings(gaps, run.history),
            *step_warnings(setup, run.events),
        ]
        for name, run in runs.items()
    }
    every = dict.fromkeys(text for texts in said.values() for text in texts)
    return [Warned(f"{' and '.join(n for n in said if text in said[n])} run: {text}") for text in every]


def march_run(
    name: str,
    setup: Setup,
    system: System,
    gaps: GapOperator,
    progress: Progress,
    reduced: ReducedModel | None,
    *,
    record: bool = False,
    watch: bool = False,
    lines: bool = False,
    checkpoints: Checkpoints | None = None,
) -> Run:
    """One run with its events and cost; one that stops early has them up to there.

    Parameters
    ----------
    record : keep the motion around the hardest events. watch : look at what `prepare.watched` says at every step.
    lines : measure at the E-lines. checkpoints : of an unreduced run.
    """
    meter, stopped, how = Meter(), None, ""
    field = field_steps(setup.study.course, output_times(setup))
    on_trial = recorded_steps(setup, system.n) if record else NO_STEPS
    of_lines = line_steps(setup, system.n) if lines else NO_STEPS
    observed, whole_at = node_dofs(setup.watched), np.union1d(np.union1d(field, on_trial), of_lines)
    seen, keeper = watched(setup.model, setup.contacts, gaps) if watch else None, None
    report: Steps = partial(progress, f"{name} run")
    if checkpoints is not None:
        keeper = checkpoints.of(name, setup, system.n, gaps, seen, observed, whole_at)
        report = keeper.told(progress)
    try:
        history, system, how = integrate(
            setup,
            system,
            gaps,
            observed=observed,
            output_every=output_every(setup.study.course),
            whole_at=whole_at,
            progress=report,
            watched=seen,
            keeper=keeper,
        )
    except Stopped as error:
        history, stopped = error.history, f"{name} run: {error}"
    cost = meter.read() if keeper is None else keeper.cost
    system, history = with_static(setup, system, history)
    v = setup.study.config.verification
    events, slips = find_events(history, gaps, v.merge, v.f_max), tuple(find_slips(history, gaps, v.merge, v.f_max))
    size = (0, 0, 0.0, 0.0) if reduced is None else (reduced.retained, reduced.modes, reduced.cpu_s, reduced.wall_s)
    kept = at_steps(history, np.union1d(field, on_trial))
    recording = recorded(setup, system, kept, events) if record else None
    found = measured(setup, system, history, of_lines) if stopped is None else None
    squeaks = tuple(find_squeaks(history, gaps, shown_window(setup.study.course, output_times(setup))))
    left, told = at_steps(history, field), spacing_words(history.spacing)
    at_lines, moved = (None, None) if found is None else found
    return Run(name, system, left, events, cost, *size, slips, how, stopped, recording, at_lines, squeaks, moved, told)


def unreduced_run(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    checkpoints: Checkpoints | None = None,
) -> Run:
    """The run of the unreduced model."""
    return march_run("reference", setup, reference.system, gaps, progress, None, watch=True, checkpoints=checkpoints)
