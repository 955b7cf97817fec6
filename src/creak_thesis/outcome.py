"""What is kept of a case: plain figures that go into a JSON file and onto the page."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from creak import InputError, read_json, write_json


@dataclass(frozen=True)
class EventRow:
    """One contact event of the window."""

    t_start: float
    t_peak: float
    force: float
    """Largest channel force, low-passed, N."""
    force_raw: float
    impulse: float
    """N s"""
    group: str = ""
    """The contact pair or connector."""


@dataclass(frozen=True)
class LoadOutcome:
    """One run and its comparison with the unreduced one."""

    cpu_s: float
    wall_s: float
    steps: int
    contact_steps: int
    energy_created: float
    """Share of the external work."""
    events: list[EventRow]
    pairs: list[list[int]] = field(default_factory=list)
    """Rows of common events: reference, this run."""
    nrmse: dict[str, float | None] = field(default_factory=dict)
    """Fit by axis x, y, z, all; None along axes without motion."""
    spectra: list[list[float]] = field(default_factory=list)
    """(n_freq, 3) root mean square over the pairs of the relative motion's amplitude, mm."""


@dataclass(frozen=True)
class Outcome:
    """One case."""

    name: str
    study: str
    variant: str
    n: int
    """Coordinates of the model before it is diagonalised."""
    channels: int
    retained: dict[str, int]
    """By part; empty for unreduced models."""
    modes: dict[str, int]
    """Fixed-interface modes by part."""
    unreduced: int
    """Coordinates of elements that stay unreduced."""
    offline_cpu_s: float
    offline_wall_s: float
    frequencies: list[float]
    """Reference, Hz, up to 100 Hz."""
    frequency_error: list[float]
    """Relative, of each; infinite without a partner."""
    mac: list[float]
    mac_matrix: list[list[float]]
    newton: dict[str, float] | None
    """`NewtonCost` as a dictionary."""
    loads: dict[str, LoadOutcome]
    freq: list[float] = field(default_factory=list)
    """Of the spectra, Hz."""
    channel_names: list[str] = field(default_factory=list)
    """Kept by the pre-check."""
    reason: str = ""
    """Why the case could not be run; empty: it was."""


def save_outcome(outcome: Outcome, key: dict[str, Any], path: Path) -> None:
    """Write an outcome with what it depends on."""
    write_json(path, {"key": key, "outcome": dataclasses.asdict(outcome)})


def load_outcome(path: Path, key: dict[str, Any]) -> Outcome | None:
    """The saved outcome; None where there is none, or it was made of something else."""
    try:
        data = read_json(path)
    except InputError:
        return None
    if data.get("key") != json.loads(json.dumps(key)):
        return None
    found = data["outcome"]
    loads = {
        name: LoadOutcome(**{**run, "events": [EventRow(**e) for e in run["events"]]})
        for name, run in found["loads"].items()
    }
    return Outcome(**{**found, "loads": loads})
