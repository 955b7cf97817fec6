"""The door from deck to reduced run, with memory: `python -m benchmarks.scale --mesh-size MM --out FOLDER`.

Every phase writes a line to FOLDER/scale.log as it begins: wall and CPU seconds since the start, memory of the process
that is its own and that which lies in files, their largest so far, and free memory. Stopped or killed, the same
command goes on: the deck and the parts that are saved are taken. The pre-check is made again.

`CREAK_MEMORY_GB` in the environment forces the ways of a smaller machine; TMPDIR says where modes go that do not fit.
"""

from __future__ import annotations

import argparse
import threading
import time
from pathlib import Path
from typing import TextIO

from creak.linalg.memory import GB, free_bytes
from creak.studies.file.reader import read_study
from creak.studies.models.health import check
from creak.studies.models.reduced import Reduced, reduce_model
from creak.studies.models.saved import Store
from creak.studies.models.superelements import save_superelement, with_modes_of_file
from creak.studies.prepare.setup import set_up
from creak.studies.run.one_run import march_run
from creak.studies.run.precheck import ready
from creak_thesis.door import write_door

SAMPLED = 0.2
"""s between looks at the memory."""
STATUS = Path("/proc/self/status")


class Log:
    """Lines of a file, and the largest memory."""

    def __init__(self, file: TextIO) -> None:
        self._file, self._phase = file, ""
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        self.own, self.highest = 0.0, 0.0
        self._done = threading.Event()
        self._watch = threading.Thread(target=self._look, daemon=True)
        self._watch.start()
        self.write("  wall s    CPU s  own GB  files GB  largest own GB  free GB  phase")

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Progress of creak: a line where a phase begins."""
        if stage != self._phase:
            self._phase = stage
            self.line(stage)

    def line(self, text: str) -> None:
        wall, cpu = time.perf_counter() - self._wall, time.process_time() - self._cpu
        own, files = memory()
        largest, self.highest = max(self.highest, own), own
        self.own = max(self.own, largest)
        free = free_bytes() / GB
        self.write(f"{wall:8.1f} {cpu:8.1f} {own:7.2f} {files:9.2f} {largest:15.2f} {free:8.2f}  {text}")

    def write(self, text: str) -> None:
        print(text, flush=True)
        self._file.write(f"{text}\n")
        self._file.flush()

    def close(self) -> None:
        self._done.set()
        self._watch.join()

    def _look(self) -> None:
        while not self._done.wait(SAMPLED):
            self.highest = max(self.highest, memory()[0])


def memory() -> tuple[float, float]:
    """GB of the process: its own, and pages of files, which the system takes back where it needs them."""
    lines = (line.split() for line in STATUS.read_text().splitlines())
    found = {
        words[0]: float(words[1]) for words in lines if words and words[0] in ("RssAnon:", "RssFile:", "RssShmem:")
    }
    return found["RssAnon:"] / 1e6, (found["RssFile:"] + found["RssShmem:"]) / 1e6


def measure(folder: Path, f_max: float, log: Log) -> None:
    """Read, reduce and run."""
    study = read_study(folder / "door.toml")
    log.line("read the model and find the contacts")
    setup = set_up(study)
    c = setup.study.config
    setup = setup.with_tables(
        reduction=c.reduction.model_copy(update={"f_max": f_max}),
        reference=c.reference.model_copy(update={"run": False}),
    )
    setup, reference, gaps, notes = ready(setup.unstarted(), log)
    for text in notes:
        log.write(f"note: {text}")
    log.write(
        f"{reference.free_dof:,} free dofs, {gaps.m} channels, {reference.modes.omega2.size} modes before the reduction"
    )
    store = folder / "superelements"

    def made(reduced: Reduced) -> Reduced:
        name, stats = reduced.system.name, reduced.system.stats
        how = "taken from its file" if reduced.reused else "reduced"
        log.line(f"{name}: {how}, {stats.internal:,} inner dofs, {stats.retained} retained, {stats.modes} modes; check")
        if reduced.reused:
            return reduced
        path = save_superelement(store, reduced, setup.model, {})  # a check that is killed does not cost it
        check(reduced, setup.model.nodes.coords, setup.band.excited)
        log.line(f"{name}: saved and checked")
        return with_modes_of_file(setup.band, reduced, path)

    model = reduce_model(setup.reduction, reference, gaps, log, Store(store), made)
    log.line(f"run: {model.retained} retained, {model.modes} modes, {model.system.n} unknowns")
    run = march_run("reduced", setup.marching, setup.observed(gaps), model, gaps, log)
    log.line(f"done: {len(run.events)} events, largest force {run.history.force.max(initial=0.0):.3f}")
    log.write(f"largest memory of its own: {max(log.own, log.highest):.2f} GB")


def main() -> None:
    """Write the door where it is not there, measure."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.scale")
    options.add_argument("--mesh-size", type=float, default=10.0, help="mm")
    options.add_argument("--out", type=Path, required=True, help="folder for deck, log and superelements; kept")
    options.add_argument("--f-max", type=float, default=700.0, help="[reduction] f_max, Hz; modes go to 1.5 times that")
    given = options.parse_args()
    if not (given.out / "door.toml").exists():
        write_door(given.mesh_size, given.out)
    with (given.out / "scale.log").open("a", encoding="utf-8") as file:
        log = Log(file)
        try:
            measure(given.out, given.f_max, log)
        finally:
            log.close()


if __name__ == "__main__":
    main()
