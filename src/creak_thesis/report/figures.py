"""Figures of the thesis page as plotly specifications."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.report_tools import Trace, axis, base_layout, fixed, line, palette, plain, stacked
from creak_thesis.arrays import FloatArray
from creak_thesis.outcome import EventRow
from creak_thesis.plan import LOADS, RATTLING
from creak_thesis.record import RecordStudy
from creak_thesis.report.blocks import FigureBlock
from creak_thesis.report.facts import Facts, against, flange_events, milliseconds

BAR = "#8a94a0"
"""Reduced model, as in the thesis."""
SERIES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#8c6d1f", "#5b6570")
AXIS_NAMES = ("x", "y", "z")
MOST_LABELLED = 3
"""Bars of a group that carry their value."""
BAR_WIDTH = 7.0
"""ms"""
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross")


@dataclass(frozen=True)
class Panel:
    """One panel of contact events: bars and markers."""

    title: str
    bars: Sequence[EventRow]
    markers: Sequence[EventRow]


def events_figure(title: str, panels: Sequence[Panel], names: tuple[str, str], caption: str) -> FigureBlock:
    """Contact force over time in the last period: grey bars of one model, black markers of the other.

    Parameters
    ----------
    names : of the bars and of the markers.
    """
    if not panels:
        return FigureBlock(title, None, caption)
    height = 110 + 170 * len(panels)
    layout = base_layout(height, legend=True)
    layout["margin"] |= {"t": 62}
    layout["annotations"] = []
    last = len(panels) if len(panels) > 1 else ""
    layout["xaxis"] = axis("time in the last period, ms", anchor=f"y{last}", range=[0, 1000], dtick=100)
    data: list[Trace] = []
    top = 1.12 * max((e.force for p in panels for e in (*p.bars, *p.markers)), default=1.0)
    for row, panel in enumerate(panels):
        key = f"yaxis{row + 1}" if row else "yaxis"
        layout[key] = axis("force, N", domain=stacked(row, len(panels)), range=[0.0, top], nticks=5)
        layout["annotations"].append(_label(panel.title, row))
        data += [_bars(panel.bars, names[0], row), _markers(panel.markers, names[1], row)]
    return FigureBlock(title, {"data": data, "layout": layout}, caption, height)


def _bars(events: Sequence[EventRow], name: str, row: int) -> Trace:
    return {
        "type": "bar",
        "x": [round(milliseconds(e), 2) for e in events],
        "y": _forces(events),
        "width": [BAR_WIDTH] * len(events),
        "marker": {"color": BAR},
        "name": name,
        "legendgroup": name,
        "showlegend": row == 0,
        "yaxis": f"y{row + 1}" if row else "y",
        "hovertemplate": "%{x:.1f} ms: %{y:.3g} N",
    }


def _markers(events: Sequence[EventRow], name: str, row: int) -> Trace:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [round(milliseconds(e), 2) for e in events],
        "y": _forces(events),
        "marker": {"color": palette.INK, "symbol": "x-thin", "size": 9, "line": {"width": 2, "color": palette.INK}},
        "name": name,
        "legendgroup": name,
        "showlegend": row == 0,
        "yaxis": f"y{row + 1}" if row else "y",
        "cliponaxis": False,
        "hovertemplate": "%{x:.1f} ms: %{y:.3g} N",
    }


def _forces(events: Sequence[EventRow]) -> list[float | None]:
    return plain(np.array([e.force for e in events], dtype=np.float64))


def _label(text: str, row: int) -> dict[str, Any]:
    return {
        "text": f"<b>{text}</b>",
        "xref": "paper",
        "x": 0.0,
        "xanchor": "left",
        "showarrow": False,
        "yref": f"y{row + 1 if row else ''} domain",
        "y": 1.0,
        "yanchor": "bottom",
        "font": {"size": 13},
    }


def events_of(facts: Facts, title: str, cases: Sequence[tuple[str, str]], caption: str) -> FigureBlock:
    """Events of reduced models against their references; `cases` are (case, load) from top to bottom."""
    panels = []
    for name, load in cases:
        own, reference = facts.load(name, load), facts.load(against(name), load)
        if own is not None and reference is not None:
            panels.append(Panel(f"{name}, {load}", flange_events(own), flange_events(reference)))
    if not panels:
        missing = "; ".join(dict.fromkeys(f"{n}: {facts.why_not(n) or 'no run'}" for n, _ in cases))
        return FigureBlock(title, None, f"No contact events to show ({missing}).")
    return events_figure(title, panels, ("reduced model", "unreduced model"), caption)


def fits_figure(facts: Facts, title: str, cases: Sequence[str], caption: str) -> FigureBlock:
    """NRMSE of the frequency responses as bars: a group for each load, a bar for each case."""
    shown = [c for c in cases if any(facts.fit(c, load) is not None for load in LOADS)]
    if not shown:
        return FigureBlock(title, None, "No frequency responses to compare: the cases were not run.")
    layout = base_layout(320, legend=True)
    layout["xaxis"] = axis("load", type="category")
    layout["yaxis"] = axis("NRMSE fit", range=_fit_range([facts.fit(c, x) for c in shown for x in LOADS]))
    layout |= {"barmode": "group", "bargap": 0.25}
    data: list[Trace] = [
        {
            "type": "bar",
            "name": c,
            "x": list(LOADS),
            "marker": {"color": colour},
            "y": [facts.fit(c, load) for load in LOADS],
            "text": [fixed(facts.fit(c, load), 4) if len(shown) <= MOST_LABELLED else "" for load in LOADS],
            "textposition": "outside",
            "cliponaxis": False,
            "hovertemplate": f"{c}, %{{x}}: %{{y:.4f}}<extra></extra>",
        }
        for c, colour in zip(shown, _colours(len(shown)), strict=True)
    ]
    return FigureBlock(title, {"data": data, "layout": layout}, f"{caption} The axis does not begin at zero.", 320)


def _colours(count: int) -> list[str]:
    """One colour for each of `count` series: the palette, or a ramp from blue to red where it is too short."""
    if count <= len(SERIES):
        return list(SERIES[:count])
    return [f"hsl({220.0 - 220.0 * k / (count - 1):.0f}, 55%, 45%)" for k in range(count)]


def range_figure(facts: Facts, title: str, names: Mapping[int, str], caption: str) -> FigureBlock:
    """NRMSE over the frequency up to which fixed-interface modes are kept, a line for each load."""
    shown = {f: c for f, c in sorted(names.items()) if facts.case(c) is not None}
    if not shown:
        return FigureBlock(title, None, "No frequency responses to compare: the cases were not run.")
    layout = base_layout(360, legend=True)
    layout["xaxis"] = axis("fixed-interface modes kept up to, Hz", rangemode="tozero")
    values = [facts.fit(c, load) for c in shown.values() for load in LOADS]
    layout["yaxis"] = axis("NRMSE fit", range=_fit_range(values))
    data = []
    for k, load in enumerate(LOADS):
        y = np.array([np.nan if (v := facts.fit(c, load)) is None else v for c in shown.values()])
        trace = line(np.array(list(shown), dtype=np.float64), y, load, SERIES[k])
        marker = {"color": SERIES[k], "size": 8, "symbol": SYMBOLS[k]}
        data.append(trace | {"mode": "lines+markers", "marker": marker})
    return FigureBlock(title, {"data": data, "layout": layout}, caption, 360)


def _fit_range(values: Sequence[float | None]) -> list[float]:
    """A range that ends at 1 and shows the lowest value; far below zero it is cut."""
    known = [v for v in values if v is not None]
    low = max(min(known, default=0.0), -0.5)
    span = max(1.0 - low, 0.02)
    return [low - 0.15 * span, 1.0 + 0.04 * span]


def mac_figure(facts: Facts, title: str, cases: Sequence[str], caption: str) -> FigureBlock:
    """MAC matrices side by side."""
    shown = [c for c in cases if (found := facts.case(c)) is not None and found.mac_matrix]
    if not shown:
        return FigureBlock(title, None, "No MAC: the cases were not run.")
    layout = base_layout(430)
    layout["annotations"] = []
    data: list[Trace] = []
    share = 1.0 / len(shown)
    for k, name in enumerate(shown):
        found = facts.case(name)
        assert found is not None
        z = np.nan_to_num(np.array(found.mac_matrix))
        suffix = str(k + 1) if k else ""
        domain = [k * share + (0.035 if k else 0.0), (k + 1) * share - (0.035 if k + 1 < len(shown) else 0.0)]
        layout[f"xaxis{suffix}"] = axis("mode of the reduced model", domain=domain, anchor=f"y{suffix}", showgrid=False)
        layout[f"yaxis{suffix}"] = axis(
            "mode of the unreduced model" if k == 0 else "", anchor=f"x{suffix}", showgrid=False
        )
        layout["annotations"].append(
            _label(name, 0)
            | {
                "xref": f"x{suffix} domain",
                "yref": f"y{suffix} domain",
            }
        )
        data.append(
            {
                "type": "heatmap",
                "z": np.round(z, 3).tolist(),
                "x": list(range(1, z.shape[1] + 1)),
                "y": list(range(1, z.shape[0] + 1)),
                "zmin": 0,
                "zmax": 1,
                "xaxis": f"x{suffix}",
                "yaxis": f"y{suffix}",
                "colorscale": [[0.0, "#f3f6f9"], [0.3, "#b9d3e8"], [0.7, "#4a90c2"], [1.0, "#08306b"]],
                "showscale": k == len(shown) - 1,
                "xgap": 1,
                "ygap": 1,
                "colorbar": {"title": {"text": "MAC"}, "thickness": 12, "outlinewidth": 0},
                "hovertemplate": "unreduced %{y}, reduced %{x}: MAC %{z:.3f}<extra></extra>",
            }
        )
    return FigureBlock(title, {"data": data, "layout": layout}, caption, 430)


def diagonal_figure(facts: Facts, title: str, cases: Sequence[str], caption: str) -> FigureBlock:
    """MAC of the paired modes over the number of the mode, a line for each case."""
    shown = [c for c in cases if (found := facts.case(c)) is not None and found.mac]
    if not shown:
        return FigureBlock(title, None, "No MAC: the cases were not run.")
    layout = base_layout(340, legend=True)
    layout["xaxis"] = axis("mode of the unreduced model")
    layout["yaxis"] = axis("MAC", range=[-0.03, 1.05])
    data: list[Trace] = []
    for k, name in enumerate(shown):
        found = facts.case(name)
        assert found is not None
        mac = np.array(found.mac)
        trace = line(np.arange(1.0, mac.size + 1), mac, name, SERIES[k % len(SERIES)])
        marker = {"size": 6, "symbol": SYMBOLS[k % len(SYMBOLS)], "color": SERIES[k % len(SERIES)]}
        data.append(trace | {"mode": "lines+markers", "marker": marker})
    return FigureBlock(title, {"data": data, "layout": layout}, caption, 340)


def spectra_figure(
    facts: Facts, title: str, name: str, load: str, axes: str, f_max: float, caption: str
) -> FigureBlock:
    """Relative displacement over frequency, root mean square over the pairs; one panel for each of `axes`."""
    own, reference = facts.load(name, load), facts.load(against(name), load)
    found = facts.case(name)
    if own is None or reference is None or found is None or not own.spectra or not reference.spectra:
        return FigureBlock(title, None, f"No frequency response ({name}: {facts.why_not(name) or 'no run'}).")
    freq = np.array(found.freq)
    keep = freq <= f_max
    height = 120 + 210 * len(axes)
    layout = base_layout(height, legend=True)
    layout["annotations"] = []
    last = len(axes) if len(axes) > 1 else ""
    layout["xaxis"] = axis("frequency, Hz", anchor=f"y{last}", range=[0.0, float(freq[keep].max(initial=1.0))])
    data: list[Trace] = []
    for row, letter in enumerate(axes):
        key = f"yaxis{row + 1}" if row else "yaxis"
        column = AXIS_NAMES.index(letter)
        values = [np.array(r.spectra)[keep, column] for r in (reference, own)]
        layout[key] = axis(
            f"{letter.upper()}, mm",
            domain=stacked(row, len(axes)),
            type="log",
            exponentformat="power",
            dtick=1,
            range=_decades(values),
        )
        layout["annotations"].append(_label(f"{name}, {load}, {letter.upper()}", row))
        for k, (who, v) in enumerate(zip(("reference", "reduced"), values, strict=True)):
            trace = line(
                freq[keep],
                np.where(v > 0.0, v, np.nan),
                palette.RUN_NAMES[who],
                palette.RUNS[who],
                row=row,
                width=(3.0, 1.4)[k],
                first=row == 0,
            )
            data.append(trace)
    return FigureBlock(title, {"data": data, "layout": layout}, caption, height)


def _decades(values: Sequence[FloatArray]) -> list[float]:
    known = np.concatenate(list(values))
    known = known[known > 0.0]
    if known.size == 0:
        return [-6.0, 0.0]
    high = float(np.log10(known.max())) + 0.3
    return [max(float(np.log10(known.min())) - 0.2, high - 6.0), high]


def cost_figure(
    title: str, names: Sequence[str], columns: Mapping[str, Sequence[float | None]], caption: str
) -> FigureBlock:
    """Cost over that of the reference as bars on a logarithmic axis; a column for each way of counting."""
    height = 160 + 34 * len(names) * max(1, len(columns)) // 2
    layout = base_layout(height, legend=True)
    layout["xaxis"] = axis("CPU time over that of the unreduced model", type="log", dtick=1, exponentformat="power")
    layout["yaxis"] = axis("", type="category", autorange="reversed")
    layout["shapes"] = [
        {
            "type": "line",
            "x0": 1,
            "x1": 1,
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "line": {"color": palette.INK, "width": 1.5, "dash": "dot"},
        }
    ]
    layout |= {"barmode": "group", "bargap": 0.3}
    data: list[Trace] = [
        {
            "type": "bar",
            "orientation": "h",
            "name": who,
            "y": list(names),
            "x": list(values),
            "marker": {"color": SERIES[k]},
            "hovertemplate": f"{who}, %{{y}}: %{{x:.3g}}<extra></extra>",
        }
        for k, (who, values) in enumerate(columns.items())
    ]
    return FigureBlock(title, {"data": data, "layout": layout}, caption, height)


def record_line(title: str, study: RecordStudy, values: FloatArray, unit: str, caption: str) -> FigureBlock:
    """Displacement over the whole record."""
    layout = base_layout(280)
    layout["xaxis"] = axis("time, s", range=[0.0, study.duration])
    layout["yaxis"] = axis(f"displacement, {unit}", zeroline=True)
    data = [line(study.time, values, "displacement", palette.REDUCED, width=1.0)]
    return FigureBlock(title, {"data": data, "layout": layout}, caption, 280)


def density_figure(title: str, study: RecordStudy, caption: str) -> FigureBlock:
    """Density of the measured acceleration over frequency, with the band that stands out of the noise."""
    layout = base_layout(300)
    layout["xaxis"] = axis("frequency, Hz", range=[0.0, float(study.freq.max())])
    layout["yaxis"] = axis("density, (mm/s²)²/Hz", type="log", exponentformat="power", dtick=2)
    layout["shapes"] = [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "x0": study.band[0],
            "x1": study.band[1],
            "y0": 0,
            "y1": 1,
            "fillcolor": BAR,
            "opacity": 0.15,
            "line": {"width": 0},
        }
    ]
    data = [line(study.freq, study.density, "density", palette.REDUCED, width=1.2)]
    return FigureBlock(title, {"data": data, "layout": layout}, caption, 300)


def loads_of(name: str) -> list[tuple[str, str]]:
    """A case under each load with contact."""
    return [(name, load) for load in RATTLING]
