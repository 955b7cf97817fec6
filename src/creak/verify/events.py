"""Contact events: when, where and how hard, and which of them two runs share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.signals.spectra import low_pass


@dataclass(frozen=True)
class Event:
    """Contact of one pair or connector, micro-contacts merged.

    Peaks are those of the most loaded channel; the impulse is that of all channels of the pair.
    """

    group: str
    """The contact pair or connector side."""
    channel: str
    """Channel with the highest force."""
    node_idx: int
    t_start: float
    t_peak: float
    t_end: float
    force_peak: float
    """Largest channel force; does not converge with the step for a penalty contact."""
    force_peak_filtered: float
    """Largest channel force, low-passed at the verification's f_max."""
    impulse: float
    """Sum over channels of the integral of force over the event."""
    closing_speed: float
    """Speed at which the gap of the first channel closed."""
    contacts: int
    """Number of micro-contacts merged into the event."""


def find_events(history: History, gaps: GapOperator, merge: float, f_max: float) -> list[Event]:
    """All events of a run, by start time.

    Intervals in which any channel of a group presses; those less than `merge` seconds apart are one event.
    Start and end are where the gap crosses zero between two steps (linear).
    """
    smooth = low_pass(history.force, history.step, f_max)
    events = []
    for group in dict.fromkeys(gaps.group):
        channels = np.array([j for j, g in enumerate(gaps.group) if g == group], dtype=np.int64)
        closed = np.asarray((history.force[:, channels] > 0.0).any(axis=1))
        for chain in _chains(closed, merge / history.step):
            events.append(_event(history, gaps, smooth, group, channels, chain))
    return sorted(events, key=lambda e: (e.t_start, e.group))


def _chains(closed: BoolArray, merge_steps: float) -> list[list[tuple[int, int]]]:
    """Runs of closed steps (first, last), grouped where the pause is shorter than `merge_steps`."""
    edges = np.diff(np.concatenate([[False], closed, [False]]).astype(np.int8))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    chains: list[list[tuple[int, int]]] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        if chains and start - chains[-1][-1][1] <= merge_steps:
            chains[-1].append((start, stop))
        else:
            chains.append([(start, stop)])
    return chains


def _event(
    history: History, gaps: GapOperator, smooth: FloatArray, group: str, channels: IntArray,
    chain: list[tuple[int, int]],
) -> Event:  # fmt: skip
    first, last = chain[0][0], chain[-1][1]
    force = history.force[first : last + 1, channels]
    row, col = np.unravel_index(int(np.argmax(force)), force.shape)
    peak = int(channels[col])
    near = slice(max(0, first - 1), last + 2)
    leader, t_start = _onset(history, channels, first)
    return Event(
        group=group,
        channel=gaps.names[peak],
        node_idx=int(gaps.nodes_idx[peak]),
        t_start=t_start,
        t_peak=float(history.time[first + int(row)]),
        t_end=_release(history, channels, last),
        force_peak=float(force.max()),
        force_peak_filtered=float(smooth[near][:, channels].max()),
        impulse=float(force.sum() * history.step),
        closing_speed=_closing_speed(history, leader, first),
        contacts=len(chain),
    )


def _crossing(history: History, channel: int, before: int) -> float:
    g0, g1 = history.gap[before, channel], history.gap[before + 1, channel]
    fraction = float(np.clip(g0 / (g0 - g1), 0.0, 1.0)) if g0 != g1 else 0.5
    return float(history.time[before]) + fraction * history.step


def _onset(history: History, channels: IntArray, first: int) -> tuple[int, float]:
    active = channels[history.force[first, channels] > 0.0]
    if first == 0:
        return int(active[0]), float(history.time[0])
    times = [_crossing(history, int(j), first - 1) for j in active]
    k = int(np.argmin(times))
    return int(active[k]), times[k]


def _release(history: History, channels: IntArray, last: int) -> float:
    if last + 1 >= history.time.size:
        return float(history.time[-1])
    active = channels[history.force[last, channels] > 0.0]
    return max(_crossing(history, int(j), last) for j in active)


def _closing_speed(history: History, channel: int, first: int) -> float:
    if first == 0:
        return 0.0
    end = first - 1 if first >= 2 else first
    return float(max(0.0, (history.gap[end - 1, channel] - history.gap[end, channel]) / history.step))


@dataclass(frozen=True)
class EventMatch:
    """Events of a reduced run against those of its reference, within a time window."""

    pairs: list[tuple[Event, Event]]
    """(reference, reduced)"""
    missed: list[Event]
    extra: list[Event]

    @property
    def amplitude_ratio_mean(self) -> float | None:
        """Mean low-passed peak of the common events, reduced / reference (thesis 3.7.3)."""
        return self._ratio("force_peak_filtered")

    @property
    def impulse_ratio_mean(self) -> float | None:
        """Mean impulse of the common events, reduced / reference."""
        return self._ratio("impulse")

    @property
    def within_5_percent(self) -> int:
        """Common events whose low-passed peaks differ by at most 5 %."""
        return sum(
            abs(b.force_peak_filtered / a.force_peak_filtered - 1.0) <= 0.05
            for a, b in self.pairs if a.force_peak_filtered > 0.0
        )  # fmt: skip

    def _ratio(self, name: str) -> float | None:
        reference = sum(getattr(a, name) for a, _ in self.pairs)
        return sum(getattr(b, name) for _, b in self.pairs) / reference if reference > 0.0 else None


def match_events(
    reference: Sequence[Event], reduced: Sequence[Event], tolerance: float, window: tuple[float, float]
) -> EventMatch:
    """Match one to one by start time within `tolerance` s, nearest first, in the same group.

    Only events that start inside `window` are counted, but their partners may start just outside it.
    """
    candidates = sorted(
        (abs(a.t_start - b.t_start), i, j)
        for i, a in enumerate(reference)
        for j, b in enumerate(reduced)
        if a.group == b.group and abs(a.t_start - b.t_start) <= tolerance
    )
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for _, i, j in candidates:
        if i not in partner and j not in taken:
            partner[i] = j
            taken.add(j)

    def inside(e: Event) -> bool:
        return window[0] <= e.t_start <= window[1]

    pairs = [(reference[i], reduced[j]) for i, j in sorted(partner.items()) if inside(reference[i])]
    missed = [e for i, e in enumerate(reference) if i not in partner and inside(e)]
    extra = [e for j, e in enumerate(reduced) if j not in taken and inside(e)]
    return EventMatch(pairs, missed, extra)
