"""Every figure of what is heard, and its third octaves, for the experts' part of the page."""

from __future__ import annotations

from typing import Any

from creak.report.tables.run import Table
from creak.report.words.answer import computed_to
from creak.report.words.text import NONE, fixed, number, plural
from creak.sound.zwicker_tables import NAMES

COLUMNS = (
    *(("N5, sone", "n5"), ("N10", "n10"), ("Nmax", "n_max"), ("dB(A)", "level"), ("sharpness, acum", "sharpness")),
    *(("sharp for, s", "sharp_time"), ("roughness, asper", "roughness"), ("prominence P", "prominence")),
    ("K_I, dB", "impulse_adjustment"),
)
MOST = 8
"""Sounds in the table of third octaves, which has a column for each."""
TIED = "The last third octaves that were computed correct the statistical part; bars are two standard deviations."
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
    ways = _ways(sound["band"], every, [row[0] for row in rows])
    why = {f"no {key.replace('_', ' ')}: {text}": None for _, h in every for key, text in h["figures_missing"].items()}
    figures = Table(["sound", *(name for name, _ in COLUMNS)], rows, note="; ".join(why))
    shown = [*listeners[0]["places"][: MOST - 1], {**listeners[0], "name": "all contact"}]
    bands = [[NAMES[k], *(_level(h["third_octaves"][k]) for h in shown)] for k in range(len(NAMES))]
    bands = [row for row in bands if any(cell != NONE for cell in row[1:])]
    return [figures, *ways, Table(["third octave, Hz", *(h["name"] for h in shown)], bands, note=_note(sound["band"]))]


def _ways(band: dict[str, Any], every: list[tuple[Any, Any]], names: list[str]) -> list[Table]:
    """Which part of N5 comes from which way, and its bar by the scatter of what is statistical."""
    end = computed_to(band)
    if end is None:
        return []
    modes = "" if band["handover"] is None else f"modes, to {band['handover']:.0f} Hz"
    columns = [
        *([modes] if modes else []),
        f"computed, to {end:.0f} Hz",
        f"with statistical energy, to {band['high']:.0f} Hz",
    ]
    keys = [*(["n5_modes"] if modes else []), "n5_computed", "n5"]
    rows = []
    for name, (_, h) in zip(names, every, strict=True):
        bars = [" to ".join(number(x, 3) for x in h[key] or []) or NONE for key in ("n5_bar", "n10_bar")]
        rows.append([name, *(number(h[key], 3) for key in keys), *bars, _tie(h["tie"])])
    return [Table(["N5, sone, by", *columns, "bar of N5", "bar of N10", "tied by"], rows, note=TIED)]


def _tie(tie: dict[str, Any] | None) -> str:
    if tie is None:
        return NONE
    by = f"{plural(tie['bands'], 'third octave')}, {fixed(tie['offset'], 1)} dB" if tie["bands"] else "nothing"
    return f"{by}; scatter {fixed(tie['scatter'], 1)} dB"


def _note(band: dict[str, Any]) -> str:
    end = computed_to(band)
    return "dB re 20 uPa." if end is None else f"dB re 20 uPa; above {end:.0f} Hz statistical energy, as noise."


def _level(value: float) -> str:
    return fixed(value, 1) if value > SILENT else NONE
