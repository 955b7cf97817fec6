"""What friction does between two parts: whether it sticks, slips by turns or slides, how often, and what it takes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.signals.spectra import low_pass_uneven
from creak.verify.events import least_force
from creak.verify.intervals import in_window, overlap, stretches
from creak.verify.slips import Slide, Slipping, deepest, slides_of

STICK, STICK_SLIP, SLIDING = "stick", "stick-slip", "sliding"
STATES = (STICK, STICK_SLIP, SLIDING)
FIGURES = (
    *("slips", "slip_rate", "slip_time", "slip_share", "slip_path", "slip_speed_rms", "friction_energy"),
    *("force_mean", "force_rms"),
)
"""Of a place, as summary.json names them."""
LASTING = 0.95
"""Share of a window that one stretch of contact fills to be lasting."""
HOLDS = 0.45
"""Of the low-pass frequency times the step, the most that steps can hold (as that of events)."""
MOST = 0.5
"""Share of the force above which what slides carries a place."""
SELDOM = 0.05
"""Share of the time in contact below which a place that slides counts as one at rest."""
LONG = 10.0
"""Times the median slip: what lasts longer between two sticks is steady sliding."""


@dataclass(frozen=True)
class Rubbing:
    """Friction of neighbouring channels in a window.

    They slide as one: by the speed of each of them and the share of the force that it carries. They count as sliding
    where what slides carries more than half of the force.
    """

    contact_time: float
    """s in which any of them presses."""
    shares: tuple[float, float, float]
    """Of that: stick, stick-slip (from the first of some slips to the end of the last), steady sliding."""
    slip_time: float
    """s in which they slide, by turns or steadily; of a part of the force that part."""
    slips: tuple[tuple[float, float], ...]
    """Start and end of each slip between two sticks that begins in the window, s."""
    path: float
    """Length of all sliding."""
    speed_rms: float
    """Root mean square of the slip speed while they press."""
    energy: float
    """What friction turned into heat."""

    @property
    def state(self) -> str:
        """What they do most of the time."""
        return STATES[int(np.argmax(self.shares))]

    @property
    def share(self) -> float:
        """Of the time in contact in which they slide."""
        return self.slip_time / self.contact_time if self.contact_time > 0.0 else 0.0

    @property
    def rate(self) -> float | None:
        """Slips per second from the first to the last one: the frequency of a squeak; None below three slips."""
        between = self.between
        return float(1.0 / between.mean()) if between.size > 1 and between.mean() > 0.0 else None

    @property
    def irregularity(self) -> float | None:
        """Standard deviation of the times between slips over their mean: 0 as regular as a clock; None below three."""
        between = self.between
        return float(between.std() / between.mean()) if between.size > 1 and between.mean() > 0.0 else None

    @property
    def between(self) -> FloatArray:
        """Times from the beginning of each slip to that of the next one, s."""
        return np.diff([start for start, _ in self.slips])


@dataclass(frozen=True)
class Pressing:
    """Normal force of contact that lasts for the whole window, of all channels together, low-passed."""

    mean: float
    rms: float
    """Root mean square of its fluctuation about the mean."""


@dataclass(frozen=True)
class Rub:
    """Friction, and force of lasting contact, of neighbouring channels in a window."""

    friction: Rubbing | None = None
    """None: they have none, or do not press."""
    force: Pressing | None = None
    """None: contact does not last."""

    @property
    def figures(self) -> dict[str, float]:
        """Those that are known, as summary.json names them."""
        found: dict[str, float | None] = dict.fromkeys(FIGURES)
        if self.friction is not None:
            r = self.friction
            every = (float(len(r.slips)), r.rate, r.slip_time, r.share, r.path, r.speed_rms, r.energy)
            found.update(zip(FIGURES, every, strict=False))
        if self.force is not None:
            found |= {"force_mean": self.force.mean, "force_rms": self.force.rms}
        return {name: x for name, x in found.items() if x is not None}


NOTHING = Rub()


def rub_of(history: History, gaps: GapOperator, channels: IntArray, window: tuple[float, float], f_max: float) -> Rub:
    """What some channels do in a window; `f_max` of the low-pass, Hz."""
    return Rub(rubbing(history, gaps, channels, window), pressing(history, channels, window, f_max))


def rubbing(history: History, gaps: GapOperator, channels: IntArray, window: tuple[float, float]) -> Rubbing | None:
    """Friction of some channels in a window; None where none of them has friction and presses in it."""
    if gaps.friction is None or not history.sliding.size:
        return None
    time, inside, every = history.time, in_window(history.time, window), gaps.friction.channels
    own = [i for i in np.flatnonzero(np.isin(every, channels)).tolist() if history.force[inside, every[i]].any()]
    if not own:
        return None
    force, slid, speed, power = (np.zeros(time.size) for _ in range(4))
    for i in own:
        pair, f = slice(2 * i, 2 * i + 2), history.force[:, every[i]]
        v = np.hypot(*history.sliding[:, pair].T)
        force += f
        slid += f * (v > 0.0)
        speed += f * v
        power -= (history.tangential[:, pair] * history.sliding[:, pair]).sum(axis=1)
    closed = np.asarray(force > 0.0)
    slid, speed = (np.divide(x, force, out=np.zeros(time.size), where=closed) for x in (slid, speed))
    as_one = np.where(slid > MOST, speed, 0.0)
    depth = deepest(history, every[own])
    every_slide = slides_of(time, history.weights, Slipping(closed, as_one, np.zeros(time.size), power), depth)
    slides = [s for s in every_slide if overlap(s.start, s.end, window)]
    slips = [s for s in slides if s.between_sticks]
    weights = np.where(inside, history.weights, 0.0)
    contact = float(weights[closed].sum())
    chains = [(chain[0].start, chain[-1].end) for chain in _by_turns(slips, closed)]
    whole = _within([(s.start, s.end) for s in slides], window)
    by_turns = min(_within(chains, window), contact)
    steady = whole - _within([(s.start, s.end) for s in slides if any(a <= s.start < b for a, b in chains)], window)
    shares = np.array([contact - by_turns - steady, by_turns, steady]).clip(0.0) / contact
    return Rubbing(
        contact,
        (float(shares[0]), float(shares[1]), float(shares[2])),
        min(contact, whole + float(weights @ (slid - (as_one > 0.0)))),
        tuple((s.start, s.end) for s in slips if window[0] <= s.start <= window[1]),
        float(weights @ speed),
        float(np.sqrt(weights @ speed**2 / contact)),
        float(weights @ power),
    )


def pressing(history: History, channels: IntArray, window: tuple[float, float], f_max: float) -> Pressing | None:
    """Force of channels of which some press for `LASTING` of a window on end; None of others.

    Parameters
    ----------
    f_max : of the low-pass, Hz; where the steps cannot hold it, or the window no period, the force is the raw one.
    """
    time, force, weights = history.time, history.force[:, channels].sum(axis=1), history.weights
    inside = in_window(time, window)
    t = time[inside]
    closed = stretches(np.asarray(force[inside] > least_force(history)))
    if not closed or max(t[last] - t[first] for first, last in closed) < LASTING * (window[1] - window[0]):
        return None
    if f_max * float(np.median(np.diff(time))) < HOLDS and f_max * (window[1] - window[0]) >= 1.0:
        time, smooth = low_pass_uneven(time, force[:, None], f_max)
        force, weights = smooth[:, 0], np.ones(time.size)
    inside = in_window(time, window)
    mean = float(np.average(force[inside], weights=weights[inside]))
    return Pressing(mean, float(np.sqrt(np.average((force[inside] - mean) ** 2, weights=weights[inside]))))


def _by_turns(slips: Sequence[Slide], closed: BoolArray) -> list[list[Slide]]:
    """Two slips or more with nothing but sticks between them; what lasts `LONG` times the median is none of them."""
    if not slips:
        return []
    long = LONG * float(np.median([s.end - s.start for s in slips]))
    opened = np.cumsum(~closed)
    found: list[list[Slide]] = [[]]
    for s in slips:
        if s.end - s.start > long:
            found.append([])
        elif found[-1] and opened[found[-1][-1].row] != opened[s.row]:
            found.append([s])
        else:
            found[-1].append(s)
    return [chain for chain in found if len(chain) > 1]


def _within(spans: Iterable[tuple[float, float]], window: tuple[float, float]) -> float:
    """Length of spans that lies in a window."""
    return sum(max(0.0, min(end, window[1]) - max(start, window[0])) for start, end in spans)
