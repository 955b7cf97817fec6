"""Stick-slip events: where and how often a rubbing pair squeaks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.verify.intervals import chains, check_merging, in_window, stretches

LONGEST = 2.5
"""Periods of f_max that a pair may stick within one event."""
DUST, SHALLOW = 1e-5, 1e-3
"""Shares of the longest slide of the run and of the deepest penetration below which a way is no slide: what sticks is
solved for to a tolerance, and slides by atoms."""


@dataclass(frozen=True)
class SlipEvent:
    """Slips of one rubbing pair that follow each other closely.

    Length, speed and the chain of slips are those of the channel that takes the most work; the work is that of all
    channels of the pair.
    """

    group: str
    channel: str
    node_idx: int
    t_start: float
    t_end: float
    slip_length: float
    """Integral of the slip speed over all its slips, length."""
    speed_peak: float
    friction_work: float
    """Energy that the slips of the pair turned into heat."""
    slips: tuple[tuple[float, float], ...]
    """Start and end of each slip, s."""
    force_drop: float = 0.0
    """Largest fall of the friction force in a slip: of the last instant that sticks less the least while it slides."""

    @property
    def per_length(self) -> float | None:
        """Impulses per length of travel: its slips over the length of all of them, 1/length."""
        return len(self.slips) / self.slip_length if self.slip_length > 0.0 else None

    @property
    def rate(self) -> float | None:
        """Slips per second within the event: the frequency of the squeak; None for a single slip."""
        span = self.slips[-1][0] - self.slips[0][0]
        return (len(self.slips) - 1) / span if span > 0.0 else None


@dataclass(frozen=True)
class Squeak:
    """Stick-slip of one rubbing pair in a window: that of the channel whose slips take the most work."""

    group: str
    channel: str
    node_idx: int
    slips: int
    """Slips between two sticks that start in the window."""
    travel: float
    """Length of all its sliding in the window, that without stick-slip too."""
    slip_length: float
    """Mean length of a slip."""
    force_drop: float
    """Largest fall of the friction force in a slip."""
    energy: float
    """What its slips turned into heat."""
    rate: float
    """Slips per second of the window."""

    @property
    def per_length(self) -> float | None:
        """Impulses per length of travel, 1/length."""
        return self.slips / self.travel if self.travel > 0.0 else None


@dataclass(frozen=True)
class Slide:
    """Something slides, for a while, under pressure."""

    channel: int
    """-1: several."""
    row: int
    """Of the history, at which it first slides."""
    start: float
    end: float
    length: float
    peak: float
    work: float
    drop: float
    """Fall of the friction force; 0 where it did not stick before."""
    between_sticks: bool
    """A slip: it presses and sticks before and after."""


def find_slips(
    history: History, gaps: GapOperator, merge: float | None = None, f_max: float = 500.0
) -> list[SlipEvent]:
    """Stick-slip events of a run, by start time.

    A slip is an interval in which a channel presses and slides, between two in which it presses and sticks: sliding
    that begins with the touch or the run, or ends with the release, is a rub, no stick-slip. A single instant at rest
    is a reversal of the sliding, no stick. Slips of a pair less than `merge` seconds apart (default `LONGEST` periods
    of `f_max`, Hz) are one event. The slip speed is extrapolated to zero inside the steps at both ends; length and work
    are trapezoidal (`History.weights`).

    Raises
    ------
    InputError : an f_max that is no positive number, a negative merge, channels of another run.
    """
    check_merging(history, gaps, merge, f_max)
    if gaps.friction is None or not history.sliding.size:
        return []
    rubbing, weights = gaps.friction.channels, history.weights
    apart = LONGEST / f_max if merge is None else merge
    by_group: dict[str, list[Slide]] = {}
    for i, j in enumerate(rubbing.tolist()):
        by_group.setdefault(gaps.group[j], []).extend(_slips(history, weights, i, j))
    events = [_event(gaps, chain) for slips in by_group.values() for chain in chains(slips, apart)]
    return sorted(events, key=lambda e: (e.t_start, e.group))


def squeak_rates(events: Sequence[SlipEvent], window: tuple[float, float]) -> dict[str, float]:
    """Slips per second that start inside the window, of each pair that slips in it (leading channel of each event)."""
    length = window[1] - window[0]
    counts: dict[str, int] = {}
    for e in events:
        inside = sum(window[0] <= start <= window[1] for start, _ in e.slips)
        if inside:
            counts[e.group] = counts.get(e.group, 0) + inside
    return {group: n / length for group, n in counts.items()} if length > 0.0 else {}


def find_squeaks(history: History, gaps: GapOperator, window: tuple[float, float]) -> list[Squeak]:
    """What stick-slip each rubbing pair has in a window; pairs without a slip are left out."""
    if gaps.friction is None or not history.sliding.size:
        return []
    weights = history.weights
    inside = in_window(history.time, window)
    found: dict[str, Squeak] = {}
    for i, j in enumerate(gaps.friction.channels.tolist()):
        slips = [s for s in _slips(history, weights, i, j) if window[0] <= s.start <= window[1]]
        energy = sum(s.work for s in slips)
        before = found.get(gaps.group[j])
        if not slips or (before is not None and before.energy >= energy):
            continue
        speed = np.hypot(history.sliding[:, 2 * i], history.sliding[:, 2 * i + 1])
        found[gaps.group[j]] = Squeak(
            group=gaps.group[j],
            channel=gaps.names[j],
            node_idx=int(gaps.nodes_idx[j]),
            slips=len(slips),
            travel=float((weights * speed)[inside & (history.force[:, j] > 0.0)].sum()),
            slip_length=sum(s.length for s in slips) / len(slips),
            force_drop=max(s.drop for s in slips),
            energy=energy,
            rate=len(slips) / (window[1] - window[0]),
        )
    return list(found.values())


def _slips(history: History, weights: FloatArray, i: int, channel: int) -> list[Slide]:
    """Slips of the i-th rubbing channel."""
    sliding, tau = (a[:, 2 * i : 2 * i + 2] for a in (history.sliding, history.tangential))
    speed, pull = np.hypot(sliding[:, 0], sliding[:, 1]), np.hypot(tau[:, 0], tau[:, 1])
    closed = np.asarray(history.force[:, channel] > 0.0)
    depth = deepest(history, [channel])
    slipping = Slipping(closed, speed, pull, -(tau * sliding).sum(axis=1))
    found = slides_of(history.time, weights, slipping, depth, channel)
    return [s for s in found if s.between_sticks]


def deepest(history: History, channels: IntArray | Sequence[int]) -> float:
    """Largest penetration of some channels, length."""
    return max(0.0, -float(history.gap[:, channels].min(initial=0.0)))


class Slipping(NamedTuple):
    """What rubs, instant by instant."""

    closed: BoolArray
    """(n_time,) whether it presses."""
    speed: FloatArray
    """(n_time,) of the slip."""
    pull: FloatArray
    """(n_time,) size of the friction force."""
    power: FloatArray
    """(n_time,) of the friction force."""


def slides_of(
    time: FloatArray, weights: FloatArray, slipping: Slipping, depth: float, channel: int = -1
) -> list[Slide]:
    """All sliding under pressure but dust, single instants at rest counted in, that of touch and release too.

    Parameters
    ----------
    depth : `deepest`.
    """
    closed, speed, pull, power = slipping
    found = []
    for first, last in stretches(_without_reversals(closed & (speed > 0.0), closed)):
        rows = slice(first, last + 1)
        w, start, end, drop = weights[rows], float(time[first]), float(time[last]), 0.0
        stuck, sticks = first > 0 and closed[first - 1], last + 1 < closed.size and closed[last + 1]
        if stuck:
            start = _at_rest(time, speed, first, min(first + 1, closed.size - 1), first - 1)
            drop = max(0.0, float(pull[first - 1] - pull[rows].min()))
        if sticks:
            end = _at_rest(time, speed, last, max(last - 1, 0), last + 1)
        stuck = stuck and start > time[0]  # what begins with the run begins from nothing that is known
        length, peak, work = float(w @ speed[rows]), float(speed[rows].max()), float(w @ power[rows])
        found.append(
            Slide(
                channel=channel,
                row=first,
                start=start,
                end=end,
                length=length,
                peak=peak,
                work=work,
                drop=drop,
                between_sticks=bool(stuck and sticks),
            )
        )
    least = max(SHALLOW * depth, DUST * max((s.length for s in found), default=0.0))
    return [s for s in found if s.length > least]


def _without_reversals(slides: BoolArray, closed: BoolArray) -> BoolArray:
    """Sliding, with single closed instants at rest in between counted in."""
    alone = closed[1:-1] & slides[:-2] & slides[2:]
    filled = slides.copy()
    filled[1:-1] |= alone
    return filled


def _at_rest(time: FloatArray, speed: FloatArray, row: int, inner: int, outer: int) -> float:
    """When the speed was zero between `row`, the last sliding instant, and `outer`, at which it sticks."""
    drop = speed[inner] - speed[row]
    if drop <= 0.0:
        return float(time[outer])
    share = speed[row] / drop * (time[row] - time[inner]) / (time[outer] - time[row])
    return float(time[row] + min(share, 1.0) * (time[outer] - time[row]))


def _event(gaps: GapOperator, chain: list[Slide]) -> SlipEvent:
    work: dict[int, float] = {}
    for s in chain:
        work[s.channel] = work.get(s.channel, 0.0) + s.work
    leader = max(work, key=lambda j: work[j])
    own = [s for s in chain if s.channel == leader]
    return SlipEvent(
        group=gaps.group[leader],
        channel=gaps.names[leader],
        node_idx=int(gaps.nodes_idx[leader]),
        t_start=min(s.start for s in chain),
        t_end=max(s.end for s in chain),
        slip_length=sum(s.length for s in own),
        speed_peak=max(s.peak for s in own),
        friction_work=sum(work.values()),
        slips=tuple((s.start, s.end) for s in own),
        force_drop=max(s.drop for s in own),
    )
