"""What the unreduced model made of single events, and changes that would help beside the bars, for summary.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from creak.studies.converge.settled import KEYS
from creak.studies.findings.tree import Findings
from creak.verify.events import Event
from creak.verify.matching import TIMES, UNTIL_THE_END
from creak.verify.rubbing import FIGURES
from creak.verify.unreduced import RubSpot, Spot, Structure
from creak.words import percent


def spots_of(findings: Findings) -> dict[str, Any]:
    """`spots`, one for each event that it marched through, and their cost; nothing where it was not asked.

    A figure is {reduced, unreduced, numerical, border}; unreduced is null where the unreduced model has no such event,
    numerical (what half its contact step changes: s of times, else a share) where that was not looked at, border (what
    a quarter of the dofs that move by themselves changes) where all do. They do not count where the reduced model is
    complete.
    """
    run, convergence = findings.runs.get("reduced"), findings.convergence
    if run is None or convergence is None or convergence.structure is None:
        return {}
    structure = convergence.structure
    row = {e.key: k for k, e in enumerate(run.events)}
    names = [(p.number, {findings.gaps.names[j] for j in p.channels.tolist()}) for p in run.places]

    def told(s: Spot) -> dict[str, Any]:
        place = next((n for n, own in names if s.event.channel in own), None)
        figures = {
            key: {
                "reduced": s.reduced.get(name),
                "unreduced": (s.unreduced or {}).get(name),
                "numerical": (s.numerical or {}).get(name),
                "border": (s.border or {}).get(name),
            }
            for name, key in KEYS.items()
        }
        return {"event": row.get(s.event.key), "place": place, "why": s.why, "problem": s.problem or None} | figures

    return {
        "spots": [told(s) for s in structure.spots],
        "rub_spots": [_rub(s) for s in structure.rubs],
        "spot_cost": {"back_substitutions": structure.solves, "wall_s": structure.wall_s},
        "spots_in_bars": any(not s.problem for s in structure.weighed),
        "spots_missing": structure.why_not or None,
    }


def _rub(s: RubSpot) -> dict[str, Any]:
    """A piece of rubbing or lasting contact."""
    both = {name: {"reduced": s.reduced.get(name), "unreduced": s.unreduced.get(name)} for name in FIGURES}
    place = {"contact": s.contact, "place": s.number or None, "t_start": s.time[0], "t_end": s.time[1]}
    return {**place, "problem": s.problem or None, **both}


def bars_of_reference(structure: Structure, event: Event) -> dict[str, float | None]:
    """How far an event of the unreduced model's own run hangs on its contact steps: s for times, shares else."""
    lasts = event.t_end - event.t_start
    bars = {name: x * (lasts if name in TIMES else 1.0) for name, x in structure.of_steps.items()}
    unknown = UNTIL_THE_END if event.unfinished else ()
    return {key: None if name in unknown else bars.get(name) for name, key in KEYS.items()}


def beside_bars(cause: dict[str, Any] | None, bars: Mapping[str, float | None]) -> dict[str, Any] | None:
    """The same with a word at each change that alters its place by no more than the place's own bar.

    Parameters
    ----------
    bars : of the place's N5 and impulse, as shares; None: not known, and nothing is said.
    """
    if cause is None or not cause.get("changes"):
        return cause
    words = []
    for change, text in zip(cause["changes"], cause["changes_words"], strict=True):
        key, (now, then) = judged_by(change), (change["now"], change["predicted"])
        bar = bars.get(key)
        small = bar is not None and then[key] is not None and abs(then[key] - now[key]) <= bar * now[key]
        words.append(f"{text}; within the uncertainty of the place, {percent(bar)}" if small and bar else text)
    return cause | {"changes_words": words}


def judged_by(change: dict[str, Any]) -> str:
    """The figure that tells what a change does: loudness where it is known."""
    return "n5" if change["now"]["n5"] is not None else "impulse"
