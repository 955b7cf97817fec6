"""Every figure of what is heard, and its third octaves, for the experts' part of the page."""

from __future__ import annotations

from typing import Any

from creak.report.tables.run import Table
from creak.report.words.text import NONE, fixed, number
from creak.sound.zwicker_tables import NAMES

COLUMNS = (
    *(("N5, sone", "n5"), ("N10", "n10"), ("Nmax", "n_max"), ("dB(A)", "level"), ("sharpness, acum", "sharpness")),
    *(("sharp for, s", "sharp_time"), ("roughness, asper", "roughness"), ("prominence P", "prominence")),
    ("K_I, dB", "impulse_adjustment"),
)
MOST = 8
"""Sounds in the table of third octaves, which has a column for each."""
SILENT = -20.0
"""dB below which a third octave has nothing."""


def sound_tables(summary: dict[str, Any]) -> list[Table]:
    """A row for each listener and sound, with why figures are none; the third octaves at the first listener."""
    sound = summary["sound"]
    listeners = [] if sound is None else sound.get("listeners", [])
    every = [(one, heard) for one in listeners for heard in (*one["places"], {**one, "name": "all contact"})]
    if not every or any("n10" not in heard for _, heard in every):  # not told by a run of an earlier creak
        return []
    several = len(listeners) > 1
    rows = [
        [f"{one['listener']}: {h['name']}" if several else h["name"], *(number(h[key], 3) for _, key in COLUMNS)]
        for one, h in every
    ]
    why = {f"no {key.replace('_', ' ')}: {text}": None for _, h in every for key, text in h["figures_missing"].items()}
    figures = Table(["sound", *(name for name, _ in COLUMNS)], rows, note="; ".join(why))
    shown = [*listeners[0]["places"][: MOST - 1], {**listeners[0], "name": "all contact"}]
    bands = [[NAMES[k], *(_level(h["third_octaves"][k]) for h in shown)] for k in range(len(NAMES))]
    bands = [row for row in bands if any(cell != NONE for cell in row[1:])]
    return [figures, Table(["third octave, Hz", *(h["name"] for h in shown)], bands, note="dB re 20 uPa.")]


def _level(value: float) -> str:
    return fixed(value, 1) if value > SILENT else NONE
