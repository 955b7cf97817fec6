"""The answer in one sentence, whether it deserves trust, and what else the reader must know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.model.units import Units
from creak.report.tables.checks import Check, alarm, is_chaotic
from creak.report.words.text import number, percent, plural, ratio, share, tidy, times
from creak.studies.converge import settled
from creak.studies.converge.settled import SETTLED, STATISTICS, UNSETTLED
from creak.studies.findings.tree import Findings, FoundRun
from creak.studies.run.compared import main_of
from creak.verify.events import events_in
from creak.verify.intervals import in_window
from creak.verify.reliability import UNRELIABLE

PENETRATION_BAR = 0.1
"""Share of the clearance above which penetration is worth a word."""
MOSTLY = 0.95
"""Share of the run from which contact counts as lasting."""
TOGETHER = 1.001
"""Force of an event over the worst of any place from which on it is that of several places of its contact."""
FEW = 3
"""Events below which lasting contact is worth a word."""


@dataclass(frozen=True)
class Penetration:
    """How far the channels of one contact came together."""

    smallest: float
    """Smallest gap, length; negative: penetration."""
    clearance: float
    """Mean initial gap, length."""

    @property
    def depth(self) -> float:
        return max(0.0, -self.smallest)

    @property
    def of_clearance(self) -> float | None:
        """Depth as a share of the clearance; None where the parts touch from the start."""
        return self.depth / self.clearance if self.clearance > 0.0 else None


def penetration(result: Findings, run: FoundRun, group: str) -> Penetration | None:
    """Of the kept channels of one contact or connector over a whole run; None without channels."""
    channels = [j for j, g in enumerate(result.gaps.group) if g == group]
    if not channels:
        return None
    smallest = float(run.closest[:, result.contacts.index(group)].min())
    return Penetration(smallest, float(result.gaps.gap0[channels].mean()))


def sentence(result: Findings, summary: dict[str, Any], units: Units) -> str:
    """What happened and how far it can be trusted, in plain words."""
    run = result.main
    if run is None:
        return "Nothing was computed: the study has no run."
    events = events_in(run.events, result.window)
    what = _what(result, run, len(events))
    hardest = max(events, key=lambda e: e.force_place, default=None)
    where = ""
    if hardest is not None:
        node = result.setup.model.nodes.label(hardest.node_idx)
        closing = f", closing at {number(hardest.closing_speed, 3)} {units.speed}" if hardest.closing_speed else ""
        force, impulse = number(hardest.force_place, 3), number(hardest.impulse, 3)
        place = max((p["force"] for p in summary["runs"][run.name].get("places", [])), default=0.0)
        together = " at several places together" if 0.0 < TOGETHER * place < hardest.force_place else ""
        where = (
            f", the hardest {force} {units.force}{together} and {impulse} {units.impulse} around node {node}{closing}"
        )
    unsafe = alarm(summary)
    if summary.get("unanswered") and result.stopped is None:
        return f"What follows is the motion alone.{unsafe}"
    if result.stopped is not None:
        reached = number(float(run.history.time[-1]), 3)
        until = f"Until {reached} s: {len(run.events)} contact events{where}"
        return f"The study ended early ({result.stopped}). {until}.{unsafe}"
    if "reference" not in result.runs:
        return f"{what}{where}. {_spotted(result)}{unsafe}"
    if "reduced" not in result.runs:
        return f"{what}{where}, computed on the unreduced model; nothing was reduced.{unsafe}"
    return f"{what}{where}; {_found(result, summary)}, {_speed(summary)}.{unsafe}"


def _spotted(result: Findings) -> str:
    """What single events say that the unreduced model marched through."""
    structure = None if result.convergence is None else result.convergence.structure
    known = [] if structure is None else [s for s in structure.spots if not s.problem]
    if not known:
        why = f": {structure.why_not}" if structure is not None and structure.why_not else ""
        return f"Nothing was held against the unreduced model{why}."
    if structure is not None and structure.complete:
        return "The reduced model has all modes that there are: it is the unreduced one."
    off = [abs(x) for s in known if (x := s.difference("impulse")) is not None]
    if np.isnan(off).any():
        return (
            f"Of {plural(len(known), 'event')} the unreduced model has {sum(s.unreduced is not None for s in known)}."
        )
    most = f" within {share(max(off))}" if off else ""
    return f"The unreduced model, marched through {plural(len(known), 'event')} of the run, has the same impulse{most}."


TRUST = {
    SETTLED: "Settled.",
    STATISTICS: "Settled as statistics, not event by event.",
    UNSETTLED: "Not settled.",
    UNRELIABLE: "Unreliable: do not rely on it.",
}
"""Verdict on a run -> first words of the page."""


def trust(summary: dict[str, Any]) -> str:
    """How far the main run hangs on numerical settings, with the reasons; empty where it was compared alone."""
    run = main_of(summary)
    if not run or ("verdict" not in run and not run["reasons"]):
        return ""
    first = "No answer." if summary.get("unanswered") else TRUST[run["verdict"]] if "verdict" in run else ""
    reasons = "; ".join(run["reasons"])
    return f"{first} {f'{reasons[:1].upper()}{reasons[1:]}.' if reasons else ''}".strip()


def verdict_line(run: Mapping[str, Any]) -> str:
    """Verdict and reasons of a run of a summary; empty where it was compared alone."""
    word, reasons = run.get("verdict"), "; ".join(run.get("reasons") or ())
    return f"{word} ({reasons})" if word and reasons else word or reasons


def mark(checks: Sequence[Check], summary: dict[str, Any]) -> str:
    """Style of the page's first bar: good, look (something failed or is open), none (nothing was checked), bad."""
    run = main_of(summary)
    if summary.get("unanswered") or run.get("verdict") == UNRELIABLE:
        return "bad"
    failed = any(c.passed is False for c in checks) or summary["stopped"]
    if failed or run.get("verdict", SETTLED) not in (SETTLED, STATISTICS):
        return "look"
    return "good" if "verdict" in run or len(summary["runs"]) > 1 else "none"


def span(result: Findings) -> str:
    """The verification window in words."""
    start, end = result.window
    length, run = end - start, result.main
    if run is not None and end < float(run.history.time[-1]) * (1.0 - 1e-9):
        return f"from {tidy(start)} to {tidy(end)} s, where both models were run"
    if start <= 0.0:
        return f"in {tidy(length)} s"
    return "in the last second" if abs(length - 1.0) < 1e-9 else f"in the last {tidy(length)} s"


def _what(result: Findings, run: FoundRun, count: int) -> str:
    if result.gaps.m == 0:
        return f"No rattle {span(result)}: nothing can touch under this load"
    if count == 0 and _pressed(result, run):
        return f"No rattle {span(result)}: what presses has rested since the start and does not let go"
    if count == 0:
        return f"No rattle {span(result)}"
    return f"{plural(count, 'rattle event')} {span(result)}"


def _pressed(result: Findings, run: FoundRun) -> bool:
    """Whether anything presses inside the window."""
    h = run.history
    return bool(h.force[in_window(h.time, result.window)].any())


def _found(result: Findings, summary: dict[str, Any]) -> str:
    match = result.events
    if match is None:
        return "the two runs were not compared"
    count = len(match.pairs) + len(match.missed)
    if count == 0:
        extra = len(match.extra)
        return f"the reduced model shows {plural(extra, 'event')} of its own" if extra else "the reduced model agrees"
    limit = 1000.0 * result.setup.study.config.verification.event_tolerance
    everything = {1: "it", 2: "both"}.get(count, f"all {count}")
    found = everything if not match.missed else f"{len(match.pairs)}"
    text = f"the reduced model found {found}{f' of {count}' if match.missed else ''} within {tidy(limit)} ms"
    if match.extra:
        text += f" and {len(match.extra)} more"
    if is_chaotic(summary):
        rate = result.statistics.rate
        return f"{text}; motion is chaotic: {number(rate[1], 3)} events per second against {number(rate[0], 3)}"
    mean = match.amplitude_ratio_mean
    return text + (f", mean force {percent(mean)}" if mean is not None else "")


def _speed(summary: dict[str, Any]) -> str:
    reduced, reference = summary["runs"]["reduced"], summary["runs"]["reference"]
    took = reference["wall_s"] * reduced["end"] / max(reference["end"], 1e-12)  # over the same simulated time
    run = ratio(took, reduced["wall_s"])
    whole = ratio(took, reduced["wall_s"] + reduced["offline_wall_s"])
    if run is None or whole is None:
        return "speed not measured"
    if run < 1.0:
        return f"{times(1.0 / run)} slower than the unreduced model"
    counted = f"{times(whole)} faster" if whole >= 1.0 else f"{times(1.0 / whole)} slower"
    return f"{times(run)} faster than the unreduced model ({counted} when the reduction itself is counted)"


def warnings(result: Findings) -> list[str]:
    """What the reader must know besides the checks."""
    out = []
    run = result.runs.get("reference") or result.runs.get("reduced")
    length = result.window[1] - result.window[0]
    if run is not None:
        count = len(events_in(run.events, result.window))
        if settled.is_chaotic(result.convergence, count, length, result.setup.study.config.highest):
            out.append(
                f"{number(count / length, 3)} events per second, and motion is chaotic: two exact solutions part after "
                "a while. Compare the statistics of the events (rate, distributions of force and impulse) rather than "
                "one with another."
            )
    return [*out, *_resolution(result), *_deep(result)]


def first_mistakes(result: Findings, units: Units) -> list[str]:
    """What the run itself shows of a study that may not be meant so: contact that never happens, or never ends."""
    run = result.main
    if run is None or run.nearest is None:
        return []
    h = run.history
    if not h.force.any():
        channel, time, gap = run.nearest
        at_rest = float(result.gaps.gap0[result.gaps.names.index(channel)])
        return [
            f"Nothing touched during the whole run: the closest approach is {number(gap, 3)} {units.length} at "
            f"{channel}, {number(time, 4)} s, which starts {number(at_rest, 3)} {units.length} open. Raise the "
            "excitation, or look whether distances and units are as meant."
        ]
    pressed = np.asarray((h.force > 0.0).any(axis=1))
    if float(h.weights @ pressed) > MOSTLY * float(h.time[-1] - h.time[0]) and len(run.events) < FEW:
        return ["The parts press on each other nearly all the time: a preload, or parts that overlap from the start?"]
    return []


def _deep(result: Findings) -> list[str]:
    """Contacts that penetrate by a good part of their clearance."""
    run = result.main
    if run is None:
        return []
    found = {g: penetration(result, run, g) for g in dict.fromkeys(result.gaps.group)}
    exact = result.setup.study.config.time.exact
    fix = (
        "Raise its stiffness if they are stiffer." if exact else "A shorter step, or more substeps, lets it be stiffer."
    )
    return [
        f"at {group} the parts penetrate each other by {share(p.of_clearance)} of the clearance. {fix}"
        for group, p in found.items()
        if p is not None and (p.of_clearance or 0.0) > PENETRATION_BAR
    ]


def _resolution(result: Findings) -> list[str]:
    c = result.setup.study.config
    step = c.time.step / c.time.substeps
    if c.time.exact or result.gaps.m == 0 or c.verification.f_max < 0.45 / step:
        return []
    return [
        f"The step of {tidy(1e3 * step)} ms cannot hold more than the {tidy(c.verification.f_max)} Hz of the "
        "low-pass: low-passed peaks are the raw ones. A shorter step separates the two."
    ]
