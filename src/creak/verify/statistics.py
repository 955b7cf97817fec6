"""Events of two runs as samples: rates and distributions, for motion too chaotic to compare event by event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.verify.events import Event, events_in

CROWDED = 0.4
"""Events in a period of the highest excitation frequency from which two exact solutions are likely to part: 40 a second
on the door of the thesis, which is shaken up to 100 Hz."""
MANY = 10
"""Events in the window from which their statistics mean something."""
PARTS = 10
"""Of a window, in which runs of chaotic motion are compared."""


@dataclass(frozen=True)
class Distance:
    """Kolmogorov-Smirnov distance of two samples."""

    value: float
    """Largest difference of their cumulative distributions, 0 to 1."""
    critical: float
    """Exceeded in 5 % of cases by two independent samples of one distribution, 1.358 sqrt((n + m) / (n m)) (Smirnov,
    Ann. Math. Stat. 19, 1948; for large n and m)."""

    @property
    def alike(self) -> bool:
        return self.value <= self.critical


@dataclass(frozen=True)
class EventStatistics:
    """Rates and distributions of the events in a window; None where a run has no events."""

    count: tuple[int, int]
    """Events in the reference and in the reduced run."""
    length: float
    """Of the window, s."""
    force: Distance | None
    """Of the low-passed peaks."""
    impulse: Distance | None

    @property
    def rate(self) -> tuple[float, float]:
        """Events per second in the reference and in the reduced run."""
        a, b = (n / self.length if self.length > 0.0 else 0.0 for n in self.count)
        return a, b

    @property
    def interval(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """95 % confidence of both rates, events per second (`rate_interval`)."""
        a, b = (rate_interval(n, self.length) for n in self.count)
        return a, b

    @property
    def rates_alike(self) -> bool:
        """Counts differ by no more than 1.96 sqrt(n + m), as 95 % of those of two equal Poisson processes."""
        a, b = self.count
        return abs(a - b) <= 1.96 * np.sqrt(a + b)


def is_crowded(count: int, length: float, highest: float) -> bool:
    """Whether so many events in a window of `length` s are more than `CROWDED`.

    Parameters
    ----------
    highest : Hz, of the excitation; 0, where it is not known: nothing is said.
    """
    return 0.0 < CROWDED * highest * length < count >= MANY


def rate_interval(count: int, length: float) -> tuple[float, float]:
    """95 % confidence of the rate of a Poisson process that gave `count` events in `length` s.

    Exact: Garwood, Biometrika 28, 1936.
    """
    if length <= 0.0:
        return 0.0, np.inf
    from scipy.special import gammaincinv  # see `signals.spectra.low_pass`

    low = float(gammaincinv(count, 0.025)) if count else 0.0
    return low / length, float(gammaincinv(count + 1, 0.975)) / length


def chance(values: Sequence[float]) -> float:
    """By what share the sum of a figure of chaotic events may be another in a run as long, 95 % confidence.

    1.96 sqrt(sum x^2) / sum x, of a compound Poisson process: var sum x = n E x^2 (Feller, An Introduction to
    Probability Theory, volume 1, XII.2). Events that keep a distance from each other vary less.
    """
    x = np.asarray(values, dtype=float)
    return float(1.96 * np.sqrt(x @ x) / x.sum()) if x.sum() > 0.0 else 0.0


def chance_between(runs: Sequence[Sequence[Event]], window: tuple[float, float]) -> float:
    """The same of the sum of impulses, 95 % confidence, by two or more runs of one excitation that part.

    Each of `PARTS` equal parts of the window has a variance over the n runs, v_p; that of the sum is V = sum v_p, and
    its share Student's t times sqrt(V) over the mean, with V^2 / sum(v_p^2 / (n - 1)) degrees of freedom: few where the
    runs part late. What the excitation does in the parts is in all runs; regular events vary less than `chance` says,
    those that remember how hard the last ones were vary more.

    Source: batch means (Law, Simulation Modeling and Analysis, 2015, 9.5.3); degrees of freedom by Welch, Biometrika
    34, 1947. In 1,000 draws each of forty processes (2 and 4 runs of 12 to 400 events) it covered 96 to 99 of 100, and
    88 to 98 where impulses remember the last ones, of which `chance` covers 63 to 73.
    """
    from scipy.stats import t

    begin, end = window
    sums = np.zeros((len(runs), PARTS))
    for of_run, events in zip(sums, runs, strict=True):
        inside = events_in(events, window)
        at = np.array([(e.t_start - begin) / (end - begin) for e in inside])
        np.add.at(of_run, np.clip((PARTS * at).astype(int), 0, PARTS - 1), [e.impulse for e in inside])
    v, mean = sums.var(axis=0, ddof=1), float(sums.sum(axis=1).mean())
    if not v.any() or not mean > 0.0:
        return 0.0
    freedom = v.sum() ** 2 / (v @ v / (len(runs) - 1))
    return float(t.ppf(0.975, freedom) * np.sqrt(v.sum()) / mean)


def compare_statistics(
    reference: Sequence[Event], reduced: Sequence[Event], window: tuple[float, float]
) -> EventStatistics:
    """Statistics of the events that start inside `window`.

    Events of one run are not quite independent of each other, so the critical distances are a yardstick, no test.
    """
    a, b = events_in(reference, window), events_in(reduced, window)

    def distance(name: str) -> Distance | None:
        return ks_distance(*(np.array([getattr(e, name) for e in events]) for events in (a, b)))

    return EventStatistics((len(a), len(b)), window[1] - window[0], distance("force_place"), distance("impulse"))


def ks_distance(a: FloatArray, b: FloatArray) -> Distance | None:
    """sup |F_a(x) - F_b(x)| of two samples (n,) and (m,); None where one is empty."""
    if not a.size or not b.size:
        return None
    x = np.concatenate([a, b])
    below = [np.searchsorted(np.sort(s), x, side="right") / s.size for s in (a, b)]
    return Distance(
        float(np.abs(below[0] - below[1]).max()), float(1.358 * np.sqrt((a.size + b.size) / (a.size * b.size)))
    )
