"""Convergence: the run once more with shorter steps, stiffer contact and more modes, each in one thing different."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.errors import CreakError
from creak.linalg.memory import free_bytes
from creak.linalg.threads import at_once, cores
from creak.progress import Progress, Shared
from creak.studies.converge.compared import assess
from creak.studies.converge.settling import (
    BASE,
    FINER,
    HALF,
    HARDER,
    MORE_MODES,
    QUARTER,
    SOFTER,
    STIFFER,
    TENFOLD,
    TWICE,
    YIELDING,
    Convergence,
    Followed,
    Outcome,
    Repeat,
    is_moved,
)
from creak.studies.file.config import ReductionTable, TimeTable
from creak.studies.file.contact_tables import ContactTable
from creak.studies.models.reduced import ReducedModel, with_more_modes
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.marching import Observed
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.varied import varied
from creak.studies.run.integrate import sprung
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run, march_run
from creak.verify.rubbing import Rub
from creak.verify.unreduced import Structure
from creak.words import listed

NO_PLACES = Followed()
GIVEN = "the contact stiffness is the study's own: what another one changes is told, and unsettles nothing"
COMPLETE = "every part is complete, with all modes that there are: the reduction leaves nothing out"
UNEXCITED = (
    "the reduced model has no modes, and the first {} are not excited, so they say nothing of those above: raise "
    "[reduction] f_max"
)
GROWING = 2.0
"""Times of a run's histories that it holds while they are put together."""
HALVED = 2.0
"""How much finer the contact is resolved with half the tolerance."""


def converge(
    result: StudyResult, progress: Progress, places: Followed = NO_PLACES, structure: Structure | None = None
) -> Convergence:
    """Repeat the study's run and tell which of its figures have settled.

    Repeated is the run of the reduced model, or of the unreduced one where the study reduces nothing. By exact flow:
    with contact resolved twice as finely, with half and twice its stiffness, and with more modes in each part that has
    any left: the next ones, wherever they lie (`linalg.modes`). With a forced step h: with h/2 and h/4 (and their
    substeps near contact) at the base run's stiffness; with 2 and 10 times that stiffness at h/4, which resolves it;
    with more modes at h. All cover the same time at the same output interval, with the same channels. A run that stops
    early, or cannot be made, is reported and the others go on. Where no part has a mode left the base run is that with
    more modes itself. What the reduction leaves out and no run can tell (`not_looked_at`) has not settled. A figure
    that has settled is free of the step, of the penalty and of the cut-off: it may still be off by what the mesh, the
    contact normals (found once), the damping and the pre-check (made with the base step, not repeated) say. Figures of
    single events that differ from run to run without trend are chaotic, not unconverged: `Convergence.statistics`
    compares the samples then.

    Parameters
    ----------
    places : of the base run, what is followed of each. structure : what the unreduced model says of its events.
    """
    base, setup = result.main, result.setup
    assert base is not None
    c, notes, repeats = setup.study.config, list[str](), list[Repeat]()

    def ready(repeat: Repeat, progress: Progress) -> _Ready:
        known = result.band.more if result.band is not None and repeat.family == "modes" else None
        if known is not None:  # f_max = "auto" has made it
            return _Ready(repeat, known[0].system, result.gaps, lambda _: known[1])
        again = repeated_setup(setup, repeat, _substeps(c.time, base))
        model: ReducedModel | ReferenceModel = result.reduced or result.reference
        if isinstance(model, ReducedModel) and repeat.family == "modes":
            model = with_more_modes(again.reduction, result.reference, result.gaps, model, progress)
        gaps = scaled_contact(result.gaps, _scaled(result.gaps, c.contact), repeat.stiffness)
        if repeat.family == "tolerance":  # shorter steps would have harder springs for hard contact of a mass
            gaps = sprung(setup.marching, model.system, gaps)
        observed = Observed(c.verification, again.static, np.zeros(0, dtype=np.int64))
        march = partial(march_run, repeat.name, again.marching, observed, model, gaps)
        return _Ready(repeat, model.system, gaps, march)

    first = Repeat(BASE, "", c.time.step, f_max=None if result.reduced is None else setup.band.f_max)
    outcomes = {BASE: outcome_of(first, base, places.base, places.rubs)}
    if base.stopped is not None:
        notes.append(f"convergence was not looked at: the {base.stopped}")
    elif not result.gaps.presses:
        notes.append("convergence was not looked at: there is no channel that can press")
    else:
        repeats, notes = plan(first, c.contact, base.gaps, setup.connectors, exact=c.time.exact)
        more, said = with_modes(first, c.reduction, result.reduced)
        repeats, notes = [*repeats, *more], [*notes, *said]
        outcomes |= _outcomes(ready, repeats, places, _side_by_side(result.reduced, base), progress)
    if repeats and result.reduced is not None and result.reduced.every_mode:
        same = replace(first, name=MORE_MODES, family="modes")
        outcomes[MORE_MODES] = replace(outcomes[BASE], repeat=same, steps=0, wall_s=0.0)
    unlooked = not_looked_at(c.reduction, result.reduced)
    more_modes = outcomes.get(MORE_MODES)
    none = result.reduced is not None and not result.reduced.complete and not outcomes[BASE].modes
    further = more_modes if more_modes and more_modes.modes and not more_modes.stopped else None
    if none and further and not is_moved(outcomes[BASE].impulse, further.impulse):
        unlooked += (UNEXCITED.format(further.modes),)
    notes += [*unlooked, *(o.stopped for o in outcomes.values() if o.stopped and o.repeat.family)]
    window = (0.0, float(base.history.time[-1])) if c.time.exact else result.window
    found = assess(outcomes, base.name, window, c.verification.event_tolerance, tuple(notes), structure, places)
    return replace(found, unlooked=unlooked, fine=c.time.accuracy == "fine")


def plan(
    base: Repeat, contact: Mapping[str, ContactTable], gaps: GapOperator, connectors: GapOperator, *, exact: bool
) -> tuple[list[Repeat], list[str]]:
    """The runs to make, one for each thing that the answer must not hang on, and what is to be said of those that are
    not made.

    Parameters
    ----------
    gaps : channels of the run. exact : no step is forced.
    """
    finite, own = _scaled(gaps, contact).size > 0, not _chosen(contact)
    hard = int(np.isinf(gaps.stiffness).sum())
    notes = [GIVEN] if finite and own else []
    if exact:
        repeats = [replace(base, name=FINER, family="tolerance", step=base.step / HALVED, refined=HALVED)]
        if finite:
            repeats += [
                replace(base, name=SOFTER, family="softer", stiffness=0.5, judged=not own),
                replace(base, name=STIFFER, family="stiffer", stiffness=2.0, judged=not own),
            ]
        if hard:
            repeats += [
                replace(base, name=YIELDING, family="yielding", harder=0.5),
                replace(base, name=HARDER, family="harder", harder=2.0),
            ]
        return repeats, notes
    h, quarter = base.step, 0.25 * base.step
    repeats = [replace(base, name=name, family="step", step=x) for name, x in ((HALF, 0.5 * h), (QUARTER, quarter))]
    if finite:
        repeats += [
            replace(base, name=name, family="stiffness", step=quarter, stiffness=factor, judged=not own)
            for name, factor in ((TWICE, 2.0), (TENFOLD, 10.0))
        ]
    if hard:
        notes.append(f"{hard} hard channels have no stiffness to vary and stay hard in all runs")
    if connectors.m:
        notes.append("the stiffness of connectors is a figure of the study, no penalty: it stays in all runs")
    if not finite:
        notes.append("no contact has a stiffness to vary: settling with it was not looked at")
    return repeats, notes


def with_modes(base: Repeat, table: ReductionTable, reduced: ReducedModel | None) -> tuple[list[Repeat], list[str]]:
    """The run with more modes, and what is to be said of parts that have no more."""
    if reduced is None:
        return [], []
    if reduced.complete:
        return [], [COMPLETE]
    full = [r.system.name for r in reduced.superelements if r.complete]
    notes = [f"complete, with all modes that there are: {listed(full)}"] if full else []
    if table.method == "guyan" or reduced.every_mode:
        return [], notes
    return [replace(base, name=MORE_MODES, family="modes")], notes


def not_looked_at(table: ReductionTable, reduced: ReducedModel | None) -> tuple[str, ...]:
    """What the reduction may leave out and no run with more modes can tell, a sentence each."""
    if reduced is None or reduced.complete:
        return ()
    said = list[str]()
    if table.method == "guyan":
        said.append("a Guyan reduction keeps no modes: what it leaves out was not looked at (craig-bampton keeps some)")
    if reduced.fewer:
        said.append(
            f'what interface = "{table.interface.type}" leaves out was not looked at ("full" leaves out nothing)'
        )
    if reduced.freed:
        said.append(
            f'interface = "{table.interface.type}" leaves parts free of each other at {reduced.freed} dofs where they '
            'meet, which makes the model softer: what that changes was not looked at ("full" joins all)'
        )
    return tuple(said)


def scaled_contact(gaps: GapOperator, channels: IntArray, factor: float) -> GapOperator:
    """The same with stiffness and pressure curves of `channels` times a factor; hard ones stay so (`Setup.harder`)."""
    by = np.ones(gaps.m)
    by[channels] = factor
    curves = None if gaps.curves is None else replace(gaps.curves, scale=gaps.curves.scale * by)
    return replace(gaps.with_stiffness(gaps.stiffness * by), curves=curves)


def _chosen(contact: Mapping[str, ContactTable]) -> set[str]:
    """Contacts whose stiffness, or the spring that stands for hard, is creak's choice."""
    return {name for name, t in contact.items() if isinstance(t.stiffness, str) and t.overclosure is None}


def _scaled(gaps: GapOperator, contact: Mapping[str, ContactTable]) -> IntArray:
    """Channels whose stiffness is varied: of contacts where it is creak's choice, of all where it is nowhere."""
    return np.flatnonzero(gaps.of_groups(_chosen(contact) or {*contact}) & np.isfinite(gaps.stiffness))


@dataclass(frozen=True)
class _Ready:
    """A repeat whose model is made."""

    repeat: Repeat
    system: System
    gaps: GapOperator
    march: Callable[[Progress], Run]


def _outcomes(
    ready: Callable[[Repeat, Progress], _Ready],
    repeats: Sequence[Repeat],
    places: Followed,
    side_by_side: int,
    progress: Progress,
) -> dict[str, Outcome]:
    """Each run; one that cannot be made has no events and says why.

    Models are made one after the other. So many then march at once, the longest first.
    """
    shared = Shared(progress)

    def failed(repeat: Repeat, error: CreakError) -> Outcome:
        return Outcome(
            repeat=repeat,
            events=(),
            impulse=0.0,
            energy_created=0.0,
            dissipated=0.0,
            steps=0,
            end=0.0,
            wall_s=0.0,
            stopped=f"{repeat.name} was not run: {error}",
        )

    def made(repeat: Repeat) -> _Ready | Outcome:
        try:
            return ready(repeat, _named(repeat, progress))
        except CreakError as error:
            return failed(repeat, error)

    def marched(one: _Ready | Outcome) -> Outcome:
        if isinstance(one, Outcome):
            return one
        repeat, gaps = one.repeat, one.gaps
        try:
            run = one.march(_named(repeat, shared))
            if run.interrupted:  # who presses Ctrl-C waits for no further run
                raise KeyboardInterrupt
            rubs = places.rubs_of(gaps, run.history)
            return outcome_of(repeat, run, places.of(one.system, gaps, run.history), rubs)
        except CreakError as error:
            return failed(repeat, error)

    every = [made(repeat) for repeat in repeats]
    return {o.repeat.name: o for o in at_once(marched, every, side_by_side, shared.halt)}


def _side_by_side(reduced: ReducedModel | None, base: Run) -> int:
    """Runs that march at once: as many as cores, as far as memory holds what each keeps.

    The unreduced model's solver takes all cores by itself.
    """
    if reduced is None:
        return 1
    return max(1, int(min(cores(), free_bytes() / (GROWING * base.history.nbytes))))


def _named(repeat: Repeat, progress: Progress) -> Progress:
    """With the name of the repeat before each phase."""

    def report(stage: str, done: int, total: int) -> None:
        progress(stage if stage.startswith(repeat.name) else f"{repeat.name}: {stage}", done, total)

    return report


def repeated_setup(setup: Setup, repeat: Repeat, substeps: int) -> Setup:
    """The setup over the same time with another step, its loads sampled anew; no fields are kept."""
    c, end = setup.study.config, float(setup.loads.time[-1])
    tables = {
        "time": c.time.model_copy(update={"step": repeat.step, "end": end, "periods": None, "substeps": substeps}),
        "output": c.output.model_copy(update={"interval": c.output.interval or c.time.step, "field_interval": None}),
    }
    return replace(varied(setup, tables), refined=repeat.refined, harder=repeat.harder)


def _substeps(table: TimeTable, base: Run) -> int:
    """Parts into which the base run divided a step near contact: shorter steps are divided into as many."""
    steps = np.diff(base.history.time)
    if table.exact:
        return table.substeps
    return max(table.substeps, round(table.step / float(steps.min())) if steps.size else 1)


def outcome_of(
    repeat: Repeat, run: Run, places: tuple[dict[str, float], ...] = (), rubs: tuple[Rub, ...] = ()
) -> Outcome:
    """What a run found."""
    h = run.history
    return Outcome(
        repeat=repeat,
        events=tuple(run.events),
        impulse=float((h.weights @ h.force).sum()),
        energy_created=h.energy_created,
        dissipated=h.energy_dissipated_by_scheme,
        steps=h.time.size - 1,
        end=float(h.time[-1]),
        wall_s=run.cost.wall_s,
        stopped=run.stopped,
        places=places,
        modes=run.modes,
        rubs=rubs,
    )
