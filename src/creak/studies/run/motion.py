"""Coordinates of a run around its hardest contact events, from which the motion of every node can be recovered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.dynamics.history import History
from creak.studies.prepare.marching import Marching
from creak.verify.events import Event, events_in

MEMORY = 400_000_000
"""Bytes of coordinates that a run keeps until its events are known."""
AFTER = 100_000_000
"""Bytes of those at contact that are kept after it."""
MOST_EVENTS = 12
FRAMES = 48
"""Most instants around an event."""
BESIDE = 2.0
"""Periods of the highest frequency of the excitation that are kept before and after an event."""
PER_PERIOD = 5.0
"""Fewest instants kept of such a period."""
NO_STEPS: IntArray = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Motion:
    """A run around one event, as coordinates of its System."""

    event: Event
    time: FloatArray
    """(k,) ends of whole steps."""
    coordinates: FloatArray
    """(n, k) q of the System."""
    supports: FloatArray
    """(n_support, k) prescribed motion."""


@dataclass(frozen=True)
class Recording:
    """Motions around the hardest events of the verification window, each event of them in one only."""

    motions: tuple[Motion, ...]
    why: str = ""
    """Why there are none."""


@dataclass(frozen=True)
class AtContact:
    """Coordinates of a run while something touches."""

    steps: IntArray
    """(k,) whole steps, sorted: those with an event of the verification window, and one more on either side."""
    coordinates: FloatArray
    """(n, k)"""


def recorded_steps(marching: Marching, period: float, n: int) -> IntArray:
    """Whole steps of the verification window at which a run of n coordinates keeps them all.

    They are every one, or as many as fit into `MEMORY`; none where that would not follow the motion.

    Parameters
    ----------
    period : of the highest frequency of the excitation, s.
    """
    time, (start, end) = marching.ends, marching.window
    inside = np.flatnonzero((time >= start - BESIDE * period) & (time <= end))
    every = -(-8 * n * inside.size // MEMORY)
    if every > 1 and every * (time[1] - time[0]) > period / PER_PERIOD:
        return NO_STEPS
    return inside[:: max(every, 1)].astype(np.int64)


def recorded(marching: Marching, period: float, system: System, history: History, events: Sequence[Event]) -> Recording:
    """The motion around the hardest events, hardest first, out of the coordinates that a run has kept.

    Every contact node comes first with its hardest event, then come the others; an event that another one's motion
    shows already is left out. Instants are those of whole steps, at most `FRAMES` of them.

    Parameters
    ----------
    period : as for `recorded_steps`.
    """
    if system.n != history.coordinates.shape[0] or not history.whole_at.size:
        return Recording((), _why_nothing(system, history))
    chosen: list[Motion] = []
    for event in _ranked(events_in(events, marching.window)):
        if len(chosen) < MOST_EVENTS and not any(_shows(m, event) for m in chosen):
            motion = _around(marching, BESIDE * period, history, event)
            chosen += [motion] if motion is not None else []
    return Recording(tuple(chosen), "" if chosen else "nothing touches in the verification window")


def at_contact(marching: Marching, system: System, history: History, events: Sequence[Event]) -> AtContact | None:
    """Of the coordinates that a run has kept those at contact; None where they are not all there, or too many."""
    ends, kept = marching.ends, history.whole_at
    inside = events_in(events, marching.window)
    first = np.searchsorted(ends, [e.t_start for e in inside], side="right") - 1
    last = np.searchsorted(ends, [e.t_end for e in inside], side="left")
    near = np.zeros(ends.size, dtype=bool)
    for a, b in zip(first.tolist(), last.tolist(), strict=True):
        near[max(a, 0) : b + 1] = True
    steps = np.flatnonzero(near)
    all_there = system.n == history.coordinates.shape[0] and np.isin(steps, kept).all()
    if not all_there or 8 * system.n * steps.size > AFTER:
        return None
    return AtContact(steps, history.coordinates[:, np.searchsorted(kept, steps)])


def at_steps(history: History, steps: IntArray) -> History:
    """The history with the coordinates of those steps only."""
    keep = np.isin(history.whole_at, steps)
    if keep.all():
        return history
    return replace(history, whole_at=history.whole_at[keep], coordinates=history.coordinates[:, keep])


def _why_nothing(system: System, history: History) -> str:
    if not history.whole_at.size:
        return (
            f"a run with {system.n} unknowns keeps no motion between the events, that would take more than "
            f"{MEMORY // 1_000_000} MB; with [output] field_interval and field_start the motion of a stretch of time "
            "is written to results.h5"
        )
    return "the run ended before its motion could be told from its coordinates"


def _ranked(events: Sequence[Event]) -> list[Event]:
    """By force, the hardest event of each contact node before the others."""
    by_force = sorted(events, key=lambda e: -e.force_place)
    seen: set[tuple[str, int]] = set()
    first: list[Event] = []
    later: list[Event] = []
    for e in by_force:
        (later if (e.group, e.node_idx) in seen else first).append(e)
        seen.add((e.group, e.node_idx))
    return first + later


def _shows(motion: Motion, event: Event) -> bool:
    return bool(motion.time[0] <= event.t_start and event.t_end <= motion.time[-1])


def _around(marching: Marching, beside: float, history: History, event: Event) -> Motion | None:
    """The kept instants from `beside` (s) an event to as much after it; None where there are fewer than three."""
    time, parts = marching.ends, marching.table.substeps
    kept = time[history.whole_at]
    at = np.flatnonzero((kept >= event.t_start - beside) & (kept <= event.t_end + beside))
    at = at[:: max(1, -(-at.size // FRAMES))]
    if at.size < 3:
        return None
    steps = history.whole_at[at]
    supports = marching.loads.support[0, parts * steps].T
    return Motion(event, time[steps], np.ascontiguousarray(history.coordinates[:, at]), supports)
