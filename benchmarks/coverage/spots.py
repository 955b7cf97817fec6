"""Spot checks on a large door: `python -m benchmarks.coverage.spots [--mesh-size 4.22] [--f-max 1500]`.

The door is reduced and run, and the unreduced model then marches through some of its events: what that costs, in
back-substitutions and seconds beside the reduction, and by how much the two differ.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

from benchmarks.stamp import stamp
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.findings.places import find_places
from creak.studies.prepare.setup import set_up
from creak.studies.run.compared import Meter
from creak.studies.run.job import run_study
from creak.studies.spots.beside import beside_unreduced
from creak.verify.matching import FIGURES
from creak_thesis.door import FINEST_MESH_SIZE, write_door


def main() -> None:
    """Measure, print and write."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.coverage.spots")
    options.add_argument("--mesh-size", type=float, default=FINEST_MESH_SIZE, help="mm")
    options.add_argument("--f-max", type=float, default=1500.0, help="Hz, of the reduction")
    options.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    began, notes = time.perf_counter(), list[str]()

    def progress(stage: str, done: int, total: int) -> None:
        if done == 0:
            print(f"{time.perf_counter() - began:7.0f} s  {stage}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder))
        setup = set_up(with_changes(read_study(Path(folder) / "door.toml"), {"reduction.f_max": given.f_max}))
        result = run_study(setup, progress)
        model, run, band = result.reduced, result.runs["reduced"], result.band
        assert model is not None
        assert band is not None
        print(f"{result.reference.free_dof:,} dofs, {model.system.n:,} kept, {len(run.events)} events", flush=True)
        meter = Meter()
        found = beside_unreduced(result, find_places(band.scope, run), progress, notes)
        cost = meter.read()
    assert found is not None
    rows = [
        {
            "event": s.event.t_start,
            "lasts": s.event.t_end - s.event.t_start,
            "why": s.why,
            "problem": s.problem,
            **{name: s.difference(name) for name in FIGURES},
            "border": s.border,
        }
        for s in found.spots
    ]
    told = {
        "made": stamp(),
        "free_dof": result.reference.free_dof,
        "events": len(run.events),
        "reduction_s": model.wall_s,
        "march_s": run.cost.wall_s,
        "spots_s": cost.wall_s,
        "peak_gb": cost.peak_rss_gb,
        "solves": found.solves,
        "why_not": found.why_not,
        "notes": notes,
        "spots": rows,
    }
    print(json.dumps(told, indent=1, default=str))
    out = given.out / f"spots_{given.mesh_size:g}.json"
    out.write_text(json.dumps(told, indent=1, default=str), encoding="utf-8")


if __name__ == "__main__":
    main()
