"""Cost of what is heard of a door beside its run: `python -m benchmarks.sound [--mesh-size MM] [--play MM]`.

One thread. Loudness over time against the sound's own length; the sound of all places and the causes of each, of a run
of five seconds, against the run itself; what is made once for a model and its listeners by itself.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

import creak
from benchmarks.door import door_study
from benchmarks.loudness import GOAL as LOUDNESS_GOAL
from benchmarks.loudness import RATE, SECONDS, TIMES, bursts, cpu_seconds
from creak.linalg.threads import one_blas_thread
from creak.sound.loudness import loudness
from creak.studies.cause.decompose import find_causes
from creak.studies.findings.places import find_places
from creak.studies.run.job import run_study
from creak.studies.sound.heard import Sound, hear
from creak_thesis.door import write_door

GOAL = 1.0
"""CPU of the sound over that of the run."""


def door_rows(mesh_size: float, load: str, play: float | None) -> list[tuple[str, str, str]]:
    """The run, its sound, its causes."""
    with tempfile.TemporaryDirectory() as folder:
        write_door(mesh_size, Path(folder), 1, load, play)
        study = creak.change_study(door_study(Path(folder)), {"reference.run": False})
        result = run_study(creak.set_up(study), lambda *_: None)
    run = result.main
    assert run is not None
    places = find_places(result.scope, run)
    channels = [p.channels for p in places]
    setup = result.setup
    of = setup.study.listening, setup.marching, setup.reduction, result.reference, result.reduced, run, channels
    hear(*of)  # compiles
    sound = hear(*of)
    assert isinstance(sound, Sound), sound
    started = time.process_time()
    find_causes(setup.marching, setup.reduction, run, places)
    causes = time.process_time() - started
    own, heard = run.cost.cpu_s, sound.cpu_s
    return [
        ("run", f"{own:.2f} s", f"{run.history.time[-1]:g} s, {run.system.n} modes"),
        ("sound", f"{heard:.2f} s", f"{len(places)} place(s), {sound.band.low:.0f} to {sound.band.high:.0f} Hz"),
        ("sound over run", f"{heard / own:.3f}", f"goal {GOAL:g}"),
        ("once for model and listener", f"{sound.offline_cpu_s:.2f} s", "rows of the listener, facets of the parts"),
        ("cause of each place", f"{causes:.2f} s", f"{causes / own:.2f} of the run"),
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.sound")
    parser.add_argument("--mesh-size", type=float, default=20.0, help="mm")
    parser.add_argument("--load", default="A3")
    parser.add_argument("--play", type=float, help="of the hooks, mm to either side; without: they are rigid")
    given = parser.parse_args()
    x = bursts()
    table = Table(
        "what", "CPU", "", title=f"Sound of the door at {given.mesh_size:g} mm, load {given.load}, one thread"
    )
    with one_blas_thread():
        loudness(x[: RATE // 10], RATE)  # compiles
        own = cpu_seconds(lambda: loudness(x, RATE), TIMES)
        table.add_row(
            f"loudness of {SECONDS:g} s", f"{own:.3f} s", f"{SECONDS / own:.0f} x real time, goal {LOUDNESS_GOAL:g}"
        )
        for row in door_rows(given.mesh_size, given.load, given.play):
            table.add_row(*row)
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
