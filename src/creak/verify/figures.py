"""What is followed of every event and every place from run to run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.verify.events import Event

FIGURES: dict[str, Callable[[Event], float]] = {
    "start": lambda e: e.t_start,
    "duration": lambda e: e.t_end - e.t_start,
    "force": lambda e: e.force_place,
    "impulse": lambda e: e.impulse,
    "closing_speed": lambda e: e.closing_speed,
}
"""What is followed of every event: s, s, low-passed peak force of its place, force s, length/s."""
OF_PLACE = ("events", "impulse", "force", "closing_speed", "n5")
"""What is followed of every place, over the verification window, as summary.json names it."""
TIMES = ("start", "duration")
"""Figures whose changes are absolute, s; those of the others are shares."""
UNTIL_THE_END = ("duration", "impulse")
"""Figures that are not known of an event that has not ended when the run does."""


def figures_of(event: Event) -> dict[str, float]:
    """All of an event."""
    return {name: of(event) for name, of in FIGURES.items()}


def change(name: str, before: float | None, after: float | None, floor: float = 0.0) -> float:
    """after - before (times, s) or that over |after| (or a floor); inf: something becomes nothing; nan: unknown."""
    if before is None or after is None:
        return np.nan
    if name in TIMES or after == before:
        return after - before
    scale = max(abs(after), floor)
    return (after - before) / scale if scale else np.inf
