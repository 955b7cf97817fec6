"""summary.json: what a study found, for machines."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from creak.dynamics.history import ENERGIES
from creak.model.plain_mesh import Mesh
from creak.studies.converge.settled import KEYS, UNCHECKED, is_chaotic, place_settled_to, settled_to
from creak.studies.converge.settling import Convergence
from creak.studies.converge.words import as_dict
from creak.studies.findings.elines import against_measured
from creak.studies.findings.elines import as_dict as eline_summary
from creak.studies.findings.limits import judged
from creak.studies.findings.places import Place
from creak.studies.findings.sound import heard_at, place_name, sound_summary
from creak.studies.findings.spots import bars_of_reference, beside_bars, spots_of
from creak.studies.findings.tree import Findings, FoundBand, FoundRun, FoundSetup, FoundTest, MeasuredRate
from creak.verify.events import Event, EventKey
from creak.verify.matching import Errors, EventMatch
from creak.verify.reliability import UNRELIABLE
from creak.verify.rubbing import FIGURES
from creak.verify.slips import SlipEvent, Squeak, squeak_rates

ROUND_OFF = 1e-9
"""Share of the external work below which no energy counts as created."""


def summary_of(findings: Findings) -> dict[str, Any]:
    """The summary as plain numbers, strings and lists; infinite or undefined figures are null."""
    f = findings
    c, why = f.setup.study.config, f.unanswered
    warnings = list(f.alarms)
    summary: dict[str, Any] = {
        "creak": f.creak,
        "run": f.identity.as_dict(),
        "study": f.setup.study.path.name,
        "title": c.title,
        "changes": f.setup.study.changes,
        "units": c.model.units,
        "model": _model(f.setup),
        "precheck": {
            "candidates": f.setup.contacts.m,
            "kept": f.gaps.m - f.setup.connectors.m,
            "closed_later": f.closed_later,
        },
        "static": f.static,
        "seeds": {name: t.signal.random for name, t in c.excitation.items() if t.signal.random is not None},
        "runs": {name: _run(run, f) for name, run in f.runs.items()},
        "elines": None if f.elines is None else eline_summary(f.elines, c.limit, c.model.units, f.setup.model),
        "superelements": {name: health.as_dict() for name, health in f.health.items()},
        "sound": sound_summary(f),
        "tests": {test.name: _test(test) for test in f.tests},
        "verification": _verification(f),
        "unread": [
            {"keyword": u.keyword, "where": u.where, "changes_answer": u.changes_answer, "why": u.why}
            for u in f.setup.unread
        ],
        "notes": [note.text for note in f.said],
        "unanswered": why,
        "other_units": f.other_units,
        "warnings": [why, *warnings] if why else warnings,
        "stopped": f.stopped,
    }
    if f.convergence is not None:
        summary["convergence"] = as_dict(f.convergence)
    summary["limits"] = judged(c.limit, summary)
    return _plain(summary)


def unreliable_runs(summary: dict[str, Any]) -> list[str]:
    """Run and reason of each run of a summary that cannot be relied on, a sentence each."""
    runs = {name: run for name, run in summary["runs"].items() if run.get("verdict") == UNRELIABLE}
    return [f"{name} run: {reason}" for name, run in runs.items() for reason in run["reasons"]]


def _model(setup: FoundSetup) -> dict[str, Any]:
    mesh = setup.model
    return {
        "nodes": mesh.nodes.count,
        "elements": mesh.n_elements,
        "dof": setup.dof,
        "free_dof": setup.free_dof,
        "mass": setup.mass,
        "parts": {p.name: {"nodes": p.nodes, "elements": p.elements, "mass": p.mass} for p in setup.parts},
    }


def _run(run: FoundRun, f: Findings) -> dict[str, Any]:
    h, model, verdict = run.history, f.setup.model, run.verdict
    gap_min = None if run.nearest is None else run.nearest[2]
    penetration = max(0.0, -(gap_min or 0.0))
    unchecked = [] if len(f.runs) > 1 else [UNCHECKED]
    bars, unknown = _bars(run, f), dict.fromkeys(KEYS.values())
    mine = f.convergence if f.convergence is not None and f.convergence.model == run.name else None
    return {
        **({} if verdict is None else {"verdict": verdict.word}),
        "reasons": unchecked if verdict is None else list(verdict.reasons),
        "integrator": run.integrator,
        "stopped": run.stopped,
        "dof": run.dof,
        "retained": run.retained,
        "modes": run.modes,
        **_band(run, f.band),
        "channels": f.gaps.m,
        "rest_channels": run.resting_channels,
        "steps": h.time.size - 1,
        "end": float(h.time[-1]),
        "contact_steps": run.contact_steps,
        "wall_s": run.cost.wall_s,
        "setup_s": run.setup_s,
        "cpu_s": run.cost.cpu_s,
        "offline_cpu_s": run.offline_cpu_s,
        "offline_wall_s": run.offline_wall_s,
        "peak_rss_gb": run.cost.peak_rss_gb,
        "energy_error": -h.energy_created if h.energy_created > ROUND_OFF else h.energy_dissipated_by_scheme,
        "energy_created": h.energy_created,
        "energy_created_of_contact": run.energy_created_of_contact,
        "scheme_dissipation": h.energy_dissipated_by_scheme,
        "energies": dict(zip(ENERGIES, h.energy[-1].tolist(), strict=True)),
        "worst_residual": run.residual,
        "events": [_event(e, model) | {"settled_to": bars.get(e.key, unknown)} for e in run.events],
        "places": _places(run, f, mine),
        "resting": [
            {"contact": p.contact, "nodes": model.nodes.ids[p.nodes_idx].tolist(), **_rub(p)} for p in run.resting
        ],
        "slip_events": [_slip_event(e, model) for e in run.slips],
        "squeak_rate": squeak_rates(run.slips, f.window),
        "squeak": [_squeak(s, f.measured_rates.get(s.group), model) for s in run.squeaks],
        "max_force": max([float(h.force.max(initial=0.0)), *(e.force_peak for e in run.events)]),
        "penetration_max": penetration,
        "max_penetration": penetration,  # earlier name of the same figure, for those who read it
        "gap_min": gap_min,
        "impulse_total": float((h.weights @ h.force).sum()),
    }


def _bars(run: FoundRun, f: Findings) -> dict[EventKey, dict[str, float | None]]:
    """Bars of the events of a run, where there are any: by repeats, or by its own contact steps."""
    c = f.convergence
    if c is None:
        return {}
    if run.name == "reference" and c.structure is not None:
        return {e.key: bars_of_reference(c.structure, e) for e in run.events}
    return {e.event.key: settled_to(e) for e in c.events} if c.model == run.name else {}


def _band(run: FoundRun, band: FoundBand | None) -> dict[str, Any]:
    """How far the modes of a reduced run go, and the stages in which that was found."""
    if run.name != "reduced" or band is None:
        return {}
    stages = {"stages": [asdict(s) for s in band.stages], "stages_ended": band.why or None} if band.stages else {}
    return {"f_max": band.f_max, **stages}


def _event(e: Event, model: Mesh) -> dict[str, Any]:
    return {
        "contact": e.group,
        "side": e.side,
        "channel": e.channel,
        "node": int(model.nodes.ids[e.node_idx]),
        "t_start": e.t_start,
        "t_peak": e.t_peak,
        "t_end": e.t_end,
        "force_peak": e.force_peak,
        "force_peak_filtered": e.force_peak_filtered,
        "force_place": e.force_place,
        "impulse": e.impulse,
        "closing_speed": e.closing_speed,
        "contacts": e.contacts,
        "touches": e.touches,
        "unfinished": e.unfinished,
    }


def _places(run: FoundRun, f: Findings, convergence: Convergence | None) -> list[dict[str, Any]]:
    """Figures over the verification window, each place with its share of the impulse of all."""
    whole, sounds = sum(p.impulse for p in run.places), f.heard(run.name)
    causes = run.causes or (None,) * len(run.places)
    bars = [place_settled_to(convergence, p.number) for p in run.places]
    places = [
        {
            "name": place_name(p),
            "contact": p.contact,
            "nodes": f.setup.model.nodes.ids[p.nodes_idx].tolist(),
            "events": len(p.events),
            "impulse": p.impulse,
            "force": p.force,
            "closing_speed": p.speed,
            **_rub(p),
            **heard_at(sounds, p.number),
            "share": p.impulse / whole if whole > 0.0 else None,
            "irregularity": p.irregularity,
            "cause": beside_bars(cause, bar),
            "settled_to": bar,
        }
        for p, cause, bar in zip(run.places, causes, bars, strict=True)
    ]
    return with_ties(places)


def with_ties(places: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each place with `ties`: numbers of the places whose N5 lies within both bars of its own; null: it has no bar."""

    def bar(p: dict[str, Any]) -> float | None:
        to = p["settled_to"].get("n5")
        return None if to is None or p["n5"] is None else to * p["n5"]

    bars = [bar(p) for p in places]
    for p, own in zip(places, bars, strict=True):
        p["ties"] = None
        if own is not None:
            others = ((k, q, b) for k, (q, b) in enumerate(zip(places, bars, strict=True), start=1) if q is not p)
            p["ties"] = [k for k, q, b in others if b is not None and abs(q["n5"] - p["n5"]) <= own + b]
    return places


def _rub(p: Place) -> dict[str, Any]:
    """Friction, and the force of lasting contact; null where there is none."""
    friction = p.rub.friction
    return {
        "friction": None if friction is None else friction.state,
        **dict.fromkeys(FIGURES),
        **p.rub.figures,
        "slips": p.slip_count,
    }


def _slip_event(e: SlipEvent, model: Mesh) -> dict[str, Any]:
    return {
        "contact": e.group,
        "channel": e.channel,
        "node": int(model.nodes.ids[e.node_idx]),
        "t_start": e.t_start,
        "t_end": e.t_end,
        "slip_length": e.slip_length,
        "speed_peak": e.speed_peak,
        "friction_work": e.friction_work,
        "rate": e.rate,
        "slips": e.slips,
        "force_drop": e.force_drop,
        "per_length": e.per_length,
    }


def _squeak(s: Squeak, rate: MeasuredRate | None, model: Mesh) -> dict[str, Any]:
    measured = None if rate is None else rate.impulses
    return {
        "contact": s.group,
        "channel": s.channel,
        "node": int(model.nodes.ids[s.node_idx]),
        "slips": s.slips,
        "rate": s.rate,
        "slip_length": s.slip_length,
        "force_drop": s.force_drop,
        "energy": s.energy,
        "travel": s.travel,
        "per_length": s.per_length,
        "material": None if rate is None else rate.material,
        "measured_per_length": measured,
        "against_measured": against_measured(s.per_length, measured),
    }


def _test(test: FoundTest) -> dict[str, Any]:
    """Figures of the agreement; results.h5 has the courses and functions."""
    modes, frfs, records = test.modes, test.frfs, test.records
    return {
        "file": test.file,
        "modes": None if modes is None else modes.as_dict(),
        "frfs": None if frfs is None else {"functions": frfs.figures, "error": frfs.error, "notes": list(frfs.notes)},
        "records": None if records is None else records.as_dict(),
    }


def _verification(f: Findings) -> dict[str, Any]:
    out: dict[str, Any] = {"window": list(f.window)}
    if f.modes is not None:
        m = f.modes
        out["mac"] = m.pairs.mac.tolist()
        out["frequencies"] = [
            [freq, float(m.freq_reduced[j]) if j >= 0 else None]
            for freq, j in zip(m.freq_reference.tolist(), m.pairs.partner.tolist(), strict=True)
        ]
    if f.spectra is not None:
        out["nrmse"] = f.spectra.nrmse
    if f.events is not None:
        out["events"] = _matched(f.events) | {"statistics": _statistics(f)}
    return out | spots_of(f)


def _matched(match: EventMatch) -> dict[str, Any]:
    return {
        "reference": len(match.pairs) + len(match.missed),
        "reduced": len(match.pairs) + len(match.extra),
        "matched": len(match.pairs),
        "missed": len(match.missed),
        "extra": len(match.extra),
        "precision": match.precision,
        "recall": match.recall,
        "time_error": _errors(match.time_error),
        "force_error": _errors(match.force_error),
        "impulse_error": _errors(match.impulse_error),
        "amplitude_ratio_mean": match.amplitude_ratio_mean,
        "impulse_ratio_mean": match.impulse_ratio_mean,
        "within_5_percent": match.within_5_percent,
    }


def _errors(e: Errors) -> dict[str, Any]:
    return {"mean": e.mean, "bias": e.bias, "percentile_95": e.percentile_95, "each": e.each.tolist()}


def _statistics(f: Findings) -> dict[str, Any]:
    s = f.statistics
    distances = {"force": s.force, "impulse": s.impulse}
    return {
        "chaotic": is_chaotic(f.convergence, s.count[0], s.length, f.setup.study.config.highest),
        "rate": {"reference": s.rate[0], "reduced": s.rate[1], "alike": s.rates_alike}
        | {f"{name}_95": list(pair) for name, pair in zip(("reference", "reduced"), s.interval, strict=True)},
        **{
            f"{name}_distance": None if d is None else {"value": d.value, "critical": d.critical, "alike": d.alike}
            for name, d in distances.items()
        },
    }


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
