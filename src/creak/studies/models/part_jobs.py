"""Parts of a study as jobs: each is reduced by a worker, which saves it beside the others."""

from __future__ import annotations

import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from creak.arrays import IntArray, Matrix
from creak.contact.gap_operator import GapOperator
from creak.digest import digest
from creak.errors import CreakError, InputError, unforeseen
from creak.progress import silent
from creak.reduction.health import Health
from creak.studies.file.reader import Study
from creak.studies.models.health import check
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import is_saved
from creak.studies.models.substructures import Substructure, part_alone, partition
from creak.studies.models.superelements import made_from, reduce_substructure, save_superelement
from creak.studies.prepare.setup import Setup, set_up


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
    reference: Path | None = None

    def run(self) -> Saved:
        return run_part(self)

    def lost(self, why: str, start: float) -> Saved:
        """Its file where that is there, else `why`."""
        saved = is_saved(self.folder, self.name, self.made_from)
        return Saved(None, None) if saved else Saved(None, None, why)


def part_jobs(
    setup: Setup, reference: ReferenceModel, gaps: GapOperator, folder: Path, ignore: Sequence[str] = ()
) -> list[PartJob]:
    """A job for each part that is to be reduced and whose file is not there yet, the largest first.

    Raises
    ------
    InputError : as `partition`.
    """
    folder, study, jobs = folder.resolve(), setup.study.from_anywhere(), []
    reduction = setup.reduction
    cut = partition(setup.structure, reduction, setup.exterior, reference, gaps)
    for number, sub in enumerate(cut.substructures):
        wanted = made_from(reduction, sub)
        if not sub.stays and not is_saved(folder, sub.part.name, wanted):
            name, given = sub.part.name, (study, number, gaps, sub.boundary, sub.shape, wanted, folder)
            jobs.append((sub.part.n, PartJob(name, digest(wanted), *given, tuple(ignore))))
    return [job for _, job in sorted(jobs, key=lambda pair: -pair[0])]


def run_part(job: PartJob) -> Saved:
    """Reduce a part, check and save it; errors become part of the outcome."""
    try:
        setup = set_up(job.study, job.ignore)
        model, reduction = setup.model, setup.reduction
        part = part_alone(setup.structure, reduction, job.gaps, job.number)
        sub = Substructure(part, job.boundary, job.shape, job.boundary[:0], False)
        _same(job, made_from(reduction, sub))
        reduced, notes = reduce_substructure(model, reduction, setup.exterior, sub, job.folder, silent)
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
