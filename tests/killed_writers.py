"""Saves a run over another one and kills the writer at every step: a script, called by tests/unit/studies/findings/test_one_run.py.

Arguments: a folder with the decks and studies of two runs, `first.toml` and `second.toml`. A line of JSON for each kill.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import creak
from creak.errors import InputError
from creak.formats.measured.histories import read_histories
from creak.formats.stored.run_identity import META

STEPS = {"open": 1, "write": 300, "ftruncate": 1, "fsync": 1, "replace": 1, "unlink": 1, "rename": 1}
"""Calls of the system after which the writer is killed: each of them, or each of so many."""


def kill_after(step: int) -> None:
    """Count the calls of this process, and end it after one of them."""
    seen = dict.fromkeys(STEPS, 0)
    left = step

    def counted(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def then(*words: Any, **options: Any) -> Any:
            nonlocal left
            found = call(*words, **options)
            seen[name] += 1
            if seen[name] % STEPS[name] == 0:
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)
            return found

        return then

    for name in STEPS:
        setattr(os, name, counted(name, getattr(os, name)))


def killed(work: Callable[[], object], step: int) -> bool:
    """Whether `work`, done in another process, was killed at this step; it was not where it has no more steps."""
    child = os.fork()
    if child == 0:
        kill_after(step)
        work()
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.waitstatus_to_exitcode(status) == 0
    return os.WIFSIGNALED(status)


def page_of(result: creak.Result) -> str:
    """A small report.html."""
    return f"<head>{META.format(result.found.identity.id)}<title>x – creak report</title></head>"


def told(read: Callable[[Path], str], folder: Path, ids: dict[str, str]) -> str:
    """The run that a reader finds in a folder, or its refusal."""
    try:
        return ids[read(folder)]
    except InputError as error:
        return f"refused: {error}"


def report(folder: Path) -> str:
    """The run that a report of a folder is of."""
    saved = creak.open_result(folder)
    of = str(saved.summary["run"]["id"])
    summary = saved.summary["runs"]["reduced"]["max_force"]
    np.testing.assert_allclose(saved.runs["reduced"].force.max(), summary, rtol=1e-12)
    page = folder / "report.html"
    assert not page.exists() or of in page.read_text(), "the page is of another run"
    return of


def convert(folder: Path) -> str:
    """The run that its histories are of."""
    read_histories(folder / "results.h5")
    with h5py.File(folder / "results.h5") as file:
        return str(file.attrs["run_id"])


def main(folder: Path) -> None:
    """Kill at step 0, 1, 2, ... until the writer comes to its end."""
    results = {name: creak.run(folder / f"{name}.toml", converge=False) for name in ("first", "second")}
    ids = {result.found.identity.id: name for name, result in results.items()}
    results["first"].save(folder / "before", page=page_of(results["first"]))
    work, step = folder / "work", 0
    while True:
        shutil.copytree(folder / "before", work)
        ended = not killed(lambda: results["second"].save(work, page=page_of(results["second"])), step)
        found = {read.__name__: told(read, work, ids) for read in (report, convert)}
        left = [p.name for p in work.glob(".*")]
        results["first"].save(work)  # the next run in that folder
        found |= {"left": str(len(left)), "cleaned": str(not list(work.glob(".*"))), "next": told(report, work, ids)}
        sys.stdout.write(json.dumps(found | {"ended": str(ended)}) + "\n")
        sys.stdout.flush()
        shutil.rmtree(work)
        if ended:
            return
        step += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
