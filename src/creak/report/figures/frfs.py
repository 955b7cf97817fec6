"""Measured frequency response functions over those of the model: magnitude, phase and coherence, one at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.formats.measured.modes import QUANTITIES
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line, stacked
from creak.report.figures.run import Figure
from creak.report.words.text import fixed, number
from creak.studies.models.frfs import FrfComparison, FrfPair

MOST = 24
"""Functions that are drawn; those that fit worst."""
AXES: tuple[dict[str, Any], ...] = (
    {},
    {"title": {"text": "phase, degrees", "standoff": 8}, "range": [-190, 190], "dtick": 90},
    {"title": {"text": "coherence", "standoff": 8}, "range": [0.0, 1.05]},
)
CAPTION = "Magnitude, phase in degrees{coherence}. The list chooses the function, the one that fits worst first."


def frf_figure(found: FrfComparison) -> tuple[Figure, list[tuple[str, str]]]:
    """Magnitude and phase of the functions that fit worst, coherence where one has it; and what to choose from: name
    and title of the first axis of each, whose traces have its number as their `meta`."""
    shown = sorted(found.pairs, key=lambda p: p.frac if np.isfinite(p.frac) else -1.0)[:MOST]
    panels = 3 if any(p.measured.coherence is not None for p in shown) else 2
    height = 130 + 210 * panels
    layout = base_layout(height, legend=True)
    layout["xaxis"] = axis("frequency, Hz", anchor=f"y{panels}")
    for row in range(panels):
        layout["yaxis" + (str(row + 1) if row else "")] = axis("", domain=stacked(row, panels)) | AXES[row]
    data: list[Trace] = []
    for k, p in enumerate(shown):
        data += [trace | {"visible": k == 0, "meta": k} for trace in _traces(p)]
    layout["yaxis"]["title"]["text"] = _title(shown[0])
    caption = CAPTION.format(coherence="" if panels == 2 else ", coherence of the test")
    if len(shown) < len(found.pairs):
        caption += f" {len(shown)} of {number(len(found.pairs))} are drawn; the table has all."
    choices = [(f"{p.measured.name}, FRAC {fixed(p.frac, 3)}", _title(p)) for p in shown]
    return Figure({"data": data, "layout": layout}, caption, height), choices


def _title(p: FrfPair) -> str:
    return f"dB re 1 {QUANTITIES[p.measured.order][1]}".replace("^2", "²")


def _traces(p: FrfPair) -> list[Trace]:
    f = p.measured.freq
    sides = ((p.measured.values, "test", palette.INK, 1.4), (p.model, "model", palette.REDUCED, 2.0))
    traces = []
    for values, name, colour, width in sides:
        traces.append(line(f, _decibels(np.abs(values)), name, colour, width=width))
        traces.append(line(f, np.degrees(np.angle(values)), name, colour, row=1, width=width, first=False))
    if p.measured.coherence is not None:
        traces.append(line(f, p.measured.coherence, "test", palette.INK, row=2, first=False))
    return traces


def _decibels(size: FloatArray) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.where(size > 0.0, size, np.nan)))
