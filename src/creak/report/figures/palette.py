"""Colours of the report: distinct for colour-blind readers and in grey print (Okabe and Ito, 2008)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray

INK = "#1b1f24"
MUTED = "#5b6570"
GRID = "#e4e8ec"

REDUCED = "#0072b2"
REFERENCE = "#e69f00"
RUNS = {"reduced": REDUCED, "reference": REFERENCE}
DRAWN = ("reference", "reduced")
"""Order of drawing, the last on top."""
RUN_NAMES = {"reduced": "reduced model", "reference": "unreduced model"}

MISSED = "#d55e00"
EXTRA = "#cc79a7"
CONTACT = "#c8102e"
DRIVEN = "#009e73"

ENERGY = {
    "external work": INK,
    "stored": REDUCED,
    "damping": "#009e73",
    "contact": "#cc79a7",
    "friction": "#8c6d1f",
    "scheme": "#d55e00",
}

PARTS = ("#7fa8cf", "#e3bf82", "#93c39b", "#c5a3cc", "#d99a86", "#8fc6c6", "#b9b9b9", "#d6cf86")
"""Pale enough for marks to stand out on them; used in turn."""

MARKS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#7b3fbf", "#8c6d1f", "#56b4e9")
"""Of curves of several places."""

DARK = {
    INK: "#e6eaee",
    MUTED: "#9ba6b1",
    GRID: "#323a42",
    "white": "#14181c",
    REDUCED: "#4ba3dd",
    "rgba(255,255,255,0.85)": "rgba(20,24,28,0.85)",
    "#009e73": "#2fc396",
    "#8c6d1f": "#c9a64a",
    "#f3f6f9": "#1d242b",
    "#b9d3e8": "#1f4c6e",
    "#08306b": "#d3e8f7",
    "#4a0d42": "#f2d6ff",
    "#b5173a": "#f0607f",
}
"""What the colours of the figures become on a dark page."""


def touched(values: FloatArray) -> FloatArray:
    """What a scale from zero shows of values: zero for those below it and for what is no number."""
    return np.nan_to_num(np.maximum(values, 0.0), nan=0.0)


def shares(values: FloatArray) -> NDArray[np.uint8]:
    """Values on a scale from zero in 8 bits: the largest has 255, and 0 only what has not been touched."""
    known = touched(values)
    of_largest = known / (known.max(initial=0.0) or 1.0)  # at most 1, as 255.0 / largest times the largest is not
    return np.maximum(np.ceil(255.0 * of_largest), known > 0.0).astype(np.uint8)


def limits(values: FloatArray, percent: float = 100.0) -> tuple[float, float]:
    """Both ends of a scale of values of any sign, the upper one at a percentile; never the same."""
    known = values[np.isfinite(values)]
    low, high = (float(x) for x in np.percentile(known, [0.0, percent])) if known.size else (0.0, 0.0)
    return low, high if high > low else low + (abs(low) or 1.0)
