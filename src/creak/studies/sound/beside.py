"""Recorded sounds beside those that a run computed: the same figures of all, ranked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.measured.recordings import Recording
from creak.formats.stored.run_identity import SUMMARY
from creak.formats.stored.sealed import read_sealed
from creak.formats.stored.sound import StoredSound, read_sound
from creak.signals.spectra import low_pass
from creak.sound.loudness import Loudness
from creak.sound.quality import FIGURES, SHARP
from creak.sound.third_octave import RINGING, at_48k
from creak.sound.zwicker_tables import BANDS, RATE
from creak.studies.sound.loud import heard_with, loudness_of

OLD = "the run is of an earlier creak, which did not tell it"
LOUDNESS = ("n5", "n_max", "level")
"""Figures beside those of `Quality`."""


@dataclass(frozen=True)
class ComparedSound:
    """One sound, computed or recorded."""

    source: str
    """Place, or file and channel."""
    recorded: bool
    highest: float | None
    """Hz at which a recording was cut; None: it is whole."""
    figures: Mapping[str, float | None]
    """`n5`, `n_max`, n10 in sone, `level` in dB(A) and the other figures of `creak.sound.quality`."""
    missing: Mapping[str, str]
    """Figure -> why it is none."""
    third_octaves: FloatArray
    """(28,) dB re 20 uPa, 25 Hz to 12.5 kHz."""
    time: FloatArray
    """(n,) s"""
    loudness: FloatArray
    """(n,) N(t), sone; empty: beyond ISO 532-1."""

    @property
    def name(self) -> str:
        """With where it was cut."""
        return self.source if self.highest is None else f"{self.source} to {self.highest:.0f} Hz"

    def as_dict(self) -> dict[str, Any]:
        """For JSON; N(t) with four digits, every 2 ms from `start`."""
        return {
            "name": self.name,
            "recorded": self.recorded,
            "highest": self.highest,
            **self.figures,
            "figures_missing": dict(self.missing),
            "third_octaves": self.third_octaves.tolist(),
            "loudness": {
                "start": float(self.time[0]) if self.time.size else 0.0,
                "step": 0.002,
                "sone": [float(f"{x:.4g}") for x in self.loudness.tolist()],
            },
        }


@dataclass(frozen=True)
class SoundComparison:
    """Sounds side by side, the loudest first: by N5, where equal by Nmax, where equal by level."""

    sounds: tuple[ComparedSound, ...]
    listener: str
    """That of the computed sounds."""
    band: tuple[float, float]
    """Hz, what is in those."""
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    """What is wrong with recordings."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "listener": self.listener,
            "band": list(self.band),
            "bands": BANDS.tolist(),
            "sounds": [s.as_dict() for s in self.sounds],
            "notes": list(self.notes),
            "warnings": list(self.warnings),
        }


def beside(folder: Path, recordings: Sequence[Recording], listener: str | None = None) -> SoundComparison:
    """The sounds of a run at a listener (its first) and recordings, which are heard twice: whole, and up to the end of
    the run's band, as nothing above is in what was computed.

    Figures of the run are those of its summary, over its verification window; those of a recording are over all of it.

    Raises
    ------
    InputError : as `read_sound`; no such listener, no recording.
    """
    stored = read_sound(folder)
    if not recordings:
        raise InputError("no recording to compare with", expected="one or more")
    name = stored.listeners[0] if listener is None else listener
    if name not in stored.listeners:
        raise InputError(f"no listener {name!r} in {folder}", fix=suggest(name, list(stored.listeners)))
    summary = read_sealed(folder / SUMMARY)["sound"]
    sounds = [*_computed(stored, stored.listeners.index(name), summary)]
    for recording in recordings:
        sounds += _recorded(recording, stored.band[1])
    note = (
        f"computed sounds have nothing outside {stored.band[0]:.0f} to {stored.band[1]:.0f} Hz: compare them with what "
        f"recordings have up to {stored.band[1]:.0f} Hz"
    )
    warnings = tuple(text for r in recordings for text in r.warnings)
    return SoundComparison(tuple(sorted(sounds, key=_rank, reverse=True)), name, stored.band, (note,), warnings)


def _rank(sound: ComparedSound) -> tuple[float, float, float]:
    n5, n_max, level = (sound.figures[name] for name in LOUDNESS)
    return np.inf if n5 is None else n5, np.inf if n_max is None else n_max, level if level is not None else -np.inf


def _computed(stored: StoredSound, listener: int, summary: Mapping[str, Any]) -> list[ComparedSound]:
    told = summary["listeners"][listener]
    every = [*told["places"], told]
    found = []
    for k, (name, one) in enumerate(zip(stored.places, every, strict=True)):
        figures = {key: one.get(key) for key in (*LOUDNESS, *FIGURES)}
        missing = one.get("figures_missing") or {key: OLD for key in FIGURES if key not in one}
        time, total = _over_time(loudness_of(stored.pressure[listener, k].astype(np.float64), stored.rate))
        found.append(ComparedSound(name, False, None, figures, missing, np.array(one["third_octaves"]), time, total))
    return found


def _recorded(recording: Recording, high: float) -> list[ComparedSound]:
    x = at_48k(recording.pressure, recording.rate)
    window = 0.0, x.size / RATE
    x = np.concatenate([x, np.zeros(round(RINGING * RATE))])  # what filters still hold at its end counts
    pieces: list[tuple[FloatArray, float | None]] = [(x, None)]
    if high < BANDS[-1]:
        pieces.append((low_pass(x, 1.0 / RATE, high), high))
    found = []
    for piece, highest in pieces:
        loud, limit = loudness_of(piece), np.inf if highest is None else highest
        heard = heard_with(piece, loud, window, None, limit, SHARP, silent=False)
        figures = {key: getattr(heard, key) for key in LOUDNESS} | heard.quality.figures
        rest = heard.quality.missing, heard.third_octaves, *_over_time(loud, window[1])
        found.append(ComparedSound(recording.name, True, highest, figures, *rest))
    return found


def _over_time(loud: Loudness | None, end: float = np.inf) -> tuple[FloatArray, FloatArray]:
    """Time up to `end` and N(t) there; none where it is beyond the standard."""
    if loud is None:
        return np.zeros(0), np.zeros(0)
    here = loud.time < end
    return loud.time[here], loud.total[here]
