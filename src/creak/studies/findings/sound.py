"""The sound of a run in summary.json and results.h5."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import h5py
import numpy as np

from creak.formats.stored.tree import COMPRESSED
from creak.formats.wav import full_scale_level
from creak.sound.carriers import SEED
from creak.sound.quality import FIGURES
from creak.sound.zwicker_tables import RATE
from creak.studies.findings.places import Place, find_places, ranked
from creak.studies.findings.tree import Findings
from creak.studies.prepare.marching import Scope
from creak.studies.run.one_run import Run
from creak.studies.sound.heard import Sound
from creak.studies.sound.loud import Heard

HEARD = ("n5", "n_max", "n5_added", "n_max_added", "level")
"""Figures of a sound: sone, sone beside the background, dB(A)."""
TOGETHER = "all"
"""Name of the sound of all contact together."""


def heard_places(scope: Scope, run: Run | None, sound: Sound | str | None) -> tuple[Place, ...]:
    """The places of a run, the loudest first; where it was not heard, the hardest hit first."""
    if run is None:
        return ()
    places = find_places(scope, run)
    return ranked(places, sound.order) if isinstance(sound, Sound) and sound.run == run.name else places


def place_name(place: Place) -> str:
    """As summary.json and files have it."""
    return f"{place.contact} {place.number}"


def sound_summary(findings: Findings) -> dict[str, Any] | None:
    """Figures over the verification window of each listener, those of the first one also at the top."""
    sound = findings.sound
    if sound is None:
        return None if findings.silence is None else {"missing": findings.silence}
    every, names = [], [place_name(p) for p in findings.runs[sound.run].places]
    for x in sound.listeners:
        *single, together = x.heard
        own = zip(names, single, strict=True)
        every.append(
            {
                "listener": x.name,
                "position": list(x.position),
                "given": x.given,
                "parts": list(x.parts),
                "compact": list(x.compact),
                "faces": list(x.faces) or None,
                "ear": x.ear or None,
                "background": None if x.background is None else x.background.tolist(),
                **_figures(together),
                "places": [{"name": name, **_figures(h), "share": _share(h, single)} for name, h in own],
            }
        )
    return {
        **{key: value for key, value in every[0].items() if key != "places"},
        "run": sound.run,
        "beside_background": sound.listeners[0].heard[-1].n5_added is not None,
        "equivalent_power": sound.power,
        "rate": RATE,
        "band": {
            "low": sound.band.low,
            "high": sound.band.high,
            "limit": sound.band.limit,
            "modes": sound.band.modes,
            "mesh": sound.band.mesh,
            "step": sound.band.step,
            "handover": sound.band.handover,
            "computed": sound.band.computed,
            "computed_limit": sound.band.computed_limit,
            "seed": SEED if sound.band.statistics else None,
        },
        "calibration": {
            "full_scale_pa": sound.full_scale,
            "full_scale_sine_db": full_scale_level(sound.full_scale),
        },
        "room": None
        if sound.room is None
        else {
            "volume": sound.room.volume,
            "reverberation": sound.room.reverberation.tolist(),
            "schroeder": sound.room.schroeder if np.isfinite(sound.room.schroeder) else None,
        },
        "wall_s": sound.wall_s,
        "cpu_s": sound.cpu_s,
        "offline_cpu_s": sound.offline_cpu_s,
        "listeners": every,
    }


def heard_at(sounds: Mapping[int, Heard], place: int) -> dict[str, Any]:
    """Figures of a place, of `Findings.heard`, by its number; null without sound."""
    if not sounds:
        return dict.fromkeys((*HEARD, *FIGURES, "figures_missing", "sound_share"))
    return {**_single(sounds[place]), "sound_share": _share(sounds[place], list(sounds.values()))}


def put_sound(file: h5py.File, sound: Sound, places: Sequence[Place]) -> None:
    """Add the group `sound` to a results.h5."""
    group, text = file.create_group("sound"), h5py.string_dtype()
    group.attrs.update({"rate": RATE, "full_scale": sound.full_scale, "band": [sound.band.low, sound.band.high]})
    group.create_dataset("listeners", data=np.array([x.name for x in sound.listeners], dtype=object), dtype=text)
    names = [*map(place_name, places), TOGETHER]
    group.create_dataset("places", data=np.array(names, dtype=object), dtype=text)
    data = group.create_dataset("pressure", data=sound.pressure, **COMPRESSED)
    data.attrs["unit"], data.attrs["axes"] = "Pa", "listener, place, time at rate from t = 0"
    ears = np.array([x.ear for x in sound.listeners], dtype=object)
    group.create_dataset("ears", data=ears, dtype=text).attrs["says"] = "which ear pressure is at; empty: no head"
    others = group.create_group("other_ear")
    for row, pressure in sound.other.items():
        data = others.create_dataset(str(row), data=pressure, **COMPRESSED)
        data.attrs["unit"], data.attrs["axes"] = "Pa", "place, time at rate from t = 0"


def _figures(heard: Heard) -> dict[str, Any]:
    return {**_single(heard), "third_octaves": heard.third_octaves.tolist()}


def _single(heard: Heard) -> dict[str, Any]:
    """Figures that are one number each; `figures_missing` says of those that are null why."""
    known = {name: getattr(heard, name) for name in (*HEARD, "n5_modes", "n5_computed", "n5_direct")}
    bars = {name: list(getattr(heard, name)) or None for name in ("n5_bar", "n10_bar")}
    tie = None if heard.tie is None else asdict(heard.tie)
    return {**known, **bars, "tie": tie, **heard.quality.figures, "figures_missing": dict(heard.quality.missing)}


def _share(heard: Heard, every: Sequence[Heard]) -> float | None:
    """Of the A-weighted energy of all places, each by itself."""
    whole = sum(h.energy for h in every)
    return heard.energy / whole if whole > 0.0 else None
