"""What a deck of the door costs before anything is solved: `python -m benchmarks.deck_size [--mesh-size MM]`.

The deck is written to a temporary folder. Reading it, and setting up the study with the assembly of K and M, run in a
process of its own each, so that the peak memory is that of the stage; imports come before the clock. CPU seconds
stand beside wall seconds: on a busy machine only these can be compared.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from rich.console import Console
from rich.table import Table

from creak.assembly.part import loose_system
from creak.formats.decks import read_model
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up_model
from creak.studies.run.compared import Cost, Meter
from creak_thesis.door import FINEST_MESH_SIZE, write_door

READ_S, ASSEMBLE_S, PEAK_GB = 30.0, 60.0, 8.0
"""Goals at 1.17 million dofs: wall seconds, and the largest resident memory of any stage."""

Row = tuple[str, str, str]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Stages:
    """What the stages cost, and the size of what they made."""

    read: Cost
    set_up: Cost
    assemble: Cost
    nodes: int
    elements: int
    channels: int
    free: int
    """Free dofs of the assembly."""
    entries: int
    """Stored entries of K."""


def read_stage(study: Path) -> Cost:
    """Read the deck of a study."""
    deck = _deck(study)
    meter = Meter()
    read_model(deck)
    return meter.read()


def assembly_stage(study: Path) -> tuple[Cost, Cost, tuple[int, ...]]:
    """Set up the study (channels of the contact, loads), then assemble K and M of the parts and join them."""
    checked, model = read_study(study), read_model(_deck(study))
    meter = Meter()
    setup = set_up_model(checked, model)
    set_up = meter.read()
    meter = Meter()
    structure = setup.structure
    parts = [structure.part(i, model) for i in range(len(model.parts))]
    system = structure.joined(parts, loose_system(model, structure.rayleigh))
    sizes = (model.nodes.count, model.n_elements, setup.contacts.m, system.n, int(system.K.nnz))
    return set_up, meter.read(), sizes


def measure(study: Path) -> Stages:
    """All stages of a study that was written, each in a fresh process."""
    read = in_fresh_process(read_stage, study)
    set_up, assemble, sizes = in_fresh_process(assembly_stage, study)
    return Stages(read, set_up, assemble, *sizes)


def in_fresh_process(work: Callable[[Path], Result], study: Path) -> Result:
    """`work(study)` in a new interpreter."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work, study).result()


def rows(stages: Stages, megabytes: float) -> list[Row]:
    """What, measured, goal."""
    peak = max(cost.peak_rss_gb for cost in (stages.read, stages.set_up, stages.assemble))
    both = Cost(stages.set_up.wall_s + stages.assemble.wall_s, stages.set_up.cpu_s + stages.assemble.cpu_s, peak)
    return [
        (f"read the deck, {megabytes:.1f} MB", _seconds(stages.read), f"< {READ_S:.0f} s"),
        ("  peak memory", f"{stages.read.peak_rss_gb:.2f} GB", ""),
        (f"set up, {stages.channels:,} channels", _seconds(stages.set_up), ""),
        (f"assemble K and M, {stages.entries:,} entries", _seconds(stages.assemble), ""),
        ("set up and assemble", _seconds(both), f"< {ASSEMBLE_S:.0f} s"),
        ("peak memory of all stages", f"{peak:.2f} GB", f"< {PEAK_GB:.0f} GB"),
    ]


def _deck(study: Path) -> Path:
    checked = read_study(study)
    return checked.places.sibling(checked.config.model.deck)


def _seconds(cost: Cost) -> str:
    return f"{cost.wall_s:.1f} s wall, {cost.cpu_s:.1f} s CPU"


def main() -> None:
    """Write, measure and print."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.deck_size")
    options.add_argument("--mesh-size", type=float, default=FINEST_MESH_SIZE, help="mm")
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        meter = Meter()
        deck, study = write_door(given.mesh_size, Path(folder))
        written, megabytes = meter.read(), deck.stat().st_size / 1e6
        stages = measure(study)
    size = f"{stages.nodes:,} nodes, {stages.elements:,} elements, {6 * stages.nodes:,} dofs, {stages.free:,} free"
    table = Table("what", "measured", "goal at 1.17 million dofs", title=f"Door of {given.mesh_size:g} mm: {size}")
    table.add_row("write the deck", _seconds(written), "")
    for row in rows(stages, megabytes):
        table.add_row(*row)
    Console(width=130).print(table)


if __name__ == "__main__":
    main()
