"""What a study found in results.h5: written beside the histories of `creak run`, read back for `creak report`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.stored.results import reading
from creak.formats.stored.run_identity import AGAIN, RESULTS, SUMMARY, identity_in, identity_of, of_two_runs
from creak.formats.stored.sealed import Damaged, opened_hdf5, read_sealed
from creak.formats.stored.tree import read_tree, write_tree
from creak.studies.findings.tree import Findings, FoundRun, FoundSound
from creak.studies.run.compared import compare_events
from creak.verify.matching import EventMatch

T = TypeVar("T")
VERSION = 14
"""Of the group `findings`; another one cannot be read."""


def write_findings(file: h5py.File, findings: Findings) -> None:
    """Add what was found to a results.h5: the group `findings`, and its mesh once more as `model`.

    Forces are not written: `runs/<name>/contact` holds them; nor is the pressure, which `sound` holds.
    """
    group = file.create_group("findings")
    group.attrs["version"] = VERSION
    write_tree(group, findings, skip=("runs", "events", "sound"))
    runs = group.create_group("runs", track_order=True)
    for name, run in findings.runs.items():
        write_tree(runs.create_group(name), run, skip=("force",))
    if findings.sound is not None:
        write_tree(group.create_group("sound"), findings.sound, skip=("pressure",))
    file["model"] = file["findings/setup/model"]


def read_findings(folder: Path, beside: Callable[[h5py.File], T]) -> tuple[Findings, T]:
    """What a study found, from the folder that `creak run` wrote.

    Parameters
    ----------
    beside : reads what else belongs to it from results.h5.

    Raises
    ------
    InputError : a file is missing, not whole, of another run or another version, or holds no findings.
    """
    text, path = folder / SUMMARY, folder / RESULTS
    if path.is_file() and not text.exists():
        raise InputError(
            f"no such results: {text}, only {RESULTS} beside it: a run was stopped while it wrote them",
            expected="both, of one run",
            fix=AGAIN,
        )
    with reading(text):
        summary = read_sealed(text)
        names, run = list(summary["runs"]), identity_of(summary)
    with reading(path), opened_hdf5(path) as file:
        if identity_in(file) != run:
            raise of_two_runs(folder)
        _check(file, path)
        if run is None:
            raise InputError(
                f"{SUMMARY} and {RESULTS} in {folder} do not say of which run they are",
                expected="results with a run id",
                fix=AGAIN,
            )
        found, more = _findings(file), beside(file)
    if names != list(found.runs):
        raise of_two_runs(folder)
    return found, more


def _check(file: h5py.File, path: Path) -> None:
    """Raise InputError where there is nothing that this version can read."""
    by = file.attrs.get("creak", "another program")
    kept = file["findings"] if "findings" in file else file.get("report")  # the name before version 8
    if kept is None:
        raise InputError(
            f"{path}, written by creak {by}, does not keep what a report needs",
            expected="results of creak run",
            fix=f"{AGAIN} Cases of a sweep do not keep it either.",
        )
    version = int(kept.attrs["version"])
    if version != VERSION:
        raise InputError(
            f"{path}, written by creak {by}, keeps its report in version {version}",
            expected=f"version {VERSION}",
            fix=f"Use creak {by}, or run the study again.",
        )


def _findings(file: h5py.File) -> Findings:
    runs = {name: _run(file, name) for name in file["findings/runs"]}
    found = read_tree(Findings, file["findings"], runs=runs, events=None, sound=_sound(file))
    return replace(found, events=_match(found))


def _match(found: Findings) -> EventMatch | None:
    """The events of both runs matched again, as they were where the study came to its end."""
    runs = {} if found.stopped is not None else found.runs
    return compare_events(runs, found.setup.study.config.verification.event_tolerance, found.window)


def _sound(file: h5py.File) -> FoundSound | None:
    """What was heard; the pressure is that at the first listener."""
    if "sound" not in file["findings"]:
        return None
    pressure = file["sound/pressure"][0]
    if pressure.ndim != 2 or not np.isfinite(pressure).all():
        raise Damaged("a sound that is not whole")
    return read_tree(FoundSound, file["findings/sound"], pressure=pressure)


def _run(file: h5py.File, name: str) -> FoundRun:
    group, run = file[f"findings/runs/{name}"], file[f"runs/{name}"]
    return read_tree(FoundRun, group, force=_forces(run, group["time"].shape[0]))


def _forces(run: h5py.Group, n_time: int) -> FloatArray:
    """(n_time, m) at every instant, out of those near contact."""
    contact = run["contact"]
    force = np.zeros((n_time, run["channel_nodes"].shape[0]))
    at = [contact[key][()] for key in ("instant", "channel")]
    for rows, most in zip(at, force.shape, strict=True):
        if rows.size and not 0 <= rows.min() <= rows.max() < most:
            raise Damaged("contact at an instant or a channel that there is not")
    force[np.ix_(*at)] = contact["force"][()]
    return force
