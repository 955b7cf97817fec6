"""The door of the thesis's size."""

from __future__ import annotations

from typing import Any

from creak.report.tables import Table
from creak.report.text import NONE, fixed, number, percent, plural, times
from creak.report.thesis.blocks import Section, TableBlock, Text, absent
from creak.report.thesis.figures import Panel, events_figure
from creak.report.thesis.words import listed
from creak.studies.thesis.outcome import EventRow


def million_section(data: dict[str, Any] | None) -> Section:
    section = Section("million", "At 1.17 million dofs")
    runs = [] if data is None else data.get("runs", [])
    if data is None or not runs:
        section.blocks.append(absent("This version of creak carries no measurement of the door of 1.17 million dofs."))
        return section
    where = "".join(f" {str(data[k]).rstrip('.')}." for k in ("where", "machine", "date") if data.get(k))
    section.blocks += [
        Text(f"{data.get('model', 'The door')}: measured beforehand, not by this run of the command.{where}"),
        TableBlock("Runs", _table(runs)),
    ]
    if all("events" in r for r in runs) and len(runs) > 1:
        section.blocks.append(_figure(runs))
    section.blocks.append(Text(_words(runs)))
    return section


def _table(runs: list[dict[str, Any]]) -> Table:
    first = runs[0]
    rows = []
    for r in runs:
        rows.append(
            [
                str(r["name"]),
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
        "run",
        "retained",
        "modes",
        "wall, s",
        "CPU, s",
        "wall, s",
        "CPU, s",
        "CPU ratio",
        "steps in contact",
        "events",
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


def _events(run: dict[str, Any]) -> list[EventRow]:
    """Events of the last period; they carry no peak time, their middle stands for it."""
    rows = [(float(s), float(e), float(f), float(i)) for _, s, e, f, i in run["events"]]
    return [EventRow(s, 0.5 * (s + e), f, f, i) for s, e, f, i in rows if s >= 4.0]


def _figure(runs: list[dict[str, Any]]) -> Any:
    reference = _events(runs[0])
    panels = [Panel(str(r["name"]), _events(r), reference) for r in runs[1:]]
    return events_figure(
        "Contact events at 1.17 million dofs",
        panels,
        ("reduced model", str(runs[0]["name"])),
        "Contact events of the last second.",
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
            text += (
                f"; {plural(len(r['events']), 'event')} against {number(len(first['events']))}, highest force "
                f"{fixed(peaks[1], 1)} N ({percent(peaks[1] / peaks[0])})"
            )
        out.append(text)
    return f"{listed(out)}." if out else "The runs carry no CPU times to compare."
