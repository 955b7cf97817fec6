"""What a convergence study found: in sentences, for summary.json and as lines of a table."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.studies.converge.rubbing import rub_words, rubs_as_dict
from creak.studies.converge.settling import (
    BAND,
    CHANCE,
    GOES_ON,
    SCATTER,
    SETTLED,
    UNREDUCED,
    WAYS,
    Convergence,
    Outcome,
    Settling,
)
from creak.verify.matching import FIGURES
from creak.verify.statistics import Distance
from creak.words import percent

WORDS = {
    "start": "start time",
    "duration": "duration",
    "force": "low-passed force",
    "impulse": "impulse",
    "closing_speed": "closing speed",
}
TOTALS = {"events": "number of events", "impulse": "total impulse", "force": "largest low-passed force"}
MORE = "a higher [reduction] f_max"
STIFFNESS = ("the contact stiffness", "the stiffness that the material has, as stiffness of the [contact]")
HARD = ("the spring that stands for hard contact", 'accuracy = "fine", or the stiffness that the material has')
REMEDIES = {
    "step": ("the forced step", "a shorter [time] step, or none, so that creak chooses"),
    "stiffness": ("the contact stiffness", "a stiffer contact with a step that resolves it"),
    "modes": ("the modes that the reduction kept", MORE),
    "tolerance": ("the resolution of contact in time", 'accuracy = "fine"'),
    "softer": STIFFNESS,
    "stiffer": STIFFNESS,
    "yielding": HARD,
    "harder": HARD,
    BAND: ("where the band of sound ends", "more modes, or a finer mesh, whichever ends it"),
    WAYS: ("where the modes hand over to the unreduced model", MORE),
    SCATTER: ("the statistical energy of plates beyond what is computed", "a finer mesh and more modes"),
    UNREDUCED: ("what the reduction leaves out of the unreduced model", MORE),
    CHANCE: ("chance, as the motion is chaotic", "a longer run"),
}
"""Family of repeated runs -> what the answer hangs on where it has not settled, and what it takes."""


def remedy_of(family: str, c: Convergence) -> tuple[str, str]:
    """What the answer hangs on, and what it takes. With all modes that there are, both runs are of the unreduced model
    and differ by how they are integrated."""
    if c.complete and family in (UNREDUCED, "modes"):
        return REMEDIES["tolerance"][0], _finer(c)
    what, takes = REMEDIES[family]
    return what, _finer(c) if family == "tolerance" or (c.complete and takes == MORE) else takes


def _finer(c: Convergence) -> str:
    """What a finer resolution of contact takes."""
    finest = 'no setting, as "fine" is the finest: use the figures with their bars'
    return finest if c.fine else REMEDIES["tolerance"][1]


def findings(c: Convergence) -> list[str]:
    """What an engineer should know, in sentences."""
    if not c.families:
        return list(c.notes)
    said = [_events_words(c)] if c.events else ["the base run has no events in the window to compare"]
    new = [f"{name} {len(found)}" for name, found in c.new.items() if found]
    said += [f"events in the window that the base run does not have: {', '.join(new)}"] if new else []
    said += _family_words(c) + [_total_words(t) for t in c.totals.values()] + _heard_words(c)
    said += map(rub_words, c.rubs)
    if c.chaotic:
        rate = len(c.events) / (c.window[1] - c.window[0])
        said.append(
            f"{rate:.0f} events per second, of which single ones part from run to run as those of two exact solutions "
            "would: compare the runs by their distributions"
        )
    if c.chaotic or 2 * sum(e.settled for e in c.judged) < len(c.judged):
        said += _distribution_words(c)
    return [*said, *c.notes]


def _events_words(c: Convergence) -> str:
    n = len(c.judged)
    each = ", ".join(f"{WORDS[name]} {c.settled_events(name)}" for name in FIGURES)
    absent = sum(bool(e.problem) for e in c.judged)
    tail = f"; {absent} of them are missing in at least one run" if absent else ""
    tail += f"; {len(c.events) - n} more {GOES_ON.replace('goes', 'go')}" if n < len(c.events) else ""
    whole = sum(e.settled for e in c.judged)
    return f"{whole} of {n} events are settled in every figure ({each}){tail}"


def _family_words(c: Convergence) -> list[str]:
    """For each family the median change of force and impulse, and what to do where that is above the limit."""
    said = []
    for family, (a, b) in c.families.items():
        median = {name: _median(c, name, family) for name in ("force", "impulse")}
        if any(m is None for m in median.values()):
            continue
        words = " and ".join(f"{percent(m)} in {WORDS[name]}" for name, m in median.items() if m is not None)
        said.append(f"from {a} to {b} the events' median change is {words}{_advice(c, family, **median)}")
    return said


def _advice(c: Convergence, family: str, force: float | None, impulse: float | None) -> str:
    """What a family that moves the events asks for."""
    if max(force or 0.0, impulse or 0.0) <= SETTLED:
        return ""
    if family == "stiffness" and (impulse or 0.0) <= SETTLED:
        return (
            ": the blow itself has settled, the share of the hardest channel has not (the stiffer, the fewer "
            "channels carry it)"
        )
    return f": what settles it is {remedy_of(family, c)[1]}"


def _median(c: Convergence, name: str, family: str) -> float | None:
    changes = [abs(e.figures[name].changes[family]) for e in c.judged]
    known = [x for x in changes if np.isfinite(x)]
    return float(np.median(known)) if known else None


def _total_words(t: Settling) -> str:
    what = TOTALS[t.name]
    if np.isnan(t.settled_to):
        return f"whole run, {what}: not settled ({t.problem})"
    verdict = "settled" if t.settled else "not settled"
    changes = ", ".join(f"{'+' if x >= 0.0 else ''}{percent(x)} by the {family}" for family, x in t.changes.items())
    changes += f", {percent(t.beside[CHANCE])} by chance" if CHANCE in t.beside else ""
    return f"whole run, {what}: {verdict} ({changes})"


def _heard_words(c: Convergence) -> list[str]:
    """How far what is heard of the places has settled."""
    known = [(k, place["n5"]) for k, place in enumerate(c.places, start=1) if "n5" in place]
    open_ones = [(k, f) for k, f in known if not f.settled]
    if not known:
        return []
    ends = (
        "" if c.band_ends is None else f", up to {c.band_ends[0]:.0f} Hz where the {c.band_ends[1]} ends what is heard"
    )
    if not open_ones:
        most = max(f.settled_to for _, f in known)
        return [f"N5 of {'the place' if len(known) == 1 else 'each place'}: settled (within {percent(most)}){ends}"]
    said = [
        f"place {k} ({percent(f.settled_to)}, most of it by the {f.worst})" if f.worst else f"place {k}"
        for k, f in open_ones
    ]
    return [f"N5 has not settled at {', '.join(said)}; at {len(known) - len(open_ones)} of {len(known)} it has{ends}"]


def _distribution_words(c: Convergence) -> list[str]:
    said = []
    for family, s in c.statistics.items():
        a, b = c.families[family]
        if s.force is None or s.impulse is None:
            continue
        differ = [name for name, d in (("low-passed force", s.force), ("impulse", s.impulse)) if not d.alike]
        differ = ["number of events"] * (not s.rates_alike) + differ
        verdict = f"differ in {', '.join(differ)}" if differ else "are alike (number, low-passed force, impulse)"
        said.append(f"as samples the events of {a} ({s.count[0]}) and {b} ({s.count[1]}) {verdict}")
    return said


def as_dict(c: Convergence) -> dict[str, Any]:
    """For summary.json; undefined figures are nan."""
    return {
        "model": c.model,
        "window": list(c.window),
        "limits": {name: f.limit for name, f in c.events[0].figures.items()} if c.events else {},
        "runs": {name: _outcome_dict(o) for name, o in c.outcomes.items()},
        "families": {name: list(pair) for name, pair in c.families.items()},
        "events": [
            {
                "contact": e.event.group,
                "channel": e.event.channel,
                "t_start": e.event.t_start,
                "settled": e.settled,
                "unfinished": e.event.unfinished,
                "problem": e.problem,
                "figures": {name: _settling_dict(f) for name, f in e.figures.items()},
            }
            for e in c.events
        ],
        "new": {name: len(found) for name, found in c.new.items()},
        "settled": {name: c.settled_events(name) for name in FIGURES},
        "totals": {name: _settling_dict(t) for name, t in c.totals.items()},
        "places": [{name: _settling_dict(f) for name, f in place.items()} for place in c.places],
        "friction": rubs_as_dict(c),
        "chaotic": c.chaotic,
        "statistics": {
            family: {
                "count": list(s.count),
                "rates_alike": s.rates_alike,
                "force": _distance(s.force),
                "impulse": _distance(s.impulse),
            }
            for family, s in c.statistics.items()
        },
        "findings": findings(c),
    }


def _outcome_dict(o: Outcome) -> dict[str, Any]:
    v = o.repeat
    return {
        "family": v.family,
        "step": v.step,
        "stiffness_factor": v.stiffness * v.harder,
        "f_max": v.f_max,
        "modes": o.modes,
        "steps": o.steps,
        "events": len(o.events),
        "impulse_total": o.impulse,
        "max_force_filtered": o.force,
        "energy_created": o.energy_created,
        "scheme_dissipation": o.dissipated,
        "wall_s": o.wall_s,
        "stopped": o.stopped,
    }


def _settling_dict(f: Settling) -> dict[str, Any]:
    return {
        "values": f.values,
        "changes": f.changes,
        "beside": f.beside,
        "sources": f.sources,
        "settled_to": f.settled_to,
        "settled": f.settled,
        "worst": f.worst,
        "base_error": f.base_error,
        "problem": f.problem,
    }


def _distance(d: Distance | None) -> dict[str, Any] | None:
    return None if d is None else {"value": d.value, "critical": d.critical, "alike": d.alike}


def csv_rows(c: Convergence) -> list[list[str]]:
    """Header and one line for each figure of each event: its value in every run, changes, settled to, verdict."""
    families = list(c.families)
    head = [
        "contact",
        "channel",
        "t_start",
        "figure",
        *c.outcomes,
        *(f"change_{f}" for f in families),
        "settled_to",
        "limit",
        "verdict",
    ]

    def cell(x: float | None) -> str:
        return "" if x is None or np.isnan(x) else f"{x:.9g}"

    rows = []
    for e in c.events:
        for name, f in e.figures.items():
            verdict = "settled" if f.settled else f"not settled{': ' + f.problem if f.problem else ''}"
            rows.append(
                [
                    e.event.group,
                    e.event.channel,
                    cell(e.event.t_start),
                    name,
                    *(cell(f.values.get(run)) for run in c.outcomes),
                    *(cell(f.changes[x]) for x in families),
                    cell(f.settled_to),
                    cell(f.limit),
                    verdict,
                ]
            )
    return [head, *rows]
