"""Contact events: when, where and how hard; which way gap channels push."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.model.dofs import dofs_of, nodes_of
from creak.signals.spectra import blocks, low_pass_uneven
from creak.verify.intervals import chains, check_merging, in_window, overlap, stretches
from creak.verify.peaks import COARSER, peak_forces

AGAINST = -0.5
"""Cosine below which two channels push against each other: normals more than 120 degrees apart."""


def sides(gaps: GapOperator) -> list[IntArray]:
    """Channels of each contact by the way they push, contact by contact; every channel is in one of them."""
    way, found = pushes(gaps), []
    for group in dict.fromkeys(gaps.group):
        left = np.array([j for j, g in enumerate(gaps.group) if g == group], dtype=np.int64)
        while left.size:
            against = way[left] @ way[left[0]] < AGAINST
            found.append(left[~against])
            left = left[against]
    return found


def pushes(gaps: GapOperator) -> FloatArray:
    """(m, 6) unit direction in which a channel pushes its secondary node.

    In space where it moves the node's place, else about the axes of rotation; where G does not hold the node, the sum
    of its row over all nodes.
    """
    G = gaps.G.tocoo()
    at, dof = nodes_of(gaps.labels[G.col]), dofs_of(gaps.labels[G.col]) - 1
    own, whole = np.zeros((gaps.m, 6)), np.zeros((gaps.m, 6))
    np.add.at(whole, (G.row, dof), G.data)
    mine = at == gaps.nodes_idx[G.row]
    np.add.at(own, (G.row[mine], dof[mine]), G.data[mine])
    way = np.where(own.any(axis=1, keepdims=True), own, whole)
    way[np.asarray(way[:, :3].any(axis=1)), 3:] = 0.0
    length = np.linalg.norm(way, axis=1)[:, None]
    return np.asarray(np.divide(way, length, out=np.zeros_like(way), where=length > 0.0))


REACH = 6.0
"""Periods of f_max around an event that its low-pass sees: the slowest pole of a Butterworth of order 4 decays by
exp(-2 pi 6 sin(pi / 8)) = 5e-7 over them."""

LONGEST = 2.5
"""Periods of f_max: contact that is lost for longer makes another event, however long it lasts before and after."""
ROUND_OFF = 1e-9
"""Share of the largest force of a run, up to which another one is none."""
TOUCHING = 1e-9
"""Share of its largest gap up to which a channel touches."""
BESIDE, FINER = 4, 2
"""Samples of a low-pass beside an event that its spline goes through, and times as fine as these it is looked at."""
EventKey = tuple[str, int, str, float]


@dataclass(frozen=True)
class Event:
    """Contact of one side of a pair or connector, micro-contacts merged.

    Peaks are those of the most loaded channel; the impulse is that of all channels of the side.
    """

    group: str
    """The contact pair or connector."""
    channel: str
    """Channel with the highest force."""
    node_idx: int
    t_start: float
    """Where the first gap crosses zero, located inside the step."""
    t_peak: float
    t_end: float
    """Where the last force vanishes: where the gap crosses zero, with contact damping earlier."""
    force_peak: float
    """Largest channel force (`peak_forces`); does not converge with the step for a penalty contact."""
    force_peak_filtered: float
    """Largest channel force, low-passed at the verification's f_max."""
    impulse: float
    """Sum over channels of the trapezoidal integral of force over the event (`History.weights`)."""
    closing_speed: float
    """Speed at which the gap of the first channel closed, from its rate at the onset; 0 where the run starts closed."""
    contacts: int
    """Number of micro-contacts merged into the event."""
    force_place: float = 0.0
    """Largest force of all channels of the pair together, low-passed as `force_peak_filtered`: that of the place, which
    does not hang on how many nodes share it."""
    touches: tuple[tuple[float, float], ...] = ()
    """Start and end of each micro-contact, s."""
    step: float = 0.0
    """Length of the step in which the event began, s: the resolution of its times."""
    side: int = 0
    """Number of the side of the contact: channels that push against each other are on different ones."""
    margin: float = math.inf
    """By how much a time without contact would have to differ for the event to be two, or one with its neighbour, s."""
    unfinished: bool = False
    """Whether it still presses at the last instant: end, duration and impulse are those up to there, and no more."""

    @property
    def key(self) -> EventKey:
        """What tells it from all others of its run: contact, side, channel and start."""
        return self.group, self.side, self.channel, self.t_start


@dataclass(frozen=True)
class _Touch:
    """One micro-contact: rows of the history, times, and the channel that touched first."""

    first: int
    last: int
    start: float
    end: float
    leader: int


def find_events(history: History, gaps: GapOperator, merge: float | None = None, f_max: float = 500.0) -> list[Event]:
    """All events of a run, by start time.

    Intervals in which any channel of a side presses are its touches: channels of one contact that push the same way
    are a side (`sides`). Touches less than half a period of `f_max` apart, which the low-passed force cannot tell from
    each other, are one blow. Blows are one event where contact is lost for less time than either of them lasts, the
    contact's own time scale, and for less than `LONGEST` periods of `f_max`. Start and end are where the gap crosses
    zero inside a step: linear between the gaps on both sides, or, where exact unilateral contact holds the gap at zero,
    at the rate that it had while open. With contact damping the force vanishes before the gap is open again: the end is
    the first instant without force. Steps may be uneven.

    A channel that is closed from the start rests until it lets go: that is no event, what follows is (`resting`). What
    still presses when the run ends is `unfinished`. What presses by no more than `ROUND_OFF` of the run's largest force
    is none: it comes of what is balanced at rest.

    Low-passed peaks are those of the forces on an even axis that keeps their impulse (`signals.resampling`); where the
    steps around an event cannot hold `f_max` they are the raw ones.

    Parameters
    ----------
    merge : s; touches of a side less than this apart are one event, whatever their own time scale.
    f_max : of the low-pass, Hz.

    Raises
    ------
    InputError : an f_max that is no positive number, a negative merge, channels of another run.
    """
    check_merging(history, gaps, merge, f_max)
    weights, closing = history.weights, without_rest(history)
    raw = peak_forces(closing, gaps)
    events, count = [], dict.fromkeys(gaps.group, 0)
    for channels in sides(gaps):
        group = gaps.group[int(channels[0])]
        side, count[group] = count[group], count[group] + 1
        closed = stretches(np.asarray((closing.force[:, channels] > 0.0).any(axis=1)))
        touches = [_touch(closing, gaps, channels, first, last) for first, last in closed]
        for chain, margin in _merged(touches, merge) if merge is not None else _own_scale(touches, f_max):
            found = _event(closing, gaps, raw, weights, channels, chain, f_max)
            events.append(replace(found, side=side, margin=margin))
    least = least_force(history)
    return sorted((e for e in events if e.force_peak > least), key=lambda e: (e.t_start, e.group, e.side))


def least_force(history: History) -> float:
    """Force up to which nothing presses but round-off."""
    return ROUND_OFF * float(history.force.max(initial=0.0))


def contact_stretches(time: FloatArray, pressing: BoolArray, f_max: float) -> tuple[tuple[float, float], ...]:
    """Start and end of the events of one signal that presses at some instants, merged as `find_events` merges them.

    A signal that presses from the start rests until it lets go.
    """
    touches = [_Touch(a, b, float(time[a]), float(time[b]), 0) for a, b in stretches(pressing) if a > 0]
    return tuple((chain[0].start, chain[-1].end) for chain, _ in _own_scale(touches, f_max))


def events_in(events: Iterable[Event], window: tuple[float, float]) -> list[Event]:
    """Events that count in a time window: those that touch at any time of it, each with all of its figures.

    A blow that began before the window and lasts into it, or goes on beyond its end, is neither cut nor left out.
    """
    return [e for e in events if overlap(e.t_start, e.t_end, window)]


def counted_instants(time: FloatArray, events: Iterable[Event], window: tuple[float, float]) -> BoolArray:
    """(n,) instants of a window, and those of the events that count in it."""
    inside = in_window(time, window)
    for e in events_in(events, window):
        inside[np.searchsorted(time, e.t_start) : np.searchsorted(time, e.t_end, side="right")] = True
    return inside


def resting(history: History) -> BoolArray:
    """(m,) channels that are closed from the start: on a preload, because parts overlap, or because they lie there.

    The last start without force at a gap of zero, and without a speed: the parabola through their first three gaps
    starts with less than half of the mean slope of the first step (none from rest, all of it at a constant speed).
    """
    pressed = np.asarray(history.force[0] > 0.0)
    if history.time.size < 3:
        return pressed
    t, d = history.time[1:3] - history.time[0], history.gap[1:3] - history.gap[0]
    mean = d[0] / t[0]
    rate = mean - (d[1] / t[1] - mean) * t[0] / (t[1] - t[0])
    still = np.abs(rate) < 0.5 * np.abs(mean)
    touching = (history.gap[0] <= TOUCHING * np.abs(history.gap).max(axis=0)) & (history.force[1] > 0.0)
    return np.asarray(pressed | (touching & still))


def without_rest(history: History) -> History:
    """The history without the force of resting channels before they first let go."""
    rest = np.flatnonzero(resting(history))
    if not rest.size:
        return history
    force = history.force.copy()
    for j in rest.tolist():
        open_at = np.flatnonzero(force[1:, j] <= 0.0)
        force[: 1 + int(open_at[0]) if open_at.size else None, j] = 0.0
    return replace(history, force=force)


def _own_scale(touches: list[_Touch], f_max: float) -> list[tuple[list[_Touch], float]]:
    """Touches of one side in order: blows, less than half a period of `f_max` apart, and events of these; margins."""
    events: list[tuple[list[_Touch], float]] = []
    before = 0.0
    for chain in chains(touches, 0.5 / f_max):
        lasts, margin = chain[-1].end - chain[0].start, math.inf
        if events:
            event, least = events.pop()
            lost, most = chain[0].start - event[-1].end, min(lasts, before, LONGEST / f_max)
            margin = abs(lost - most)
            if lost < most:
                chain, margin = event + chain, min(margin, least)
            else:
                events.append((event, min(margin, least)))
        events.append((chain, margin))
        before = lasts
    return events


def _merged(touches: list[_Touch], merge: float) -> list[tuple[list[_Touch], float]]:
    """Touches of one side less than `merge` apart, and margins."""
    found = chains(touches, merge)
    lost = np.array([b.start - a.end for a, b in pairwise(touch for chain in found for touch in chain)])
    margin = np.concatenate([[math.inf], np.abs(lost - merge), [math.inf]])
    at = np.concatenate([[0], np.cumsum([len(chain) for chain in found])])
    return [(chain, float(margin[a : b + 1].min())) for chain, a, b in zip(found, at[:-1], at[1:], strict=True)]


def _event(
    history: History,
    gaps: GapOperator,
    raw: FloatArray,
    weights: FloatArray,
    channels: IntArray,
    chain: list[_Touch],
    f_max: float,
) -> Event:
    first, last, begin = chain[0].first, chain[-1].last, chain[0]
    active = channels[(history.force[first : last + 1, channels] > 0.0).any(axis=0)]
    row, peak, force, impulse = _peak_and_impulse(history, raw, weights, active, first, last)
    filtered = _filtered_peak(history, active, chain, f_max, force)
    alone = active.size == 1
    return Event(
        group=gaps.group[peak],
        channel=gaps.names[peak],
        node_idx=int(gaps.nodes_idx[peak]),
        t_start=begin.start,
        t_peak=float(history.time[row]),
        t_end=chain[-1].end,
        force_peak=force,
        force_peak_filtered=filtered,
        impulse=impulse,
        closing_speed=_closing_speed(history, begin),
        contacts=len(chain),
        force_place=filtered if alone else _filtered_peak(history, active, chain, f_max, force, together=True),
        touches=tuple((t.start, t.end) for t in chain),
        step=float(history.time[max(first, 1)] - history.time[max(first, 1) - 1]),
        unfinished=bool(last + 1 == history.time.size),
    )


def _peak_and_impulse(
    history: History, raw: FloatArray, weights: FloatArray, channels: IntArray, first: int, last: int
) -> tuple[int, int, float, float]:
    """Row, channel and size of the largest force, and the impulse of all channels."""
    row, channel, top, impulse = first, int(channels[0]), -1.0, 0.0
    for part in blocks(last + 1 - first, channels.size):
        rows = slice(first + part.start, first + part.stop)
        force = raw[rows][:, channels]
        impulse += float(weights[rows] @ history.force[rows][:, channels].sum(axis=1))
        k, j = np.unravel_index(int(np.argmax(force)), force.shape)
        if force[k, j] > top:
            row, channel, top = rows.start + int(k), int(channels[j]), float(force[k, j])
    return row, channel, top, impulse


def _filtered_peak(
    history: History, channels: IntArray, chain: list[_Touch], f_max: float, raw: float, together: bool = False
) -> float:
    """Largest low-passed force of one channel, or of all `together`, from the start of an event to its end; 0 where the
    low-pass of what comes before and after outweighs it: contact does not pull. Between samples it is a spline: an
    event may be shorter than one."""
    from scipy.interpolate import make_interp_spline

    time, first, last = history.time, chain[0].first, chain[-1].last
    begin, end = max(0, first - 1), min(last + 1, time.size - 1)
    if f_max * float(np.median(np.diff(time[begin : end + 1]))) >= 0.45:
        return float(history.force[first : last + 1, channels].sum(axis=1).max()) if together else raw
    a, b = np.searchsorted(time, [time[begin] - REACH / f_max, time[end] + REACH / f_max])
    rows, top = slice(int(a), int(b)), 0.0
    for part in [slice(None)] if together else blocks(channels.size, int(b - a)):
        force = history.force[rows][:, channels[part]]
        even, smooth = low_pass_uneven(time[rows], force.sum(axis=1)[:, None] if together else force, f_max)
        if even.size < 2:
            top = max(top, float(smooth.max()))
            continue
        span = np.clip([chain[0].start, chain[-1].end], even[0], even[-1])
        near = slice(max(0, int(np.searchsorted(even, span[0])) - BESIDE), int(np.searchsorted(even, span[1])) + BESIDE)
        at = np.linspace(span[0], span[1], FINER * math.ceil(float(np.ptp(span) / (even[1] - even[0]))) + 2)
        curve = make_interp_spline(even[near], smooth[near], k=min(3, even[near].size - 1))
        top = max(top, float(curve(at).max()))
    return top


# --- where a touch begins and ends inside a step -------------------------------------------------------------------


def _touch(history: History, gaps: GapOperator, channels: IntArray, first: int, last: int) -> _Touch:
    active = channels[history.force[first, channels] > 0.0]
    start, leader = float(history.time[0]), int(active[0])
    if first > 0:
        times = _crossings(history, gaps, active, first - 1, first, first - 2)
        leader, start = int(active[np.argmin(times)]), float(times.min())
    end = float(history.time[-1])
    if last + 1 < history.time.size:
        left = channels[history.force[last, channels] > 0.0]
        end = float(_crossings(history, gaps, left, last + 1, last, last + 2).max())
    return _Touch(first, last, start, max(start, end), leader)


def _crossings(
    history: History, gaps: GapOperator, channels: IntArray, opened: int, closed: int, beyond: int
) -> FloatArray:
    """Times at which gaps cross zero between an open and a closed instant, (k,).

    `beyond` is the instant past the open one: the rate towards it tells where a gap got there that is then held at
    zero, or at little less by a stiff spring.
    """
    time, step = history.time, history.time[closed] - history.time[opened]
    g0, g1 = history.gap[opened, channels], history.gap[closed, channels].copy()
    stopped = np.isinf(gaps.stiffness[channels])
    if 0 <= beyond < time.size:
        before = time[opened] - time[beyond]
        rate = (g0 - history.gap[beyond, channels]) / before
        stopped |= abs(before) <= COARSER * abs(step)
        g1[stopped] = np.minimum(g1, g0 + rate * step)[stopped]
    drop = g0 - g1
    share = np.divide(g0, drop, out=np.full(channels.size, 0.5), where=drop != 0.0)
    return np.asarray(time[opened] + np.clip(share, 0.0, 1.0) * step)


def _closing_speed(history: History, touch: _Touch) -> float:
    """Speed of the gap at the onset.

    Of the parabola through the last three open gaps, or fewer where there are no more. Where the step of the onset is
    shorter than the one before it, its end takes the place of the first of them: the motion up to there is that
    of the open gap, as contact acts from there on; not so where contact is held at zero.
    """
    first, j, time, gap = touch.first, touch.leader, history.time, history.gap
    if first == 0:
        return 0.0
    open_before = np.flatnonzero(history.force[max(0, first - 3) : first, j] > 0.0)
    low = max(0, first - 3) + (int(open_before[-1]) + 1 if open_before.size else 0)
    shorter = first > 1 and time[first - 1] - time[first - 2] > COARSER * (time[first] - time[first - 1])
    end = first
    if first - low < 2 or (shorter and gap[first, j] < 0.0):
        low, end = max(low, first - 2), first + 1
    t, g = time[low:end], gap[low:end, j]
    slope = np.diff(g) / np.diff(t)
    rate = slope[-1]
    if slope.size == 2:
        rate += (slope[1] - slope[0]) / (t[2] - t[0]) * (2.0 * touch.start - t[1] - t[2])
    return float(max(0.0, -rate))
