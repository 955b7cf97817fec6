"""Rows of the report's tables, as text ready to show."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from creak.reduction.health import health_rows
from creak.report.text import NONE, Units, fixed, four, number, percent, plural, ratio, share, tidy
from creak.report.verdict import RUN_WORDS, main_run
from creak.studies.run import StudyResult, events_in
from creak.verify.events import Event

MOST_EVENTS = 400
"""Lines of the event table; all events are in summary.json."""


@dataclass(frozen=True)
class Table:
    """A table; the first `text_columns` columns are words, the others numbers."""

    head: list[str]
    rows: list[list[str]]
    text_columns: int = 1
    note: str = ""
    flags: list[str] = field(default_factory=list)
    """Style of each row: `missed`, `extra` or nothing; empty for no styles."""
    groups: list[tuple[str, int]] = field(default_factory=list)
    """Headings over so many columns each; empty for none."""


def event_table(result: StudyResult, units: Units) -> Table:
    """Matched pairs, missed and extra events by time; the events of the only run where there is one."""
    if result.events is None:
        return _single_event_table(result, units)
    match = result.events
    lines: list[tuple[Event | None, Event | None]] = [
        *match.pairs, *((e, None) for e in match.missed), *((None, e) for e in match.extra)
    ]  # fmt: skip
    lines.sort(key=lambda pair: (pair[0] or pair[1]).t_start)  # type: ignore[union-attr]
    groups = [("", 3), (f"peak, low-passed, {units.force}", 3), (f"peak, raw, {units.force}", 2),
              (f"impulse, {units.impulse}", 3), ("duration, ms", 2),
              (f"closing speed, {units.speed}", 2), ("", 1)]  # fmt: skip
    two, three = ["unred.", "red."], ["unred.", "red.", "diff."]
    head = ["time, s", "where", "Δt, ms", *three, *two, *three, *two, *two, ""]
    rows = [_pair_row(a, b, result) for a, b in lines[:MOST_EVENTS]]
    flags = ["missed" if b is None else "extra" if a is None else "" for a, b in lines[:MOST_EVENTS]]
    return Table(head, rows, 2, _cut(len(lines)), flags, groups)


def _cut(count: int) -> str:
    return f"The first {MOST_EVENTS} of {count} lines; summary.json holds all." if count > MOST_EVENTS else ""


def _pair_row(a: Event | None, b: Event | None, result: StudyResult) -> list[str]:
    known = a or b
    assert known is not None
    apart = 1000.0 * (b.t_start - a.t_start) if a and b else None

    def both(name: str, decimals: int, *, difference: bool) -> list[str]:
        x, y = (None if e is None else float(getattr(e, name)) for e in (a, b))
        cells = [_cell(x, decimals), _cell(y, decimals)]
        return [*cells, percent(ratio(y, x))] if difference else cells

    return [
        fixed(known.t_start, 4), where(known, result), fixed(apart, 2),
        *both("force_peak_filtered", 3, difference=True), *both("force_peak", 3, difference=False),
        *both("impulse", 3, difference=True), _duration(a, result), _duration(b, result),
        *both("closing_speed", 3, difference=False),
        "missed" if b is None else "extra" if a is None else "",
    ]  # fmt: skip


def _cell(value: float | None, digits: int) -> str:
    return number(value, digits)


def _duration(e: Event | None, result: StudyResult) -> str:
    """Milliseconds; below one step they are not resolved."""
    if e is None:
        return NONE
    step = result.setup.study.config.time.step
    return f"< {tidy(1e3 * step)}" if e.t_end - e.t_start < 0.999 * step else fixed(1e3 * (e.t_end - e.t_start), 1)


def where(e: Event, result: StudyResult) -> str:
    """Contact and node of an event."""
    return f"{e.group}, node {result.setup.model.nodes.label(e.node_idx)}"


def _single_event_table(result: StudyResult, units: Units) -> Table:
    run = main_run(result)
    events = events_in(run.events, result.window) if run else []
    head = ["time, s", "where", f"peak, low-passed, {units.force}", f"peak, raw, {units.force}",
            f"impulse, {units.impulse}", "duration, ms", f"closing speed, {units.speed}", "touches"]  # fmt: skip
    rows = [
        [fixed(e.t_start, 4), where(e, result), number(e.force_peak_filtered, 3), number(e.force_peak, 3),
         number(e.impulse, 3), _duration(e, result), number(e.closing_speed, 3), number(e.contacts)]
        for e in events[:MOST_EVENTS]
    ]  # fmt: skip
    return Table(head, rows, 2, _cut(len(events)))


def statistics_table(result: StudyResult, units: Units) -> Table:
    """Rates and distributions of the events in the window, run by run."""
    names = [n for n in ("reference", "reduced") if n in result.runs]
    length = result.window[1] - result.window[0]
    columns = [_statistics(events_in(result.runs[n].events, result.window), length) for n in names]
    labels = ["events", "events per second", f"median peak, low-passed, {units.force}",
              f"largest peak, low-passed, {units.force}", f"median impulse, {units.impulse}",
              f"sum of impulses, {units.impulse}", "median duration, ms"]  # fmt: skip
    rows = [[label, *(number(c[k]) for c in columns)] for k, label in enumerate(labels)]
    if len(columns) == 2:
        for k, row in enumerate(rows):
            row.append(percent(ratio(columns[1][k], columns[0][k])))
    head = ["", *(RUN_WORDS[n] for n in names)]
    return Table([*head, "difference"] if len(columns) == 2 else head, rows)


def _statistics(events: list[Event], length: float) -> list[float | None]:
    if not events:
        return [0, 0.0 if length > 0.0 else None, None, None, None, 0.0, None]
    peak, impulse = (np.array([getattr(e, n) for e in events]) for n in ("force_peak_filtered", "impulse"))
    duration = [e.t_end - e.t_start for e in events]
    return [
        len(events), len(events) / length if length > 0.0 else None, float(np.median(peak)), float(peak.max()),
        float(np.median(impulse)), float(impulse.sum()), 1000.0 * float(np.median(duration)),
    ]  # fmt: skip


def frequency_table(result: StudyResult) -> Table | None:
    """Frequencies of the paired modes and their MAC."""
    modes = result.modes
    if modes is None or modes.freq_reference.size == 0:
        return None
    rows = []
    for i, (f, j) in enumerate(zip(modes.freq_reference.tolist(), modes.pairs.partner.tolist(), strict=True)):
        other = float(modes.freq_reduced[j]) if j >= 0 else None
        error = percent(ratio(other, f), 3) if f > 0.01 else NONE
        rows.append([str(i + 1), fixed(f, 3), fixed(other, 3), error, four(float(modes.pairs.mac[i]))])
    return Table(["mode", "unreduced, Hz", "reduced, Hz", "error", "MAC"], rows)


def gap_table(result: StudyResult, units: Units) -> Table | None:
    """Candidates and kept channels of each contact, and how far its gap closed."""
    setup = result.setup
    every = [*dict.fromkeys(setup.contacts.group), *dict.fromkeys(setup.connectors.group)]
    if not every:
        return None
    rows = []
    for group in every:
        source = setup.contacts if group in setup.contacts.group else setup.connectors
        all_of = [j for j, g in enumerate(source.group) if g == group]
        kept = [j for j, g in enumerate(result.gaps.group) if g == group]
        low, high = (float(f(source.gap0[all_of])) for f in (np.min, np.max))
        rows.append([group, number(len(all_of)), number(len(kept)), number(low), number(high),
                     number(_smallest_gap(result, kept)), number(_mean(result.gaps.stiffness[kept]), 3)])  # fmt: skip
    head = ["contact or connector", "candidates", "kept", f"clearance from, {units.length}", f"to, {units.length}",
            f"smallest gap, {units.length}", f"mean channel stiffness, {units.stiffness}"]  # fmt: skip
    return Table(head, rows)


def _smallest_gap(result: StudyResult, channels: list[int]) -> float | None:
    run = main_run(result)
    return float(run.history.gap[:, channels].min()) if run is not None and channels else None


def _mean(values: Any) -> float | None:
    return float(np.mean(values)) if len(values) else None


def part_table(summary: dict[str, Any], units: Units) -> Table:
    """Nodes, elements and mass of each part, and of the whole."""
    model = summary["model"]
    named = [*model["parts"].items(), ("whole model", model)]
    rows = [[name, number(p["nodes"]), number(p["elements"]), _mass(p["mass"], units)] for name, p in named]
    note = f"{number(model['dof'])} degrees of freedom, {number(model['free_dof'])} of them free."
    return Table(["part", "nodes", "elements", "mass, kg"], rows, note=note, flags=[""] * (len(rows) - 1) + ["total"])


def _mass(mass: float | None, units: Units) -> str:
    return number(None if mass is None else mass * units.to_kg)


def cost_table(result: StudyResult, summary: dict[str, Any]) -> Table:
    """What the runs cost, and reduced against reference."""
    names = [n for n in ("reference", "reduced") if n in summary["runs"]]
    runs = [summary["runs"][n] for n in names]
    simulated = {n: float(result.runs[n].history.time[-1] - result.runs[n].history.time[0]) for n in names}
    for name, run in zip(names, runs, strict=True):
        run = run | {"step_ms": 1000.0 * (ratio(run["wall_s"], run["steps"]) or 0.0)}
        run["real_time"] = ratio(simulated[name], run["wall_s"])
        runs[names.index(name)] = run
    rows = [_cost_row(label, key, runs, compare) for label, key, compare in _COSTS]
    head = ["", *(RUN_WORDS[n] for n in names)]
    if len(runs) == 2:
        head.append("reduced / unreduced")
    return Table(head, rows, note=_real_time(names, runs, simulated))


def health_tables(result: StudyResult) -> list[tuple[str, Table]]:
    """One table of checks for each superelement."""
    head = ["", "value", "remark"]
    return [
        (name, Table(head, [list(row) for row in health_rows(health)], 3)) for name, health in result.health.items()
    ]  # fmt: skip


_COSTS = (
    ("unknowns in the time integration", "dof", True),
    ("retained degrees of freedom", "retained", False),
    ("fixed-interface modes", "modes", False),
    ("gap channels", "channels", False),
    ("steps", "steps", False),
    ("steps with contact", "contact_steps", False),
    ("time integration, wall, s", "wall_s", True),
    ("time integration, CPU, s", "cpu_s", True),
    ("before the first step, wall, s", "setup_s", True),
    ("one step, wall, ms", "step_ms", True),
    ("reduction, wall, s", "offline_wall_s", False),
    ("reduction, CPU, s", "offline_cpu_s", False),
    ("peak memory, GB", "peak_rss_gb", True),
    ("simulated time / wall time", "real_time", False),
)


def _cost_row(label: str, key: str, runs: list[dict[str, Any]], compare: bool) -> list[str]:
    absent = ("retained", "modes", "offline_wall_s", "offline_cpu_s")
    cells = [NONE if key in absent and not run[key] else number(run[key], 3) for run in runs]
    if len(runs) == 2:
        cells.append(number(ratio(runs[1][key], runs[0][key]), 3) if compare else "")
    return [label, *cells]


def _real_time(names: list[str], runs: list[dict[str, Any]], simulated: dict[str, float]) -> str:
    words = []
    for name, run in zip(names, runs, strict=True):
        if run["real_time"]:
            pace = "faster" if run["real_time"] >= 1.0 else "slower"
            who = RUN_WORDS[name]
            took = f"The {who} run of {tidy(simulated[name])} s took {number(run['wall_s'], 3)} s"
            words.append(f"{took}: {pace} than real time.")
    return " ".join(words)


def energy_sentence(result: StudyResult) -> str:
    """What the balance leaves over, in words."""
    words = []
    for name, run in sorted(result.runs.items(), reverse=True):
        h = run.history
        who = RUN_WORDS[name]
        if not h.energy.any():
            continue
        made = h.energy_created
        left = share(max(h.energy_dissipated_by_scheme, 0.0))
        created = f"at worst {share(made)} was created on the way" if made > 1e-12 else "none was created at any time"
        words.append(
            f"At the end of the {who} run {left} of the energy put in is left over, dissipated by the integration "
            f"scheme; {created}."
        )
    return " ".join(words)


def unread_rows(summary: dict[str, Any]) -> list[tuple[str, str, str, bool]]:
    """Keywords of the deck that were not used: keyword, where, what it means, whether the answer changes."""
    return [(u["keyword"], u["where"], u["why"], u["changes_answer"]) for u in summary["unread"]]


def counted_events(result: StudyResult) -> str:
    """How many events each run shows over its whole length."""
    return "; ".join(
        f"{RUN_WORDS[name]} run: {plural(len(run.events), 'event')}" for name, run in result.runs.items()
    )
