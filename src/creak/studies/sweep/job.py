"""A sweep: every case that has no result yet is run by worker processes, here or on a cluster.

What is there stands in a table, a row for each case, as sweep.csv and sweep.h5."""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from creak.errors import InputError
from creak.formats.complete_file import complete_file, write_text
from creak.formats.destination import remove_dead
from creak.formats.measured.csv_rows import plain_cell, plain_row
from creak.formats.stored.sealed import hdf5_file
from creak.studies.sweep.case import NOT_RUN, RECORD, Outcome, Task, Write, ended, finished_record
from creak.studies.sweep.cases import Case, shown
from creak.studies.sweep.figures import OF_EVENTS, OF_RUNS, RUNS, unit_of
from creak.studies.sweep.file import SweepFile
from creak.studies.tasks.queue import Runner
from creak.version import version

CHECKS = ("nrmse_x", "nrmse_y", "nrmse_z", "nrmse_all", "worst_mac", *OF_EVENTS)
SHARED = ("superelements_reused", "superelements_made", "reference_reused")
PROVENANCE = (
    *("case_wall_s", "units", "creak", "run_id", "study_hash", "deck_hash", "date", "host", "python", "numpy"),
    *("scipy", "threads"),
)
FIGURES = (*(f"{run}.{key}" for run in RUNS for key in OF_RUNS), *CHECKS, *SHARED, *PROVENANCE)


@dataclass(frozen=True)
class Row:
    """A case and how it ended."""

    case: Case
    outcome: Outcome


def waiting(case: Case) -> Row:
    """The row of a case that has not been run."""
    return Row(case, Outcome(NOT_RUN, "", {"study_hash": case.study_hash, "deck_hash": case.deck_hash}))


def columns(rows: Sequence[Row]) -> dict[str, list[Any]]:
    """Column -> cells, None where a case has no such figure. Figures that no case has are left out."""
    out: dict[str, list[Any]] = {"case": [r.case.name for r in rows]}
    for key in rows[0].case.changes if rows else ():
        out[key] = [shown(r.case.changes[key]) for r in rows]
    out["seed"] = [r.case.seed for r in rows]
    out["status"] = [r.outcome.status for r in rows]
    out["error"] = [r.outcome.error for r in rows]
    for name in FIGURES:
        cells = [r.outcome.record.get(name) for r in rows]
        if any(c is not None for c in cells):
            out[name] = cells
    return out


def write_table(sweep: SweepFile, rows: Sequence[Row], folder: Path) -> list[Path]:
    """Write sweep.csv and sweep.h5 into `folder`; each appears under its name only when complete."""
    table = columns(rows)
    text, binary = folder / "sweep.csv", folder / "sweep.h5"
    with complete_file(text) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(plain_row(list(table)))
        writer.writerows(zip(*(map(_cell, cells) for cells in table.values()), strict=True))
    units = next((r.outcome.record["units"] for r in rows if "units" in r.outcome.record), None)
    with complete_file(binary, stream=False) as partial, hdf5_file(partial) as out:
        file = out.file
        file.attrs.update(_attributes(sweep, table))
        for name, cells in table.items():
            data = file.create_dataset(name, data=_array(cells), dtype=_dtype(cells))
            if unit_of(name, units):
                data.attrs["unit"] = unit_of(name, units)
    return [text, binary]


def _attributes(sweep: SweepFile, table: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "title": sweep.config.title,
        "sweep": sweep.text,
        "base": str(sweep.base),
        "creak": version(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "columns": list(table),
    }


def _cell(value: Any) -> Any:
    """Numbers so that they read back the same; one line of text."""
    if value is None:
        return ""
    if isinstance(value, str):
        return plain_cell(" ".join(value.split()))
    return repr(value).lower() if isinstance(value, bool) else repr(value)


def _numbers(cells: Sequence[Any]) -> bool:
    return all(c is None or isinstance(c, int | float) for c in cells) and any(c is not None for c in cells)


def _dtype(cells: Sequence[Any]) -> Any:
    if not _numbers(cells):
        return h5py.string_dtype()
    whole = all(isinstance(c, int) and not isinstance(c, bool) for c in cells)
    return np.int64 if whole else bool if all(isinstance(c, bool) for c in cells) else np.float64


def _array(cells: Sequence[Any]) -> Any:
    """Numbers as an array, NaN where there is none; words otherwise."""
    if not _numbers(cells):
        return ["" if c is None else str(c) for c in cells]
    dtype = _dtype(cells)
    return np.array([np.nan if c is None else c for c in cells], dtype=dtype)


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
