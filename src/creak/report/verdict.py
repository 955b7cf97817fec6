"""The answer in one sentence, and whether the reduced model deserves trust."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.report.text import THIN, Units, four, number, percent, plural, ratio, share, tidy, times
from creak.studies.run import Run, StudyResult, events_in

MAC_BAR = 0.99
NRMSE_BAR = 0.99
FORCE_BAR = 0.05
ENERGY_BAR = 0.005
AT_REST = 1e-6
"""Share of the largest axis below which an axis counts as not moving."""
MANY = 10
"""Events in the window from which their rate means something."""
RUN_WORDS = {"reduced": "reduced", "reference": "unreduced"}
CHAOTIC_RATE = 40.0
"""Events per second above which two exact solutions part."""


@dataclass(frozen=True)
class Check:
    """One line of the table of checks; `passed` is None where there was nothing to check."""

    name: str
    bar: str
    found: str
    passed: bool | None


def main_run(result: StudyResult) -> Run | None:
    """The run that the report speaks of: reduced where there is one."""
    return result.runs.get("reduced") or result.runs.get("reference")


def sentence(result: StudyResult, summary: dict[str, Any], units: Units) -> str:
    """What happened and how far it can be trusted, in plain words."""
    run = main_run(result)
    if run is None:
        return "Nothing was computed: the study has no run."
    events = events_in(result.runs.get("reference", run).events, result.window)
    what = _what(result, run, len(events))
    hardest = max(events, key=lambda e: e.force_peak_filtered, default=None)
    where = ""
    if hardest is not None:
        node = result.setup.model.nodes.label(hardest.node_idx)
        where = f", the hardest {number(hardest.force_peak_filtered, 3)} {units.force} at node {node}"
    if "reference" not in result.runs:
        return f"{what}{where}. The unreduced model was not run, so the reduced model is not checked here."
    if "reduced" not in result.runs:
        return f"{what}{where}, computed on the unreduced model; nothing was reduced."
    return f"{what}{where}; {_found(result)}, {_speed(summary)}."


def span(result: StudyResult) -> str:
    """The verification window in words."""
    start, end = result.window
    length = end - start
    if start <= 0.0:
        return f"in {tidy(length)} s"
    return "in the last second" if abs(length - 1.0) < 1e-9 else f"in the last {tidy(length)} s"


def _what(result: StudyResult, run: Run, count: int) -> str:
    if result.gaps.m == 0:
        return f"No rattle {span(result)}: nothing can touch under this load"
    if count == 0 and _pressed(result, run):
        return f"No contact begins {span(result)}, but one that began before lasts into it"
    if count == 0:
        return f"No rattle {span(result)}"
    return f"{plural(count, 'rattle event')} {span(result)}"


def _pressed(result: StudyResult, run: Run) -> bool:
    """Whether anything presses inside the window."""
    h = run.history
    return bool(h.force[(h.time >= result.window[0]) & (h.time <= result.window[1])].any())


def _found(result: StudyResult) -> str:
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
    mean = match.amplitude_ratio_mean
    return text + (f", mean force {percent(mean)}" if mean is not None else "")


def _speed(summary: dict[str, Any]) -> str:
    reduced, reference = summary["runs"]["reduced"], summary["runs"]["reference"]
    run = ratio(reference["wall_s"], reduced["wall_s"])
    whole = ratio(reference["wall_s"], reduced["wall_s"] + reduced["offline_wall_s"])
    if run is None or whole is None:
        return "speed not measured"
    if run < 1.0:
        return f"{times(1.0 / run)} slower than the unreduced model"
    counted = f"{times(whole)} faster" if whole >= 1.0 else f"{times(1.0 / whole)} slower"
    return f"{times(run)} faster than the unreduced model ({counted} when the reduction itself is counted)"


def checks(result: StudyResult, summary: dict[str, Any]) -> list[Check]:
    """The comparison with the unreduced model against the bars, and the energy balance."""
    return [_mac(result), _nrmse(result), _events(result), _mean_force(result), _each_force(result),
            _energy(summary)]  # fmt: skip


def _mac(result: StudyResult) -> Check:
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


def why_no_mac(result: StudyResult) -> str:
    """Why there are no mode shapes to compare."""
    if result.reduced is None:
        return "there is no reduced model"
    if result.modes is None:
        return "the study watches no nodes"
    return f"no mode lies below {tidy(result.setup.study.config.verification.mac_f_max)} Hz"


def _nrmse(result: StudyResult) -> Check:
    name, bar = "Relative motion, lowest NRMSE fit of x, y, z", f"at least {NRMSE_BAR}"
    fit = result.spectra.nrmse if result.spectra is not None else {}
    if not fit:
        return Check(name, bar, f"not compared: {why_no_fit(result)}", None)
    moving = moving_axes(result)
    if not moving:
        return Check(name, bar, "not compared: the pairs do not move against each other", None)
    axis, value = min(((a, fit[a]) for a in moving), key=lambda item: item[1])
    rest = "".join(f"; no motion along {a}" for a in ("x", "y", "z") if a not in moving)
    found = f"{four(value)} ({axis}; all together {four(fit['all'])}{rest})"
    return Check(name, bar, found, value >= NRMSE_BAR)


def moving_axes(result: StudyResult) -> list[str]:
    """Axes along which the pairs of the reference move at all: the fit of mere round-off means nothing."""
    spectra = result.spectra.spectra if result.spectra is not None else {}
    of = spectra.get("reference", spectra.get("reduced"))
    if of is None or of.size == 0:
        return []
    size = np.linalg.norm(of, axis=(0, 1))
    return [a for a, s in zip("xyz", size.tolist(), strict=True) if s > AT_REST * size.max()]


def why_no_fit(result: StudyResult) -> str:
    """Why there is no NRMSE."""
    if result.setup.pairs.size == 0:
        return "the study names no verification pairs"
    return "there is only one run"


def _events(result: StudyResult) -> Check:
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


def _mean_force(result: StudyResult) -> Check:
    name, bar = "Contact force, mean of the common events", f"within 5{THIN}%"
    match = result.events
    mean = match.amplitude_ratio_mean if match is not None else None
    if match is None or mean is None:
        return Check(name, bar, "not compared: no common events", None)
    found = f"{percent(mean)} (low-passed peaks); impulse {percent(match.impulse_ratio_mean)}"
    return Check(name, bar, found, abs(mean - 1.0) <= FORCE_BAR)


def _each_force(result: StudyResult) -> Check:
    name, bar = "Contact force, event by event", f"each within 5{THIN}%"
    match = result.events
    if match is None or not match.pairs:
        return Check(name, bar, "not compared: no common events", None)
    count = len(match.pairs)
    ratios = [ratio(b.force_peak_filtered, a.force_peak_filtered) for a, b in match.pairs]
    worst = max((r for r in ratios if r is not None), key=lambda r: abs(r - 1.0), default=None)
    found = f"{match.within_5_percent} of {count} (largest difference {percent(worst)})"
    return Check(name, bar, found, match.within_5_percent == count)


def _energy(summary: dict[str, Any]) -> Check:
    created = {name: run["energy_created"] for name, run in summary["runs"].items()}
    name, bar = "Energy created by the integration", f"at most {share(ENERGY_BAR)}"
    known = {k: v for k, v in created.items() if v is not None}
    if not known:
        return Check(name, bar, "no balance: the run has no energy figures", None)
    found = "; ".join(f"{RUN_WORDS[run]} {share(v) if v > 1e-12 else 'none'}" for run, v in known.items())
    return Check(name, bar, found, max(known.values()) <= ENERGY_BAR)


def warnings(result: StudyResult) -> list[str]:
    """What the reader must know besides the checks."""
    out = []
    run = main_run(result)
    length = result.window[1] - result.window[0]
    if run is not None and length > 0.0:
        rate = len(events_in(run.events, result.window)) / length
        if rate > CHAOTIC_RATE and rate * length >= MANY:
            out.append(
                f"{number(rate, 3)} events per second: motion with so many impacts is chaotic, and two exact solutions "
                "part after a while. Compare the statistics of the events rather than one event with another."
            )
    out += _resolution(result)
    return out


def _resolution(result: StudyResult) -> list[str]:
    c = result.setup.study.config
    if result.gaps.m == 0 or c.verification.f_max < 0.45 / c.time.step:
        return []
    return [
        f"The step of {tidy(1e3 * c.time.step)} ms cannot hold more than the {tidy(c.verification.f_max)} Hz of the "
        "low-pass: low-passed peaks are the raw ones. A shorter step separates the two."
    ]
