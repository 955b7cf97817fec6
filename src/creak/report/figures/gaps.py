"""Figures of the gaps: over time, how close every channel came in the linear pre-check, and the E-lines over the
model."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.units import Units
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line, plain, stacked
from creak.report.figures.run import MOST_ROWS, Figure, groups_by_force
from creak.report.figures.view import Surface, front, outward
from creak.report.words.text import number
from creak.studies.findings.elines import BOTH, FALSE_ALARM, MISS, NEITHER, margins, risks
from creak.studies.findings.tree import Findings
from creak.studies.run.elines import LineFindings
from creak.verify.intervals import in_window

MOST_OUTLINE = 5000
"""Edges of the outline behind the map."""
OPEN_GAPS = 4.0
"""Gaps wider than this many clearances are cut off."""


def gap_figure(result: Findings, units: Units) -> Figure:
    """Smallest gap of each contact over time, both runs; below zero the parts penetrate."""
    groups = groups_by_force(result) or list(result.contacts)
    if not groups or not result.runs:
        return Figure(None, "No gaps: the study has no channel that can close.")
    shown = groups[:MOST_ROWS]
    height = 130 + 150 * len(shown)
    layout = base_layout(height, legend=True)
    layout["xaxis"] = axis("time, s", anchor=f"y{len(shown) if len(shown) > 1 else ''}", range=list(result.window))
    data: list[Trace] = []
    for row, group in enumerate(shown):
        traces, low, high = _gap_row(result, group, row)
        data += traces
        pad = 0.08 * (high - low)
        name = "yaxis" + (str(row + 1) if row else "")
        layout[name] = axis(
            f"{group}, {units.length}",
            domain=stacked(row, len(shown)),
            zeroline=True,
            zerolinecolor=palette.MUTED,
            range=[low - pad, high + pad],
        )
    caption = (
        "Smallest gap of the channels of the contact at each instant. At zero the parts touch; how far it falls below "
        "is how far the contact springs give way."
    )
    if not groups_by_force(result):
        caption += " Nothing touched in the verification window."
    return Figure({"data": data, "layout": layout}, caption, height)


def _gap_row(result: Findings, group: str, row: int) -> tuple[list[Trace], float, float]:
    channels = [j for j, g in enumerate(result.gaps.group) if g == group]
    contact = result.contacts.index(group)
    traces, low, high = [], 0.0, 0.0
    top = OPEN_GAPS * float(result.gaps.gap0[channels].mean())
    for run in (n for n in palette.DRAWN if n in result.runs):
        found = result.runs[run]
        inside = in_window(found.history.time, result.window)
        time, gap = found.time[inside], found.closest[inside, contact].astype(np.float64)
        if gap.size:
            low, high = min(low, float(gap.min())), max(high, float(gap.max()))
        width = 3.2 if run == "reference" and len(result.runs) > 1 else 1.4
        traces.append(line(time, gap, palette.RUN_NAMES[run], palette.RUNS[run], row=row, width=width, first=row == 0))
    return traces, low, min(high, top) if top > 0.0 else (high or 1.0)


def precheck_figure(result: Findings, surface: Surface | None, units: Units) -> Figure:
    """Every contact channel where it lies, coloured by the smallest gap of the linear run; those kept are ringed."""
    setup, smallest = result.setup, result.linear_gaps
    if smallest is None:
        return Figure(None, _no_map(result))
    xyz = setup.model.nodes.coords
    view = front(xyz, outward(setup.contacts, xyz))
    at = view.flat(xyz[setup.contacts.nodes_idx])
    table = setup.study.config.precheck
    kept = smallest <= table.near(setup.contacts.gap0)
    layout, data = map_of(at if surface is None else view.flat(xyz[surface.nodes_idx]), surface, 20)
    data.append(_dots(result, at, smallest, kept, units))
    caption = (
        "How close every channel comes in a run without contact, motion that grows from period to period taken on to "
        "where it ends. Ringed: kept for the runs with contact, because the gap falls to the margin of "
        f"{table.words(units.length)} or less; the others were left out. A gap below zero "
        "means that the parts would pass through each other there."
    )
    return Figure({"data": data, "layout": layout}, caption, 520)


def map_of(every: FloatArray, surface: Surface | None, top: int) -> tuple[dict[str, Any], list[Trace]]:
    """Layout of a map of the model, with `top` pixels above it, and the outline of its surface at `every` (n, 2)."""
    layout = base_layout(520)
    bare = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False, "constrain": "domain"}
    layout["xaxis"] = axis("", scaleanchor="y", range=_span(every[:, 0]), **bare)
    layout["yaxis"] = axis("", range=_span(every[:, 1]), **bare)
    layout["margin"] = {"l": 8, "r": 8, "t": top, "b": 8}
    return layout, [] if surface is None else [_outline(every, surface)]


def _span(values: FloatArray) -> list[float]:
    """A little more than the values, thin ones with some air."""
    low, high = float(values.min()), float(values.max())
    pad = 0.04 * (high - low) or 1.0
    return [low - pad, high + pad]


def _no_map(result: Findings) -> str:
    if not result.setup.contacts.m:
        return "No map: the study has no contact pairs."
    if not result.setup.study.config.precheck.enabled:
        return "No map: the pre-check was switched off."
    return "No map: only contact holds the structure, so there is no linear run without it."


def _outline(flat: FloatArray, surface: Surface) -> Trace:
    edges = surface.outline
    edges = edges[:: -(-len(edges) // MOST_OUTLINE)] if len(edges) else edges
    gaps = np.full((len(edges), 1), np.nan)
    x, y = (np.concatenate([flat[edges, k], gaps], axis=1).ravel() for k in (0, 1))
    return {
        "type": "scatter",
        "mode": "lines",
        "x": plain(x),
        "y": plain(y),
        "line": {"color": palette.GRID, "width": 1},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _dots(result: Findings, at: FloatArray, smallest: FloatArray, kept: Any, units: Units) -> Trace:
    c, nodes = result.setup.contacts, result.setup.model.nodes
    order = np.argsort(-smallest, kind="stable")
    words = [
        f"{c.group[j]}, node {nodes.label(int(c.nodes_idx[j]))}<br>gap at rest {number(float(c.gap0[j]), 3)}, "
        f"smallest {number(float(smallest[j]), 3)} {units.length}"
        for j in order.tolist()
    ]
    low, high = palette.limits(smallest, 95.0)
    return {
        "type": "scatter",
        "mode": "markers",
        "x": plain(at[order, 0]),
        "y": plain(at[order, 1]),
        "text": words,
        "hovertemplate": "%{text}<extra></extra>",
        "showlegend": False,
        "marker": {
            "color": plain(smallest[order]),
            "size": 8,
            "cmin": low,
            "cmax": high,
            "colorscale": [[0.0, "#4a0d42"], [0.35, "#b5173a"], [0.65, "#e8743b"], [1.0, "#f7c948"]],
            "line": {"color": palette.INK, "width": [1.6 if k else 0.0 for k in kept[order].tolist()]},
            "colorbar": {
                "title": {"text": f"smallest gap, {units.length}", "side": "right"},
                "thickness": 12,
                "len": 0.9,
                "outlinewidth": 0,
            },
        },
    }


COLOURS = {BOTH: "#b5173a", FALSE_ALARM: "#f7c948", MISS: "#7b3fbf", NEITHER: "#8fa3b5"}
NAMES = {
    BOTH: "both say that they can touch",
    FALSE_ALARM: "false alarm: linear alone",
    MISS: "missed: with contact alone",
    NEITHER: "both say that they stay apart",
}
SHAPES = {BOTH: "circle", FALSE_ALARM: "triangle-up", MISS: "diamond", NEITHER: "circle-open"}


def eline_figure(result: Findings, surface: Surface | None, units: Units) -> Figure:
    """Every point where it lies, by what the linear run and the one with contact say of it."""
    found, setup = result.elines, result.setup
    if found is None:
        return Figure(None, "No picture: the study has no E-lines.")
    linear, contact = risks(found)
    if linear is None and contact is None:
        return Figure(None, f"No picture: {found.why}.")
    first = linear if linear is not None else contact
    assert first is not None
    second = contact if contact is not None else first
    xyz = setup.model.nodes.coords
    view = front(xyz, outward(setup.contacts, xyz))
    at = view.flat(found.position)
    layout, data = map_of(at if surface is None else view.flat(xyz[surface.nodes_idx]), surface, 40)
    layout["showlegend"] = True
    groups = {
        NEITHER: ~first & ~second,
        FALSE_ALARM: first & ~second,
        BOTH: first & second,
        MISS: ~first & second,
    }
    data += [_line_dots(result, found, at, np.flatnonzero(g), word, units) for word, g in groups.items() if g.any()]
    caption = (
        "Each point of each line, seen from the front. A point can touch where its gap less tolerance and closing "
        "displacement is zero or less, or where it pressed."
    )
    if linear is None or contact is None:
        caption += f" One run alone: {found.why or 'there is no other'}."
    return Figure({"data": data, "layout": layout}, caption, 520)


def _line_dots(result: Findings, found: LineFindings, at: FloatArray, mine: IntArray, word: str, units: Units) -> Trace:
    nodes = result.setup.model.nodes
    measures = {"linear": found.linear, "with contact": found.contact}
    closest = {name: margins(found, m.closing) for name, m in measures.items() if m is not None}
    words = []
    for i in mine.tolist():
        margin = ", ".join(f"{name} {number(float(m[i]), 3)}" for name, m in closest.items())
        line = found.lines[int(found.line_of[i])].name
        gap = number(float(found.gap0[i]), 3)
        node = nodes.label(int(found.nodes_idx[i]))
        words.append(f"{line}, node {node}<br>gap at rest {gap}; margin {margin} {units.length}")
    return {
        "type": "scatter",
        "mode": "markers",
        "name": NAMES[word],
        "showlegend": True,
        "x": plain(at[mine, 0]),
        "y": plain(at[mine, 1]),
        "text": words,
        "hovertemplate": "%{text}<extra></extra>",
        "marker": {
            "color": COLOURS[word],
            "symbol": SHAPES[word],
            "size": 8 if word == NEITHER else 10,
            "line": {"color": palette.INK, "width": 0 if word == NEITHER else 0.6},
        },
    }
