"""What is heard, for the page: audio in it, and loudness over time with the events that make it."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.report.figures import palette
from creak.report.figures.axes import INSTANT, Trace, axis, base_layout, line, plain
from creak.report.figures.run import Figure
from creak.report.tables.run import Table
from creak.report.words.answer import computed_to
from creak.report.words.text import NONE, fixed, number, plural
from creak.sound.forced import without_clicks
from creak.sound.loudness import loudness
from creak.sound.zwicker_tables import NAMES, RATE
from creak.studies.findings.tree import Findings
from creak.verify.events import Event

MOST = 8
"""Places that can be played and are drawn; one more is all of them together."""
LONGEST = 5.0
"""s of a sound on the page."""
SLOWER = ((6, 3_500.0), (3, 7_000.0), (2, 10_500.0))
"""The rate is divided by this where the sound's band ends below so many Hz."""
QUIET = 0.7
"""Of full scale: the loudest sample on the page."""
SAMPLES = 32767
HEIGHT = 340
COLUMNS = (
    *(("N5, sone", "n5"), ("N10", "n10"), ("Nmax", "n_max"), ("dB(A)", "level"), ("sharpness, acum", "sharpness")),
    *(("sharp for, s", "sharp_time"), ("roughness, asper", "roughness"), ("prominence P", "prominence")),
    ("K_I, dB", "impulse_adjustment"),
)
MOST_BANDS = 8
"""Sounds in the table of third octaves, which has a column for each."""
TIED = "The last third octaves that were computed correct the statistical part; bars are two standard deviations."
SILENT = -20.0
"""dB below which a third octave has nothing."""


def players(result: Findings) -> list[str]:
    """A WAV file as data URI for each place that is shown, then one for all together; none without sound.

    All have one scale: the quieter place is quieter. What is in the verification window can be heard.
    """
    sound = result.sound
    if sound is None:
        return []
    first, last = (round(t * RATE) for t in result.window)
    last = min(last, first + round(LONGEST * RATE), sound.pressure.shape[1])
    shown = without_clicks(sound.pressure[:, min(first, last - 2) : last].astype(np.float64), RATE)
    shown = np.vstack([shown[:-1][:MOST], shown[-1:]])
    peak = float(np.abs(shown).max(initial=0.0))
    if peak == 0.0:
        return []
    parts = next((n for n, most in SLOWER if sound.band.high <= most), 1)
    return [_uri(QUIET * x / peak, RATE, parts) for x in shown]


def _uri(x: FloatArray, rate: float, parts: int) -> str:
    """16 bits at rate / parts."""
    from scipy.io import wavfile  # see `signals.spectra.low_pass`
    from scipy.signal import resample_poly

    slow = resample_poly(x, 1, parts) if parts > 1 else x
    file = io.BytesIO()
    wavfile.write(file, round(rate / parts), np.clip(slow * SAMPLES, -SAMPLES, SAMPLES).astype(np.int16))
    return f"data:audio/wav;base64,{base64.b64encode(file.getvalue()).decode('ascii')}"


def loudness_figure(result: Findings) -> Figure:
    """N(t) of each place by itself and of all contact, and the beginning of each event."""
    sound = result.sound
    if sound is None:
        return Figure(None, "No picture: the run was not heard.")
    data: list[Trace] = []
    names = [*(f"{p.number} {p.contact}" for p in result.places[:MOST]), "all contact"]
    rows = [*range(min(MOST, len(result.places))), sound.pressure.shape[0] - 1]
    colours = [*palette.MARKS[: len(names) - 1], palette.INK]
    for row, name, colour in zip(rows, names, colours, strict=True):
        try:
            heard = loudness(sound.pressure[row].astype(np.float64), RATE)
        except InputError:
            continue  # beyond ISO 532-1, as the notes say
        data.append(_curve(heard.time, heard.total, name, colour, last=row == rows[-1]))
        if row < len(result.places):
            data.append(_marks(heard.time, heard.total, result.places[row].events, colour, name))
    if not data:
        return Figure(None, "No picture: too loud at low frequency for ISO 532-1.")
    layout = base_layout(HEIGHT, legend=True)
    layout["xaxis"] = axis("time, s", range=list(result.window))
    layout["yaxis"] = axis("loudness N, sone", rangemode="tozero")
    beyond = f"; above {number(sound.band.computed, 3)} Hz statistical energy" if sound.band.statistics else ""
    caption = (
        f"Loudness over time (ISO 532-1) at {sound.listeners[0].name}, {sound.band.low:.0f} to "
        f"{number(sound.band.high, 3)} Hz, of each place's own contact forces{beyond}; dots: its events begin."
    )
    return Figure({"data": data, "layout": layout}, caption, HEIGHT)


def _curve(time: FloatArray, total: FloatArray, name: str, colour: str, *, last: bool) -> Trace:
    trace = line(time, total, name, colour, width=2.0 if last else 1.3)
    trace["line"]["dash"] = "dot" if last else "solid"
    return trace | {"hovertemplate": f"{name}: %{{y:.3g}} sone at %{{x:.4g}} s<extra></extra>"}


def _marks(time: FloatArray, total: FloatArray, events: Sequence[Event], colour: str, name: str) -> Trace:
    starts = np.array([e.t_start for e in events])
    force = [number(e.force_place, 3) for e in events]
    return {
        "type": "scatter",
        "mode": "markers",
        "showlegend": False,
        "x": plain(starts, INSTANT),
        "y": plain(np.interp(starts, time, total)),
        "text": force,
        "marker": {"color": colour, "size": 6},
        "hovertemplate": f"{name}: event at %{{x:.5g}} s, force %{{text}}<extra></extra>",
    }


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
    shown = [*listeners[0]["places"][: MOST_BANDS - 1], {**listeners[0], "name": "all contact"}]
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
