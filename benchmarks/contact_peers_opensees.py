"""The strips of `benchmarks.contact_peers` in OpenSees: `python contact_peers_opensees.py CASE.json RESULT.json`.

Runs in an interpreter that has openseespy and needs nothing else. Shells: ShellMITC4. Contact: one zero-length spring
per pair of facing nodes, compression only, after the gap (ElasticPPGap that never yields). As the model is linear
but for these springs, the strips lie in one plane, so that facing nodes coincide.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import openseespy.opensees as ops

NEVER = 1e12
"""Yield force of the gap springs and penalty of the prescribed motion (per mm)."""
TOLERANCE, ITERATIONS = 1e-8, 30
"""Norm of a correction of displacement, mm, and corrections allowed."""
FALLBACKS = ("Newton", "NewtonLineSearch")
"""Tried where Krylov-Newton does not converge, which was the fastest here (Newton, modified Newton were tried)."""


def build(case: dict[str, Any]) -> None:
    """Nodes, shells, supports, gap springs, base motion."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.section("ElasticMembranePlateSection", 1, case["E"], case["nu"], case["thickness"], case["rho"])
    for label, x, y, _ in case["nodes"]:
        ops.node(label, x, y, 0.0)
    for label, *corners in case["quads"]:
        ops.element("ShellMITC4", label, *corners, 1)
    for label in case["fixed"]:
        ops.fix(label, 1, 1, 1, 1, 1, 1)
    for label in case["moving"]:
        ops.fix(label, 1, 1, 0, 1, 1, 1)
    first = 1 + max(quad[0] for quad in case["quads"])
    for k, (upper, lower, area) in enumerate(case["pairs"]):
        ops.uniaxialMaterial("ElasticPPGap", k + 1, case["stiffness"] * area, -NEVER, -case["gap"])
        ops.element("zeroLength", first + k, lower, upper, "-mat", k + 1, "-dir", 3)
    ops.timeSeries("Path", 1, "-dt", case["step"], "-values", *case["base"], "-useLast")
    ops.pattern("Plain", 1, 1)
    for label in case["moving"]:
        ops.sp(label, 3, 1.0)
    ops.rayleigh(0.0, 0.0, case["beta"], 0.0)  # of the initial stiffness


def prepare(case: dict[str, Any]) -> None:
    """Solution strategy; HHT of OpenSees calls 1 + alpha what creak and CalculiX call alpha."""
    ops.constraints("Penalty", NEVER, NEVER)
    ops.numberer("RCM")
    ops.system(case["solver"])
    ops.test("NormDispIncr", TOLERANCE, ITERATIONS, 0)
    ops.algorithm("KrylovNewton")
    ops.integrator("HHT", 1.0 + case["alpha"])
    ops.analysis("Transient")


def advance(step: float) -> bool:
    """One step; other algorithms are tried where Krylov-Newton does not converge."""
    if ops.analyze(1, step) == 0:
        return True
    for name in FALLBACKS:
        ops.algorithm(name)
        done = ops.analyze(1, step) == 0
        ops.algorithm("KrylovNewton")
        if done:
            return True
    return False


def march(case: dict[str, Any]) -> dict[str, Any]:
    """Step until the end, the limit of CPU seconds or a step that does not converge."""
    started = time.process_time()
    build(case)
    prepare(case)
    setup = time.process_time() - started
    first = 1 + max(quad[0] for quad in case["quads"])
    springs = range(first, first + len(case["pairs"]))
    rows: list[list[float]] = [[0.0] * 4]
    failed, iterations = "", 0
    for n in range(1, len(case["base"])):
        if not advance(case["step"]):
            failed = f"step {n} does not converge ({ITERATIONS} iterations; Krylov-Newton, Newton, line search)"
            break
        iterations += ops.testIter()
        force = sum(max(0.0, -ops.basicForce(tag)[0]) for tag in springs)
        rows.append([n * case["step"], *(ops.nodeDisp(label, 3) for label in case["watched"]), force])
        if time.process_time() - started > case["limit"]:
            failed = f"over {case['limit']:.0f} s of CPU"
            break
    cpu = time.process_time() - started
    return {
        "rows": rows,
        "failed": failed,
        "setup_s": setup,
        "cpu_s": cpu,
        "iterations": iterations,
        "version": ops.version(),
    }


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as source:
        outcome = march(json.load(source))
    with open(sys.argv[2], "w", encoding="utf-8") as target:
        json.dump(outcome, target)
