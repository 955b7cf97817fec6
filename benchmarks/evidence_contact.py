"""Contact in `benchmarks.evidence`: its stiffness, forced steps, and node-to-surface beside surface-to-surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.evidence_door import Bench, figures, rattle
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.condensed import response
from creak.dynamics.scheme import HHT
from creak.dynamics.step_matrix import StepFactor
from creak.studies.models.reduced import ReducedModel
from creak.studies.run.integrate import limited
from creak.studies.run.one_run import Run

STIFFNESSES = (0.1, 0.5, 1.0, 2.0, 10.0, 100.0)
UNEQUAL = (1.0, 2.0, 4.0, 16.0, 64.0, 256.0)
"""Stiffness of the reduced model's node-to-surface contact over its reference's."""
FORCED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("HHT", {"integrator": "hht", "step": 1e-3}),
    ("HHT, 4 substeps", {"integrator": "hht", "step": 1e-3, "substeps": 4}),
    ("HHT", {"integrator": "hht", "step": 2.5e-4}),
    ("HHT", {"integrator": "hht", "step": 1e-4}),
    ("HHT", {"integrator": "hht", "step": 2e-5}),
)
THESIS: dict[str, Any] = {"integrator": "hht", "alpha": -0.05, "step": 1e-3}
"""Of its runs, 1 kHz."""
WINDOW_S = 2.0
"""s of the unreduced runs that look at how contact is defined."""
INSTANTS = (1e-3, 1e-4, 1e-5, 1e-6)
"""s over which a channel's compliance is looked at."""


def stiffened(gaps: GapOperator, factor: float) -> GapOperator:
    """Channels with their stiffness times a factor; infinite: hard."""
    return replace(gaps, stiffness=gaps.stiffness * factor)


def penalties(bench: Bench, model: ReducedModel, load: str) -> dict[str, Any]:
    """The answer against the contact stiffness, at the default accuracy."""
    base = bench.run(load, model)
    rows = []
    for factor in (*STIFFNESSES, np.inf):
        run = base if factor == 1.0 else bench.run(load, model, gaps=stiffened(bench.gaps, factor))
        name = "hard" if np.isinf(factor) else factor
        rows.append({"factor": name, **contact_figures(run), **figures([(base, run)], bench.tolerance)})
    k = bench.gaps.stiffness
    return {"load": load, "median_stiffness": float(np.median(k)), "rows": rows}


def contact_figures(run: Run) -> dict[str, Any]:
    """Peaks, depth, and how many channels share the impulse, (sum J)^2 / sum J^2."""
    h, events = run.history, run.events
    J = h.weights @ h.force
    return rattle(run) | {
        "raw_peak": max((e.force_peak for e in events), default=0.0),
        "channel_low_passed": max((e.force_peak_filtered for e in events), default=0.0),
        "shared_by": float(J.sum() ** 2 / (J @ J)) if J.any() else 0.0,
    }


def forced_steps(bench: Bench, model: ReducedModel, loads: Sequence[str]) -> dict[str, Any]:
    """Runs with a forced step against those of the default accuracy, both reduced alike."""
    settled = {load: bench.run(load, model) for load in loads}
    rows = []
    for name, time in FORCED:
        setup = bench.forced(time)
        gaps, _ = limited(setup.marching, setup.model.nodes.coords, bench.reference.system, bench.gaps)
        runs = {load: bench.run(load, model, gaps=gaps, base=setup) for load in loads}
        rows.append(
            {
                "scheme": name,
                "step": time["step"],
                "per_period": 1.0 / (100.0 * time["step"]),
                "median_stiffness": float(np.median(gaps.stiffness)),
                "dissipated": max(r.history.energy_dissipated_by_scheme for r in runs.values()),
                "cpu_s": sum(r.cost.cpu_s for r in runs.values()) / len(runs),
                **figures([(settled[load], runs[load]) for load in loads], bench.tolerance),
            }
        )
    cost = sum(r.cost.cpu_s for r in settled.values()) / len(settled)
    return {
        "loads": list(loads),
        "full_stiffness": float(np.median(bench.gaps.stiffness)),
        "settled_cpu_s": cost,
        "rows": rows,
    }


def node_contact(mesh_size: float, f_max: float, load: str) -> dict[str, Any]:
    """The thesis's second question: reduced against unreduced, contact by surfaces and by nodes."""
    record: dict[str, Any] = {"mesh_size": mesh_size, "load": load, "end": WINDOW_S, "methods": {}}
    for method in ("surface-to-surface", "node-to-surface"):
        bench = Bench(mesh_size, {"contact.flange.method": method})
        model = bench.model({"f_max": f_max})
        record["methods"][method] = _both_ways(bench, model, load) | {"compliance": _compliance(bench, model)}
        if method == "node-to-surface":
            base = bench.run(load, model)
            record["unequal"] = [_unequal(bench, model, base, load, factor) for factor in UNEQUAL]
            few = [bench.model({"f_max": f}) for f in (300.0,)]
            record["few_modes"] = [
                {"f_max": 300.0, "modes": m.modes, **figures([(base, bench.run(load, m))], bench.tolerance)}
                for m in few
            ]
    return record


def _both_ways(bench: Bench, model: ReducedModel, load: str) -> dict[str, Any]:
    """Reduced over unreduced at the default accuracy, and with the thesis's step."""
    full, own = bench.unreduced(load, WINDOW_S), bench.run(load, model)
    setup = bench.forced(THESIS)
    gaps, _ = limited(setup.marching, setup.model.nodes.coords, bench.reference.system, bench.gaps)
    coarse, coarse_own = (
        bench.unreduced(load, WINDOW_S, gaps=gaps, base=setup),
        bench.run(load, model, gaps=gaps, base=setup),
    )
    tolerance = bench.tolerance
    return {
        "channels": bench.gaps.m,
        "median_stiffness": float(np.median(bench.gaps.stiffness)),
        "settled": contact_figures(_early(full, tolerance))
        | figures([(_early(full, tolerance), _early(own, tolerance))], tolerance),
        "thesis_step": contact_figures(_early(coarse, tolerance))
        | figures([(_early(coarse, tolerance), _early(coarse_own, tolerance))], tolerance),
        "unreduced_cpu_s": full.cost.cpu_s,
    }


def _early(run: Run, tolerance: float) -> Run:
    """Events of the window that both runs cover."""
    return replace(run, events=[e for e in run.events if e.t_start < WINDOW_S - tolerance])


def _unequal(bench: Bench, model: ReducedModel, base: Run, load: str, factor: float) -> dict[str, Any]:
    run = base if factor == 1.0 else bench.run(load, model, gaps=stiffened(bench.gaps, factor))
    found, own = contact_figures(run), contact_figures(base)
    ratios = {f"{k}_ratio": found[k] / own[k] for k in ("raw_peak", "channel_low_passed", "force", "impulse")}
    return {"factor": factor, **ratios, **figures([(base, run)], bench.tolerance)}


def _compliance(bench: Bench, model: ReducedModel) -> list[dict[str, float]]:
    """Motion of a channel under its own force within a step, reduced over unreduced, median over the channels."""
    rows, systems = [], (bench.reference.system, model.system)
    for h in INSTANTS:
        full, own = (
            response(StepFactor(s, HHT(-0.05), h), channel_matrices(s, bench.gaps).G, keep=False)[0].diagonal()
            for s in systems
        )
        rows.append({"step": h, "ratio": float(np.median(own / full))})
    return rows
