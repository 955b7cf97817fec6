"""The main job: a study in, two runs and their comparison out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator, join
from creak.linalg.threads import one_blas_thread
from creak.model.units import UNITS
from creak.progress import Progress, Sentence
from creak.studies.file.paths import new_identity
from creak.studies.models.reduced import ReducedModel, Stage, reduce_model
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import NO_STORE, Store
from creak.studies.prepare.amount_check import weak_drive
from creak.studies.prepare.marching import Marching, Observed, Scope
from creak.studies.prepare.reduction import Reduction
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import never_closed
from creak.studies.prepare.watched import motion_warnings
from creak.studies.run.agreement import (
    Fit,
    compare_modes,
    compare_spectra,
    lost_modes,
    response_fit,
)
from creak.studies.run.checkpoint import Checkpoints
from creak.studies.run.compared import ResultBase, compare_events, main_run
from creak.studies.run.elines import LineFindings, compare_lines, touched_points
from creak.studies.run.foretold import foretold
from creak.studies.run.integrate import limited, sprung, step_warnings
from creak.studies.run.kernels import compiling
from creak.studies.run.one_run import Run, march_run
from creak.studies.run.precheck import may_have_rung, ready, run_with_closed, sure_of_dropped, with_closed
from creak.studies.unraised import none_ignored
from creak.studies.warned import REST, Warned, attempted, is_asked_to_end, left_by_ctrl_c
from creak.verify.reliability import UNRELIABLE, reasons_against
from creak.verify.unreduced import Structure

if TYPE_CHECKING:
    from creak.reduction.health import Health

MOVED = 1e-9
"""Share of its gap at rest by which a channel must close to have moved: above round-off, far below anything else."""
ReferenceRun = Callable[[Marching, Observed, ReferenceModel, GapOperator, Progress], Run]


@dataclass(frozen=True)
class ReducedRun:
    """A reduced model with its run, and how its f_max was found."""

    reduction: Reduction
    """Raised as often as it took."""
    marching: Marching
    scope: Scope
    gaps: GapOperator
    """Channels of the run."""
    reduced: ReducedModel
    run: Run
    more: tuple[ReducedModel, Run] | None = None
    """The run with more modes that the last stage was compared with; None: there is none yet, or it has all modes."""
    stages: tuple[Stage, ...] = ()
    """All models that were run; none where f_max was given."""
    why: str = ""
    """Why no further stage was made although the answer has not settled, and what it would cost."""
    structure: Structure | None = None
    """What the unreduced model says of the run; None: it was not asked yet."""


March = Callable[[ReducedModel], Run]
Settle = Callable[[ReducedRun, ReferenceModel, March, Progress], ReducedRun]


@dataclass(frozen=True)
class StudyResult(ResultBase[Run]):
    """Everything that a study found, with its models."""

    setup: Setup
    gaps: GapOperator
    """Channels that were kept, contacts first, connectors after."""
    reference: ReferenceModel
    reduced: ReducedModel | None
    notes: list[str]
    health: dict[str, Health]
    """Of each superelement, by name."""
    band: ReducedRun | None = None
    """How f_max was found; None: nothing was reduced."""

    @property
    def scope(self) -> Scope:
        """What is told of its runs."""
        return Scope(self.setup.model, self.setup.study.config.verification, self.window)

    @property
    def unanswered(self) -> str | None:
        """Why its run says nothing of rattle, in a sentence; None: it does, whatever it says."""
        if why := self.setup.no_contact:
            return why
        run = self.main
        if run is None or run.history.force.any():
            return None
        if why := weak_drive(self.setup.study.driving, self.setup.loads):
            return why
        linear = self.reference.linear_gaps
        closed = _closed(run.gaps.gap0, run.history.gap.min(axis=0, initial=np.inf))
        if closed or (linear is not None and _closed(self.setup.contacts.gap0, linear)):
            return None
        return (
            "no gap of its contacts and connectors becomes smaller than it is at rest, so nothing can rattle: what "
            "drives the model is zero, or does not reach them"
        )


def _closed(at_rest: FloatArray, smallest: FloatArray) -> bool:
    return bool((at_rest - smallest > MOVED * np.abs(at_rest)).any())


@none_ignored()
@one_blas_thread()
def run_study(
    setup: Setup,
    progress: Progress,
    store: Store = NO_STORE,
    reference_run: ReferenceRun | None = None,
    *,
    record: bool = False,
    checkpoints: Checkpoints | None = None,
    settle: Settle | None = None,
) -> StudyResult:
    """Pre-check, reduction, both runs, verification.

    A run that stops early keeps what it has and ends the study: `StudyResult.stopped` says why.

    Parameters
    ----------
    store : of superelements; those that still fit are used instead of being made again.
    reference_run : makes the run of the unreduced model, or takes a saved one of the same model, channels and loads.
    record : keep the motion around the hardest events of the reduced run, or of the only one (`studies.motion`).
    checkpoints : from which an unreduced run goes on, and which it writes.
    settle : raises f_max = "auto" from where it begins; None: it stays there.
    """
    c = setup.study.config
    units = UNITS[c.model.units]
    with compiling(setup.marching, solves_steps=setup.solves_steps) as compiled:
        setup, reference, gaps, notes = ready(setup, progress, store.folder, compiled)
        marching, kept, nodes = setup.marching, gaps.m, setup.model.nodes
        scope = Scope(setup.model, c.verification, marching.window)
        limit = partial(limited, marching, nodes.coords, reference.system, units.stiffness)
        closed = partial(with_closed, c.precheck, setup.contacts, setup.connectors, units.length)
        observed = partial(setup.observed, lines=True, record=record)
        runs: dict[str, Run] = {}
        reduced: ReducedModel | None = None
        band: ReducedRun | None = None
        stopped: str | None = None
        health: dict[str, Health] = {}
        if c.reduction.method != "none":
            model_of = partial(reduce_model, setup.reduction, reference, progress=progress, store=store)
            settles = settle if setup.band.auto and c.reduction.method != "guyan" else None

            def reduced_run(gaps: GapOperator, last: bool) -> tuple[ReducedRun, Run]:
                model, seen = model_of(gaps), observed(gaps)
                if said := foretold(marching, model.system, gaps, seen, reference.linear_closed):
                    progress(Sentence(said), 1, 1)

                def march(model: ReducedModel) -> Run:
                    compiled(progress)
                    return march_run("reduced", marching, seen, model, gaps, progress)

                def sure(found: ReducedRun) -> ReducedRun:
                    def again(dropped: GapOperator) -> Run:
                        progress(Sentence(may_have_rung(dropped)), 1, 1)
                        channels, _ = limit(join([gaps, dropped]))
                        watched = setup.observed(channels)
                        return march_run("reduced", marching, watched, found.reduced, channels, progress)

                    return replace(found, run=sure_of_dropped(setup.contacts, found.run, again))

                found = sure(ReducedRun(setup.reduction, marching, scope, gaps, model, march(model)))
                settled = last or found.run.stopped is not None or closed(gaps, found.run.history) is None
                if settled and settles is not None and gaps.presses:
                    found = settles(found, reference, march, progress)
                    found = found if found.reduced is model else sure(found)
                return found, found.run

            gaps, found, more = run_with_closed(gaps, limit, closed, reduced_run)
            band, reduced, runs["reduced"] = found, found.reduced, found.run
            setup = replace(setup, raised=found.reduction.band.raised)
            from creak.studies.models.health import checked  # what comes after the run is not waited for before it

            notes += [*more, *reduced.notes]
            if found.run.interrupted or (found.more is not None and found.more[1].interrupted):
                left_by_ctrl_c(REST if found.run.interrupted else "runs with more modes", notes)
            try:
                found_of = partial(checked, reduced.superelements, nodes, setup.band, progress, store.folder)
                health = attempted("health of the superelements", found_of, health, notes, ctrl_c=False)
            except KeyboardInterrupt:
                stopped = "stopped while the superelements were checked"
            notes += [
                Warned(f"superelement {name}: {text}") for name, h in health.items() for text in h.findings.warnings
            ]
        stopped = next((r.stopped for r in runs.values() if r.stopped), stopped)
        compiled(progress, steps=True)
        if stopped is None and c.runs_unreduced and not is_asked_to_end(notes):
            checkpoint = None if checkpoints is None else partial(checkpoints.of, setup.origin)
            own: ReferenceRun = partial(march_run, "reference", checkpoint=checkpoint)
            if reduced is None:

                def only_run(gaps: GapOperator, last: bool) -> tuple[Run, Run]:
                    if record or reference_run is None:
                        run = own(marching, observed(gaps), reference, gaps, progress)
                    else:
                        run = reference_run(marching, setup.observed(gaps), reference, gaps, progress)
                    return run, run

                gaps, runs["reference"], more = run_with_closed(gaps, limit, closed, only_run)
                notes += more
            else:
                make, springs = reference_run or own, sprung(marching, runs["reduced"].system, gaps)
                runs["reference"] = make(marching.compared, setup.observed(gaps), reference, springs, progress)
            stopped = runs["reference"].stopped
            if runs["reference"].interrupted:
                left_by_ctrl_c(REST, notes)
    notes += [] if checkpoints is None else checkpoints.notes
    if gaps.m == 0 and (setup.contacts.m or setup.connectors.m):
        which = "both runs are" if len(runs) > 1 else "the run is"
        notes.append(f"no channel can close under this load: {which} linear")
    notes += run_warnings(marching, gaps, runs, units.length)
    notes += [f"{name} run: {text}" for name, run in runs.items() for text in run.notes]
    if runs and gaps.m and not any(run.history.force.any() for run in runs.values()):
        notes.append(never_closed(gaps, next(iter(runs.values())).history, units.length))
    window, v, watch = marching.window, c.verification, setup.watch
    whole = {} if stopped else runs
    main, condensed = main_run(whole), None if reduced is None else reduced.system
    reduction, loads = setup.reduction, marching.loads

    def lines_of(main: Run) -> LineFindings:
        touched = touched_points(watch.lines.points, gaps, main.history, window)
        return compare_lines(marching, watch.lines, reduction, reference, condensed, (main.lines, touched), progress)

    def responses() -> Fit:
        if condensed is None or reference.of_parts is not None:
            return {}
        return response_fit(watch.pairs, v.f_max, loads, reduction, reference, condensed, window)

    lines = None
    if main is not None and watch.lines.points.m:
        lines = attempted("E-lines", partial(lines_of, main), None, notes)
    modes = attempted(
        "modes of both models", lambda: compare_modes(watch, v.mac_f_max, reference, reduced, gaps), None, notes
    )
    notes += lost_modes(modes, reduction)
    spectra = attempted(
        "spectra of both runs", lambda: compare_spectra(watch, v.f_max, whole, window, responses), None, notes
    )
    return StudyResult(
        setup,
        gaps,
        reference,
        reduced,
        [*setup.notes, *notes],
        health,
        band,
        identity=new_identity(setup.study.text, setup.digests),
        runs=runs,
        modes=modes,
        spectra=spectra,
        events=compare_events(whole, v.event_tolerance, window),
        elines=lines,
        window=window,
        closed_later=gaps.m - kept,
        stopped=stopped,
    )


def run_warnings(marching: Marching, gaps: GapOperator, runs: dict[str, Run], unit: str) -> list[Warned]:
    """What the user should know of each run, in this unit of length; where it is the same of both, once."""
    against = partial(reasons_against, forced=not marching.table.exact, unit=unit)
    said = {
        name: [
            *(f"{UNRELIABLE}: {reason}" for reason in against(run.history)),
            *motion_warnings(gaps, run.history, unit),
            *step_warnings(marching, run.events),
        ]
        for name, run in runs.items()
    }
    every = dict.fromkeys(text for texts in said.values() for text in texts)
    return [Warned(f"{' and '.join(n for n in said if text in said[n])} run: {text}") for text in every]
