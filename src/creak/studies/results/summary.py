"""summary.json: what a study found, for machines."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from creak.dynamics.history import ENERGIES
from creak.model.mesh import Model
from creak.studies.converge.settled import KEYS, UNCHECKED, is_chaotic, place_settled_to, settled_to, verdict_of
from creak.studies.converge.settling import Convergence
from creak.studies.converge.unanswered import unanswered
from creak.studies.converge.words import as_dict
from creak.studies.prepare.static_loads import static_gravity
from creak.studies.results.elines import against_measured, measured_rates
from creak.studies.results.elines import as_dict as eline_summary
from creak.studies.results.limits import judged
from creak.studies.results.places import Place, resting_places
from creak.studies.results.sound import heard_at, heard_places, place_name, sound_summary
from creak.studies.results.spots import bars_of_reference, spots_of
from creak.studies.results.static_figures import static_figures
from creak.studies.run.compared import event_statistics, main_run
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run
from creak.studies.sound.heard import Sound
from creak.studies.warned import warnings_of
from creak.verify.events import Event, resting
from creak.verify.matching import Errors, EventMatch
from creak.verify.reliability import UNRELIABLE, created_of_contact
from creak.verify.rubbing import FIGURES
from creak.verify.slips import SlipEvent, Squeak, squeak_rates
from creak.version import version

ROUND_OFF = 1e-9
"""Share of the external work below which no energy counts as created."""


def summarise(
    result: StudyResult,
    convergence: Convergence | None = None,
    sound: Sound | str | None = None,
    causes: Mapping[int, dict[str, Any]] | None = None,
) -> dict[str, Any]:
    """The summary as plain numbers, strings and lists; infinite or undefined figures are null.

    Parameters
    ----------
    convergence : of `creak.studies.converge.repeats`, where it was looked at.
    sound : of `creak.studies.sound.heard`, or why there is none; None: it was not asked for.
    causes : of each place of the main run, by its number (`creak.studies.cause.told`).
    """
    setup, model = result.setup, result.setup.model
    c, why = setup.study.config, unanswered(result)
    heard = heard_places(result, result.runs[sound.run], sound) if isinstance(sound, Sound) else ()
    summary: dict[str, Any] = {
        "creak": version(),
        "run": result.identity.as_dict(),
        "study": setup.study.path.name,
        "title": c.title,
        "changes": dict(setup.study.places.changes),
        "units": c.model.units,
        "model": _model(result),
        "precheck": {
            "candidates": setup.contacts.m,
            "kept": result.gaps.m - setup.connectors.m,
            "closed_later": result.closed_later,
        },
        "static": _static(result),
        "seeds": {name: t.signal.random for name, t in c.excitation.items() if t.signal.random is not None},
        "runs": {name: _run(run, result, model, convergence, sound) for name, run in result.runs.items()},
        "elines": None if result.elines is None else eline_summary(result.elines, c.limit, c.model.units, model),
        "superelements": {name: health.as_dict() for name, health in result.health.items()},
        "sound": sound_summary(sound, heard),
        "verification": _verification(result, convergence),
        "unread": [
            {"keyword": u.keyword, "where": u.where, "changes_answer": u.changes_answer, "why": u.why}
            for u in model.unread
        ],
        "notes": result.notes,
        "unanswered": why,
        "warnings": [*([why] if why else []), *warnings_of(result.notes)],
        "stopped": result.stopped,
    }
    if convergence is not None:
        summary["convergence"] = as_dict(convergence)
    summary["limits"] = judged(c.limit, summary)
    main = main_run(result.runs)
    if main is not None and causes:
        for number, cause in causes.items():
            summary["runs"][main.name]["places"][number - 1]["cause"] = cause
    return _plain(summary)


def unreliable_runs(summary: dict[str, Any]) -> list[str]:
    """Run and reason of each run of a summary that cannot be relied on, a sentence each."""
    runs = {name: run for name, run in summary["runs"].items() if run.get("verdict") == UNRELIABLE}
    return [f"{name} run: {reason}" for name, run in runs.items() for reason in run["reasons"]]


def _static(result: StudyResult) -> dict[str, Any] | None:
    """What the run starts from; None without a static start."""
    s = result.setup
    if s.static is None:
        return None
    groups = [*s.contacts.group, *s.connectors.group]
    return static_figures(s.static, s.model.nodes, s.watched, groups, static_gravity(s.model, s.study.driving))


def _model(result: StudyResult) -> dict[str, Any]:
    model, parts = result.setup.model, result.reference.parts
    in_parts, in_elements = (p.nodes_idx for p in model.parts), (b.nodes_idx.ravel() for b in model.blocks)
    used = np.unique(np.concatenate([*in_parts, *in_elements]))
    return {
        "nodes": model.nodes.count,
        "elements": model.n_elements,
        "dof": 6 * int(used.size),
        "free_dof": result.reference.free_dof,
        "mass": result.reference.system.stats.mass,
        "parts": {
            p.name: {
                "nodes": int(model.parts[i].nodes_idx.size),
                "elements": p.stats.elements,
                "mass": p.stats.mass,
            }
            for i, p in enumerate(parts)
        },
    }


def _run(
    run: Run, result: StudyResult, model: Model, convergence: Convergence | None, sound: Sound | str | None
) -> dict[str, Any]:
    h = run.history
    penetration, verdict = float(max(0.0, -h.gap.min(initial=0.0))), verdict_of(run, result, convergence)
    unchecked = [] if len(result.runs) > 1 else [UNCHECKED]
    mine = convergence if convergence is not None and convergence.model == run.name else None
    settled = {} if mine is None else {id(e.event): settled_to(e) for e in mine.events}
    if run.name == "reference" and convergence is not None and convergence.structure is not None:
        settled = {id(e): bars_of_reference(convergence.structure, e) for e in run.events}
    unknown = dict.fromkeys(KEYS.values())
    places = heard_places(result, run, sound)
    whole = sum(p.impulse for p in places)
    return {
        **({} if verdict is None else {"verdict": verdict.word}),
        "reasons": unchecked if verdict is None else list(verdict.reasons),
        "integrator": run.integrator,
        "stopped": run.stopped,
        "dof": run.system.n,
        "retained": run.retained,
        "modes": run.modes,
        **_band(run, result),
        "channels": result.gaps.m,
        "rest_channels": int(resting(h).sum()),
        "steps": h.time.size - 1,
        "end": float(h.time[-1]),
        "contact_steps": h.contact_steps,
        "wall_s": run.cost.wall_s,
        "setup_s": h.setup_s,
        "cpu_s": run.cost.cpu_s,
        "offline_cpu_s": run.offline_cpu_s,
        "offline_wall_s": run.offline_wall_s,
        "peak_rss_gb": run.cost.peak_rss_gb,
        "energy_error": -h.energy_created if h.energy_created > ROUND_OFF else h.energy_dissipated_by_scheme,
        "energy_created": h.energy_created,
        "energy_created_of_contact": created_of_contact(h),
        "scheme_dissipation": h.energy_dissipated_by_scheme,
        "energies": dict(zip(ENERGIES, h.energy[-1].tolist(), strict=True)),
        "worst_residual": h.residual,
        "events": [_event(e, model) | {"settled_to": settled.get(id(e), unknown)} for e in run.events],
        "places": with_ties(
            [_place(p, run, model, sound, whole) | {"settled_to": place_settled_to(mine, p.number)} for p in places]
        ),
        "resting": [
            {"contact": p.contact, "nodes": model.nodes.ids[p.nodes_idx].tolist(), **_rub(p)}
            for p in resting_places(result, run)
        ],
        "slip_events": [_slip_event(e, model) for e in run.slips],
        "squeak_rate": squeak_rates(run.slips, result.window),
        "squeak": [_squeak(s, result, model) for s in run.squeaks],
        "max_force": float(h.force.max(initial=0.0)),
        "penetration_max": penetration,
        "max_penetration": penetration,  # earlier name of the same figure, for those who read it
        "gap_min": float(h.gap.min()) if h.gap.size else None,
        "impulse_total": float((h.weights @ h.force).sum()),
    }


def _band(run: Run, result: StudyResult) -> dict[str, Any]:
    """How far the modes of a reduced run go, and the stages in which that was found."""
    if run.name != "reduced" or result.setup.study.config.reduction.method == "guyan":
        return {}
    band = {"f_max": result.setup.band.f_max}
    if result.band is None or not result.band.stages:
        return band
    return {**band, "stages": [asdict(s) for s in result.band.stages], "stages_ended": result.band.why or None}


def _event(e: Event, model: Model) -> dict[str, Any]:
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
    }


def _place(p: Place, run: Run, model: Model, sound: Sound | str | None, whole: float) -> dict[str, Any]:
    """Figures over the verification window, `whole` the impulse of all places."""
    return {
        "name": place_name(p),
        "contact": p.contact,
        "nodes": model.nodes.ids[p.nodes_idx].tolist(),
        "events": len(p.events),
        "impulse": p.impulse,
        "force": p.force,
        "closing_speed": p.speed,
        **_rub(p),
        **heard_at(sound, run.name, p.number - 1),
        "share": p.impulse / whole if whole > 0.0 else None,
        "irregularity": p.irregularity,
        "cause": None,
    }


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


def _slip_event(e: SlipEvent, model: Model) -> dict[str, Any]:
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


def _squeak(s: Squeak, result: StudyResult, model: Model) -> dict[str, Any]:
    lines = result.setup.elines.lines
    line = next((x for x in lines if x.contact and x.name == s.group), None)
    measured = measured_rates(line, result.setup.study.config.model.units)
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
        "material": None if line is None else line.material,
        "measured_per_length": measured,
        "against_measured": against_measured(s.per_length, measured),
    }


def _verification(result: StudyResult, convergence: Convergence | None) -> dict[str, Any]:
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
        out["events"] = _matched(result.events) | {"statistics": _statistics(result, convergence)}
    return out | spots_of(result, None if convergence is None else convergence.structure)


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


def _statistics(result: StudyResult, convergence: Convergence | None) -> dict[str, Any]:
    s = event_statistics(result)
    distances = {"force": s.force, "impulse": s.impulse}
    return {
        "chaotic": is_chaotic(convergence, s.count[0], s.length, result.setup.study.config.highest),
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
