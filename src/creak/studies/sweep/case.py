"""One case of a sweep: run, and its folder, which holds the complete result or is not there.

Runs of the unreduced model that several cases share are kept once."""

from __future__ import annotations

import os
import platform
import shutil
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from threadpoolctl import threadpool_info

from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.record.watch import Extremes
from creak.errors import CreakError, InputError, NumericalError, unforeseen
from creak.formats.complete_file import complete_file, write_text
from creak.formats.destination import partial_name
from creak.formats.stored.npz_arrays import read_arrays
from creak.formats.stored.run_identity import RESULTS, SUMMARY, identity_in, identity_of
from creak.formats.stored.sealed import Damaged, opened_hdf5, read_sealed, sealed_text
from creak.progress import Progress, silent
from creak.studies.evaluate import Evaluation, evaluate
from creak.studies.file.config import VerificationTable
from creak.studies.file.reader import read_study
from creak.studies.findings.save import save
from creak.studies.findings.summary import unreliable_runs
from creak.studies.models.reduced import ReducedModel
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import Store
from creak.studies.prepare.marching import Marching, Observed
from creak.studies.prepare.setup import set_up
from creak.studies.run.compared import Cost
from creak.studies.run.one_run import Run, march_run
from creak.studies.sweep.figures import flat_figures
from creak.verify.events import find_events
from creak.verify.reliability import UNRELIABLE
from creak.verify.slips import find_slips
from creak.version import version

ROUND_OFF = 1e-9
"""Share of its end by which a run may miss it."""


class SharedReference:
    """Takes the run of the unreduced model from a file, or makes it and writes the file.

    Parameters
    ----------
    path : named after everything that the run depends on; two that write it at once write the same.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.reused = False

    def __call__(
        self, marching: Marching, observed: Observed, reference: ReferenceModel, gaps: GapOperator, progress: Progress
    ) -> Run:
        """The run; what came from the file has the cost that it had when it was made."""
        run = _read(self.path, marching, observed.verification, reference, gaps)
        self.reused = run is not None
        if run is not None:
            return replace(run, notes=("taken from another case, with its costs",))
        run = march_run("reference", marching, observed, reference, gaps, progress)
        if run.stopped is None:
            _write(self.path, run, gaps)
        return run


def _write(path: Path, run: Run, gaps: GapOperator) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    history = {f"history_{f.name}": getattr(run.history, f.name) for f in fields(History) if f.name != "extremes"}
    seen = run.history.extremes
    watched = {} if seen is None else {f"seen_{f.name}": getattr(seen, f.name) for f in fields(Extremes)}
    cost = {f"cost_{f.name}": getattr(run.cost, f.name) for f in fields(Cost)}
    with complete_file(path, kept=True) as partial, partial.open("wb") as file:
        np.savez(
            file,
            allow_pickle=False,
            integrator=np.array(run.integrator),
            channels=np.array(gaps.names, dtype=str),
            n=np.array(run.system.n),
            **{
                k: np.asarray(v, dtype=str if isinstance(v, tuple) else None)
                for k, v in {**history, **watched, **cost}.items()
            },
        )


def _named(x: Any) -> Any:
    """Names as they were, a tuple of words."""
    return tuple(x.tolist()) if x.dtype.kind == "U" else x


def _read(
    path: Path, marching: Marching, v: VerificationTable, reference: ReferenceModel, gaps: GapOperator
) -> Run | None:
    """The saved run; None where there is none, it is damaged, or has another end, other channels or coordinates."""
    try:
        saved: dict[str, Any] = {k: a if a.ndim else a.item() for k, a in read_arrays(path).items()}
        seen = Extremes(**{f.name: _named(saved[f"seen_{f.name}"]) for f in fields(Extremes)})
        own = {f.name: saved[f"history_{f.name}"] for f in fields(History) if f.name != "extremes"}
        history = History(**own, extremes=seen)
        cost = Cost(**{f.name: saved[f"cost_{f.name}"] for f in fields(Cost)})
    except (Damaged, KeyError):
        return None
    if saved["n"] != reference.system.n or saved["channels"].tolist() != list(gaps.names):
        return None
    end = float(marching.loads.time[-1])
    if not history.time.size or abs(history.time[-1] - end) > ROUND_OFF * end:
        return None
    events, slips = find_events(history, gaps, v.merge, v.f_max), tuple(find_slips(history, gaps, v.merge, v.f_max))
    of = {"name": "reference", "integrator": saved["integrator"], "cost": cost, "events": events, "slips": slips}
    return Run(reference.system, gaps, history, **of)


RECORD = "case.json"
DONE, FAILED, NOT_RUN = "done", "failed", "not run"
WHY = "unreliable"
"""Key of a record: why its figures are worth nothing; empty where nothing speaks against them."""

Write = Callable[[Evaluation, Path], object]


@dataclass(frozen=True)
class Task:
    """What a worker needs to run a case; all paths absolute."""

    name: str
    id: str
    study: Path
    folder: Path
    """Of its results."""
    superelements: Path
    """Folder shared by all cases."""
    reference: Path | None
    """File of the run of the unreduced model, shared by the cases that have the same."""
    hashes: Mapping[str, str]
    """For the record: of the study and of the deck."""
    creak: str
    """Version that the results are to come from."""
    ignore: tuple[str, ...] = ()
    write: Write | None = None
    """Writes the results into the folder; None: without what a page shows."""
    converge: bool | None = None
    """As `creak.run` has it."""

    def run(self) -> Outcome:
        return run_case(self)

    def lost(self, why: str, start: float) -> Outcome:
        """Its result where that is there, else `why`."""
        record = finished_record(self.folder, self.id)
        return ended(record) if record is not None else Outcome(FAILED, why, provenance(self, start))


@dataclass(frozen=True)
class Outcome:
    """How a case ended."""

    status: str
    error: str
    record: Mapping[str, Any]
    """Figures and provenance, plain data."""


def run_case(task: Task) -> Outcome:
    """Run a case unless its folder has the result already; errors become part of the outcome."""
    record = finished_record(task.folder, task.id)
    if record is not None:
        return ended(record)
    start = time.perf_counter()
    error = ""
    try:
        return ended(_made(task, start))
    except CreakError as problem:
        error = str(problem)
    except MemoryError:
        error = "out of memory; use fewer workers, a coarser mesh or fewer outputs"
    except Exception as problem:
        error = unforeseen(problem)
    return Outcome(FAILED, error, provenance(task, start))


def ended(record: Mapping[str, Any]) -> Outcome:
    """How a case with a result ended: done, or unreliable with the reason in place of an error."""
    why = record.get(WHY, "")
    return Outcome(UNRELIABLE if why else DONE, why, record)


def _made(task: Task, start: float) -> dict[str, Any]:
    if task.creak != version():
        raise InputError(
            f"the worker on {socket.gethostname()} has creak {version()}, the sweep was started with {task.creak}",
            fix="Install the same version everywhere.",
        )
    if not task.study.is_file():
        raise InputError(
            f"the worker on {socket.gethostname()} does not see {task.study}",
            expected="a folder that all workers share",
            fix="Name one with --out.",
        )
    setup = set_up(read_study(task.study), task.ignore, task.superelements)
    reference = None if task.reference is None else SharedReference(task.reference)
    case = evaluate(
        setup,
        silent,
        store=Store(task.superelements, "all"),
        converge=task.converge,
        reference_run=reference,
        record=False,
    )
    result, summary = case.found, case.summary
    sharing = _superelements(result.reduced)
    if result.stopped is not None:
        raise NumericalError(result.stopped)
    sharing["reference_reused"] = reference is not None and reference.reused
    why = "; ".join(unreliable_runs(summary))
    record = {
        "id": task.id,
        "run_id": result.identity.id,
        "name": task.name,
        WHY: why,
        **flat_figures(summary),
        **sharing,
    }

    def write(folder: Path) -> None:
        if task.write is None:
            save(case.findings, case.records(), folder)
        else:
            task.write(case, folder)
        record.update(provenance(task, start))
        write_text(folder / RECORD, sealed_text(record, allow_nan=True))

    publish(task.folder, task.id, write)
    return record


def _superelements(reduced: ReducedModel | None) -> dict[str, Any]:
    """How many were reduced anew, and how many were not."""
    made = () if reduced is None else reduced.superelements
    reused = sum(r.reused for r in made)
    return {"superelements_reused": reused, "superelements_made": len(made) - reused}


def publish(folder: Path, id: str, write: Callable[[Path], None]) -> None:
    """Have `write` fill a hidden folder, then rename it; a result of an older study gives way to it."""
    partial = folder.with_name(partial_name(folder.name))
    partial.mkdir(parents=True)
    try:
        write(partial)
        if folder.exists() and finished_record(folder, id) is None:
            old = folder.with_name(partial_name(folder.name))
            os.rename(folder, old)
            shutil.rmtree(old, ignore_errors=True)
        try:
            os.rename(partial, folder)
        except OSError:
            if finished_record(folder, id) is None:  # else another worker has finished the same case meanwhile
                raise
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def finished_record(folder: Path, id: str | None = None) -> dict[str, Any] | None:
    """The record of a finished case; None where there is none, one with another id, or files of several runs."""
    try:
        record = read_sealed(folder / RECORD)
    except (OSError, ValueError):
        return None
    fits = "id" in record and id in (None, record["id"])
    return record if fits and _of_one_run(folder, record.get("run_id")) else None


def _of_one_run(folder: Path, run_id: str | None) -> bool:
    """Whether summary.json and results.h5, where they are there, are of the run of the record."""
    summary, results = folder / SUMMARY, folder / RESULTS
    try:
        if summary.exists():
            of_summary = identity_of(read_sealed(summary))
            if run_id != (None if of_summary is None else of_summary.id):
                return False
        if results.exists():
            with opened_hdf5(results) as file:
                of_results = identity_in(file)
            return run_id == (None if of_results is None else of_results.id)
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return True


def provenance(task: Task, start: float) -> dict[str, Any]:
    """Where a row of the table comes from."""
    return {
        "case_wall_s": time.perf_counter() - start,
        "creak": version(),
        **task.hashes,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": socket.gethostname(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "threads": max((int(pool["num_threads"]) for pool in threadpool_info()), default=1),
    }
