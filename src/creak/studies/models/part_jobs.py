"""Parts of a study as jobs: each is reduced by a worker, which saves it beside the others.

For `creak reduce` a worker looks at the superelement's health too. For a run it keeps what the run itself would keep.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from creak.arrays import IntArray, Matrix
from creak.contact.gap_operator import GapOperator
from creak.digest import digest
from creak.errors import CreakError, InputError, unforeseen
from creak.progress import Progress, silent
from creak.reduction.health import Health
from creak.studies.file.reader import Study
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import Keep, Store, is_kept, is_saved
from creak.studies.models.substructures import Substructure, part_alone, partition
from creak.studies.models.superelements import made_from, reduce_substructure, save_superelement
from creak.studies.prepare.reduction import Reduction
from creak.studies.prepare.setup import set_up
from creak.studies.tasks.queue import Runner

IN_WORKERS = "reduce the parts in workers"


@dataclass(frozen=True)
class Saved:
    """What became of a part."""

    health: Health | None
    path: Path | None
    error: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class PartJob:
    """What a worker needs to reduce a part; all paths absolute."""

    name: str
    id: str
    study: Study
    number: int
    """Of the part, in the model as it is cut."""
    gaps: GapOperator
    """Channels kept: with keep_out they say where the model is cut."""
    boundary: IntArray
    shape: Matrix | None
    made_from: Mapping[str, str]
    """What the worker has to find too."""
    folder: Path
    ignore: tuple[str, ...]
    keep: Keep = "nothing"
    """What stays of it for a run; "nothing": it is saved as `creak reduce` does."""
    raised: int = 0
    """How often f_max was."""
    reference: Path | None = None

    def run(self) -> Saved:
        return run_part(self)

    def lost(self, why: str, start: float) -> Saved:
        """Its file where that is there, else `why`."""
        saved = self.keep == "nothing" and is_saved(self.folder, self.name, self.made_from)
        return Saved(None, None) if saved else Saved(None, None, why)


def part_jobs(reduction: Reduction, reference: ReferenceModel, gaps: GapOperator, store: Store) -> list[PartJob]:
    """A job for each part that is to be reduced and whose file is not there yet, the largest first.

    Raises
    ------
    InputError : as `partition`.
    """
    if store.folder is None or store.study is None:
        raise ValueError("workers set up a study, and hand over what they reduce in a folder")
    folder, study, jobs = store.folder.resolve(), store.study.from_anywhere(), []
    there = is_saved if store.keep == "nothing" else is_kept
    for number, sub in enumerate(partition(reduction, reference, gaps).substructures):
        wanted = made_from(reduction, sub)
        if not sub.stays and not there(folder, sub.part.name, wanted):
            name, given = sub.part.name, (study, number, gaps, sub.boundary, sub.shape, wanted, folder)
            job = PartJob(name, digest(wanted), *given, store.ignore, store.keep, reduction.band.raised)
            jobs.append((sub.part.n, job))
    return [job for _, job in sorted(jobs, key=lambda pair: -pair[0])]


def reduce_elsewhere(
    reduction: Reduction, reference: ReferenceModel, gaps: GapOperator, store: Store, progress: Progress
) -> list[str]:
    """Have the workers of a store, where it has some, reduce what is not there yet; notes for people.

    What a worker could not reduce, whoever waits for it does by itself.
    """
    if store.runner is None:
        return []
    notes = list[str]()
    for name, saved in ended(store.runner, part_jobs(reduction, reference, gaps, store), progress):
        notes += [f"superelement {name}: reduced here, for the worker could not: {saved.error}"] if saved.error else []
        notes += saved.notes
    return notes


def ended(runner: Runner, jobs: Sequence[PartJob], progress: Progress) -> Iterator[tuple[str, Saved]]:
    """Name of each part, and what became of it, as its worker tells."""
    if not jobs:
        return
    progress(IN_WORKERS, 0, len(jobs))
    for done, told in enumerate(runner(jobs), start=1):
        progress(IN_WORKERS, done, len(jobs))
        yield told


def run_part(job: PartJob) -> Saved:
    """Reduce a part, check and save it; errors become part of the outcome."""
    try:
        reduction = replace(set_up(job.study, job.ignore, job.folder), raised=job.raised).reduction
        model, part = reduction.structure.model, part_alone(reduction, job.gaps, job.number)
        sub = Substructure(part, job.boundary, job.shape, job.boundary[:0], False)
        _same(job, made_from(reduction, sub))
        reduced, notes = reduce_substructure(reduction, sub, Store(job.folder, job.keep), silent)
        if job.keep != "nothing":
            return Saved(None, None, notes=tuple(notes))
        from creak.studies.models.health import check  # a run does not wait for it

        health, about = None, dict[str, Any](deck=str(model.source))
        try:
            health = check(reduced, model.nodes, reduction.band.excited)
            about["health"] = health.as_dict()
        finally:
            path = save_superelement(job.folder, reduced, model, about)
        return Saved(health, path, notes=tuple(notes))
    except CreakError as problem:
        return Saved(None, None, str(problem))
    except MemoryError:
        return Saved(None, None, f"out of memory on {socket.gethostname()}; use fewer workers")
    except Exception as problem:
        return Saved(None, None, unforeseen(problem))


def _same(job: PartJob, found: Mapping[str, str]) -> None:
    """Raise InputError where this machine makes another part of the study than the one that sent the job."""
    other = [key for key, value in job.made_from.items() if found[key] != value]
    if other:
        raise InputError(
            f"the worker on {socket.gethostname()} finds another part {job.name} in {job.study.path}: its "
            f"{', '.join(other)}",
            expected="the same creak, study and deck under the same path on all machines",
        )
