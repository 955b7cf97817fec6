"""Tables of contact events, their agreement and statistics, and of stick-slip events."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from creak.formats.measured.csv_rows import plain_row
from creak.model.units import Units
from creak.report.tables.checks import RUN_WORDS
from creak.report.tables.run import Table
from creak.report.words.text import NONE, fixed, number, percent, plural, ratio, share
from creak.studies.findings.elines import against_measured, measured_rates
from creak.studies.findings.places import place_of
from creak.studies.findings.tree import Findings
from creak.verify.events import Event, events_in
from creak.verify.slips import SlipEvent, squeak_rates

MOST_EVENTS = 400
"""Lines of the event table; all events are in summary.json."""


def event_table(result: Findings, units: Units) -> Table:
    """Matched pairs, missed and extra events by time; the events of the only run where there is one."""
    if result.events is None:
        return _single_event_table(result, units)
    match = result.events
    lines: list[tuple[Event | None, Event | None]] = [
        *match.pairs,
        *((e, None) for e in match.missed),
        *((None, e) for e in match.extra),
    ]
    lines.sort(key=lambda pair: (pair[0] or pair[1]).t_start)  # type: ignore[union-attr]
    groups = [
        ("", 3),
        (f"force, {units.force}", 3),
        (f"impulse, {units.impulse}", 3),
        ("duration, ms", 2),
        (f"closing speed, {units.speed}", 2),
        ("", 1),
    ]
    two, three = ["unred.", "red."], ["unred.", "red.", "diff."]
    head = ["time, s", "where", "Δt, ms", *three, *three, *two, *two, ""]
    rows = [_pair_row(a, b, result) for a, b in lines[:MOST_EVENTS]]
    flags = ["missed" if b is None else "extra" if a is None else "" for a, b in lines[:MOST_EVENTS]]
    shown = [e for pair in lines[:MOST_EVENTS] for e in pair if e is not None]
    return Table(head, rows, 2, f"{_unfinished(shown)}{_cut(len(lines))}".strip(), flags, groups)


def _cut(count: int) -> str:
    return f" The first {MOST_EVENTS} of {count} lines; summary.json holds all." if count > MOST_EVENTS else ""


def _unfinished(shown: Sequence[Event]) -> str:
    """What `>` says before a duration."""
    said = " An event with > before its duration goes on when the run ends: its impulse is that up to there."
    return said if any(e.unfinished for e in shown) else ""


def _pair_row(a: Event | None, b: Event | None, result: Findings) -> list[str]:
    known = a or b
    assert known is not None
    apart = 1000.0 * (b.t_start - a.t_start) if a and b else None

    def both(name: str, decimals: int, *, difference: bool) -> list[str]:
        x, y = (None if e is None else float(getattr(e, name)) for e in (a, b))
        cells = [_cell(x, decimals), _cell(y, decimals)]
        return [*cells, percent(ratio(y, x))] if difference else cells

    return [
        fixed(known.t_start, 4),
        where(known.group, known.node_idx, result),
        fixed(apart, 2),
        *both("force_place", 3, difference=True),
        *both("impulse", 3, difference=True),
        _duration(a),
        _duration(b),
        *both("closing_speed", 3, difference=False),
        "missed" if b is None else "extra" if a is None else "",
    ]


def _cell(value: float | None, digits: int) -> str:
    return number(value, digits)


def _duration(e: Event | None) -> str:
    """Milliseconds; below one step they are not resolved, and where it goes on when the run ends they are more."""
    if e is None:
        return NONE
    length = e.t_end - e.t_start
    if e.unfinished:
        return f"> {number(1e3 * length, 2)}"
    return f"< {number(1e3 * e.step, 2)}" if length < 0.999 * e.step else number(1e3 * length, 2)


def where(group: str, node_idx: int, result: Findings) -> str:
    """Contact and node of an event."""
    return f"{group}, node {result.setup.model.nodes.label(node_idx)}"


def _single_event_table(result: Findings, units: Units) -> Table:
    run = result.main
    events = events_in(run.events, result.window) if run else []
    head = [
        "time, s",
        "where",
        f"force, {units.force}",
        f"impulse, {units.impulse}",
        "duration, ms",
        f"closing speed, {units.speed}",
        "touches",
    ]
    rows = [
        [
            fixed(e.t_start, 4),
            where(e.group, e.node_idx, result),
            number(e.force_place, 3),
            number(e.impulse, 3),
            _duration(e),
            number(e.closing_speed, 3),
            number(e.contacts),
        ]
        for e in events[:MOST_EVENTS]
    ]
    return Table(head, rows, 2, f"{_unfinished(events[:MOST_EVENTS])}{_cut(len(events))}".strip())


def statistics_table(result: Findings, units: Units) -> Table:
    """Rates and distributions of the events in the window, run by run."""
    names = [n for n in ("reference", "reduced") if n in result.runs]
    length = result.window[1] - result.window[0]
    columns = [_statistics(events_in(result.runs[n].events, result.window), length) for n in names]
    labels = [
        "events",
        "events per second",
        f"median force, {units.force}",
        f"largest force, {units.force}",
        f"median impulse, {units.impulse}",
        f"sum of impulses, {units.impulse}",
        "median duration, ms",
    ]
    rows = [[label, *(number(c[k]) for c in columns)] for k, label in enumerate(labels)]
    if len(columns) == 2:
        for k, row in enumerate(rows):
            row.append(percent(ratio(columns[1][k], columns[0][k])))
    head = ["", *(RUN_WORDS[n] for n in names)]
    return Table([*head, "difference"] if len(columns) == 2 else head, rows, note=_distribution_words(result))


def _distribution_words(result: Findings) -> str:
    """How far the distributions of both runs are apart."""
    if result.events is None:
        return ""
    s = result.statistics
    if s.force is None or s.impulse is None:
        return ""
    return (
        f"Kolmogorov-Smirnov distance of the two runs' distributions: {fixed(s.force.value, 3)} for forces, "
        f"{fixed(s.impulse.value, 3)} for impulses; two samples of one distribution stay below "
        f"{fixed(s.force.critical, 3)} in 95 of 100 cases."
    )


def agreement_table(result: Findings) -> Table | None:
    """How well the common events agree, each and in the mean; None where the runs were not compared."""
    match = result.events
    if match is None or not match.pairs:
        return None
    time, force, impulse = match.time_error, match.force_error, match.impulse_error

    def milliseconds(value: float | None) -> str:
        return NONE if value is None else f"{number(1e3 * value, 2)} ms"

    rows = [
        ["start time", milliseconds(time.mean), milliseconds(time.percentile_95), milliseconds(time.bias)],
        ["force", share(force.mean), share(force.percentile_95), percent(match.amplitude_ratio_mean)],
        ["impulse", share(impulse.mean), share(impulse.percentile_95), percent(match.impulse_ratio_mean)],
    ]
    note = (
        f"{share(match.recall)} of the unreduced model's events were found (recall); {share(match.precision)} of the "
        "reduced model's events are real (precision)."
    )
    return Table(["common events", "mean error of each", "95 % stay below", "error of the mean"], rows, note=note)


def slip_table(result: Findings, units: Units) -> Table | None:
    """Stick-slip events of the window in every run; None where nothing rubs."""
    if not result.gaps.rubs:
        return None
    found = [(name, e) for name, run in result.runs.items() for e in slips_in(run.slips, result.window)]
    found.sort(key=lambda item: (item[1].t_start, item[0]))
    head = [
        "time, s",
        "where",
        "run",
        "slips",
        "slips per second",
        "duration, ms",
        f"slip, {units.length}",
        f"peak speed, {units.speed}",
        f"friction work, {units.energy}",
        f"force drop, {units.force}",
        f"slips per {units.length}",
    ]
    rows = [
        [
            fixed(e.t_start, 4),
            where(e.group, e.node_idx, result),
            RUN_WORDS[name],
            number(len(e.slips)),
            number(e.rate, 3),
            fixed(1e3 * (e.t_end - e.t_start), 1),
            number(e.slip_length, 3),
            number(e.speed_peak, 3),
            number(e.friction_work, 3),
            number(e.force_drop, 3),
            number(e.per_length, 3),
        ]
        for name, e in found[:MOST_EVENTS]
    ]
    return Table(head, rows, 3, _cut(len(found)).strip())


def slips_in(slips: tuple[SlipEvent, ...], window: tuple[float, float]) -> list[SlipEvent]:
    """Stick-slip events of which a slip begins inside a time window."""
    return [e for e in slips if any(window[0] <= start <= window[1] for start, _ in e.slips)]


def squeak_table(result: Findings, units: Units) -> Table | None:
    """Stick-slip of each pair in the window, beside what was measured of its materials; None where nothing slips."""
    lines = {} if result.elines is None else {x.name: x for x in result.elines.lines if x.contact}
    found = [(name, s) for name, run in result.runs.items() for s in run.squeaks]
    if not found:
        return None
    head = [
        "where",
        "run",
        "slips per second",
        f"mean slip, {units.length}",
        f"force drop, {units.force}",
        f"energy, {units.energy}",
        f"travel, {units.length}",
        f"slips per {units.length}",
        f"measured, 1/{units.length}",
        "materials",
    ]
    rows = []
    for name, s in found:
        line = lines.get(s.group)
        rates = measured_rates(line, result.setup.study.config.model.units)
        told = NONE if rates is None else f"{number(rates[0], 3)} to {number(rates[1], 3)}"
        word = against_measured(s.per_length, rates)
        rows.append(
            [
                where(s.group, s.node_idx, result),
                RUN_WORDS[name],
                *(number(x, 3) for x in (s.rate, s.slip_length, s.force_drop, s.energy, s.travel, s.per_length)),
                told if word is None else f"{told} ({word})",
                NONE if line is None or line.pair is None else f"{line.material}: {line.pair.source}",
            ]
        )
    return Table(head, rows, 2, "Of the channel whose slips take the most work; over the verification window.")


def squeak_sentence(result: Findings) -> str:
    """How often each pair slips in the window."""
    words = []
    for name, run in result.runs.items():
        rates = squeak_rates(run.slips, result.window)
        words += [f"{RUN_WORDS[name]} {group} {number(rate, 3)}" for group, rate in rates.items()]
    return f"Slips per second in the window: {'; '.join(words)}." if words else ""


def _statistics(events: list[Event], length: float) -> list[float | None]:
    if not events:
        return [0, 0.0 if length > 0.0 else None, None, None, None, 0.0, None]
    peak, impulse = (np.array([getattr(e, n) for e in events]) for n in ("force_place", "impulse"))
    duration = [e.t_end - e.t_start for e in events]
    return [
        len(events),
        len(events) / length if length > 0.0 else None,
        float(np.median(peak)),
        float(peak.max()),
        float(np.median(impulse)),
        float(impulse.sum()),
        1000.0 * float(np.median(duration)),
    ]


def counted_events(result: Findings) -> str:
    """How many events each run shows over its whole length."""
    return "; ".join(f"{RUN_WORDS[name]} run: {plural(len(run.events), 'event')}" for name, run in result.runs.items())


def event_csv(result: Findings, units: Units) -> str:
    """A line per event of the verification window and run; `match` numbers those that are the same event."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(
        [
            "run",
            "match",
            "contact",
            "place",
            "node",
            "channel",
            "t_start_s",
            "t_peak_s",
            "t_end_s",
            f"force_{_unit(units.force)}",
            f"node_force_low_passed_{_unit(units.force)}",
            f"node_force_raw_{_unit(units.force)}",
            f"impulse_{_unit(units.impulse)}",
            f"closing_speed_{_unit(units.speed)}",
            "micro_contacts",
            "unfinished",
        ]
    )
    numbers = _matches(result)
    for name, run in result.runs.items():
        for e in events_in(run.events, result.window):
            writer.writerow(plain_row(_row(name, e, numbers.get((name, id(e)), ""), result)))
    return out.getvalue()


def _unit(text: str) -> str:
    return text.replace("/", "_per_").replace(" ", "_")


def _matches(result: Findings) -> dict[tuple[str, int], int]:
    """(run, event) -> number of the pair."""
    if result.events is None:
        return {}
    out = {}
    for k, (reference, reduced) in enumerate(result.events.pairs, start=1):
        out[("reference", id(reference))] = k
        out[("reduced", id(reduced))] = k
    return out


def _row(name: str, e: Event, match: Any, result: Findings) -> list[Any]:
    place = place_of(result.places, e)
    return [
        name,
        match,
        e.group,
        "" if place is None else place.number,
        result.setup.model.nodes.label(e.node_idx),
        e.channel,
        *(f"{x:.9g}" for x in (e.t_start, e.t_peak, e.t_end)),
        *(f"{x:.9g}" for x in (e.force_place, e.force_peak_filtered, e.force_peak, e.impulse, e.closing_speed)),
        e.contacts,
        "yes" if e.unfinished else "",
    ]
