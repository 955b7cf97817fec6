"""Building blocks of the plotly figures: axes, lines, thinning of long records."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.report.figures.palette import GRID, INK, MUTED

Trace = dict[str, Any]

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
MOST_POINTS = 12_000
"""Points of a curve up to which all are drawn."""
COLUMNS = 2000
"""In which a longer curve keeps its extremes and its area: narrower than the pixels of a page."""
FINER = 12
"""Times that columns may be halved where points lie in few of them."""
FULL = 10
"""Points of a column up to which all are drawn, the most that a fuller one is drawn with."""
INSTANT = 17
"""Digits of an instant, all that it has: those of a hit are far closer to each other than to the start of the run."""
CLOSE = 1e-3
"""Of the mean between two points: where the straight line comes so near to it, that is drawn."""


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
    """A curve in a panel, thinned where it is long; only its first appearance is listed in the legend."""
    x, y = thinned(x, y)
    return {
        "type": "scatter",
        "mode": "lines" if x.size > 1 else "markers",
        "x": plain(x, INSTANT),
        "y": plain(y),
        "name": name,
        "legendgroup": name,
        "showlegend": first,
        "line": {"color": colour, "width": width},
        "yaxis": f"y{row + 1}" if row else "y",
    }


def plain(values: FloatArray, digits: int = 6) -> list[float | None]:
    """So many significant digits, undefined values as None: what JSON can hold."""
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in values.tolist()]


def thinned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A curve, straight between its points, with fewer of them; its extremes and its area stay, column by column.

    Of the points in a column of x the first, lowest, highest and last stay where they are. Where the straight line
    between two of them has not the mean of what was there, that mean is drawn. Columns are as narrow as the number of
    points allows.

    Parameters
    ----------
    x : (n,) rising, however uneven. y : (n,) numbers.
    """
    if x.size <= MOST_POINTS or not x[-1] > x[0]:
        return x, y
    for columns in COLUMNS << np.arange(FINER, -1, -1):
        column = np.minimum((x - x[0]) * (columns / (x[-1] - x[0])), columns - 1).astype(np.int64)
        ends = np.flatnonzero(np.diff(column, prepend=-1, append=columns))
        if np.minimum(np.diff(ends), FULL).sum() <= MOST_POINTS:
            break
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(x) * (y[1:] + y[:-1]))])
    few: list[FloatArray] = []
    for a, b in itertools.pairwise(ends.tolist()):
        if b - a <= FULL:
            few.append(np.stack([x[a:b], y[a:b]]))
            continue
        lowest, highest = a + int(y[a:b].argmin()), a + int(y[a:b].argmax())
        rows = sorted({a, lowest, highest, b - 1})
        for r, s in itertools.pairwise(rows):
            few.append(np.array([[x[r]], [y[r]]]))
            straight = 0.5 * (y[r] + y[s])
            mean = (area[s] - area[r]) / (x[s] - x[r]) if x[s] > x[r] else straight
            if abs(mean - straight) > CLOSE * abs(mean):
                few.append(np.array([[x[r], x[s]], [np.clip(mean, y[lowest], y[highest])] * 2]))
        few.append(np.array([[x[b - 1]], [y[b - 1]]]))
    found = np.concatenate(few, axis=1)
    return found[0], found[1]
