"""The door at 1.17 million dofs, reduced: `python -m benchmarks.million [--retained N] [--bounded N]`.

The pre-check's margin is chosen so that about N dofs are retained. `--bounded N` then reduces the frame alone to N
retained dofs without modes: constraint modes are streamed, so memory must not grow with them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.door import SCHEME, door_study, silent
from benchmarks.reduction import Row, reduction_cost
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import compile_kernels
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import simulate
from creak.model.dofs import node_dofs
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.models.substructures import partition
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.compared import Meter
from creak.studies.run.integrate import limited
from creak.studies.run.precheck import with_linear_gaps
from creak_thesis.door import FINEST_MESH_SIZE, write_door


def main() -> None:
    """Measure and print."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.million")
    options.add_argument("--mesh-size", type=float, default=FINEST_MESH_SIZE, help="mm")
    options.add_argument("--retained", type=int, default=1500)
    options.add_argument("--bounded", type=int, default=8280)
    given = options.parse_args()
    console = Console(width=130)
    table = Table("what", "measured", "against")
    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder))
        started = time.perf_counter()
        setup = set_up(door_study(Path(folder)))
        read_s = time.perf_counter() - started
    meter = Meter()
    reference = build_reference(setup.structure, setup.band, silent)
    cost = meter.read()
    gaps = closest(setup, reference, given.retained)
    title = f"Door, {6 * setup.model.nodes.count:,} dofs, {reference.system.n:,} free, {gaps.m} channels"
    table.add_row("read and set up", f"{read_s:.0f} s", "")
    table.add_row("assembly and its modes", f"{cost.wall_s:.0f} s, {cost.peak_rss_gb:.1f} GB", "")
    console.print(title)
    reference.release()
    for row in whole_reduction(setup, reference, gaps):
        console.print(*row)
        table.add_row(*row)
    cut = partition(setup.reduction, reference, gaps)
    boundaries = [(s.part, s.boundary) for s in cut.substructures]
    for part, boundary in boundaries:
        for row in reduction_cost(part, boundary, setup.band.f_max):
            console.print(*row)
            table.add_row(*row)
    table.add_section()
    if given.bounded:
        frame = next(p for p in reference.parts if p.name == "FRAME")
        held = next(b for p, b in boundaries if p.name == "FRAME")
        flange = np.flatnonzero(np.isin(frame.coordinates, node_dofs(setup.contacts.retained_nodes)))
        flange = np.setdiff1d(flange, held)[: given.bounded - held.size]
        for row in reduction_cost(frame, np.union1d(flange, held), None):
            console.print(*row)
            table.add_row(*row)
    console.print(title)
    console.print(table)


def closest(setup: Setup, reference: ReferenceModel, retained: int) -> GapOperator:
    """The channels that come closest in a linear run, as many as retain about so many dofs in all."""
    table = setup.study.config.precheck
    smallest = with_linear_gaps(table, setup.reduction, setup.marching, reference, silent).linear_gaps
    order = np.argsort(smallest, kind="stable")
    low, high = 1, order.size
    while low < high:
        middle = (low + high + 1) // 2
        cut = partition(setup.reduction, reference, setup.contacts.select(np.sort(order[:middle])))
        count = sum(s.boundary.size for s in cut.substructures)
        low, high = (middle, high) if count <= retained else (low, middle - 1)
    return setup.contacts.select(np.sort(order[:low]))


def whole_reduction(setup: Setup, reference: ReferenceModel, gaps: GapOperator) -> list[Row]:
    """All parts, coupled and diagonalised, as `creak run` does it; then five seconds of it."""
    compile_kernels()
    gaps, _ = limited(setup.marching, setup.model.nodes.coords, reference.system, gaps)
    meter = Meter()
    model = reduce_model(setup.reduction, reference, gaps, silent)
    cost = meter.read()
    for _ in range(2):  # the first run may compile
        started = time.perf_counter()
        simulate(model.system, gaps, setup.loads, SCHEME, OutputRequest(np.zeros(0, dtype=np.int64)))
        wall = time.perf_counter() - started
    return [
        ("whole reduction", f"{cost.wall_s:.0f} s wall, {cost.cpu_s:.0f} s CPU", "limit 1800 s"),
        ("  peak memory, all", f"{cost.peak_rss_gb:.1f} GB", "limit 20 GB"),
        ("  retained, modes", f"{model.retained}, {model.modes}", ""),
        ("reduced run", f"{wall:.1f} s for {setup.loads.time[-1]:.0f} s", "limit 5 s"),
    ]


if __name__ == "__main__":
    main()
