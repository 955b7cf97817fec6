"""All cases of the thesis on a door of one mesh size, each kept as soon as it is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import creak
from creak import CreakError
from creak_thesis.doors import Benches
from creak_thesis.measure import Bay, measure
from creak_thesis.outcome import Outcome, load_outcome, save_outcome
from creak_thesis.plan import Case, plan

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class ThesisResult:
    """What the page is made of."""

    mesh_size: float
    outcomes: dict[str, Outcome]
    """By case."""
    folder: Path


def run_thesis(mesh_size: float, out: Path, progress: Progress, cases: list[Case] | None = None) -> ThesisResult:
    """Measure what is not measured yet.

    A case that fails leaves its reason and does not stop the others; it is tried again next time.

    Parameters
    ----------
    mesh_size : mm.
    out : folder; `out/cases` keeps one file per case, so a stopped run goes on where it was.
    """
    planned = plan() if cases is None else cases
    variants = {c.variant.name: c.variant for c in plan()}
    bay = Bay(
        Benches(mesh_size, out / "doors", progress), variants, {c.name: c for c in plan()}, out / "runs", progress
    )
    outcomes = {}
    for k, case in enumerate(planned):
        progress(f"case {case.name}", k, len(planned))
        outcomes[case.name] = _outcome(case, bay, out / "cases", mesh_size)
    progress("cases", len(planned), len(planned))
    return ThesisResult(mesh_size, outcomes, out)


def _outcome(case: Case, bay: Bay, folder: Path, mesh_size: float) -> Outcome:
    path = folder / f"{case.name.replace('/', '_').replace(' ', '_')}.json"
    key = {"mesh_size": mesh_size, "creak": creak.__version__, **case.key}
    found = load_outcome(path, key)
    if found is not None:
        return found
    try:
        made = measure(case, bay)
    except CreakError as error:
        return Outcome(
            name=case.name,
            study=case.study,
            variant=case.variant.name,
            n=0,
            channels=0,
            retained={},
            modes={},
            unreduced=0,
            offline_cpu_s=0.0,
            offline_wall_s=0.0,
            frequencies=[],
            frequency_error=[],
            mac=[],
            mac_matrix=[],
            newton=None,
            loads={},
            reason=str(error),
        )
    save_outcome(made, key, path)
    return made
