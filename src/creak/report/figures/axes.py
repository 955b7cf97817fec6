"""Building blocks of the plotly figures: axes, lines, thinning of long records."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.report.figures.palette import GRID, INK, MUTED

Trace = dict[str, Any]

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
MOST_POINTS = 6000
"""Points of a curve; longer records are thinned."""


def base_layout(height: int, *, legend: bool = False) -> dict[str, Any]:
    """Layout shared by all figures."""
    return {
        "height": height,
        "margin": {"l": 76, "r": 18, "t": 44, "b": 52},
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "hovermode": "closest",
        "showlegend": legend,
        "legend": {"orientation": "h", "x": 0.0, "xanchor": "left", "y": 0.995, "yanchor": "top", "yref": "container"},
    }


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis in the report's style."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": GRID,
        "linecolor": MUTED,
        "tickcolor": MUTED,
        "ticks": "outside",
        "ticklen": 4,
        "showline": True,
        "zeroline": False,
        "automargin": True,
        **more,
    }


def stacked(row: int, count: int) -> list[float]:
    """Vertical domain of a row of panels, the first on top."""
    share = 1.0 / count
    gap = 0.18 * share if count > 1 else 0.0
    return [max(0.0, 1.0 - (row + 1) * share + gap / 2.0), 1.0 - row * share - (gap / 2.0 if row else 0.0)]


def line(
    x: FloatArray, y: FloatArray, name: str, colour: str, *, row: int = 0, width: float = 1.4, first: bool = True
) -> Trace:
    """A curve in a panel; only its first appearance is listed in the legend."""
    return {
        "type": "scatter",
        "mode": "lines" if x.size > 1 else "markers",
        "x": plain(x),
        "y": plain(y),
        "name": name,
        "legendgroup": name,
        "showlegend": first,
        "line": {"color": colour, "width": width},
        "yaxis": f"y{row + 1}" if row else "y",
    }


def plain(values: FloatArray) -> list[float | None]:
    """Six significant digits, undefined values as None: what JSON can hold."""
    return [float(f"{v:.6g}") if np.isfinite(v) else None for v in values.tolist()]


def peaks_kept(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A record of non-negative values, thinned to the highest of each stretch."""
    stretch = -(-x.size // MOST_POINTS)
    if stretch <= 1:
        return x, y
    n = x.size // stretch * stretch
    block = y[:n].reshape(-1, stretch)
    top = block.argmax(axis=1)
    row = np.arange(top.size)
    return x[:n].reshape(-1, stretch)[row, top], block[row, top]


def thinned(x: FloatArray, y: FloatArray, most: int = 1500) -> tuple[FloatArray, FloatArray]:
    """Every so many samples of a record, its last one included."""
    stride = -(-x.size // most)
    if stride <= 1:
        return x, y
    rows = np.unique(np.append(np.arange(0, x.size, stride), x.size - 1))
    return x[rows], y[rows]
