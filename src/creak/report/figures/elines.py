"""The E-lines over the model: where linear says that parts can touch, and where they do with contact."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.units import Units
from creak.report.figures import palette
from creak.report.figures.axes import Trace, plain
from creak.report.figures.gaps import map_of
from creak.report.figures.run import Figure
from creak.report.figures.surface import Surface
from creak.report.figures.view import front, outward
from creak.report.words.text import number
from creak.studies.findings.elines import BOTH, FALSE_ALARM, MISS, NEITHER, margins, risks
from creak.studies.findings.tree import Findings
from creak.studies.run.elines import LineFindings

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
    data += [_dots(result, found, at, np.flatnonzero(g), word, units) for word, g in groups.items() if g.any()]
    caption = (
        "Each point of each line, seen from the front. A point can touch where its gap less tolerance and closing "
        "displacement is zero or less, or where it pressed."
    )
    if linear is None or contact is None:
        caption += f" One run alone: {found.why or 'there is no other'}."
    return Figure({"data": data, "layout": layout}, caption, 520)


def _dots(result: Findings, found: LineFindings, at: FloatArray, mine: IntArray, word: str, units: Units) -> Trace:
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
