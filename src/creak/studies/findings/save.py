"""What a study leaves on disk: summary.json, results.h5, convergence.csv and report.html, together or not at all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path

import h5py

from creak.errors import InputError
from creak.formats.complete_file import files_together, write_bytes, write_text
from creak.formats.destination import destination, remove_dead
from creak.formats.measured.csv_rows import plain_row
from creak.formats.stored.results import RunRecord, put_results
from creak.formats.stored.run_identity import CONVERGENCE, REPORT, RESULTS, SUMMARY, stale_files, write_identity
from creak.formats.stored.sealed import sealed_text
from creak.formats.stored.tree import write_tree
from creak.studies.converge.settling import Convergence
from creak.studies.converge.words import csv_rows
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings


def check_folder(folder: Path) -> None:
    """Check that the files of a run can stand in `folder`.

    Raises
    ------
    InputError : one of their names is taken by a folder, a pipe or another node.
    """
    for name in (RESULTS, CONVERGENCE, REPORT, SUMMARY):
        destination(folder / name, stream=False)


def save(
    findings: Findings,
    records: Mapping[str, RunRecord],
    folder: Path,
    more: Callable[[h5py.File], None] | None = None,
    page: str | None = None,
) -> list[Path]:
    """Write the files of a run into `folder` (made if need be); all appear when the last of them is complete.

    summary.json is the last to appear and the first of its predecessors to go: where it is, all others are of its run.
    Page and table of an earlier run that this one does not replace are removed.

    Parameters
    ----------
    records : of each run, by name, as `histories.record_of` makes them.
    more : writes what else belongs into results.h5, the mesh included; without it the mesh is there with fields only.
    page : the text of report.html.

    Raises
    ------
    WriteError : the disk is full, or fails; what was there before is as it was.
    """
    check_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    remove_dead(folder)
    run, convergence = findings.identity, findings.convergence
    study, units = findings.setup.study, findings.setup.study.config.model.units
    attributes = {"creak": findings.creak, "title": study.config.title, "units": units, "study": study.text}
    bare = more is None and any(record.field is not None for record in records.values())

    def rest(file: h5py.File) -> None:
        write_identity(file, run)
        if bare:
            write_tree(file.create_group("model"), findings.setup.model)
        elif more is not None:
            more(file)

    text = sealed_text(summary_of(findings))
    texts = {CONVERGENCE: None if convergence is None else _table(convergence, run.id), REPORT: page, SUMMARY: text}
    given = {name: words.encode("utf-8") for name, words in texts.items() if words is not None}
    more_bytes = sum(map(len, given.values()))
    with files_together() as files:
        with files.file(folder / RESULTS, more_bytes) as unfinished:
            put_results(unfinished, records, attributes, units, rest)
        for name, data in given.items():
            more_bytes -= len(data)
            with files.file(folder / name, more_bytes) as unfinished:
                write_bytes(unfinished, data)
        files.appear(stale_files(folder, run, frozenset(given)))
    return [folder / name for name in (SUMMARY, RESULTS, CONVERGENCE, REPORT) if name in given or name == RESULTS]


def save_convergence(convergence: Convergence, folder: Path, run: str) -> Path:
    """Write convergence.csv into `folder`: a line for each figure of each event, `run` the last cell of each."""
    path = folder / CONVERGENCE
    write_text(path, _table(convergence, run))
    return path


def _table(convergence: Convergence, run: str) -> str:
    head, *rows = csv_rows(convergence)
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows([[*head, "run"], *(plain_row([*row, run]) for row in rows)])
    return text.getvalue()


def refuse_other_study(folder: Path, study: str) -> None:
    """Check that a run of a study may replace what is in `folder`.

    Results of the same study file are replaced, whatever the file said then; so is what cannot be read.

    Parameters
    ----------
    study : name of the study file, or of the deck that is run by itself.

    Raises
    ------
    InputError : the folder holds the results of another study file.
    """
    try:
        found = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        other = found["study"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return
    if isinstance(other, str) and other != study:
        raise InputError(
            f"{folder} holds the results of {other}, which {study} would replace",
            expected="a folder of its own for each study",
            fix="Write beside it with --out FOLDER, or replace it with --force.",
        )
