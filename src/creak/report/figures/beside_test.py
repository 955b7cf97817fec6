"""What was measured over what was computed: MAC, frequency response functions, time histories, one at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.formats.measured.modes import QUANTITIES
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line, stacked
from creak.report.figures.run import Figure, mac_heat
from creak.report.words.text import fixed, number
from creak.studies.findings.beside_records import RecordFits
from creak.studies.models.frfs import FrfFit, FrfPair
from creak.verify.mode_fit import ModeFit

MOST = 24
"""Functions that are drawn, those that fit worst, or channels."""
RECORDS = 620
"""Height of courses and spectra."""
AXES: tuple[dict[str, Any], ...] = (
    {},
    {"title": {"text": "phase, degrees", "standoff": 8}, "range": [-190, 190], "dtick": 90},
    {"title": {"text": "coherence", "standoff": 8}, "range": [0.0, 1.05]},
)
CAPTION = "Magnitude, phase in degrees{coherence}. The list chooses the function, the one that fits worst first."


def frf_figure(found: FrfFit) -> tuple[Figure, list[tuple[str, str]]]:
    """Magnitude and phase of the functions that fit worst, coherence where one has it; and what to choose from: name
    and title of the first axis of each, whose traces have its number as their `meta`."""
    order = sorted(range(len(found.pairs)), key=lambda k: p.frac if np.isfinite((p := found.pairs[k]).frac) else -1.0)
    shown = [found.pairs[k] for k in order[:MOST]]
    reduced = [found.reduced[k].model if found.reduced else None for k in order[:MOST]]
    panels = 3 if any(p.measured.coherence is not None for p in shown) else 2
    height = 130 + 210 * panels
    layout = base_layout(height, legend=True)
    layout["xaxis"] = axis("frequency, Hz", anchor=f"y{panels}")
    for row in range(panels):
        layout["yaxis" + (str(row + 1) if row else "")] = axis("", domain=stacked(row, panels)) | AXES[row]
    data: list[Trace] = []
    for k, (p, small) in enumerate(zip(shown, reduced, strict=True)):
        data += [trace | {"visible": k == 0, "meta": k} for trace in _traces(p, small)]
    layout["yaxis"]["title"]["text"] = _title(shown[0])
    caption = CAPTION.format(coherence="" if panels == 2 else ", coherence of the test")
    if len(shown) < len(found.pairs):
        caption += f" {len(shown)} of {number(len(found.pairs))} are drawn; the table has all."
    choices = [(f"{p.measured.name}, FRAC {fixed(p.frac, 3)}", _title(p)) for p in shown]
    return Figure({"data": data, "layout": layout}, caption, height), choices


def _title(p: FrfPair) -> str:
    return f"dB re 1 {QUANTITIES[p.measured.order][1]}".replace("^2", "²")


def _traces(p: FrfPair, reduced: ComplexArray | None) -> list[Trace]:
    f = p.measured.freq
    sides = [(p.measured.values, "test", palette.INK, 1.4)]
    if reduced is None:
        sides.append((p.model, "model", palette.REDUCED, 2.0))
    else:
        sides += [(p.model, "unreduced", palette.REFERENCE, 2.0), (reduced, "reduced", palette.REDUCED, 1.4)]
    traces = []
    for values, name, colour, width in sides:
        traces.append(line(f, _decibels(np.abs(values)), name, colour, width=width))
        traces.append(line(f, np.degrees(np.angle(values)), name, colour, row=1, width=width, first=False))
    if p.measured.coherence is not None:
        traces.append(line(f, p.measured.coherence, "test", palette.INK, row=2, first=False))
    return traces


def _decibels(size: FloatArray) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.where(size > 0.0, size, np.nan)))


def mac_figure(found: ModeFit) -> Figure:
    """All measured modes against all of the model."""
    spec, height = mac_heat(
        found.mac,
        ("test", "model"),
        ("measured mode", "mode of the model"),
        (found.frequencies_test, found.frequencies_model),
    )
    caption = (
        "Modal assurance criterion between all modes, at the sensors and along their directions. Modes of the model "
        "count from its first, rigid ones included."
    )
    return Figure(spec, caption, height)


def auto_figure(found: ModeFit) -> Figure:
    """The measured modes against each other."""
    test = found.frequencies_test
    spec, height = mac_heat(found.auto_mac_test, ("test", "test"), ("measured mode", "measured mode"), (test, test))
    caption = (
        "The measured modes against each other: what is dark off the diagonal are modes that the sensors cannot tell "
        "apart, whose partner is then chosen by frequency."
    )
    return Figure(spec, caption, height)


def records_figure(found: RecordFits) -> tuple[Figure, list[tuple[str, str]]]:
    """Course in time above, amplitude spectrum below, contacts as bars beneath the course; and what to choose from, as
    of `frf_figure`."""
    layout = base_layout(RECORDS, legend=True)
    first = found.pairs[0]
    layout["xaxis"] = axis("time, s")
    layout["yaxis"] = axis(f"{first.name}, {first.unit}", domain=[0.56, 1.0])
    layout["xaxis2"] = axis("frequency, Hz", anchor="y2")
    layout["yaxis2"] = axis("amplitude", domain=[0.0, 0.38], anchor="x2", type="log")
    data: list[Trace] = []
    for k, p in enumerate(found.pairs[:MOST]):
        sides = (
            (p.fit.test, p.fit.spectra[0], "test", palette.INK),
            (p.fit.model, p.fit.spectra[1], "run", palette.REDUCED),
        )
        for which, (values, spectrum, name, colour) in enumerate(sides):
            traces = [line(p.fit.time, values, name, colour)]
            traces.append(line(p.fit.freq[1:], spectrum[1:], name, colour, row=1, first=False) | {"xaxis": "x2"})
            if p.fit.events is not None and p.name.endswith("force"):
                traces.append(_contacts(p.fit.events[which], which, p.fit.test.max(), name, colour))
            data += [trace | {"visible": k == 0, "meta": k} for trace in traces]
    caption = (
        "Measured course over the computed one, and their amplitude spectra (Hann window over the time that both have)."
    )
    if any(p.fit.events is not None for p in found.pairs):
        caption += " Bars beneath a force are its contacts, in the test above, in the run below."
    choices = [(p.name, f"{p.name}, {p.unit}") for p in found.pairs[:MOST]]
    return Figure({"data": data, "layout": layout}, caption, RECORDS), choices


def _contacts(events: tuple[tuple[float, float], ...], which: int, top: float, name: str, colour: str) -> Trace:
    """A bar for each contact, below zero."""
    y = -(0.06 + 0.05 * which) * float(top)
    x = [t for start, end in events for t in (start, end, None)]
    return {
        "type": "scatter",
        "mode": "lines",
        "x": x,
        "y": [None if t is None else y for t in x],
        "name": name,
        "legendgroup": name,
        "showlegend": False,
        "line": {"color": colour, "width": 5},
        "hovertemplate": "contact from or to %{x:.4f} s<extra></extra>",
    }
