"""The answer in one sentence, and whether the reduced model deserves trust."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.report.found import Found, FoundRun
from creak.report.text import NONE, THIN, Units, fixed, four, number, percent, plural, ratio, share, tidy, times
from creak.studies.converge.settled import SETTLED, STATISTICS, UNSETTLED
from creak.studies.run.compared import event_statistics, main_run
from creak.studies.run.job import events_in
from creak.verify import nrmse
from creak.verify.reliability import CONTACT_BAR, ENERGY_BAR, UNRELIABLE
from creak.verify.statistics import CHAOTIC_RATE, Distance, EventStatistics, is_chaotic

MAC_BAR = 0.99
NRMSE_BAR = 0.99
FORCE_BAR = 0.05
ROUND_OFF = 1e-12
"""Share of the energy put in up to which created energy is none."""
PENETRATION_BAR = 0.1
"""Share of the clearance above which penetration is worth a word."""
MOSTLY = 0.95
"""Share of the run from which contact counts as lasting."""
FEW = 3
"""Events below which lasting contact is worth a word."""
RUN_WORDS = {"reduced": "reduced", "reference": "unreduced"}
CREATED = {"energy_created": (ENERGY_BAR, "put in"), "energy_created_of_contact": (CONTACT_BAR, "that contact took up")}
"""Figure of a run -> how much of which energy may have been created."""


@dataclass(frozen=True)
class Check:
    """One line of the table of checks; `passed` is None where there was nothing to check."""

    name: str
    bar: str
    found: str
    passed: bool | None


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


def penetration(result: Found, run: FoundRun, group: str) -> Penetration | None:
    """Of the kept channels of one contact or connector over a whole run; None without channels."""
    channels = [j for j, g in enumerate(result.gaps.group) if g == group]
    if not channels:
        return None
    smallest = float(run.closest[:, result.contacts.index(group)].min())
    return Penetration(smallest, float(result.gaps.gap0[channels].mean()))


def sentence(result: Found, summary: dict[str, Any], units: Units) -> str:
    """What happened and how far it can be trusted, in plain words."""
    run = main_run(result.runs)
    if run is None:
        return "Nothing was computed: the study has no run."
    events = events_in(result.runs.get("reference", run).events, result.window)
    what = _what(result, run, len(events))
    hardest = max(events, key=lambda e: e.force_place, default=None)
    where = ""
    if hardest is not None:
        node = result.setup.model.nodes.label(hardest.node_idx)
        closing = f", closing at {number(hardest.closing_speed, 3)} {units.speed}" if hardest.closing_speed else ""
        where = f", the hardest {number(hardest.force_place, 3)} {units.force} around node {node}{closing}"
    alarm = _alarm(summary)
    if result.stopped is not None:
        reached = number(float(run.history.time[-1]), 3)
        until = f"Until {reached} s: {len(run.events)} contact events{where}"
        return f"The study ended early ({result.stopped}). {until}.{alarm}"
    if "reference" not in result.runs:
        return f"{what}{where}. The unreduced model was not run, so the reduced model is not checked here.{alarm}"
    if "reduced" not in result.runs:
        return f"{what}{where}, computed on the unreduced model; nothing was reduced.{alarm}"
    return f"{what}{where}; {_found(result)}, {_speed(summary)}.{alarm}"


TRUST = {
    SETTLED: "Settled.",
    STATISTICS: "Settled as statistics, not event by event.",
    UNSETTLED: "Not settled.",
    UNRELIABLE: "Unreliable.",
}
"""Verdict on a run -> first words of the page."""


def trust(summary: dict[str, Any]) -> str:
    """How far the main run hangs on numerical settings, with the reasons; empty where nothing was looked at."""
    run = _main(summary)
    if "verdict" not in run:
        return ""
    reasons = "; ".join(run["reasons"])
    return f"{TRUST[run['verdict']]}{f' {reasons[:1].upper()}{reasons[1:]}.' if reasons else ''}"


def is_good(checks: Sequence[Check], summary: dict[str, Any]) -> bool:
    """Nothing failed and nothing is open: the page's first bar may be green."""
    word = _main(summary).get("verdict", SETTLED)
    return word in (SETTLED, STATISTICS) and all(c.passed is not False for c in checks)


def _main(summary: dict[str, Any]) -> dict[str, Any]:
    runs = summary["runs"]
    return dict(runs.get("reduced") or runs.get("reference") or {})


def _alarm(summary: dict[str, Any]) -> str:
    """What makes the forces of a run worthless, whatever else agrees."""
    if any(not finite(run) for run in summary["runs"].values()):
        return " Do not rely on it: its figures are not finite. Shorten the step or soften the contact."
    for key, (bar, what) in CREATED.items():
        worst = max((run[key] for run in summary["runs"].values()), default=0.0)
        if worst > bar:
            return (
                f" Do not rely on it: the time integration created {share(worst)} of the energy {what}. Shorten the "
                "step, soften the contact or dissipate more."
            )
    return ""


def finite(run: dict[str, Any]) -> bool:
    """Whether the balance of a run is one of numbers."""
    return all(value is not None for value in (*(run[key] for key in CREATED), *run["energies"].values()))


def span(result: Found) -> str:
    """The verification window in words."""
    start, end = result.window
    length, run = end - start, main_run(result.runs)
    if run is not None and end < float(run.history.time[-1]) * (1.0 - 1e-9):
        return f"from {tidy(start)} to {tidy(end)} s, where both models were run"
    if start <= 0.0:
        return f"in {tidy(length)} s"
    return "in the last second" if abs(length - 1.0) < 1e-9 else f"in the last {tidy(length)} s"


def _what(result: Found, run: FoundRun, count: int) -> str:
    if result.gaps.m == 0:
        return f"No rattle {span(result)}: nothing can touch under this load"
    if count == 0 and _pressed(result, run):
        return f"No contact begins {span(result)}, but one that began before lasts into it"
    if count == 0:
        return f"No rattle {span(result)}"
    return f"{plural(count, 'rattle event')} {span(result)}"


def _pressed(result: Found, run: FoundRun) -> bool:
    """Whether anything presses inside the window."""
    h = run.history
    return bool(h.force[(h.time >= result.window[0]) & (h.time <= result.window[1])].any())


def _found(result: Found) -> str:
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
    s = event_statistics(result)
    if s.chaotic:
        return f"{text}; motion is chaotic: {number(s.rate[1], 3)} events per second against {number(s.rate[0], 3)}"
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


def checks(result: Found, summary: dict[str, Any]) -> list[Check]:
    """The comparison with the unreduced model against the bars, and the energy balance."""
    judged = [_events(result), _mean_force(result), _each_force(result)]
    if result.events is not None:
        s = event_statistics(result)
        if s.chaotic:
            judged = [*(_not_judged(check) for check in judged), *_statistics(s)]
    return [_mac(result), _nrmse(result), *judged, _energy(summary)]


def _not_judged(check: Check) -> Check:
    """A comparison event by event where motion is chaotic: told, without a mark."""
    return Check(check.name, check.bar, f"{check.found}; not judged, the motion is chaotic", None)


def _statistics(s: EventStatistics) -> list[Check]:
    """Rates and distributions, for motion in which two exact solutions part."""
    a, b = s.rate
    words = f"{number(b, 3)} per second, unreduced {number(a, 3)}"
    spread = number(1.96 * float(np.sqrt(sum(s.count))) / s.length, 2)
    checks = [Check("Event rate", f"within {spread} per second, 95{THIN}% of pairs of runs", words, s.rates_alike)]
    for name, distance in (("force", s.force), ("impulse", s.impulse)):
        checks.append(_distribution(f"Distribution of the event {name}", distance))
    return checks


def _distribution(name: str, distance: Distance | None) -> Check:
    if distance is None:
        return Check(name, NONE, "one run has no events", False)
    bar = f"Kolmogorov-Smirnov distance at most {fixed(distance.critical, 3)}"
    return Check(name, bar, fixed(distance.value, 3), distance.alike)


def _mac(result: Found) -> Check:
    name, bar = "Mode shapes, lowest MAC", f"at least {MAC_BAR}"
    modes = result.modes
    f_max = result.setup.study.config.verification.mac_f_max
    if modes is None or modes.pairs.mac.size == 0:
        return Check(name, bar, f"not compared: {why_no_mac(result)}", None)
    worst = int(modes.pairs.mac.argmin())
    mac = float(modes.pairs.mac[worst])
    found = (
        f"{four(mac)} (mode {worst + 1}, {number(float(modes.freq_reference[worst]), 3)} Hz; "
        f"{plural(modes.pairs.mac.size, 'mode')} up to {tidy(f_max)} Hz)"
    )
    return Check(name, bar, found, mac >= MAC_BAR)


def why_no_mac(result: Found) -> str:
    """Why there are no mode shapes to compare."""
    if "reduced" not in result.runs:
        return "there is no reduced model"
    if result.modes is None:
        return "the study watches no nodes"
    return f"no mode lies below {tidy(result.setup.study.config.verification.mac_f_max)} Hz"


def _nrmse(result: Found) -> Check:
    name, bar = "Relative motion, lowest NRMSE fit of x, y, z", f"at least {NRMSE_BAR}"
    fit = result.spectra.nrmse if result.spectra is not None else {}
    if not fit:
        return Check(name, bar, f"not compared: {why_no_fit(result)}", None)
    moving = [(value, a) for a in nrmse.AXES if (value := fit[a]) is not None]
    if not moving:
        return Check(name, bar, "not compared: the pairs do not move against each other", None)
    value, axis = min(moving)
    rest = "".join(f"; no motion along {a}" for a in nrmse.AXES if fit[a] is None)
    found = f"{four(value)} ({axis}; all together {four(fit['all'])}{rest})"
    return Check(name, bar, found, value >= NRMSE_BAR)


def moving_axes(result: Found) -> list[str]:
    """Axes along which the pairs of the reference move at all: the fit of mere round-off means nothing."""
    spectra = result.spectra.spectra if result.spectra is not None else {}
    of = spectra.get("reference", spectra.get("reduced"))
    return [] if of is None else nrmse.moving_axes(of)


def why_no_fit(result: Found) -> str:
    """Why there is no NRMSE."""
    if result.setup.pairs.size == 0:
        return "the study names no verification pairs"
    return "there is only one run"


def _events(result: Found) -> Check:
    name, match = "Contact events", result.events
    limit = 1000.0 * result.setup.study.config.verification.event_tolerance
    bar = f"all found within {tidy(limit)} ms, none added"
    if match is None:
        return Check(name, bar, "not compared: there is only one run", None)
    total = len(match.pairs) + len(match.missed)
    if total + len(match.extra) == 0:
        return Check(name, bar, "no events in either run", True)
    found = f"{len(match.pairs)} of {total} matched, {len(match.missed)} missed, {len(match.extra)} extra"
    return Check(name, bar, found, not match.missed and not match.extra)


def _mean_force(result: Found) -> Check:
    name, bar = "Contact force, mean of the common events", f"within 5{THIN}%"
    match = result.events
    mean = match.amplitude_ratio_mean if match is not None else None
    if match is None or mean is None:
        return Check(name, bar, "not compared: no common events", None)
    found = f"{percent(mean)} (low-passed peaks); impulse {percent(match.impulse_ratio_mean)}"
    return Check(name, bar, found, abs(mean - 1.0) <= FORCE_BAR)


def _each_force(result: Found) -> Check:
    name, bar = "Contact force, event by event", f"each within 5{THIN}%"
    match = result.events
    if match is None or not match.pairs:
        return Check(name, bar, "not compared: no common events", None)
    count = len(match.pairs)
    ratios = [ratio(b.force_place, a.force_place) for a, b in match.pairs]
    worst = max((r for r in ratios if r is not None), key=lambda r: abs(r - 1.0), default=None)
    found = f"{match.within_5_percent} of {count} (largest difference {percent(worst)})"
    return Check(name, bar, found, match.within_5_percent == count)


def _energy(summary: dict[str, Any]) -> Check:
    name = "Energy created by the integration"
    bar = f"at most {share(ENERGY_BAR)}, {share(CONTACT_BAR)} of what contact took up"
    runs = summary["runs"]
    if not runs:
        return Check(name, bar, "no balance: there is no run", None)
    found = "; ".join(f"{RUN_WORDS[name]} {_created(run)}" for name, run in runs.items())
    return Check(name, bar, found, not _alarm(summary))


def _created(run: dict[str, Any]) -> str:
    if not finite(run):
        return "not finite"
    of_all, of_contact = (run[key] for key in CREATED)
    text = share(of_all) if of_all > ROUND_OFF else "none"
    return f"{text}, {share(of_contact)} of what contact took up" if of_contact > ROUND_OFF else text


def warnings(result: Found) -> list[str]:
    """What the reader must know besides the checks."""
    out = []
    run = result.runs.get("reference") or result.runs.get("reduced")
    length = result.window[1] - result.window[0]
    if run is not None:
        count = len(events_in(run.events, result.window))
        if is_chaotic(count, length):
            out.append(
                f"{number(count / length, 3)} events per second: motion with more than some "
                f"{number(int(CHAOTIC_RATE))} of them is chaotic, and two exact solutions part after a while. Compare "
                "the statistics of the events (rate, distributions of force and impulse) rather than one with another."
            )
    return [*out, *_resolution(result), *_deep(result)]


def first_mistakes(result: Found, units: Units) -> list[str]:
    """What the run itself shows of a study that may not be meant so: contact that never happens, or never ends."""
    run = main_run(result.runs)
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


def _deep(result: Found) -> list[str]:
    """Contacts that penetrate by a good part of their clearance."""
    run = main_run(result.runs)
    if run is None:
        return []
    found = {g: penetration(result, run, g) for g in dict.fromkeys(result.gaps.group)}
    return [
        f"at {group} the parts penetrate each other by {share(p.of_clearance)} of the clearance. A shorter step allows "
        "a stiffer contact, and so do [time] substeps."
        for group, p in found.items()
        if p is not None and (p.of_clearance or 0.0) > PENETRATION_BAR
    ]


def _resolution(result: Found) -> list[str]:
    c = result.setup.study.config
    step = c.time.step / c.time.substeps
    if c.time.exact or result.gaps.m == 0 or c.verification.f_max < 0.45 / step:
        return []
    return [
        f"The step of {tidy(1e3 * step)} ms cannot hold more than the {tidy(c.verification.f_max)} Hz of the "
        "low-pass: low-passed peaks are the raw ones. A shorter step separates the two."
    ]
