"""A sweep: every case that has no result yet is run by worker processes, here or on a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from creak.errors import InputError
from creak.formats.complete_file import write_text
from creak.formats.partials import remove_dead
from creak.studies.sweep.case import RECORD, Outcome, Task, Write, ended, finished_record
from creak.studies.sweep.cases import Case
from creak.studies.sweep.file import SweepFile
from creak.studies.sweep.table import Row, waiting, write_table
from creak.studies.tasks.queue import Runner
from creak.version import version

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
            raise InputError(
                f"{folder} is in the way: it is no result of a sweep, or not all of one run",
                fix="Move it, or use --out.",
            )
        if record is None and case.id in spare:
            old = out / spare.pop(case.id)
            record = finished_record(old)
            if rename:
                os.rename(old, folder)
        if record is not None and record["id"] == case.id:
            found[case.name] = ended(record)
    return found


def tasks_of(
    cases: Sequence[Case],
    out: Path,
    ignore: Sequence[str] = (),
    write: Write | None = None,
) -> dict[str, Task]:
    """Name -> task; the studies of the cases are written beside their folders."""
    out, tasks = out.resolve(), {}
    for case in cases:
        study = out / f"{case.folder_name}.toml"
        if not study.is_file() or study.read_bytes() != case.text.encode("utf-8"):
            write_text(study, case.text)
        reference = None if case.reference_key is None else out / "references" / f"{case.reference_key}.npz"
        hashes = {"study_hash": case.study_hash, "deck_hash": case.deck_hash}
        tasks[case.name] = Task(
            name=case.name,
            id=case.id,
            study=study,
            folder=out / case.folder_name,
            superelements=out / "superelements",
            reference=reference,
            hashes=hashes,
            creak=version(),
            ignore=tuple(ignore),
            write=write,
            converge=case.converge,
        )
    return tasks


def run_sweep(
    sweep: SweepFile,
    cases: Sequence[Case],
    out: Path,
    outcomes: Runner,
    tasks: Mapping[str, Task],
    known: Mapping[str, Outcome],
    progress: Progress,
) -> list[Row]:
    """Run the cases that are not `known`; the rows of all, in order. sweep.csv and sweep.h5 are written on the way.

    A case whose worker dies time and again has failed, like one that raises. An interruption leaves the table of what
    ended.

    Parameters
    ----------
    outcomes : runs tasks, on this machine (`sweep_workers`) or on a cluster (`sweep_cluster`).
    """
    rows = {c.name: Row(c, known[c.name]) if c.name in known else waiting(c) for c in cases}
    by_name, done, written = {c.name: c for c in cases}, len(known), time.monotonic()
    try:
        for name, outcome in outcomes([tasks[c.name] for c in cases if c.name not in known]):
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
