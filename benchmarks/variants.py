"""Draws of a door side by side against single runs: `python -m benchmarks.variants [--mesh-size MM] [--draws N]`.

Every draw has gaps of its own, a correlated field along the flange. A single run is the march and its events alone, on
the model that is there already: what a loop over `simulate_flow` would cost.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.door import door_study
from benchmarks.stamp import stamp
from creak.dynamics.flow.march import simulate_flow
from creak.dynamics.record.recorder import OutputRequest
from creak.linalg.threads import cores
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import Study
from creak.studies.prepare.setup import set_up
from creak.studies.prepare.watched import watched
from creak.studies.robust import job
from creak.studies.robust.draws import Draw, make_causes
from creak.studies.robust.shared_model import NOTHING, SharedModel, march_draws, shared_model, variant_of
from creak.verify.events import find_events
from creak_thesis.door import write_door

FIELD = {"type": "field", "tolerance": 0.6, "length": 120.0}
KEY = "contact.flange.clearance"
MANY = 10_000


def silent(stage: str, done: int, total: int) -> None:
    """No progress."""


def scattered(folder: Path, mesh_size: float) -> Study:
    """The study of a door whose gaps scatter."""
    if not (folder / "door.toml").exists():
        write_door(mesh_size, folder)
    return with_changes(door_study(folder), {"scatter": {"vary": {KEY: FIELD}}})


def make_draws(study: Study, count: int) -> tuple[SharedModel, list[Draw], job.GapOperator]:
    """The model and its draws."""
    setup = set_up(study)
    c, fields = study.config, job.fields_of(setup.contacts, setup.model.nodes)
    data, given = c.model_dump(mode="json", by_alias=True), tomllib.loads(study.text)
    causes = make_causes(c.scatter, data, given, fields, study.places, {})
    unit = np.random.default_rng(1).random((count, causes[-1].columns.stop))
    draws = [Draw(k, {}, {"flange": field}) for k, field in enumerate(causes[0].values(unit))]
    channels = job.join([setup.contacts, setup.connectors])
    return shared_model(setup, draws, silent), draws, channels


def single(bench: SharedModel, draw: Draw) -> tuple[float, float, int]:
    """Wall and CPU time of one run by itself, and its events."""
    variant, start, cpu = variant_of(bench, draw), time.perf_counter(), time.process_time()
    v = bench.setup.study.config.verification
    history = simulate_flow(
        bench.system,
        variant.gaps,
        variant.loads,
        OutputRequest(NOTHING, watched=watched(bench.setup.model, bench.setup.contacts, variant.gaps)),
        resolution=bench.setup.marching.resolution,
    )
    events = len(find_events(history, variant.gaps, v.merge, v.f_max))
    return time.perf_counter() - start, time.process_time() - cpu, events


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.variants")
    parser.add_argument("--mesh-size", type=float, default=20.0, help="mm")
    parser.add_argument("--draws", type=int, default=64)
    parser.add_argument("--singles", type=int, default=8)
    parser.add_argument("--door", type=Path, help="folder with door.toml and superelements/, else written anew")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        bench, draws, channels = make_draws(scattered(given.door or Path(made), given.mesh_size), given.draws)
        alone = [single(bench, draw) for draw in draws[: given.singles]]
        one, one_cpu = (float(np.mean([run[k] for run in alone])) for k in (0, 1))
        say = sys.stdout.write
        say(f"{stamp()}\n{bench.system.n} modes, {bench.gaps.m} channels, {bench.base.n_step * bench.base.H:g} s\n")
        say(f"single runs: {one:.2f} s each ({one_cpu:.2f} s CPU), {np.mean([n for _, _, n in alone]):.0f} events\n")
        for threads in sorted({1, cores()}):
            start, cpu = time.perf_counter(), time.process_time()
            seen = dict(march_draws(bench, channels, draws, threads))
            wall, cpu = time.perf_counter() - start, time.process_time() - cpu
            each, each_cpu = wall / len(seen), cpu / len(seen)
            say(
                f"{threads} thread(s): {len(seen)} draws in {wall:.1f} s, {each:.2f} s each ({each_cpu:.2f} s CPU), "
                f"{one / each:.2f} times as fast as single runs ({one_cpu / each_cpu:.2f} by CPU); "
                f"{MANY:,} would take {MANY * each / 3600.0:.2f} h\n"
            )
        wider = 2.0 * float(-bench.linear.whole.min())
        quiet = [replace(draw, fields={name: gaps + wider for name, gaps in draw.fields.items()}) for draw in draws]
        cpu = time.process_time()
        seen = dict(march_draws(bench, channels, quiet, 1))
        each_cpu = (time.process_time() - cpu) / len(seen)
        say(f"draws in which nothing can touch: {each_cpu:.3f} s CPU each\n")
        say(f"largest memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB\n")


if __name__ == "__main__":
    main()
