"""The report's figures as plotly specifications, one function each; what is absent is said in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.history import ENERGIES, History
from creak.model.units import Units
from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line, plain, stacked, thinned
from creak.report.tables.checks import moving_axes, why_no_fit, why_no_mac
from creak.report.words.text import four
from creak.studies.findings.tree import Findings
from creak.verify.events import events_in
from creak.verify.intervals import in_window

ENERGY_CAPTION = (
    "Work done from outside and where it went, from the start of the run: stored is kinetic and strain energy, "
    "contact its springs and dampers, friction the work of sliding, scheme what the others leave over: the algorithmic "
    "dissipation of the time integration, below zero where it created energy."
)
MOST_ROWS = 6
"""Contacts drawn one below the other; the hardest pressed ones."""


@dataclass(frozen=True)
class Figure:
    """A plotly figure, or why there is none."""

    spec: dict[str, Any] | None
    caption: str
    height: int = 0


def force_figure(result: Findings, units: Units) -> Figure:
    """Contact force over time, largest channel of each contact: reduced upward, reference mirrored downward."""
    groups = groups_by_force(result)
    if not groups:
        return Figure(None, _no_force(result))
    shown = groups[:MOST_ROWS]
    height = 150 + 190 * len(shown)
    layout = base_layout(height, legend=True)
    layout["xaxis"] = axis("time, s", anchor=f"y{len(shown) if len(shown) > 1 else ''}", range=list(result.window))
    data: list[Trace] = []
    layout["shapes"] = []
    for row, group in enumerate(shown):
        name = "yaxis" + (str(row + 1) if row else "")
        layout[name] = axis(f"{group}, raw, {units.force}", domain=stacked(row, len(shown)), zeroline=True)
        traces, peak = _force_row(result, group, row)
        data += traces
        layout["shapes"] += _event_bands(result, group, row)
        layout[name] |= _mirrored_ticks(peak, "reference" in result.runs and "reduced" in result.runs)
    return Figure({"data": data, "layout": layout}, _force_caption(result, len(groups)), height)


def _no_force(result: Findings) -> str:
    if result.gaps.m == 0:
        return "No contact forces: the study has no channel that can close."
    return "No contact forces: nothing touched in the verification window."


def groups_by_force(result: Findings) -> list[str]:
    """Contacts and connectors that pressed in the window, the hardest first."""
    peaks: dict[str, float] = {}
    for run in result.runs.values():
        inside = in_window(run.history.time, result.window)
        for j, group in enumerate(result.gaps.group):
            top = float(run.history.force[inside, j].max(initial=0.0))
            peaks[group] = max(peaks.get(group, 0.0), top)
    return sorted((g for g, p in peaks.items() if p > 0.0), key=lambda g: -peaks[g])


def _force_row(result: Findings, group: str, row: int) -> tuple[list[Trace], float]:
    channels = [j for j, g in enumerate(result.gaps.group) if g == group]
    traces, top = [], 0.0
    for name, run in result.runs.items():
        inside = in_window(run.history.time, result.window)
        force = run.history.force[inside][:, channels].max(axis=1)
        top = max(top, float(force.max(initial=0.0)))
        sign = -1.0 if name == "reference" and "reduced" in result.runs else 1.0
        time = run.history.time[inside]
        trace = line(time, sign * force, palette.RUN_NAMES[name], palette.RUNS[name], row=row, first=row == 0)
        hover = {"customdata": [abs(f) for f in trace["y"]], "hovertemplate": "%{x:.4f} s: %{customdata:.3g}"}
        traces.append(trace | hover | {"fill": "tozeroy"})
    return traces, top


def _event_bands(result: Findings, group: str, row: int) -> list[dict[str, Any]]:
    """A band for each event, on the half of the run it belongs to; missed and extra ones in their own colour."""
    match = result.events
    missed = {id(e) for e in match.missed} if match else set()
    extra = {id(e) for e in match.extra} if match else set()
    halves = {"reduced": (0.5, 1.0), "reference": (0.0, 0.5)} if match else dict.fromkeys(result.runs, (0.0, 1.0))
    y = "y" + (str(row + 1) if row else "")
    bands = []
    for name, run in result.runs.items():
        for e in events_in(run.events, result.window):
            if e.group != group:
                continue
            colour = palette.MISSED if id(e) in missed else palette.EXTRA if id(e) in extra else palette.MUTED
            low, high = halves[name]
            bands.append(
                {
                    "type": "rect",
                    "xref": "x",
                    "yref": f"{y} domain",
                    "x0": e.t_start,
                    "x1": e.t_end,
                    "y0": low,
                    "y1": high,
                    "fillcolor": colour,
                    "opacity": 0.2 if colour == palette.MUTED else 0.45,
                    "line": {"width": 0},
                    "layer": "below",
                }
            )
    return bands


def _mirrored_ticks(peak: float, mirrored: bool) -> dict[str, Any]:
    """A symmetric axis whose ticks carry no sign."""
    if not mirrored or peak <= 0.0:
        return {"rangemode": "tozero"}
    step = 10.0 ** np.floor(np.log10(peak))
    step *= next(f for f in (0.2, 0.5, 1.0, 2.0, 5.0) if peak / (f * step) <= 4.0)
    ticks = np.arange(-4, 5) * step
    words = [f"{abs(t):.3g}" for t in ticks]
    return {"range": [-1.08 * peak, 1.08 * peak], "tickvals": plain(ticks), "ticktext": words}


def _force_caption(result: Findings, groups: int) -> str:
    text = (
        "Raw force of the hardest pressed node of the contact at each instant, over the verification window; events "
        "shaded. It hangs on mesh and step: the force that tables and places give is that of all nodes together, "
        "low-passed."
    )
    if "reduced" in result.runs and "reference" in result.runs:
        text += (
            " Reduced model upward, unreduced model mirrored downward; an event without a partner is orange (missed) "
            "or pink (extra)."
        )
    if groups > MOST_ROWS:
        text += f" The {MOST_ROWS} hardest pressed of {groups} contacts are shown."
    return text


def mac_figure(result: Findings) -> Figure:
    """MAC between all reference and reduced modes as a heat map."""
    modes = result.modes
    if modes is None or 0 in modes.pairs.matrix.shape:
        return Figure(None, f"No mode shapes to compare: {why_no_mac(result)}.")
    spec, height = mac_heat(
        modes.pairs.matrix,
        ("unreduced", "reduced"),
        ("mode of the unreduced model", "mode of the reduced model"),
        (modes.freq_reference, modes.freq_reduced),
    )
    caption = (
        "Modal assurance criterion between all modes, over the motion of the compared nodes only: a partner stands "
        "out; other shades mean that two modes look alike at these nodes."
    )
    return Figure(spec, caption, height)


def mac_heat(
    matrix: FloatArray, short: tuple[str, str], titles: tuple[str, str], frequencies: tuple[FloatArray, FloatArray]
) -> tuple[dict[str, Any], int]:
    """A MAC matrix (n_row, n_column) as a heat map, and its height; modes count from 1.

    Parameters
    ----------
    short, titles, frequencies : of the rows and the columns: a word, the name of the axis, Hz.
    """
    n_row, n_column = matrix.shape
    size = int(np.clip(26 * n_row, 200, 430))
    layout = base_layout(size + 110)
    layout["xaxis"] = axis(titles[1], dtick=max(1, -(-n_column // 14)), tick0=1, showgrid=False)
    layout["yaxis"] = axis(titles[0], dtick=max(1, -(-n_row // 14)), tick0=1, showgrid=False)
    hover = f"{short[0]} %{{y}}, {short[1]} %{{x}}: MAC %{{z:.4f}}"
    trace: Trace = {
        "type": "heatmap",
        "z": np.round(matrix, 4).tolist(),
        "x": list(range(1, n_column + 1)),
        "y": list(range(1, n_row + 1)),
        "zmin": 0,
        "zmax": 1,
        "xgap": 1,
        "ygap": 1,
        "colorscale": [[0.0, "#f3f6f9"], [0.3, "#b9d3e8"], [0.7, "#4a90c2"], [1.0, "#08306b"]],
        "colorbar": {"title": {"text": "MAC"}, "thickness": 12, "len": 0.9, "outlinewidth": 0},
        "hovertemplate": f"{hover}<extra></extra>",
    }
    if n_row * n_column < 5000:
        trace["customdata"] = [[f"{a:.2f} / {b:.2f} Hz" for b in frequencies[1]] for a in frequencies[0]]
        trace["hovertemplate"] = f"{hover}<br>%{{customdata}}<extra></extra>"
    return {"data": [trace], "layout": layout}, size + 110


def spectra_figure(result: Findings, units: Units) -> Figure:
    """Mean magnitude over the verification pairs of the relative displacement, per axis."""
    spectra = result.spectra
    if spectra is None:
        return Figure(None, f"No spectra: {why_no_fit(result)}.")
    if spectra.freq.size == 0:
        return Figure(None, "No spectra: the window is too short for a line below the verification's f_max.")
    size = {name: np.abs(s).mean(axis=1) for name, s in spectra.spectra.items()}
    top = max(float(s.max(initial=0.0)) for s in size.values())
    if top == 0.0:
        return Figure(None, "No spectra: the verification pairs do not move against each other.")
    layout = base_layout(660, legend=True)
    layout["xaxis"] = axis("frequency, Hz", anchor="y3", range=[0.0, float(spectra.freq[-1])])
    layout["annotations"] = []
    data: list[Trace] = []
    for k, name in enumerate("xyz"):
        suffix = str(k + 1) if k else ""
        layout[f"yaxis{suffix}"] = axis(
            f"{name}, {units.length}",
            domain=stacked(k, 3),
            type="log",
            exponentformat="power",
            dtick=1,
            minor={"showgrid": False},
            range=_decades(size, k),
        )
        drawn = [run for run in palette.DRAWN if run in size]
        data += [_spectrum_line(spectra.freq, size[run][:, k], run, k, len(size)) for run in drawn]
        layout["annotations"].append(_panel_label(_fit_words(result, name), f"y{suffix} domain"))
    return Figure({"data": data, "layout": layout}, _spectra_caption(result), 660)


def _spectrum_line(freq: FloatArray, height: FloatArray, run: str, row: int, count: int) -> Trace:
    """One run in one panel; the reference is a broad line under the reduced model's thin one."""
    x, y = thinned(freq, height)
    width = 3.2 if run == "reference" and count > 1 else 1.4
    y = np.where(y > 0.0, y, np.nan)
    return line(x, y, palette.RUN_NAMES[run], palette.RUNS[run], row=row, width=width, first=row == 0)


def _fit_words(result: Findings, name: str) -> str:
    """What stands in the corner of a panel of spectra."""
    if name not in moving_axes(result):
        return f"no motion along {name} (round-off only)"
    fits = result.spectra.nrmse if result.spectra is not None else {}
    return f"NRMSE fit {four(fits[name])}" if name in fits else ""


def _panel_label(text: str, yref: str) -> dict[str, Any]:
    return {
        "text": text,
        "xref": "paper",
        "x": 1.0,
        "xanchor": "right",
        "showarrow": False,
        "yref": yref,
        "y": 0.97,
        "yanchor": "top",
        "bgcolor": "rgba(255,255,255,0.85)",
        "font": {"size": 13},
    }


def _decades(size: dict[str, FloatArray], k: int) -> list[float]:
    """Log range of an axis: its values, at most seven decades."""
    values = np.concatenate([s[:, k] for s in size.values()])
    values = values[values > 0.0]
    if values.size == 0:
        return [-6.0, 0.0]
    high = float(np.log10(values.max())) + 0.3
    return [max(float(np.log10(values.min())) - 0.2, high - 7.0), high]


def _spectra_caption(result: Findings) -> str:
    text = (
        f"Displacement of secondary against main node, mean magnitude over {result.setup.pairs.shape[0]} pairs, "
        "over the verification window."
    )
    fitted = result.spectra is not None and bool(result.spectra.nrmse)
    return text + (" The fit is 1 for equal spectra, phase included." if fitted else "")


def energy_terms(history: History) -> dict[str, FloatArray]:
    """The terms of the balance by their names in the report, (n_time,) each; friction only where something rubs."""
    e = {name: history.energy[:, k] for k, name in enumerate(ENERGIES)}
    terms = {
        "external work": e["external"],
        "stored": e["kinetic"] + e["strain"],
        "damping": e["damping"],
        "contact": e["contact"] + e["contact_damping"],
        "friction": e["friction"],
        "scheme": e["scheme"],
    }
    if not terms["friction"].any():
        del terms["friction"]
    return terms


def energy_figure(result: Findings, units: Units) -> Figure:
    """Cumulative work and stored energy of each run over time."""
    if not result.runs:
        return Figure(None, "No energy balance: there is no run.")
    if all(not run.history.energy.any() for run in result.runs.values()):
        return Figure(None, "No energy balance: nothing moved.")
    layout = base_layout(400, legend=True)
    data: list[Trace] = []
    count = len(result.runs)
    layout["annotations"] = []
    listed: set[str] = set()
    for k, (name, run) in enumerate(sorted(result.runs.items())[::-1]):
        suffix = str(k + 1) if k else ""
        domain = [k * 0.52, 0.48 + k * 0.52] if count > 1 else [0.0, 1.0]
        layout[f"xaxis{suffix}"] = axis("time, s", domain=domain, anchor=f"y{suffix}")
        layout[f"yaxis{suffix}"] = axis(f"energy, {units.energy}" if k == 0 else "", anchor=f"x{suffix}")
        if k:
            layout[f"yaxis{suffix}"] |= {"matches": "y", "showticklabels": False}
        layout["annotations"].append(
            {
                "text": f"<b>{palette.RUN_NAMES[name]}</b>",
                "xref": f"x{suffix} domain",
                "x": 0.0,
                "xanchor": "left",
                "yref": "paper",
                "y": 1.0,
                "yanchor": "bottom",
                "showarrow": False,
            }
        )
        for term, values in energy_terms(run.history).items():
            trace = line(run.history.time, values, term, palette.ENERGY[term], row=k, first=term not in listed)
            listed.add(term)
            data.append(trace | {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}"})
    return Figure({"data": data, "layout": layout}, ENERGY_CAPTION, 400)
