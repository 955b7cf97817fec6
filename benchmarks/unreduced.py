"""Five seconds of the unreduced door beside the reduced one: `python -m benchmarks.unreduced [--out FILE]`.

At 1.17 million dofs the unreduced run takes most of an hour; the thesis's took 463,450 s of CPU time. Its cost is told
beside that of HHT-alpha with steps of 1 ms, too. Both runs have the same channels, as many as retain about `--retained`
dofs. The page of `creak thesis` shows what `--out src/creak_thesis/report/million.json` wrote; nobody else writes to
that file.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.door import SCHEME, Door, door_study, silent
from benchmarks.million import closest
from benchmarks.stamp import stamp
from benchmarks.stepping import full_order
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import compile_kernels
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import simulate
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.prepare.marching import Observed, excitation_window
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.integrate import limited
from creak.studies.run.one_run import Run, march_run
from creak.verify.events import events_in
from creak.verify.matching import match_events
from creak_thesis.door import FINEST_MESH_SIZE, LOADS, write_door

THESIS_CPU_S = 463_450.0
"""CPU time of the thesis's unreduced run (table 4.7)."""
HHT_STEP = 1e-3
"""s"""
REPORT_S = 60.0
"""Seconds between lines of progress."""


class Lines:
    """A line of progress a minute."""

    def __init__(self, console: Console) -> None:
        self._console, self._last = console, time.perf_counter()

    def __call__(self, stage: str, done: int, total: int) -> None:
        if time.perf_counter() - self._last > REPORT_S:
            self._last = time.perf_counter()
            self._console.print(f"{stage}: {done} of {total}")


def main() -> None:
    """Run both and compare."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.unreduced")
    options.add_argument("--mesh-size", type=float, default=FINEST_MESH_SIZE, help="mm")
    options.add_argument("--load", choices=list(LOADS), default="A4")
    options.add_argument("--retained", type=int, default=1500)
    options.add_argument("--out", type=Path, help="JSON file for the figures")
    given = options.parse_args()
    console, made = Console(width=130), stamp()
    compile_kernels()
    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder), load=given.load)
        setup = set_up(door_study(Path(folder)))
    reference = build_reference(setup.structure, setup.band, silent)
    gaps = closest(setup, reference, given.retained)
    reference.release()
    gaps, _ = limited(setup.marching, setup.model.nodes.coords, reference.system, gaps)
    title = f"Door, {6 * setup.model.nodes.count:,} dofs, {reference.system.n:,} free, {gaps.m} channels"
    title += f", load {given.load} ({LOADS[given.load]:g} mm a line)"
    console.print(title)
    table = Table("what", "measured", "against", title=title)
    for row in full_order(Door(setup, reference, gaps)):
        console.print(*row)
        table.add_row(*row)
    lines = Lines(console)
    observed = Observed(setup.study.config.verification, setup.static, setup.watch.nodes)
    full = march_run("unreduced", setup.marching, observed, reference, gaps, lines)
    console.print(cost_line(full))
    table.add_row(*over_hht(full, setup, reference.system, gaps))
    model = reduce_model(setup.reduction, reference, gaps, silent)
    reduced = march_run("reduced", setup.marching, observed, model, gaps, lines)
    for row in comparison(
        full,
        reduced,
        setup.study.config.verification.event_tolerance,
        excitation_window(setup.study.course, setup.marching.ends),
    ):
        table.add_row(*row)
    console.print(table)
    if given.out is not None:
        found = record(made, title, [figures(full), figures(reduced)])
        given.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def over_hht(full: Run, setup: Setup, system: System, gaps: GapOperator, steps: int = 200) -> tuple[str, str, str]:
    """CPU time of a run over that of as many seconds by HHT-alpha with steps of 1 ms."""
    every = max(1, round(HHT_STEP / setup.loads.step))
    rows = slice(0, every * steps + 1, every)
    s = setup.loads
    loads = Loads(s.time[rows], s.support[:, rows], s.force[rows], s.force_labels)
    began = time.process_time()
    history = simulate(system, gaps, loads, SCHEME, OutputRequest(np.zeros(0, dtype=np.int64)))
    one = (time.process_time() - began - history.setup_s) / loads.n_step
    ratio = full.cost.cpu_s / (one * full.history.time[-1] / HHT_STEP)
    return "unreduced run over HHT at 1 ms", f"{ratio:.2f} x (a step {1e3 * one:.0f} ms CPU)", "limit 3"


def record(made: Mapping[str, str], model: str, runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What the file holds: where it comes from, the model, both runs."""
    return {"made": dict(made), "model": model, "runs": [dict(r) for r in runs]}


def cost_line(run: Run) -> str:
    """Wall and CPU time."""
    return f"{run.cost.wall_s:.1f} s wall, {run.cost.cpu_s:.1f} s CPU, {run.cost.peak_rss_gb:.1f} GB"


def figures(run: Run) -> dict[str, object]:
    """What a table of costs needs."""
    return {
        "name": run.name,
        "integrator": run.integrator,
        "wall_s": run.cost.wall_s,
        "cpu_s": run.cost.cpu_s,
        "peak_rss_gb": run.cost.peak_rss_gb,
        "offline_cpu_s": run.offline_cpu_s,
        "offline_wall_s": run.offline_wall_s,
        "retained": run.retained,
        "modes": run.modes,
        "contact_steps": run.history.contact_steps,
        "energy_created": run.history.energy_created,
        "events": [[e.group, e.t_start, e.t_end, e.force_peak, e.impulse] for e in run.events],
    }


def comparison(full: Run, reduced: Run, tolerance: float, window: tuple[float, float]) -> list[tuple[str, str, str]]:
    """Cost of both runs, and their events in the window."""
    match = match_events(full.events, reduced.events, tolerance, window)
    rows = [
        ("unreduced run, 5 s", cost_line(full), f"thesis {THESIS_CPU_S:,.0f} s CPU"),
        ("  steps in contact", f"{full.history.contact_steps} of {full.history.time.size - 1}", ""),
        ("  energy created", f"{100 * full.history.energy_created:.4f} %", "limit 0.5 %"),
        ("reduction", f"{reduced.offline_wall_s:.0f} s wall, {reduced.offline_cpu_s:.0f} s CPU", ""),
        ("reduced run, 5 s", cost_line(reduced), f"{reduced.retained} retained, {reduced.modes} modes"),
        ("  online CPU time saved", f"{100 * (1 - reduced.cost.cpu_s / full.cost.cpu_s):.3f} %", "thesis 97.9 %"),
        (
            "events in the window",
            f"{len(events_in(full.events, window))}, {len(events_in(reduced.events, window))}",
            f"{len(match.pairs)} in common",
        ),
    ]
    if match.pairs:
        times, ratio, impulse = match.time_error, match.amplitude_ratio_mean, match.impulse_ratio_mean
        apart = f"{1e3 * (times.mean or 0.0):.3f} ms, ratio {ratio:.4f}, {impulse:.4f}"
        rows.append(("  mean start, force, impulse", apart, ""))
    return rows


if __name__ == "__main__":
    main()
