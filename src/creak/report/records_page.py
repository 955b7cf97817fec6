"""The page of `creak compare RESULTS TEST`: measured courses over computed ones, one channel at a time."""

from __future__ import annotations

from pathlib import Path

from creak.formats.complete_file import write_text
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line
from creak.report.figures.run import Figure
from creak.report.html import file_parts, script_json
from creak.report.tables.run import Table
from creak.report.templates import page_templates
from creak.report.words.records import record_rows, record_sentence
from creak.studies.findings.beside_records import RecordComparison
from creak.version import version

MOST = 24
"""Channels that are drawn."""
HEIGHT = 620


def write_records(found: RecordComparison, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    rows, drawn = record_rows(found), {"records": _figure(found)}
    text = (
        page_templates("creak.report")
        .get_template("records.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{found.results.name} beside {found.test.name}",
            sentence=record_sentence(found),
            channels=Table(rows[0], rows[1:]),
            choices=[(p.name, _title(p.name, p.unit)) for p in found.pairs[:MOST]],
            notes=[f"{note[:1].upper()}{note[1:]}." for note in found.notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
        )
    )
    write_text(path, text)


def _figure(found: RecordComparison) -> Figure:
    """Course in time above, amplitude spectrum below; contacts as bars beneath the course."""
    layout = base_layout(HEIGHT, legend=True)
    first = found.pairs[0]
    layout["xaxis"] = axis("time, s")
    layout["yaxis"] = axis(_title(first.name, first.unit), domain=[0.56, 1.0])
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
    return Figure({"data": data, "layout": layout}, caption, HEIGHT)


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


def _title(name: str, unit: str) -> str:
    return f"{name}, {unit}"
