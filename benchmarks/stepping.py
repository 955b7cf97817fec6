"""What a step costs: `python -m benchmarks.stepping [--mesh-size H ...]`.

In back-substitutions for the unreduced model, against plain Newton, and for the reduced one against real time and
against the memory traffic of its own matrices.
"""

from __future__ import annotations

import argparse
import runpy
import time
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.door import SCHEME, Door, door
from creak.arrays import FloatArray
from creak.contact.step_problem import compile_kernels
from creak.dynamics.flow import march as flow_march
from creak.dynamics.instant import Instant
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import CondensedStepper, Stepper, simulate
from creak.linalg.threads import one_blas_thread
from creak_thesis.measure import PlainNewton, touching

Row = tuple[str, str, str]
LARGE = 400_000
"""Free dofs from which on plain Newton is left out, and the reduced run left to `benchmarks.million`."""


def main() -> None:
    """Measure on doors of several mesh sizes."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stepping")
    parser.add_argument("--mesh-size", type=float, nargs="+", default=[20.0], help="mm")
    for size in parser.parse_args().mesh_size:
        model = door(size)
        table = Table("what", "measured", "against", title=f"Door, {model.reference.system.n:,} free dofs")
        for rows in (full_order, against_plain_newton, reduced_order):
            for row in rows(model):
                table.add_row(*row)
            table.add_section()
        Console(width=130).print(table)
    table = Table("what", "measured", "against", title="Contact that lasts: a block that sticks and slips on a belt")
    for row in lasting_contact():
        table.add_row(*row)
    Console(width=130).print(table)


def lasting_contact() -> list[Row]:
    """Long steps against kicks alone, both after their compilation, on the example of a block on a belt."""
    example = runpy.run_path(str(Path(__file__).parents[1] / "examples" / "stick_slip_belt.py"))
    rows, seconds = [], []
    for name, shortest in (("kicks alone", 1e30), ("long steps", flow_march.SHORTEST)):
        with patch.object(flow_march, "SHORTEST", shortest):
            rate = example["main"]("")["rate_hz"]
            started = time.process_time()
            example["run"]()
            seconds.append(time.process_time() - started)
        rows.append((name, f"{seconds[-1]:.3f} s for {example['END']} s, {rate:.5f} Hz", f"{example['RATE']:.5f} Hz"))
    return [*rows, ("ratio", f"{seconds[0] / seconds[1]:.0f} x", "limit 20 x")]


def timed_steps(stepper: Stepper, now: Instant, steps: int) -> tuple[dict[bool, list[float]], Instant]:
    """Seconds of each step, by whether it ended in contact."""
    seconds: dict[bool, list[float]] = {False: [], True: []}
    with one_blas_thread():
        for _ in range(steps):
            started = time.perf_counter()
            for after in stepper.advance(now):
                now = after
            seconds[bool(now.p.any())].append(time.perf_counter() - started)
    return seconds, now


def full_order(model: Door, steps: int = 40) -> list[Row]:
    """Step over back-substitution: free flight (limit 1.5) and contact (limit 2.5).

    A back-substitution is timed after every step, so that both see the machine in the same state.
    """
    system, loads = model.reference.system, model.setup.loads
    rows: list[Row] = []
    for name, gaps, pressed, limit in (
        ("free flight", model.gaps, False, 1.5),
        ("contact", touching(model.gaps), True, 2.5),
    ):
        stepper = CondensedStepper(system, gaps, loads, SCHEME)
        now, taken, solved = stepper.start(), [], []
        for _ in range(steps):
            seconds, now = timed_steps(stepper, now, 1)
            taken += seconds[pressed]
            solved += [solve_seconds(stepper, now.x.Ku)] if seconds[pressed] else []
        step, one = float(np.median(taken)), float(np.median(solved))
        what = f"{1e3 * step:.2f} ms = {step / one:.2f} back-substitutions of {1e3 * one:.2f} ms ({len(taken)} steps)"
        rows.append((f"step in {name}", what, f"limit {limit}"))
    return rows


def solve_seconds(stepper: CondensedStepper, b: FloatArray) -> float:
    """Wall time of one back-substitution with the step matrix."""
    started = time.perf_counter()
    stepper.solver.solve(b)
    return time.perf_counter() - started


def against_plain_newton(model: Door, steps: int = 10) -> list[Row]:
    """Condensed contact against Newton with refactorisation, on steps in contact."""
    system, loads, gaps = model.reference.system, model.setup.loads, touching(model.gaps)
    if system.n > LARGE:
        return []
    condensed = CondensedStepper(system, gaps, loads, SCHEME)
    fast, end = timed_steps(condensed, condensed.start(), steps)
    plain = PlainNewton(system, gaps, loads, SCHEME)
    slow, twin = timed_steps(plain, plain.start(), steps)
    cost = [sum(sum(v) for v in s.values()) / steps for s in (fast, slow)]
    apart = float(np.abs(end.x.u - twin.x.u).max() / np.abs(end.x.u).max())
    return [
        ("condensed step", f"{1e3 * cost[0]:.1f} ms", ""),
        ("plain Newton step", f"{1e3 * cost[1]:.1f} ms, {plain.factorisations / steps:.1f} factorisations", ""),
        ("ratio", f"{cost[1] / cost[0]:.0f} x, results apart by {apart:.1e}", "1e-8"),
    ]


def reduced_order(model: Door) -> list[Row]:
    """The reduced five-second run at 1 kHz and at 100 kHz, and the energy balance."""
    if model.reference.system.n > LARGE:
        return []
    compile_kernels()
    reduced = model.reduced()
    system, n_step = reduced.system, model.setup.loads.n_step
    rows: list[Row] = [
        ("reduction", f"{reduced.wall_s:.1f} s for {reduced.retained} retained dofs and {reduced.modes} modes", "")
    ]
    for parts, limit in ((1, 5.0), (100, 60.0)):
        loads = model.setup.marching.divided(parts)
        warm = replace(loads, time=loads.time[:3], support=loads.support[:, :3], force=loads.force[:3])
        none = np.zeros(0, dtype=np.int64)
        simulate(system, model.gaps, warm, SCHEME, OutputRequest(none))
        started = time.perf_counter()
        history = simulate(system, model.gaps, loads, SCHEME, OutputRequest(none, every=parts))
        wall = time.perf_counter() - started
        span = f"{system.n} modes, {model.gaps.m} channels, {1e-3 * parts / model.setup.loads.step:.0f} kHz"
        floor = n_step * parts * traffic_seconds(system.n, model.gaps.m)
        rows += [
            (
                f"reduced run, {span}",
                f"{wall:.2f} s, {1e6 * wall / (n_step * parts):.0f} us a step",
                f"limit {limit:.0f} s",
            ),
            ("  against its memory traffic", f"{wall / floor:.1f} x", ""),
            ("  energy created", f"{100 * history.energy_created:.3f} % of the external work", "limit 0.5 %"),
            ("  dissipated by the scheme", f"{100 * history.energy_dissipated_by_scheme:.2f} %", ""),
        ]
    return rows


def traffic_seconds(n: int, m: int, vectors: int = 12) -> float:
    """Seconds to read G (m, n) and `vectors` vectors of n once: the least that a step can take."""
    data = np.ones((m + vectors, n))
    x = np.ones(n)
    with one_blas_thread():
        times = []
        for _ in range(200):
            started = time.perf_counter()
            data @ x
            times.append(time.perf_counter() - started)
    return float(np.median(times))


if __name__ == "__main__":
    main()
