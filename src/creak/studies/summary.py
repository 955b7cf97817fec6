"""summary.json: what a study found, for machines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import creak
from creak.model.mesh import Model
from creak.studies.run import Run, StudyResult
from creak.verify.events import Event


def summarise(result: StudyResult) -> dict[str, Any]:
    """The summary as plain numbers, strings and lists; infinite or undefined figures are null."""
    setup, model = result.setup, result.setup.model
    c = setup.study.config
    summary = {
        "creak": creak.__version__,
        "title": c.title,
        "units": c.model.units,
        "model": _model(result),
        "precheck": {"candidates": setup.contacts.m, "kept": result.gaps.m - setup.connectors.m},
        "seeds": {name: t.signal.seed for name, t in c.excitation.items() if t.signal.type == "multisine"},
        "runs": {name: _run(run, result, model) for name, run in result.runs.items()},
        "superelements": {name: health.as_dict() for name, health in result.health.items()},
        "verification": _verification(result),
        "unread": [
            {"keyword": u.keyword, "where": u.where, "changes_answer": u.changes_answer, "why": u.why}
            for u in model.unread
        ],
        "notes": result.notes,
    }
    return _plain(summary)


def _model(result: StudyResult) -> dict[str, Any]:
    model, parts = result.setup.model, result.reference.parts
    in_parts, in_elements = (p.nodes_idx for p in model.parts), (b.nodes_idx.ravel() for b in model.blocks)
    used = np.unique(np.concatenate([*in_parts, *in_elements]))
    return {
        "nodes": model.nodes.count,
        "elements": model.n_elements,
        "dof": 6 * int(used.size),
        "free_dof": result.reference.system.n,
        "mass": result.reference.system.stats["mass"],
        "parts": {
            p.name: {"nodes": int(model.parts[i].nodes_idx.size), "elements": int(p.stats["elements"]),
                     "mass": p.stats["mass"]}
            for i, p in enumerate(parts)
        },
    }  # fmt: skip


def _run(run: Run, result: StudyResult, model: Model) -> dict[str, Any]:
    h = run.history
    return {
        "dof": run.system.n,
        "retained": run.retained,
        "modes": run.modes,
        "channels": result.gaps.m,
        "steps": h.time.size - 1,
        "contact_steps": h.contact_steps,
        "wall_s": run.cost.wall_s,
        "setup_s": h.setup_s,
        "cpu_s": run.cost.cpu_s,
        "offline_cpu_s": run.offline_cpu_s,
        "offline_wall_s": run.offline_wall_s,
        "peak_rss_gb": run.cost.peak_rss_gb,
        "energy_error": -h.energy_created if h.energy_created > 0.0 else h.energy_dissipated_by_scheme,
        "energy_created": h.energy_created,
        "scheme_dissipation": h.energy_dissipated_by_scheme,
        "events": [_event(e, model) for e in run.events],
        "max_force": float(h.force.max(initial=0.0)),
        "max_penetration": float(max(0.0, -h.gap.min(initial=0.0))),
        "impulse_total": float(h.force.sum() * h.step),
    }


def _event(e: Event, model: Model) -> dict[str, Any]:
    return {
        "contact": e.group,
        "channel": e.channel,
        "node": int(model.nodes.ids[e.node_idx]),
        "t_start": e.t_start,
        "t_peak": e.t_peak,
        "t_end": e.t_end,
        "force_peak": e.force_peak,
        "force_peak_filtered": e.force_peak_filtered,
        "impulse": e.impulse,
        "closing_speed": e.closing_speed,
        "contacts": e.contacts,
    }


def _verification(result: StudyResult) -> dict[str, Any]:
    out: dict[str, Any] = {"window": list(result.window)}
    if result.modes is not None:
        m = result.modes
        out["mac"] = m.pairs.mac.tolist()
        out["frequencies"] = [
            [f, float(m.freq_reduced[j]) if j >= 0 else None]
            for f, j in zip(m.freq_reference.tolist(), m.pairs.partner.tolist(), strict=True)
        ]
    if result.spectra is not None:
        out["nrmse"] = result.spectra.nrmse
    if result.events is not None:
        match = result.events
        out["events"] = {
            "reference": len(match.pairs) + len(match.missed),
            "reduced": len(match.pairs) + len(match.extra),
            "matched": len(match.pairs),
            "missed": len(match.missed),
            "extra": len(match.extra),
            "amplitude_ratio_mean": match.amplitude_ratio_mean,
            "impulse_ratio_mean": match.impulse_ratio_mean,
            "within_5_percent": match.within_5_percent,
        }
    return out


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
