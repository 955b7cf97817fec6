"""Is the default answer right, and do its error bars say so? `python -m benchmarks.coverage.door [--mesh-size H]`.

The door under the loads A2 to A4 with several seeds of the excitation, run with nothing set. Each run is held to two
others of the same reduced model: the same scheme with steps near contact of a tenth, and generalised-alpha with steps
of 2.5 us throughout and the full contact stiffness (with `--other-step 5e-6` its own error of impulse and force, four
times that, is a part of what is counted). Counted are the events within the tolerance of the default accuracy, and the
error bars that cover the error. Rows go to a JSON file as they come; a run that is there is not made again.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from benchmarks.door import silent
from creak.dynamics.scheme import generalised_alpha
from creak.dynamics.simulate import simulate
from creak.studies.converge.figures import FIGURES, TIMES, change
from creak.studies.converge.settled import settled_to, verdict_of
from creak.studies.converge.settling import OF_DURATION, SETTLED
from creak.studies.converge.variants import converge
from creak.studies.file.reader import Study, read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.integrate import divided_loads
from creak.studies.run.job import march_run, run_study
from creak.verify.events import Event, find_events
from creak.verify.matching import match_events
from creak_thesis.door import write_door
from creak_thesis.door.study import LOADS

OTHER_STEP = 2.5e-6
"""s, of generalised-alpha."""
FINER = 10.0
KEYS = {"start": "t_start", "duration": "duration", "impulse": "impulse", "force": "force"}
"""Figures that the accuracy promises."""


def main() -> None:
    """Run what is not in the file yet, and print the counts."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.coverage.door")
    options.add_argument("--mesh-size", type=float, default=40.0, help="mm")
    options.add_argument("--seeds", type=int, default=8)
    options.add_argument("--other", type=int, default=8, help="seeds that generalised-alpha runs too")
    options.add_argument("--other-step", type=float, default=OTHER_STEP, help="s, of generalised-alpha")
    options.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    path = given.out / f"coverage_{given.mesh_size:g}.json"
    rows: dict[str, Any] = json.loads(path.read_text()) if path.exists() else {}
    console = Console(width=160)
    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder))
        study = read_study(Path(folder) / "door.toml")
        for seed in range(1, given.seeds + 1):
            for load in ("A2", "A3", "A4"):
                name = f"{load} seed {seed}"
                if name not in rows:
                    step = given.other_step if seed <= given.other else None
                    rows[name] = case(changed(study, LOADS[load], seed), step, Path(folder) / "store")
                    path.write_text(json.dumps(rows, indent=1))
                console.print(name, line(rows[name]))
    console.print(totals(list(rows.values())))


def changed(study: Study, amplitude: float, seed: int) -> Study:
    """The study with another load, and without the unreduced run."""
    c = study.config
    hinge = c.excitation["hinge"]
    signal = hinge.signal.model_copy(update={"amplitude": amplitude, "seed": seed})
    tables = {
        "excitation": {"hinge": hinge.model_copy(update={"signal": signal})},
        "reference": c.reference.model_copy(update={"run": False}),
    }
    return replace(study, config=c.model_copy(update=tables))


def case(study: Study, other_step: float | None, store: Path) -> dict[str, Any]:
    """One run, its error bars, and what finer runs say of it; `other_step`: of generalised-alpha, None: without."""
    setup = set_up(study)
    result = run_study(setup, silent, store)
    started = time.perf_counter()
    found = converge(result, silent)
    bars_s = time.perf_counter() - started
    run = result.runs["reduced"]
    verdict = verdict_of(run, result, found)
    assert result.reduced is not None
    fine = march_run("fine", replace(setup, refined=FINER), result.reduced.system, result.gaps, silent, None)
    bars = {id(e.event): settled_to(e) for e in found.events}
    tolerance = study.config.verification.event_tolerance
    row: dict[str, Any] = {
        "verdict": None if verdict is None else verdict.word,
        "main_cpu_s": run.cost.cpu_s,
        "bars_wall_s": bars_s,
        "whole_impulse": sum(e.impulse for e in run.events),
        "against_finer": held(run.events, fine.events, bars, tolerance),
    }
    if other_step is not None:
        v, parts = study.config.verification, round(setup.study.config.time.step / other_step)
        history = simulate(
            run.system,
            result.gaps,
            divided_loads(setup, parts),
            generalised_alpha(),
            observed=np.zeros(0, dtype=np.int64),
            output_every=parts,
        )
        row["against_other"] = held(run.events, find_events(history, result.gaps, v.merge, v.f_max), bars, tolerance)
    return row


def held(
    own: Sequence[Event], exact: Sequence[Event], bars: Mapping[int, Mapping[str, float | None]], tolerance: float
) -> dict[str, Any]:
    """Events of the default run against a finer one: error of each figure and its bar, shares (of the
    duration for times)."""
    match = match_events(exact, own, tolerance, (0.0, np.inf))
    figures: dict[str, list[tuple[float, float | None]]] = {name: [] for name in KEYS}
    for better, mine in match.pairs:
        for name, key in KEYS.items():
            error, bar = abs(change(name, FIGURES[name](mine), FIGURES[name](better))), bars.get(id(mine), {}).get(key)
            lasts = better.t_end - better.t_start if name in TIMES else 1.0
            figures[name].append((error / lasts, None if bar is None else bar / lasts))
    impulse = sum(e.impulse for e in exact)
    counts = {"matched": len(match.pairs), "missed": len(match.missed), "extra": len(match.extra)}
    return {**counts, "whole_impulse": impulse, **figures}


def _limit(name: str) -> float:
    return OF_DURATION if name in TIMES else SETTLED


def within(found: Mapping[str, Any]) -> int:
    """Events of which every figure is within the tolerance."""
    each = zip(*([error <= _limit(name) for error, _ in found[name]] for name in KEYS), strict=True)
    return sum(all(figures) for figures in each)


def covered(found: Mapping[str, Any]) -> tuple[int, int]:
    """Error bars that cover the error (or a tenth of the tolerance), and their number; one not known covers nothing."""
    pairs = [(error, bar, _limit(name)) for name in KEYS for error, bar in found[name]]
    return sum(error <= max(bar or 0.0, 0.1 * limit) for error, bar, limit in pairs), len(pairs)


def line(row: Mapping[str, Any]) -> str:
    """One case in a line."""
    parts = [f"{row['verdict']:<10} {row['main_cpu_s']:5.2f} s"]
    for key in ("against_finer", "against_other"):
        if key in row:
            f, (good, bars) = row[key], covered(row[key])
            off = row["whole_impulse"] / f["whole_impulse"] - 1.0 if f["whole_impulse"] else 0.0
            parts.append(
                f"{key.replace('_', ' ')}: {f['matched']}/{f['missed']}/{f['extra']}, {within(f)} within, "
                f"bars {good} of {bars}, impulse {100 * off:+.2f} %"
            )
    return "; ".join(parts)


def totals(rows: Sequence[Mapping[str, Any]]) -> str:
    """All cases together."""
    said = [f"verdicts: { {w: sum(r['verdict'] == w for r in rows) for w in sorted({r['verdict'] for r in rows})} }"]
    for key in ("against_finer", "against_other"):
        some = [r[key] for r in rows if key in r]
        if not some:
            continue
        events = sum(f["matched"] + f["missed"] + f["extra"] for f in some)
        good, bars = np.sum([covered(f) for f in some], axis=0)
        inside = sum(within(f) for f in some)
        said.append(
            f"{key.replace('_', ' ')}: {inside} of {events} events within tolerance ({inside / max(events, 1):.1%}), "
            f"error bars cover {good} of {bars} ({good / max(bars, 1):.1%})"
        )
    return "\n".join(said)


if __name__ == "__main__":
    main()
