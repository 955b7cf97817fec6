"""The whole main job: a study that is set up in, everything that is found of it out. A case of a sweep is the same."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal

from creak.linalg.threads import one_blas_thread
from creak.progress import Progress
from creak.studies.file.paths import store_of
from creak.studies.findings.gather import findings_of
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.unit_check import other_units
from creak.studies.run.checkpoint import Checkpoints
from creak.studies.run.job import ReducedRun, ReferenceRun, StudyResult, run_study
from creak.studies.warned import Warned, attempted

if TYPE_CHECKING:
    from creak.formats.stored.results import RunRecord
    from creak.studies.converge.settling import Convergence
    from creak.studies.sound.heard import Sound

Changes = Literal["none", "predicted", "checked"]
LONG = 60.0
"""Seconds that a run took from which it is written at once; a shorter one is sooner run again than written twice."""


@dataclass(frozen=True)
class Evaluation:
    """What a study ran, and what it found."""

    found: StudyResult = field(repr=False)
    """Models, matrices and histories."""
    findings: Findings = field(repr=False)
    """What all files, tables and pages are views of."""
    sound: Sound | str | None = field(default=None, repr=False)
    """What is heard of the contacts at each listener, or why nothing is."""

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of summary.json (docs/results.md)."""
        return summary_of(self.findings)

    def records(self) -> dict[str, RunRecord]:
        """What results.h5 holds of each run."""
        from creak.studies.findings.histories import record_of

        setup = self.found.setup
        of = setup.model.nodes, setup.watch, setup.marching
        return {name: record_of(run, *of) for name, run in self.found.runs.items()}

    @property
    def convergence(self) -> Convergence | None:
        """What `converge` found; None: it was not asked for."""
        return self.findings.convergence


@one_blas_thread()
def evaluate(
    setup: Setup,
    progress: Progress,
    *,
    store: Store | None = None,
    converge: bool | None = None,
    record: bool = True,
    changes: Changes = "none",
    checkpoints: Checkpoints | None = None,
    reference_run: ReferenceRun | None = None,
    first: Callable[[Evaluation], object] | None = None,
) -> Evaluation:
    """Run a study, then hear it, repeat it and look for causes.

    The run is what costs; what is told of it must not lose it. A failure or Ctrl-C in sound, repeats or causes leaves
    that out and becomes a note that warns.

    Parameters
    ----------
    store : of superelements; None: those saved beside the study are taken, and none are kept.
    converge, record, changes : as `creak.run` has them.
    checkpoints : from which an unreduced run goes on, and which it writes.
    reference_run : makes the run of the unreduced model, or takes a saved one.
    first : gets a run that took `LONG` as soon as it is there, before anything is told of it: to keep it.

    Raises
    ------
    InputError : what is asked for does not fit the model, or is not there. NumericalError : a reduction or a
        factorisation failed.
    """
    store = store or Store(store_of(setup.study.path))
    from creak.studies.converge.auto_band import settle
    from creak.studies.spots.beside import beside_unreduced, events_beside

    proof, said_of_proof = setup.study.config.proof, list[str]()
    prove = None if proof == "none" else partial(events_beside, notes=said_of_proof)
    options: dict[str, Any] = {"record": record, "checkpoints": checkpoints}
    raising = partial(settle, prove=prove, store=store)
    table = setup.study.config.time
    quick = table.accuracy == "quick"  # f_max = "auto" stays where it begins
    told = converge is not False or changes != "none"
    least, begun, convergence = 0, time.perf_counter(), None
    while True:
        settles = None if quick else partial(raising, least=least)
        found = run_study(setup, progress, store, reference_run, **options, settle=settles)
        is_long = time.perf_counter() - begun >= LONG

        from creak.studies.cause.effects import causes_of  # what comes after the run is not waited for before it
        from creak.studies.converge.repeats import converge as repeat
        from creak.studies.converge.settled import lacks_modes
        from creak.studies.findings.histories import followed
        from creak.studies.findings.measured import beside_tests
        from creak.studies.findings.places import find_places
        from creak.studies.findings.sound import heard_places
        from creak.studies.sound.heard import NO_MODES, Sound, hear

        main, notes = found.main, [*found.notes, *said_of_proof]
        worth = table.exact and not quick and "reduced" in found.runs and found.stopped is None and found.gaps.presses
        repeated = worth if converge is None else converge
        if first is not None and is_long and (repeated or changes != "none"):
            attempted("a first copy of the results", partial(_hand_over, found, first), None, notes)
        progress("sound", 0, 1)
        places = [] if main is None else [p.channels for p in find_places(found.scope, main)]
        silence: Sound | str = "none: it could not be computed"
        if odd := other_units(setup.model, setup.study.config.model.units):
            sound: Sound | str = f"none: {odd}, so nothing is known in Pa"
        else:
            of = found.setup.marching, found.setup.reduction, found.reference, found.reduced
            whole = None if found.stopped is not None else main
            heard = partial(hear, found.setup.study.listening, *of, whole, places)
            sound = attempted("sound", heard, silence, notes)
        progress("sound", 1, 1)
        if repeated:
            structure = beside_unreduced(found, heard_places(found.scope, main, sound), progress, notes)
            again = partial(repeat, found, progress, followed(found.scope, main, sound), structure)
            convergence = attempted("repeated runs", again, None, notes)
        lacking = convergence is not None and lacks_modes(convergence) and "reference" not in found.runs
        least = _stages_that_ended(found.band) if lacking and found.stopped is None else 0
        if not least:
            break
        said_of_proof.clear()
    if isinstance(sound, Sound):
        notes += sound.notes
    elif setup.study.config.listener:
        notes.append(Warned(f"no sound: {sound}"))
    elif sound == NO_MODES and places:
        notes.append(f"forces, but no loudness of what touches: {NO_MODES.removeprefix('none: ')}")
    causes: dict[int, dict[str, Any]] = {}
    if told:
        nothing: tuple[dict[int, dict[str, Any]], list[str]] = {}, []
        causes, said = attempted("causes", lambda: causes_of(found, sound, progress, changes), nothing, notes)
        notes += said
    tests = beside_tests(found, sound, progress, notes)
    found = replace(found, notes=notes)
    return Evaluation(found, findings_of(found, convergence, sound, causes, tests), sound)


def _stages_that_ended(band: ReducedRun | None) -> int:
    """Stages of f_max = "auto" that the answer ended and not their cost; 0: none did, or no mode would change it."""
    if band is None or band.why or band.run.stopped is not None:
        return 0
    return 0 if band.reduced.every_mode or band.reduced.thinned else len(band.stages)


def _hand_over(found: StudyResult, first: Callable[[Evaluation], object]) -> None:
    first(Evaluation(found, findings_of(found)))
