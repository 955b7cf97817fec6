"""What tells one run from another: it stands in every file of a run, and every reader compares it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import h5py

from creak.errors import InputError

SUMMARY, RESULTS, REPORT, CONVERGENCE = "summary.json", "results.h5", "report.html", "convergence.csv"
"""The files of a run."""
AGAIN = "Run the study again."
META = '<meta name="creak-run" content="{}">'
"""In the head of report.html."""
ANY_REPORT = "creak report</title>"
HEAD = 4096
"""Characters of a page in which its head is looked for."""


@dataclass(frozen=True)
class RunIdentity:
    """One run."""

    id: str
    """Random, made anew for every run: the same input run twice gives two."""
    study_sha256: str
    """Of the text of the study file."""
    deck_sha256: str
    """Of the deck; with includes, of the list of their digests. Empty: the model came from no file."""
    files_sha256: str
    """Of the other files that the study names; of several, of the list of their digests. Empty: it names none."""

    def as_dict(self) -> dict[str, str]:
        return asdict(self)


def write_identity(file: h5py.File, run: RunIdentity) -> None:
    """As attributes of a results.h5: `run_id`, `study_sha256`, `deck_sha256`, `files_sha256`."""
    file.attrs.update({"run_id" if key == "id" else key: value for key, value in run.as_dict().items()})


def identity_in(file: h5py.File) -> RunIdentity | None:
    """The run of a results.h5; None: an earlier version wrote it."""
    if "run_id" not in file.attrs:
        return None
    id, study, deck = (str(file.attrs[key]) for key in ("run_id", "study_sha256", "deck_sha256"))
    return RunIdentity(id, study, deck, str(file.attrs.get("files_sha256", "")))  # earlier versions do not tell it


def identity_of(summary: Mapping[str, Any]) -> RunIdentity | None:
    """The run of a summary.json; None: an earlier version wrote it."""
    found = summary.get("run")
    if found is None:
        return None
    return RunIdentity(found["id"], found["study_sha256"], found["deck_sha256"], found.get("files_sha256", ""))


def of_two_runs(folder: Path) -> InputError:
    """For files that do not belong together."""
    return InputError(
        f"{SUMMARY} and {RESULTS} in {folder} are not of the same run",
        expected="the files of one run, as it wrote them",
        fix=AGAIN,
    )


def stale_files(folder: Path, run: RunIdentity, written: frozenset[str]) -> list[Path]:
    """Page and table of another run that would stay beside the files `written` of this one."""
    found = []
    for name, is_other in ((REPORT, _other_page), (CONVERGENCE, _other_table)):
        path = folder / name
        if name not in written and path.is_file() and is_other(path, run.id):
            found.append(path)
    return found


def _other_page(path: Path, id: str) -> bool:
    """Whether it is creak's page of another run."""
    head = _head(path)
    return META.format(id) not in head and ANY_REPORT in head


def _other_table(path: Path, id: str) -> bool:
    """Whether it is creak's table of another run; a line is enough to tell, the run is its last cell."""
    head, line = [*_head(path).splitlines(), "", ""][:2]
    return head.startswith("contact,channel,t_start,") and not (head.endswith(",run") and line.endswith(f",{id}"))


def _head(path: Path) -> str:
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.read(HEAD)
