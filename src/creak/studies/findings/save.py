"""What a study leaves on disk: summary.json, results.h5, convergence.csv and report.html, together or not at all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import h5py
import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.recovery import by_node, recovered
from creak.dynamics.history import ENERGIES, History
from creak.errors import InputError
from creak.formats.complete_file import files_together, write_bytes, write_text
from creak.formats.destination import destination
from creak.formats.measured.csv_rows import plain_row
from creak.formats.partials import remove_dead
from creak.formats.stored.results import ContactRecord, Field, LineRecord, RunRecord, put_results
from creak.formats.stored.run_identity import CONVERGENCE, REPORT, RESULTS, SUMMARY, stale_files, write_identity
from creak.formats.stored.sealed_json import sealed_text
from creak.formats.stored.tree import write_tree
from creak.model.plain_mesh import PlainMesh, plain_mesh
from creak.signals.resampling import cell_means
from creak.studies.converge.settling import Convergence
from creak.studies.converge.words import csv_rows
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run

UNASKED = 32_000_000
"""Bytes that the motion of all nodes may take where the study does not ask for it; fewer instants then."""
MARGIN = 4
"""Instants before and after a touch that are stored with it."""


def check_folder(folder: Path) -> None:
    """Check that the files of a run can stand in `folder`.

    Raises
    ------
    InputError : one of their names is taken by a folder, a pipe or another node.
    """
    for name in (RESULTS, CONVERGENCE, REPORT, SUMMARY):
        destination(folder / name, stream=False)


def save(
    result: StudyResult,
    findings: Findings,
    folder: Path,
    more: Callable[[h5py.File], None] | None = None,
    page: str | None = None,
) -> list[Path]:
    """Write the files of a run into `folder` (made if need be); all appear when the last of them is complete.

    summary.json is the last to appear and the first of its predecessors to go: where it is, all others are of its run.
    Page and table of an earlier run that this one does not replace are removed.

    Parameters
    ----------
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
    records = {name: _record(one, result) for name, one in result.runs.items()}
    c = result.setup.study.config
    attributes = {"creak": findings.creak, "title": c.title, "units": c.model.units, "study": result.setup.study.text}
    if more is None and any(record.field is not None for record in records.values()):
        more = partial(_write_mesh, mesh=plain_mesh(result.setup.model))

    def rest(file: h5py.File) -> None:
        write_identity(file, run)
        if more is not None:
            more(file)

    text = sealed_text(summary_of(findings))
    texts = {CONVERGENCE: None if convergence is None else _table(convergence, run.id), REPORT: page, SUMMARY: text}
    given = {name: words.encode("utf-8") for name, words in texts.items() if words is not None}
    more_bytes = sum(map(len, given.values()))
    with files_together() as files:
        with files.file(folder / RESULTS, more_bytes) as unfinished:
            put_results(unfinished, records, attributes, c.model.units, rest)
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


def _write_mesh(file: h5py.File, mesh: PlainMesh) -> None:
    write_tree(file.create_group("model"), mesh)


def _record(run: Run, result: StudyResult) -> RunRecord:
    h, nodes, watched = run.history, result.setup.model.nodes, result.setup.watched
    at, friction = h.output_index, result.gaps.friction
    rubbing = np.zeros(0, dtype=np.int64) if friction is None else friction.channels
    touched = np.flatnonzero((h.force > 0.0).any(axis=0))
    return RunRecord(
        time=h.time[at],
        gap=h.gap[at],
        normal_force=cell_means(h.time, h.force, h.time[at]),
        slip=h.slip,
        friction_force=_means(h, h.tangential),
        slip_speed=_means(h, h.sliding),
        contact=ContactRecord(_near_contact(h), h.time, touched, h.gap, h.force, rubbing, h.tangential, h.sliding),
        displacement=h.displacement.reshape(at.size, watched.size, 6),
        node_ids=nodes.ids[watched].astype(np.int64),
        node_names=[nodes.label(int(i)) for i in watched],
        channels=result.gaps.names,
        channel_nodes=nodes.ids[result.gaps.nodes_idx].astype(np.int64),
        energy=h.energy[at],
        energy_terms=ENERGIES,
        field=_field(run, result),
        elines=_lines(run, result),
    )


def _lines(run: Run, result: StudyResult) -> LineRecord | None:
    moved, points = run.line_motion, result.setup.elines.points
    if moved is None:
        return None
    labels = result.setup.model.nodes.ids[points.nodes_idx].astype(np.int64)
    return LineRecord(moved.time, moved.motion, points.names, labels)


def _means(h: History, x: FloatArray) -> FloatArray:
    """Means over the output intervals of what only rubbing channels have."""
    return cell_means(h.time, x, h.time[h.output_index]) if x.size else np.zeros((h.output_index.size, 0))


def _near_contact(h: History) -> IntArray:
    """Instants at which anything presses, and `MARGIN` before and after."""
    pressed = np.asarray((h.force > 0.0).any(axis=1))
    near = np.convolve(pressed, np.ones(2 * MARGIN + 1), mode="full")[MARGIN : MARGIN + pressed.size] > 0.5
    return np.flatnonzero(near)


def _field(run: Run, result: StudyResult) -> Field | None:
    """The motion of all nodes as the study asks for it; where it does not, around the hardest event."""
    h, nodes = run.history, result.setup.model.nodes
    if h.whole_at.size:
        parts = result.setup.study.config.time.substeps
        time, q = result.setup.marching.ends[h.whole_at], h.coordinates
        s = result.setup.loads.support[0, parts * h.whole_at].T
    elif run.recording is not None and run.recording.motions:
        m = run.recording.motions[0]
        every = max(1, -(-m.time.size * 24 * nodes.count // UNASKED))
        time, q, s = m.time[::every], m.coordinates[:, ::every], m.supports[:, ::every]
    else:
        return None
    labels = run.system.labels
    blocks = ((here, by_node(u, labels, nodes.count)) for here, u in recovered(run.system, q, s))
    return Field(time, blocks, nodes.ids.astype(np.int64), nodes.coords)


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
