"""A sweep: every case that has no result yet is run on the workers of a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import creak
from creak.errors import InputError
from creak.formats.complete_file import write_text
from creak.formats.partials import remove_dead
from creak.studies.sweep_case import (
    DONE,
    FAILED,
    RECORD,
    Outcome,
    Report,
    Task,
    finished_record,
    provenance,
    run_case,
)
from creak.studies.sweep_cases import Case
from creak.studies.sweep_file import SweepFile
from creak.studies.sweep_table import Row, waiting, write_table

if TYPE_CHECKING:
    from distributed import Client, Future

RETRIES = 2
"""Of a case whose worker was lost in a way that the scheduler does not see by itself."""
EVERY = 10.0
"""s between tables written on the way."""

Progress = Callable[[Row, int, int], None]
"""Called with each case that ends, how many have, and of how many."""


def finished(cases: Sequence[Case], out: Path, *, rename: bool = True) -> dict[str, Outcome]:
    """Name -> outcome of the cases that need no run; results that lie under another name are renamed.

    Raises
    ------
    InputError : a folder that a case needs holds something else.
    """
    wanted = {c.folder_name for c in cases}
    folders = [p.parent for p in out.glob(f"*/{RECORD}") if not p.parent.name.startswith(".")]
    records = {folder.name: finished_record(folder) for folder in folders}
    spare = {r["id"]: name for name, r in records.items() if r is not None and name not in wanted}
    found = {}
    for case in cases:
        folder, record = out / case.folder_name, records.get(case.folder_name)
        if record is None and folder.exists():
            raise InputError(f"{folder} is in the way: it is no result of a sweep, or not all of one run",
                             fix="Move it, or use --out.")  # fmt: skip
        if record is None and case.id in spare:
            old = out / spare.pop(case.id)
            record = finished_record(old)
            if rename:
                os.rename(old, folder)
        if record is not None and record["id"] == case.id:
            found[case.name] = Outcome(DONE, "", record)
    return found


def tasks_of(
    cases: Sequence[Case], out: Path, ignore: Sequence[str] = (), report: Report | None = None
) -> dict[str, Task]:
    """Name -> task; the studies of the cases are written beside their folders."""
    out, tasks = out.resolve(), {}
    for case in cases:
        study = out / f"{case.folder_name}.toml"
        if not study.is_file() or study.read_text(encoding="utf-8") != case.text:
            write_text(study, case.text)
        reference = None if case.reference_key is None else out / "references" / f"{case.reference_key}.npz"
        hashes = {"study_hash": case.study_hash, "deck_hash": case.deck_hash}
        tasks[case.name] = Task(
            case.name, case.id, study, out / case.folder_name, out / "superelements", reference, hashes,
            creak.__version__, tuple(ignore), report,
        )  # fmt: skip
    return tasks


@dataclass
class Queue:
    """Tasks not yet started. Of those that need the same reference run one goes first, the others wait for it."""

    tasks: list[Task]
    _making: set[Path] = field(default_factory=set)

    def ready(self, free: int) -> list[Task]:
        """Tasks that may start now, no more than `free`; they leave the queue."""
        out: list[Task] = []
        for task in list(self.tasks):
            if len(out) >= free:
                break
            path = task.reference
            if path is not None and not path.exists():
                if path in self._making:
                    continue
                self._making.add(path)
            self.tasks.remove(task)
            out.append(task)
        return out

    def ended(self, task: Task) -> None:
        """A task ended, in whatever way; if it left no reference, the next one makes it."""
        if task.reference is not None:
            self._making.discard(task.reference)


def run_sweep(
    sweep: SweepFile, cases: Sequence[Case], out: Path, client: Client, tasks: Mapping[str, Task],
    known: Mapping[str, Outcome], progress: Progress,
) -> list[Row]:  # fmt: skip
    """Run the cases that are not `known`; the rows of all, in order. sweep.csv and sweep.h5 are written on the way.

    A worker that dies is replaced and its case run again; a case whose worker dies more often than the
    scheduler allows has failed, like one that raises. An interruption leaves the table of what ended.
    """
    rows = {c.name: Row(c, known[c.name]) if c.name in known else waiting(c) for c in cases}
    by_name, done, written = {c.name: c for c in cases}, len(known), time.monotonic()
    try:
        for name, outcome in outcomes(client, [tasks[c.name] for c in cases if c.name not in known]):
            rows[name] = Row(by_name[name], outcome)
            done += 1
            progress(rows[name], done, len(cases))
            if time.monotonic() - written > EVERY:
                write_table(sweep, list(rows.values()), out)
                written = time.monotonic()
    finally:
        write_table(sweep, list(rows.values()), out)
        remove_dead(out)
    return list(rows.values())


def outcomes(client: Client, tasks: Sequence[Task]) -> Iterator[tuple[str, Outcome]]:
    """Yield (name, outcome) of every task as it ends.

    No more tasks are handed out than there are workers: one that kills its worker takes no other along.
    """
    from distributed import as_completed

    queue, start, most = Queue(list(tasks)), time.perf_counter(), 1
    running: dict[str, Task] = {}
    submitted = as_completed(raise_errors=False)

    def submit() -> None:
        nonlocal most
        most = max(most, len(client.scheduler_info(n_workers=-1)["workers"]))
        for task in queue.ready(most - len(running)):
            future = client.submit(run_case, task, key=f"{task.name}-{task.id}", pure=False, retries=RETRIES)
            running[future.key] = task
            submitted.add(future)

    submit()
    for future in submitted:
        task = running.pop(future.key)
        queue.ended(task)
        outcome = _outcome(future, task, start)
        future.release()
        submit()
        yield task.name, outcome


def _outcome(future: Future, task: Task, start: float) -> Outcome:
    if future.status == "finished":
        return future.result()
    record = finished_record(task.folder, task.id)
    if record is not None:
        return Outcome(DONE, "", record)
    error = future.exception() if future.status == "error" else None
    lost = type(error).__name__ == "KilledWorker"
    why = "its worker process died every time (out of memory?)" if lost else str(error or f"{future.status} by dask")
    return Outcome(FAILED, why, provenance(task, start))
