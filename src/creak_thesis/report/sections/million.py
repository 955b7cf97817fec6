"""The door of the thesis's size."""

from __future__ import annotations

from typing import Any

from creak.report_tools import NONE, Table, fixed, number, percent, plural, times
from creak_thesis.outcome import EventRow
from creak_thesis.report.blocks import Section, TableBlock, Text, absent
from creak_thesis.report.facts import matched
from creak_thesis.report.words import listed

SHOWN = 20
"""Rows of a table of events; the hardest are shown."""


def million_section(data: dict[str, Any] | None) -> Section:
    section = Section("million", "At 1.17 million dofs")
    runs = [] if data is None else data.get("runs", [])
    if data is None or not runs:
        section.blocks.append(absent("This version of creak carries no measurement of the door of 1.17 million dofs."))
        return section
    section.blocks += [
        Text(f"{data['model']}: measured beforehand, not by this run of the command. {_made(data['made'])}"),
        TableBlock("Runs", _table(runs)),
    ]
    if all("events" in r for r in runs) and len(runs) > 1:
        section.blocks += [
            TableBlock(f"Contact events: {r['name']} against {runs[0]['name']}", _events(runs[0], r)) for r in runs[1:]
        ]
    section.blocks.append(Text(_words(runs)))
    return section


def _made(made: dict[str, str]) -> str:
    """Version, commit, date, machine and command; what else there is to say."""
    said = f"{made['command']}, creak {made['creak']}, commit {made['commit']}, {made['date']}, {made['machine']}."
    return f"{said} {made['note']}" if "note" in made else said


def _table(runs: list[dict[str, Any]]) -> Table:
    first = runs[0]
    rows = []
    for r in runs:
        rows.append(
            [
                f"{r['name']}, {r['integrator']}",
                _count(r.get("retained")),
                _count(r.get("modes")),
                _digits(r.get("offline_wall_s")),
                _digits(r.get("offline_cpu_s")),
                _digits(r.get("wall_s")),
                _digits(r.get("cpu_s")),
                NONE if not first.get("cpu_s") or r.get("cpu_s") is None else number(r["cpu_s"] / first["cpu_s"], 3),
                _count(r.get("contact_steps")),
                str(len(r.get("events", []))),
            ]
        )
    head = [
        *("run", "retained", "modes", "wall, s", "CPU, s", "wall, s", "CPU, s", "CPU ratio"),
        *("steps in contact", "events"),
    ]
    return Table(
        head,
        rows,
        groups=[("", 3), ("reduction", 2), ("run", 3), ("", 2)],
        note="Thesis, table 4.4: unreduced 463,450 s of CPU time, D8 9,870 s, ratio 0.0213.",
    )


def _count(value: int | None) -> str:
    return NONE if not value else number(int(value))


def _digits(value: float | None) -> str:
    return NONE if value is None or value == 0.0 else number(float(value), 3)


def _rows(run: dict[str, Any]) -> list[EventRow]:
    return [EventRow(float(s), float(s), float(f), float(f), float(i), str(g)) for g, s, _, f, i in run["events"]]


def _events(first: dict[str, Any], second: dict[str, Any]) -> Table:
    """The hardest events of the whole run, those of both within 10 ms of each other in one row."""
    own, other = _rows(first), _rows(second)
    pairs = matched(own, other)
    lines: list[tuple[float, EventRow | None, EventRow | None]] = [(a.t_start, a, b) for a, b in pairs]
    lines += [(a.t_start, a, None) for a in own if all(a is not x for x, _ in pairs)]
    lines += [(b.t_start, None, b) for b in other if all(b is not y for _, y in pairs)]
    hardest = sorted(lines, key=lambda x: max(e.force for e in x[1:] if e is not None), reverse=True)[:SHOWN]
    rows = []
    for start, a, b in sorted(hardest, key=lambda x: x[0]):
        cells = [[NONE] * 2 if e is None else [number(e.force, 3), number(e.impulse, 3)] for e in (a, b)]
        rows.append([fixed(start, 4), cells[0][0], cells[1][0], cells[0][1], cells[1][1]])
    names = [str(first["name"]), str(second["name"])]
    note = f"The {SHOWN} hardest of {len(lines)}." if len(lines) > SHOWN else ""
    return Table(
        ["start, s", *names, *names], rows, groups=[("", 1), ("highest force, N", 2), ("impulse, N s", 2)], note=note
    )


def _words(runs: list[dict[str, Any]]) -> str:
    first = runs[0]
    out = []
    for r in runs[1:]:
        if not r.get("cpu_s") or not first.get("cpu_s"):
            continue
        text = f"{r['name']} runs {times(first['cpu_s'] / r['cpu_s'])} faster in CPU time than {first['name']}"
        whole = (r.get("offline_cpu_s") or 0.0) + r["cpu_s"]
        text += f", {times(first['cpu_s'] / whole)} with its reduction counted"
        if r.get("events") and first.get("events"):
            peaks = [max(e[3] for e in x["events"]) for x in (first, r)]
            common = len(matched(_rows(first), _rows(r)))
            text += (
                f"; {plural(len(r['events']), 'event')} against {number(len(first['events']))}, {common} of "
                "them the same within 10 ms, highest force "
                f"{number(peaks[1], 3)} N ({percent(peaks[1] / peaks[0])})"
            )
        out.append(text)
    return f"{listed(out)}." if out else "The runs carry no CPU times to compare."
