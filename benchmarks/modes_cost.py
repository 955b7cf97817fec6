"""What the modes of the unreduced door cost, phase by phase: `python -m benchmarks.modes_cost [--count N] [--free]`.

`creak.linalg.modes.modes` runs as it is; its functions are replaced by timed ones for the run. A phase has the time
that its functions spend outside those of other phases. The unit is a back-substitution of 128 columns, per column,
measured right after the factor was made and again at the end; that time is no phase's. A name that is gone, or that
was never called, stops the benchmark: it would measure something else.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from rich.console import Console
from rich.table import Table

from creak.arrays import Matrix
from creak.assembly.system import System
from creak.formats.decks import read_model
from creak.linalg import lanczos as lanczos_module
from creak.linalg import modes as modes_module
from creak.linalg import pencil as pencil_module
from creak.linalg import ritz
from creak.linalg.factor import Factor
from creak.linalg.modes import Modes, modes
from creak.reduction.constraint_modes import COLUMNS
from creak.studies.models.deck_modes import undamped_system
from creak.studies.run.compared import Meter
from creak_thesis.door import write_door

GOAL = 4.0
"""Back-substitutions of one column, per mode converged, that all of it may cost."""
COUNTS = (100, 300)
FACTOR, STURM, SOLVES, MASS = "factor", "Sturm factor", "solves", "products with M"
ORTHOGONAL, DENSE = "orthogonalisation", "dense eigenproblem"
VECTORS, RESIDUAL, REST = "eigenvectors", "residual check", "rest"
PHASES = (FACTOR, STURM, SOLVES, MASS, ORTHOGONAL, DENSE, VECTORS, RESIDUAL, REST)
"""`REST` is what none of the others is: the shifted matrices, the cleaning of rigid-body values."""
SMALL = 3000
"""Dofs of the first, uncounted run."""
UNIT = "unit"
"""The benchmark's own back-substitutions."""

Row = tuple[str, str, str]


class Clock:
    """Seconds of each phase; time belongs to the innermost phase that is running."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self.seconds = dict.fromkeys((*PHASES, UNIT), 0.0)
        self.calls = dict.fromkeys((*PHASES, UNIT), 0)
        self._running: list[str] = []
        self._since = 0.0

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Count the time inside to `name`."""
        self._turn()
        self.calls[name] += 1
        self._running.append(name)
        try:
            yield
        finally:
            self._turn()
            self._running.pop()

    def _turn(self) -> None:
        now = self._now()
        if self._running:
            self.seconds[self._running[-1]] += now - self._since
        self._since = now

    def timed(self, name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        """`work` with its time counted to `name`; inside the residual check all is the check's."""

        def run(*args: Any, **options: Any) -> Any:
            if RESIDUAL in self._running:
                return work(*args, **options)
            with self.phase(name):
                return work(*args, **options)

        return run


class TimedFactor:
    """A factor whose solves are counted."""

    def __init__(self, clock: Clock, made: Factor) -> None:
        self.made, self.n_negative = made, made.n_negative
        self.solve = clock.timed(SOLVES, made.solve)


@dataclass(frozen=True)
class Measured:
    """Modes and what they cost."""

    modes: Modes
    seconds: dict[str, float]
    unit: float
    """Seconds of a blocked back-substitution, per column."""

    @property
    def total(self) -> float:
        return sum(self.seconds.values())

    def units_per_mode(self, seconds: float) -> float:
        """A time in back-substitutions of one column, per mode converged."""
        return seconds / (self.unit * self.modes.omega2.size)


def measure(K: Matrix, M: Matrix, count: int, free: bool, now: Callable[[], float] = time.perf_counter) -> Measured:
    """The `count` lowest modes of sparse K, M, and the cost of every phase by the clock `now`.

    Raises
    ------
    AttributeError : a function that is to be timed is gone.
    RuntimeError : one of them was not called.
    """
    clock = Clock(now)
    kept: list[Factor] = []
    before: list[float] = []

    def factor(A: Matrix, *, definite: bool = True) -> TimedFactor:
        with clock.phase(FACTOR if definite else STURM):
            made = original(A, definite=definite)
        if definite:
            kept.append(made)
            with clock.phase(UNIT):
                before.append(column_seconds(made, K.shape[0], now))
        return TimedFactor(clock, made)

    original = pencil_module.factor
    with ExitStack() as stack:
        stack.enter_context(patch.object(pencil_module, "factor", factor))
        for owner, name, phase in _timed_names():
            stack.enter_context(patch.object(owner, name, clock.timed(phase, getattr(owner, name))))
        with clock.phase(REST):
            found = modes(K, M, count=count, free=free)
    silent = [phase for phase in PHASES if not clock.calls[phase]]
    if silent or len(kept) != 1:
        raise RuntimeError(f"not called: {silent}; factors of K: {len(kept)}; the timed names are out of date")
    after = column_seconds(kept[0], K.shape[0], now)
    return Measured(found, {name: clock.seconds[name] for name in PHASES}, 0.5 * (before[0] + after))


def column_seconds(solver: Factor, n: int, now: Callable[[], float]) -> float:
    """Seconds per column of a back-substitution of `COLUMNS` columns, the better of two."""
    B = np.asfortranarray(np.random.default_rng(1).standard_normal((n, COLUMNS)))
    seconds = []
    for _ in range(2):
        started = now()
        solver.solve(B)
        seconds.append(now() - started)
    return min(seconds) / COLUMNS


def _timed_names() -> list[tuple[Any, str, str]]:
    """Owner, name and phase of what `modes` calls."""
    krylov, basis = lanczos_module._Krylov, lanczos_module._Basis
    return [
        (lanczos_module.BlockProduct, "__call__", MASS),
        (krylov, "step", ORTHOGONAL),
        (krylov, "next_block", ORTHOGONAL),
        (ritz, "_eigen", DENSE),
        (basis, "combined", VECTORS),
        (modes_module, "_residual", RESIDUAL),
    ]


def assembled_door(mesh_size: float, free: bool) -> System:
    """The unreduced door, links eliminated, as the deck holds it or without any support."""
    with tempfile.TemporaryDirectory() as folder:
        model = read_model(write_door(mesh_size, Path(folder))[0])
    return undamped_system(replace(model, fixed=()) if free else model)


def rows(measured: Measured) -> list[Row]:
    """Phase, seconds and units per mode."""
    found, total = measured.modes, measured.total
    lines = [
        (name, f"{seconds:.2f} s, {100 * seconds / total:.0f} %", f"{measured.units_per_mode(seconds):.2f}")
        for name, seconds in measured.seconds.items()
    ]
    count = found.omega2.size
    unit = f"{count} modes to {found.frequencies[-1]:.0f} Hz, {1e3 * measured.unit:.2f} ms a column"
    checks = f"largest residual {found.residual:.1e}, Sturm count {'agrees' if found.sturm_ok else 'DISAGREES'}"
    return [
        (unit, f"{found.columns} columns solved", f"{found.columns / count:.2f}"),
        *lines,
        ("all", f"{total:.2f} s, {1e3 * total / count:.1f} ms a mode", f"{measured.units_per_mode(total):.2f}"),
        ("", checks, f"goal {GOAL:g}"),
    ]


def main() -> None:
    """Assemble, measure and print."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.modes_cost")
    options.add_argument("--mesh-size", type=float, default=10.0, help="mm")
    options.add_argument("--count", type=int, action="append", help="modes; may be given more than once")
    options.add_argument("--free", action="store_true", help="without supports: six rigid-body modes come first")
    options.add_argument("--cpu", action="store_true", help="CPU seconds: for one thread on a busy machine")
    given = options.parse_args()
    now = time.process_time if given.cpu else time.perf_counter
    system = assembled_door(given.mesh_size, given.free)
    held = "free" if given.free else "held by its supports"
    title = f"Door, {held}, {system.n:,} free dofs, {'CPU' if given.cpu else 'wall'} seconds"
    table = Table("what", "measured", "column solves a mode", title=title)
    measure(system.K[:SMALL, :SMALL], system.M[:SMALL, :SMALL], 8, True)  # imports and compiles what is needed
    for count in given.count or COUNTS:
        meter = Meter()
        for row in rows(measure(system.K, system.M, count, given.free, now)):
            table.add_row(*row)
        table.add_row("", f"peak memory {meter.read().peak_rss_gb:.2f} GB", "", end_section=True)
    Console(width=130).print(table)


if __name__ == "__main__":
    main()
