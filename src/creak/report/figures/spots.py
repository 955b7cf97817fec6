"""The first picture of trust: single events of the reduced run over what the unreduced model makes of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.model.units import Units
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line
from creak.report.figures.run import Figure
from creak.report.words.text import number
from creak.studies.converge.settling import SETTLED
from creak.studies.findings.tree import Findings
from creak.verify.unreduced import Spot, Structure

SHOWN = {"impulse": ("impulse", "circle"), "force": ("force", "diamond"), "closing_speed": ("closing speed", "square")}
"""Figures drawn -> name and mark."""
HEIGHT = 460


def spots_figure(result: Findings, units: Units) -> Figure:
    """Figures of each checked event, reduced against unreduced, as shares of the largest of their kind."""
    structure = None if result.convergence is None else result.convergence.structure
    if structure is None:
        return Figure(None, "No event was held against the unreduced model.")
    spots = [s for s in (*structure.spots, *structure.run) if s.unreduced is not None]
    if not spots:
        return Figure(None, f"No event was held against the unreduced model: {structure.why_not or 'it has none'}.")
    unit = {"impulse": units.impulse, "force": units.force, "closing_speed": units.speed}
    data: list[Trace] = _bar()
    for (name, (word, mark)), colour in zip(SHOWN.items(), palette.MARKS, strict=False):
        known = [(s, s.unreduced[name], s.reduced[name]) for s in spots if s.unreduced and name in s.unreduced]
        largest = max((max(a, b) for _, a, b in known), default=0.0)
        if largest > 0.0:
            data.append(_points(known, largest, f"{word}, of {number(largest, 3)} {unit[name]}", mark, colour))
    layout = base_layout(HEIGHT, legend=True)
    layout["xaxis"] = axis("unreduced model, share of the largest", range=[0.0, 1.06])
    layout["yaxis"] = axis("reduced model", range=[0.0, 1.06])
    return Figure({"data": data, "layout": layout}, _caption(structure), HEIGHT)


def _bar() -> list[Trace]:
    """The line of equal figures, and both edges of what counts as settled."""
    ends = np.array([0.0, 1.06])
    same = line(ends, ends, "the same", palette.MUTED, width=1.0)
    edges = [
        line(
            ends, ends * (1.0 + side * SETTLED), f"within {100 * SETTLED:g} %", palette.MUTED, width=0.8, first=side > 0
        )
        for side in (1, -1)
    ]
    for edge in edges:
        edge["line"]["dash"] = "dot"
    return [same, *edges]


def _points(
    known: list[tuple[Spot, float, float]], largest: float, name: str, mark: str, colour: str
) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [a / largest for _, a, _ in known],
        "y": [b / largest for _, _, b in known],
        "name": name,
        "marker": {"color": colour, "symbol": mark, "size": 9},
        "text": [f"{s.event.group}, {s.event.t_start:.4f} s" for s, _, _ in known],
        "hovertemplate": "%{text}<br>unreduced %{x:.4f}, reduced %{y:.4f}<extra></extra>",
    }


def _caption(structure: Structure) -> str:
    if not structure.spots:
        return "Events that the runs of both models share."
    steps = " Here it has all modes, so what differs is the error of the unreduced model's own contact steps."
    return (
        "The unreduced model took over the motion of the reduced one shortly before each of these events (the hardest "
        "of each place, and some drawn at random) and went through it by itself. A point on the line is an event that "
        "the reduction does not change." + (steps if structure.complete else "")
    )
