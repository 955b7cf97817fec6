"""Do the bars and verdicts of the door hold? `python -m benchmarks.coverage.door [--mesh-size H] [--until S]`.

The door under the loads A2 to A4 with several seeds of the excitation, run with nothing set, against its unreduced
model under the same loads: over the whole time, or up to `--until`. That is marched in contact steps of half the
default length and of the default one, so that its own error is known. Rows go to a file as they come, and one that is
there is not made again.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchmarks.coverage.__main__ import known, line
from benchmarks.coverage.study import held
from benchmarks.coverage.table import lines, summary
from benchmarks.door import silent
from benchmarks.stamp import stamp
from creak.studies.evaluate import evaluate
from creak.studies.file.reader import Study, read_study
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import set_up
from creak.studies.run.one_run import march_run
from creak_thesis.door import write_door
from creak_thesis.door.writer import LOADS


def main() -> None:
    """Run what is not in the file yet, and print the counts."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.coverage.door")
    options.add_argument("--mesh-size", type=float, default=40.0, help="mm")
    options.add_argument("--until", type=float, help="s, of the unreduced run; as long as the other where not given")
    options.add_argument("--seeds", type=int, default=8)
    options.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / f"door_{given.mesh_size:g}.jsonl"
    rows = known(log)
    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder))
        study = read_study(Path(folder) / "door.toml")
        for seed in range(1, given.seeds + 1):
            for load in ("A2", "A3", "A4"):
                name = f"{load}/{seed}"
                if name not in rows:
                    rows[name] = case(name, changed(study, LOADS[load], seed), given.until, Path(folder) / "store")
                    with log.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(rows[name]) + "\n")
                    print(line(rows[name]), flush=True)
    found = summary(list(rows.values()))
    (log.with_suffix(".json")).write_text(json.dumps({"made": stamp(), **found}, indent=1), encoding="utf-8")
    print("\n".join(lines(found)))


def changed(study: Study, amplitude: float, seed: int) -> Study:
    """The study with another load."""
    hinge = study.config.excitation["hinge"]
    signal = hinge.signal.model_copy(update={"amplitude": amplitude, "seed": seed})
    tables = {"excitation": {"hinge": hinge.model_copy(update={"signal": signal})}}
    return replace(study, config=study.config.model_copy(update=tables))


def case(name: str, study: Study, until: float | None, store: Path) -> dict[str, Any]:
    """What creak tells of a run, beside the unreduced model."""
    began = time.process_time()
    result = evaluate(set_up(study), silent, store=Store(store, "last"))
    found, told = result.found, json.loads(json.dumps(result.summary, default=str))["runs"]["reduced"]
    creak_s, v = time.process_time() - began, study.config.verification
    setup = found.setup
    if until is not None:
        table = study.config.reference.model_copy(update={"run": "whole", "until": until})
        config = setup.study.config.model_copy(update={"reference": table})
        setup = replace(setup, study=replace(setup.study, config=config))
    began = time.process_time()
    finer = (replace(setup, refined=by).marching.compared for by in (2.0, 1.0))
    fine, rough = (
        march_run("reference", marching, setup.observed(found.gaps), found.reference, found.gaps, silent)
        for marching in finer
    )
    end = float(fine.history.time[-1])
    bars = [e["settled_to"] for e in told["events"]]
    both = zip(found.runs["reduced"].events, bars, strict=True)
    early = [(e, bar) for e, bar in both if e.t_start < end]
    impulse = sum(e.impulse for e in fine.events)
    return {
        "seed": name,
        "words": f"door, {found.reference.free_dof:,} dofs, f_max {found.setup.band.f_max:g}",
        "verdict": told.get("verdict"),
        "reasons": told["reasons"],
        "own": {
            "events": len(fine.events),
            "impulse": impulse,
            "error": abs(sum(e.impulse for e in rough.events) / impulse - 1.0) if impulse else 0.0,
            "settled": True,
            "friction_work": 0.0,
            "cpu_s": time.process_time() - began,
        },
        "reduced": held(
            fine.events, [e for e, _ in early], [bar for _, bar in early], rough.events, v.event_tolerance, end
        ),
        "friction_work": 0.0,
        "cpu_s": creak_s,
    }


if __name__ == "__main__":
    main()
