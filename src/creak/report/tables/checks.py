"""The table of checks: the reduced model against the unreduced one, and the energy balance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.report.words.correlation import GOOD_DB, GOOD_FRAC, frf_fits
from creak.report.words.text import NONE, THIN, fixed, four, number, percent, plural, ratio, share, tidy
from creak.studies.converge.settling import SETTLED, UNREDUCED
from creak.studies.findings.tree import Findings
from creak.verify import nrmse
from creak.verify.mode_fit import GOOD_HZ, GOOD_MAC
from creak.verify.reliability import CONTACT_BAR, ENERGY_BAR
from creak.verify.statistics import Distance, EventStatistics

MAC_BAR = 0.99
NRMSE_BAR = 0.99
FORCE_BAR = 0.05
ROUND_OFF = 1e-12
"""Share of the energy put in up to which created energy is none."""
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


def checks(result: Findings, summary: dict[str, Any]) -> list[Check]:
    """The comparison with the unreduced model against the bars, and the energy balance."""
    judged = [_events(result), _mean_force(result), _each_force(result)]
    if "reference" not in result.runs and "reduced" in result.runs:
        judged = [*_spots(result), *_rubs(result)]
    if result.events is not None and is_chaotic(summary):
        judged = [*(_not_judged(check) for check in judged), *_statistics(result.statistics)]
    return [_mac(result), _nrmse(result), *judged, _energy(summary)]


def against_tests(result: Findings) -> Iterator[Check]:
    """Measured modes and functions that fit the model."""
    for test in result.tests:
        if test.modes is not None:
            count, good = test.modes.frequencies_test.size, sum(p.fits for p in test.modes.pairs)
            near = f"frequency within {100.0 * GOOD_HZ:g}{THIN}%"
            bar = f"{near}; one channel tells no shape" if test.modes.of_one_channel else f"MAC {GOOD_MAC:g}, {near}"
            yield Check(f"Measured modes, {test.name}", bar, f"{good} of {count}", good == count)
        if test.frfs is not None:
            count, good = len(test.frfs.pairs), sum(map(frf_fits, test.frfs.pairs))
            bar = f"FRAC {GOOD_FRAC:g}, level within {GOOD_DB:g} dB"
            yield Check(f"Measured functions, {test.name}", bar, f"{good} of {count}", good == count)


def is_chaotic(summary: dict[str, Any]) -> bool:
    """Whether the events of both runs are compared by their statistics, not one by one."""
    return bool(summary["verification"]["events"]["statistics"]["chaotic"])


def created(summary: dict[str, Any]) -> str:
    """How much energy the runs created, where that is more than is sound; empty where it is not."""
    words = []
    for name, run in summary["runs"].items():
        if not finite(run):
            words.append(f"the figures of the {RUN_WORDS[name]} run are not finite")
            continue
        words += [
            f"the {RUN_WORDS[name]} run created {share(run[key])} of the energy {what}, where {share(bar)} is the limit"
            for key, (bar, what) in CREATED.items()
            if run[key] > bar
        ]
    return "; ".join(words)


def alarm(summary: dict[str, Any]) -> str:
    """What makes the forces of a run worthless, whatever else agrees."""
    words = created(summary)
    return f" Do not rely on it: {words}. The warnings say what to do." if words else ""


def finite(run: dict[str, Any]) -> bool:
    """Whether the balance of a run is one of numbers."""
    return all(value is not None for value in (*(run[key] for key in CREATED), *run["energies"].values()))


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


def _spots(result: Findings) -> list[Check]:
    """Single events that the unreduced model marched through, by figure."""
    structure = None if result.convergence is None else result.convergence.structure
    bar = f"each within {100 * SETTLED:g}{THIN}%"
    if structure is None or not structure.spots:
        why = "nobody asked" if structure is None else structure.why_not
        return [Check("Single events against the unreduced model", bar, f"not compared: {why}", None)]
    found = []
    for name, word in (("impulse", "impulse"), ("force", "force"), ("closing_speed", "closing speed")):
        known = [x for s in structure.spots if (x := s.difference(name)) is not None]
        lost = sum(np.isnan(x) for x in known)
        off = [abs(x) for x in known if not np.isnan(x)]
        inside = sum(x <= SETTLED for x in off)
        words = f"{inside} of {len(known)}" + (f", at most {share(max(off))} off" if off else "")
        words += f"; {lost} of them the unreduced model does not have" if lost else ""
        if structure.complete:
            words += "; of the unreduced model's own steps: the reduced one has all modes"
        good = None if structure.complete else inside == len(known)
        found.append(Check(f"Single events against the unreduced model, {word}", bar, words, good))
    return found


def _rubs(result: Findings) -> list[Check]:
    """Friction and lasting contact in the pieces that the unreduced model went through, places one by one."""
    rubs = () if result.convergence is None else result.convergence.rubs
    every = (r.figures[name].beside.get(UNREDUCED) for r in rubs for name in r.deciding)
    off = [by for by in every if by is not None]
    if not off:
        return []
    inside = sum(x <= SETTLED for x in off)
    words = f"{inside} of {len(off)} figures, at most {share(max(off))} off"
    name = "Friction and lasting contact against the unreduced model"
    return [Check(name, f"each within {100 * SETTLED:g}{THIN}%", words, inside == len(off))]


def _mac(result: Findings) -> Check:
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


def why_no_mac(result: Findings) -> str:
    """Why there are no mode shapes to compare."""
    if "reduced" not in result.runs:
        return "there is no reduced model"
    if result.modes is None:
        return "the study watches no nodes, or memory does not hold a factor of the whole model"
    return f"no mode lies below {tidy(result.setup.study.config.verification.mac_f_max)} Hz"


def _nrmse(result: Findings) -> Check:
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


def moving_axes(result: Findings) -> list[str]:
    """Axes along which the pairs of the reference move at all: the fit of mere round-off means nothing."""
    spectra = result.spectra.spectra if result.spectra is not None else {}
    of = spectra.get("reference", spectra.get("reduced"))
    return [] if of is None else nrmse.moving_axes(of)


def why_no_fit(result: Findings) -> str:
    """Why there is no NRMSE."""
    if result.setup.pairs.size == 0:
        return "the study names no verification pairs"
    return "there is only one run"


def _events(result: Findings) -> Check:
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


def _mean_force(result: Findings) -> Check:
    name, bar = "Contact force, mean of the common events", f"within 5{THIN}%"
    match = result.events
    mean = match.amplitude_ratio_mean if match is not None else None
    if match is None or mean is None:
        return Check(name, bar, "not compared: no common events", None)
    found = f"{percent(mean)} (force); impulse {percent(match.impulse_ratio_mean)}"
    return Check(name, bar, found, abs(mean - 1.0) <= FORCE_BAR)


def _each_force(result: Findings) -> Check:
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
    return Check(name, bar, found, not alarm(summary))


def _created(run: dict[str, Any]) -> str:
    if not finite(run):
        return "not finite"
    of_all, of_contact = (run[key] for key in CREATED)
    text = share(of_all) if of_all > ROUND_OFF else "none"
    return f"{text}, {share(of_contact)} of what contact took up" if of_contact > ROUND_OFF else text
