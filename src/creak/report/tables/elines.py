"""E-lines as rows of a table, for terminal and page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from creak.model.plain_mesh import Mesh
from creak.model.units import Units
from creak.report.tables.run import Table
from creak.report.words.text import NONE, number, plural
from creak.studies.findings.elines import BOTH, FALSE_ALARM, MISS, NEITHER, Figures, LineRow, pairs_of_lines
from creak.studies.run.elines import LineFindings

OUTCOMES = {
    BOTH: "both: risk",
    NEITHER: "both: free",
    FALSE_ALARM: "false alarm of linear",
    MISS: "missed by linear",
}
MOST_LINES = 400
"""Rows of a table; all lines are in summary.json."""


def screen_rows(rows: list[LineRow], model: Mesh, percentile: float) -> list[list[str]]:
    """Header and a row for each line, from the linear run alone; lengths are those of the study."""
    part = f"{percentile:g} %"
    head = ["line", "points", "margin", part, "gap", "closing", "node", "can touch", "in plane", part, "can squeak"]
    return [head, *(_linear(r, model) for r in rows)]


def _linear(row: LineRow, model: Mesh) -> list[str]:
    f = row.linear
    if f is None:
        return [row.line.name, number(row.points), *[NONE] * 9]
    return [
        row.line.name,
        number(row.points),
        number(f.margin, 3),
        number(f.margin_percentile, 3),
        number(f.gap, 3),
        number(f.closing, 3),
        model.nodes.label(f.node_idx),
        "yes" if f.risk else "no",
        number(f.in_plane, 3),
        number(f.in_plane_percentile, 3),
        NONE if f.squeak is None else f.squeak,
    ]


def eline_words(told: dict[str, Any]) -> str:
    """How far the linear answer of a summary's E-lines can be relied on, in a sentence."""
    count = len(told["lines"])
    if told["false_alarms"] is None:
        return f"{plural(count, 'line')}; nothing to compare: {told['why'] or 'one run is missing'}."
    alarms = f"raises {plural(told['false_alarms'], 'false alarm')} and misses {plural(told['misses'], 'line')}"
    of_points = (
        f"of single points it raises {number(told['points_false_alarms'])} and misses {number(told['points_misses'])}"
    )
    return f"{plural(count, 'line')}. The linear run ({told['linear_run']}) {alarms}; {of_points}."


def eline_table(rows: list[LineRow], model: Mesh, units: Units, percentile: float) -> Table:
    """A row for each line, linear beside contact."""
    head = [
        "line",
        "what they say",
        "points",
        f"gap, {units.length}",
        f"tolerance, {units.length}",
        "closing, linear",
        "with contact",
        "margin, linear",
        "with contact",
        f"at {percentile:g} %, linear",
        "with contact",
        "node",
        "in plane, linear",
        "with contact",
        "can squeak, linear",
        "with contact",
    ]
    flags = ["extra" if r.outcome == FALSE_ALARM else "missed" if r.outcome == MISS else "" for r in rows[:MOST_LINES]]
    note = f"All lengths in {units.length}; the figures of a line are those of its worst point, named by its node."
    if any(r.line.tolerance for r in rows):
        note += " A table of tolerances has one for each point; the side is that which the gap may lose."
    if len(rows) > MOST_LINES:
        note += f" The {MOST_LINES} tightest of {len(rows)} lines; all are in summary.json."
    return Table(head, [_both(r, model) for r in rows[:MOST_LINES]], text_columns=2, note=note, flags=flags)


def material_table(found: LineFindings, file: str | None) -> Table | None:
    """What was measured of the material pairs of the lines, and under which conditions; None where no line has one.

    Parameters
    ----------
    file : of pairs beside those of the study.
    """
    pairs = pairs_of_lines(found)
    if not pairs:
        return None
    head = [
        *("material pair", "lines", "source", "impulses, 1/mm", "friction, static", "kinetic", "decay, mm/s"),
        *("normal force, N", "speed, mm/s", "temperature, °C", "humidity, %"),
    ]
    rows = []
    for name, p in pairs.items():
        conditions = (p.normal_force, p.speed, p.temperature, p.humidity)
        rows.append(
            [
                name,
                ", ".join(line.name for line in found.lines if line.material == name),
                p.source,
                f"{number(p.impulse_rate_min, 3)} to {number(p.impulse_rate_max, 3)}",
                *(number(x, 3) for x in (p.friction_static, p.friction_kinetic, p.friction_decay, *conditions)),
            ]
        )
    note = "As measured; the last four columns are the conditions of the measurement."
    return Table(head, rows, text_columns=3, note=f"{note} Pairs of {file} and of the study." if file else note)


def _both(row: LineRow, model: Mesh) -> list[str]:
    first = row.linear or row.contact
    assert first is not None
    return [
        row.line.name,
        NONE if row.outcome is None else OUTCOMES[row.outcome],
        number(row.points),
        number(first.gap, 3),
        _tolerance(row, first),
        *_pair(row, lambda f: number(f.closing, 3)),
        *_pair(row, lambda f: number(f.margin, 3)),
        *_pair(row, lambda f: number(f.margin_percentile, 3)),
        model.nodes.label(first.node_idx),
        *_pair(row, lambda f: number(f.in_plane, 3)),
        *_pair(row, lambda f: f.squeak or NONE),
    ]


def _tolerance(row: LineRow, first: Figures) -> str:
    """What scatter may take of the worst point's gap, and the table and side that say so."""
    told = number(first.tolerance, 3)
    return f"{told} ({row.line.tolerance})" if row.line.tolerance else told


def _pair(row: LineRow, text: Callable[[Figures], str]) -> list[str]:
    return [NONE if f is None else text(f) for f in (row.linear, row.contact)]
