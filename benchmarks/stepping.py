"""What a step costs: in back-substitutions for the unreduced model, against real time for the reduced one."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from benchmarks.door import SCHEME, Door
from creak.contact.unilateral import compile_kernels
from creak.dynamics.loads import Loads
from creak.dynamics.plain_newton import PlainNewtonHHT
from creak.dynamics.simulate import CondensedHHT, Instant, Stepper, simulate
from creak.linalg.threads import one_blas_thread

Row = tuple[str, str, str]


def shortened(loads: Loads, n: int) -> Loads:
    """The first n steps."""
    return replace(loads, time=loads.time[: n + 1], support=loads.support[:, : n + 1], force=loads.force[: n + 1])


def timed_steps(stepper: Stepper, now: Instant, first: int, n: int) -> tuple[dict[bool, list[float]], Instant]:
    """Seconds of each step, by whether it ended in contact."""
    seconds: dict[bool, list[float]] = {False: [], True: []}
    with one_blas_thread():
        for k in range(first, first + n):
            started = time.perf_counter()
            now = stepper.step(k, now)
            seconds[bool(now.p.any())].append(time.perf_counter() - started)
    return seconds, now


def full_order(door: Door, steps: int = 800) -> list[Row]:
    """Step over back-substitution: free flight (limit 1.5) and contact (limit 2.5)."""
    loads = door.setup.loads.consistent_with(SCHEME)
    stepper = CondensedHHT(door.reference.system, door.gaps, loads, SCHEME)
    seconds, _ = timed_steps(stepper, stepper.start(), 1, steps)
    b = np.random.default_rng(1).standard_normal(door.reference.system.n)
    solves = []
    for _ in range(50):
        started = time.perf_counter()
        stepper.solver.solve(b)
        solves.append(time.perf_counter() - started)
    one = float(np.median(solves))
    rows = [("one back-substitution", f"{1e3 * one:.2f} ms", "")]
    for contact, limit in ((False, 1.5), (True, 2.5)):
        name = "step in contact" if contact else "step in free flight"
        if seconds[contact]:
            step = float(np.median(seconds[contact]))
            rows.append((name, f"{1e3 * step:.2f} ms = {step / one:.2f} back-substitutions", f"limit {limit}"))
    return rows


def against_plain_newton(door: Door, steps: int = 12) -> list[Row]:
    """Condensed contact against Newton with refactorisation, on the first steps in contact."""
    loads = door.setup.loads.consistent_with(SCHEME)
    condensed = CondensedHHT(door.reference.system, door.gaps, loads, SCHEME)
    now, k = condensed.start(), 1
    while not now.p.any() and k <= loads.n_step:
        now, k = condensed.step(k, now), k + 1
    if not now.p.any():
        return [("condensed against plain Newton", "no contact in this run", "")]
    fast, end = timed_steps(condensed, now, k, steps)
    plain = PlainNewtonHHT(door.reference.system, door.gaps, loads, SCHEME)
    slow, twin = timed_steps(plain, now, k, steps)
    cost = [sum(sum(v) for v in s.values()) / steps for s in (fast, slow)]
    apart = float(np.abs(end.x.u - twin.x.u).max() / np.abs(end.x.u).max())
    return [
        ("condensed step", f"{1e3 * cost[0]:.1f} ms", ""),
        ("plain Newton step", f"{1e3 * cost[1]:.1f} ms, {plain.factorisations / steps:.1f} factorisations", ""),
        ("ratio", f"{cost[1] / cost[0]:.0f} x, results apart by {apart:.1e}", "1e-8"),
    ]


def reduced_order(door: Door) -> list[Row]:
    """The reduced five-second run against real time, and the energy balance with half the step."""
    compile_kernels()
    model = door.reduced()
    none = np.zeros(0, dtype=np.int64)
    started = time.perf_counter()
    history = simulate(model.system, door.gaps, door.setup.loads, SCHEME, observed=none)
    wall = time.perf_counter() - started
    span = float(door.setup.loads.time[-1])
    return [
        ("reduction", f"{model.wall_s:.1f} s for {model.retained} retained dofs and {model.modes} modes", ""),
        ("reduced run", f"{wall:.2f} s for {span:.0f} s, {1e6 * wall / door.setup.loads.n_step:.0f} us a step",
         f"limit {span:.0f} s"),
        ("energy created", f"{100 * history.energy_created:.3f} % of the external work", "limit 0.5 %"),
        ("dissipated by the scheme", f"{100 * history.energy_dissipated_by_scheme:.2f} %", ""),
    ]  # fmt: skip
