"""One random study: what creak tells of it with nothing set, beside the independent march of its full matrices."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import creak
from benchmarks.coverage.full import OF_CONTACT, Full
from benchmarks.coverage.march import Course
from benchmarks.coverage.prepare import prepared
from creak.verify.events import Event
from creak.verify.matching import FIGURES, change, match_events
from creak.verify.statistics import compare_statistics

KEYS = {
    "start": "t_start",
    "duration": "duration",
    "impulse": "impulse",
    "force": "force",
    "closing_speed": "closing_speed",
}
"""Figure of an event -> key of its bar in summary.json."""
OWN = 5e-3
"""Share by which twice the step may change the total impulse of a march that has settled, with the same events."""
WHOLE = (0.0, np.inf)


def row(seed: int, folder: Path) -> dict[str, Any]:
    """All that is found of a seed; of one that fails, why."""
    began = time.process_time()
    base: dict[str, Any] = {"seed": seed}
    try:
        case, setup, full = prepared(seed, folder)
        base |= {"words": case.words, "n": int(full.modes.omega.size), "channels": full.gaps.m, "end": full.end}
        base |= {"fastest": case.fastest, "f_max": setup.study.config.reduction.f_max}
        v = setup.study.config.verification
        fine, coarse = (full.run(parts * OF_CONTACT) for parts in (2.0, 1.0))
        own, rough = (full.events(c, v.merge, v.f_max) for c in (fine, coarse))
        base |= {"own": of_own(full, fine, own, rough, coarse.full or fine.full, v.event_tolerance)}
        base["own"]["cpu_s"] = time.process_time() - began
    except Exception as error:  # a benchmark of 200 models goes on with the next one, and says which failed
        return base | {"failed": f"independent march: {type(error).__name__}: {error}"}
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            result = creak.run(case.study)
    except Exception as error:
        return base | {"failed": f"creak: {type(error).__name__}: {error}"}
    told = json.loads(json.dumps(result.summary, default=str))
    main = told["runs"]["reduced"]
    bars = [e["settled_to"] for e in main["events"]]
    base |= {"verdict": main.get("verdict"), "reasons": main["reasons"], "warnings": told["warnings"]}
    base |= {"modes": main["modes"], "dof": main["dof"], "kept": main["channels"]}
    base["reduced"] = held(own, result.runs["reduced"].events, bars, rough, v.event_tolerance, full.end)
    if "reference" in result.runs:
        events = result.runs["reference"].events
        base["reference"] = held(own, events, [{}] * len(events), rough, v.event_tolerance, full.end)
    base["friction_work"] = main["energies"]["friction"]
    base["cpu_s"] = time.process_time() - began
    return base


def of_own(
    full: Full, fine: Course, own: Sequence[Event], rough: Sequence[Event], cut: bool, tolerance: float
) -> dict[str, Any]:
    """Figures of the march itself and whether it has settled."""
    total, coarse = (sum(e.impulse for e in events) for events in (own, rough))
    match = match_events(own, rough, tolerance, WHOLE)
    whole = not cut and not match.missed and not match.extra
    return {
        "events": len(own),
        "impulse": total,
        "error": abs(coarse / total - 1.0) if total else 0.0,
        "settled": bool(whole and abs(coarse - total) <= OWN * max(total, 1e-300)),
        "cut_short": cut,
        "steps": fine.steps,
        "friction_work": fine.friction_work,
        "blows": sum(0.5 * e.impulse * e.closing_speed for e in own),
        "slip_time": fine.slip_time,
        "contact_khz": full.modes.contact_omega / 2e3 / np.pi,
    }


def held(
    own: Sequence[Event],
    events: Sequence[Event],
    bars: Sequence[dict[str, float | None]],
    rough: Sequence[Event],
    tolerance: float,
    end: float,
) -> dict[str, Any]:
    """Events of a run of creak against the march's: each figure's error, its bar, and the march's own error.

    Errors of times are in s, those of others shares of the march's figure, all without sign.
    """
    match = match_events(own, events, tolerance, WHOLE)
    mine = {id(e): k for k, e in enumerate(events)}
    other = {id(a): b for a, b in match_events(own, rough, tolerance, WHOLE).pairs}
    figures: dict[str, list[Any]] = {name: [] for name in KEYS}
    for exact, found in match.pairs:
        for name, key in KEYS.items():
            error = change(name, FIGURES[name](found), FIGURES[name](exact))
            check = other.get(id(exact))
            own_error = None if check is None else abs(change(name, FIGURES[name](check), FIGURES[name](exact)))
            figures[name].append([abs(error), bars[mine[id(found)]].get(key), own_error])
    alike = compare_statistics(own, events, (0.0, end))
    known = [d.alike for d in (alike.force, alike.impulse) if d is not None]
    return {
        "events": len(events),
        "impulse": sum(e.impulse for e in events),
        "matched": len(match.pairs),
        "missed": len(match.missed),
        "extra": len(match.extra),
        "durations": [a.t_end - a.t_start for a, _ in match.pairs],
        "alike": bool(alike.rates_alike and all(known)),
        "figures": figures,
    }
