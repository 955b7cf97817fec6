"""Sounds side by side as rows for the terminal and as one picture."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from creak.errors import shortened
from creak.formats.complete_file import complete_file, write_bytes
from creak.report.figures import palette
from creak.report.words.text import NONE, number
from creak.sound.zwicker_tables import BANDS, NAMES
from creak.studies.sound.beside import ComparedSound, SoundComparison

COLUMNS = (
    *(("N5", "n5"), ("N10", "n10"), ("Nmax", "n_max"), ("dB(A)", "level")),
    *(("acum", "sharpness"), ("asper", "roughness"), ("P", "prominence")),
)
"""What fits on a line of 80 characters."""
NAME = 20
"""Characters of a name."""
MOST = 8
"""Sounds in the picture."""


def rows(found: SoundComparison) -> list[list[str]]:
    """Header and a row for each sound, the loudest first; * is recorded, + is recorded and cut to the run's band."""
    head = ["* recorded, + cut", *(name for name, _ in COLUMNS)]
    return [head, *([_name(s), *(_figure(s, key) for _, key in COLUMNS)] for s in found.sounds)]


def reasons(found: SoundComparison) -> list[str]:
    """Why figures are none, each once; and the names that the table cuts."""
    high = f"{found.band[1]:.0f} Hz"
    said = [f"+ is a recording cut to what is below {high}"] if any(s.highest for s in found.sounds) else []
    said += [f"{_name(s)}: {s.name}" for s in found.sounds if len(s.source) > NAME - 2]
    none: dict[str, list[str]] = {}
    for sound in found.sounds:
        for key, why in sound.missing.items():
            none.setdefault(f"no {key.replace('_', ' ')}: {why}", []).append(sound.name)
    return [*said, *(f"{why} ({', '.join(names)})" for why, names in none.items())]


def _name(sound: ComparedSound) -> str:
    mark = ("* " if sound.highest is None else "+ ") if sound.recorded else ""
    return mark + shortened(sound.source, NAME - 2)


def _figure(sound: ComparedSound, key: str) -> str:
    value = sound.figures[key]
    return NONE if value is None else number(value, 3)


def write_picture(found: SoundComparison, path: Path) -> None:
    """N(t) and third octaves of the loudest sounds as a PNG file; recorded ones are dashed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawing = Figure(figsize=(11.0, 7.0), layout="constrained")
    FigureCanvasAgg(drawing)
    over_time, octaves = drawing.subplots(2, 1)
    for sound, colour in zip(found.sounds[:MOST], palette.MARKS, strict=False):
        how: dict[str, Any] = {"color": colour, "linewidth": 1.4, "linestyle": "--" if sound.recorded else "-"}
        over_time.plot(sound.time, sound.loudness, label=sound.name.replace("$", r"\$"), **how)
        octaves.step(np.arange(BANDS.size), sound.third_octaves, where="mid", **how)
    over_time.set(xlabel="time, s", ylabel="loudness N, sone")
    over_time.set_ylim(bottom=0.0)
    over_time.legend(frameon=False, fontsize="small", loc="upper right")
    octaves.set_xticks(range(1, BANDS.size, 3), NAMES[1::3])
    octaves.set(xlabel="third octave, Hz", ylabel="level, dB re 20 uPa")
    loudest = max(float(s.third_octaves.max()) for s in found.sounds)
    octaves.set_ylim(min(0.0, loudest - 60.0), loudest + 5.0)
    for axes in (over_time, octaves):
        axes.spines[["top", "right"]].set_visible(False)
    data = io.BytesIO()
    drawing.savefig(data, format="png", dpi=140, metadata={"Software": "creak"})
    with complete_file(path) as partial:
        write_bytes(partial, data.getvalue())
