"""docs/accuracy.png from the record of `benchmarks.evidence`: errors over the number of unknowns."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

FLOOR = 1e-6
"""Errors below are drawn here."""
PANELS = (
    ("unknowns", "frequency_error", "unknowns of the reduced model", "worst frequency error to 100 Hz"),
    ("unknowns", "impulse_error", "unknowns of the reduced model", "mean impulse error of matched events"),
    ("offline_s", "online_s", "making it, CPU s", "a run of five seconds, CPU s"),
)


def draw(rows: list[Mapping[str, Any]], path: Path) -> None:
    """Numbered as in the table; cases that miss or add events are hollow, errors that are not known left out."""
    figure = Figure(figsize=(12.5, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes, colours = figure.subplots(1, 3), colormaps["tab20"]
    for ax, (across, up, x_label, y_label) in zip(axes, PANELS, strict=True):
        for k, row in enumerate(rows):
            if row[up] is None:
                continue
            x, y, colour = row[across], max(abs(row[up]), FLOOR), colours(k % 20)
            face = "white" if row["missed"] + row["extra"] else colour
            ax.loglog(x, y, "o", ms=8, mec=colour, mfc=face, mew=2)
            ax.annotate(str(k + 1), (x, y), fontsize=7, xytext=(6, 4), textcoords="offset points")
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.grid(alpha=0.3)
    names = [f"{k + 1} {row['name']}" for k, row in enumerate(rows)]
    handles = [Line2D([], [], marker="o", ls="", color=colours(k % 20), label=name) for k, name in enumerate(names)]
    figure.legend(handles=handles, loc="outside right upper", fontsize=8, frameon=False)
    figure.savefig(path, dpi=110)
