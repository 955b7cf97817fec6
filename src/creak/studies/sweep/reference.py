"""Runs of the unreduced model that cases of a sweep share."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.record.watch import Extremes
from creak.formats.complete_file import complete_file
from creak.formats.stored.npz_arrays import read_arrays
from creak.formats.stored.sealed_hdf5 import Damaged
from creak.progress import Progress
from creak.studies.file.config import VerificationTable
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.marching import Marching, Observed
from creak.studies.run.compared import Cost
from creak.studies.run.one_run import Run, march_run
from creak.verify.events import find_events
from creak.verify.slips import find_slips

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
