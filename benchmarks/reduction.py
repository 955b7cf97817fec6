"""What a reduction costs, phase by phase, in blocked back-substitutions per column."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.door import Door
from creak.assembly.system import System
from creak.linalg.factor import Factor
from creak.reduction.constraint_modes import COLUMNS
from creak.reduction.craig_bampton import fixed_interface_basis, reduced_matrices
from creak.reduction.inside import Inside
from creak.studies.models.substructures import partition
from creak.studies.run.compared import Meter

Row = tuple[str, str, str]
LIMIT = "limit 2 x"


def craig_bampton_cost(door: Door) -> list[Row]:
    """Each part's reduction as the study asks for it."""
    f_max = door.setup.band.f_max
    cut = partition(door.setup.reduction, door.reference, door.gaps)
    return [row for sub in cut.substructures for row in reduction_cost(sub.part, sub.boundary, f_max)]


def reduction_cost(part: System, boundary: np.ndarray, f_max: float | None) -> list[Row]:
    """Factor, fixed-interface modes and constraint modes of one part; `f_max` None: no modes (Guyan).

    A phase costs wall / (columns solved x seconds per column); the seconds are those of a back-substitution of
    128 columns, measured before and after the phase.
    """
    inside, meter = Inside(part, boundary), Meter()
    name = f"{part.name}: {inside.i.size:,} inner dofs"
    wall, solver = timed(lambda: inside.factor)
    before = column_seconds(solver, inside.i.size)
    rows: list[Row] = [(name, f"factor {wall:.1f} s, {1e3 * before:.2f} ms a column", f"{boundary.size} retained")]
    count = 0 if f_max is None else None
    wall, basis = timed(lambda: fixed_interface_basis(inside, None, f_max, count))
    between = column_seconds(solver, inside.i.size)
    if basis.fixed.columns:
        unit, kept = 0.5 * (before + between), basis.fixed.omega2.size
        ratio = wall / (basis.fixed.columns * unit)
        rows.append((f"  {kept} modes", f"{wall:.1f} s for {basis.fixed.columns} columns: {ratio:.1f} x", LIMIT))
    wall, _ = timed(lambda: reduced_matrices(part, basis))
    unit = 0.5 * (between + column_seconds(solver, inside.i.size))
    solved = 2 * inside.coupled.size
    rows.append(("  constraint modes", f"{wall:.1f} s for {solved} columns: {wall / (solved * unit):.1f} x", LIMIT))
    return [*rows, ("  peak memory", f"{meter.read().peak_rss_gb:.1f} GB", "")]


def timed(work):  # type: ignore[no-untyped-def]
    """Wall seconds and result."""
    started = time.perf_counter()
    result = work()
    return time.perf_counter() - started, result


def column_seconds(solver: Factor, n: int) -> float:
    """Seconds per column of a back-substitution of `COLUMNS` columns."""
    B = np.asfortranarray(np.random.default_rng(1).standard_normal((n, COLUMNS)))
    return min(timed(lambda: solver.solve(B))[0] for _ in range(2)) / COLUMNS
