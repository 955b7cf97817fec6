"""What a run without contact tells of draws: how far gaps close, and so how far each is from touching."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.flow.unhindered import gaps_without_contact
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.signals.spectra import largest

FACTORS = (0.25, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0)
"""On the load, of the fragility curve."""
SURE = 0.05
"""Of its closing without contact that must be left of a gap, so that it stays open for sure: between two instants its
course is taken for a parabola."""
SAME = 1e-12
"""Of the largest load, round-off of a multiple of it."""


@dataclass(frozen=True)
class Linear:
    """A run without contact."""

    excursion: FloatArray
    """(m,) most that each kept channel closes in the window, 0 or less."""
    whole: FloatArray
    """The same of the whole run."""
    dropped: FloatArray
    """(2, k) gap at rest of the channels that the pre-check dropped, and most that they close in the whole run."""

    def times(self, factor: float) -> Linear:
        """That of `factor` times the loads, at rest before."""
        rest, closes = self.dropped
        return Linear(factor * self.excursion, factor * self.whole, np.stack([rest, factor * closes]))

    def clear_of(self, gap0: FloatArray, factors: FloatArray) -> BoolArray:
        """(n,) does nothing touch for sure, so that a run with contact is this one?

        Parameters
        ----------
        gap0 : (n, m) gaps at rest of each draw. factors : (n,) on the loads, at rest before.
        """
        by, (rest, closes) = (1.0 + SURE) * factors[:, None], self.dropped
        open_ones = (gap0 + by * self.whole > 0.0).all(axis=1)
        return np.asarray(open_ones & (rest + by * closes > 0.0).all(axis=1))

    def slack(self, gap0: FloatArray, factors: FloatArray, of_places: Sequence[BoolArray]) -> FloatArray:
        """(n, n_place, n_factor) smallest gap of each place, the loads times each of `FACTORS` besides.

        Parameters
        ----------
        gap0, factors : as for `clear_of`. of_places : (m,) channels of each place; inf where it has none.
        """
        found = np.full((len(gap0), len(of_places), len(FACTORS)), np.inf)
        for k, own in enumerate(of_places):
            for j, factor in enumerate(FACTORS if own.any() else ()):
                left = gap0[:, own] + (factor * factors)[:, None] * self.excursion[own]
                found[:, k, j] = left.min(axis=1)
        return found


def own_linear(
    system: System, gaps: GapOperator, dropped: GapOperator, loads: Loads, window: tuple[float, float]
) -> Linear:
    """How far gaps close in the study's own load without contact, between the steps too.

    Parameters
    ----------
    dropped : channels that the pre-check dropped.
    """
    every = join([gaps.without_force(), dropped])
    found = gaps_without_contact(system, every, loads, window=window)
    closing = [np.minimum(low[: gaps.m] - gaps.gap0, 0.0) for low in (found.in_window, found.lowest)]
    return Linear(closing[0], closing[1], np.stack([dropped.gap0, found.lowest[gaps.m :] - dropped.gap0]))


def linear_of(history: History, gaps: GapOperator, window: tuple[float, float], rest: FloatArray) -> Linear:
    """Of a run in which nothing touched, or could not, how far gaps closed.

    Parameters
    ----------
    rest : (k,) gaps at rest of the channels that the pre-check dropped.
    """
    inside = (history.time >= window[0]) & (history.time <= window[1])
    spans = [(history.time[i], history.gap[i]) for i in (inside, slice(None))]
    closing = [np.minimum(-largest(-gap, time) - gaps.gap0, 0.0) for time, gap in spans]
    return Linear(closing[0], closing[1], dropped_of(history, rest))


def dropped_of(history: History, rest: FloatArray) -> FloatArray:
    """`Linear.dropped` of any run; channels that were not watched stay at rest."""
    lowest = rest if history.extremes is None else history.extremes.gap
    return np.stack([rest, lowest - rest])


def closes(dropped: FloatArray) -> bool:
    """Does one of the channels that the pre-check dropped close?"""
    return bool((dropped.sum(axis=0) <= 0.0).any())


def multiple(loads: Loads, base: Loads) -> float | None:
    """f with loads = f base, 0 or more; None: they are no such multiple."""
    pairs = [(loads.support, base.support), (loads.force, base.force)]
    on = [loads.force_labels, base.force_labels]
    if any(a.shape != b.shape for a, b in pairs) or not all(map(np.array_equal, *on)):
        return None
    ours, of = (np.concatenate([x.ravel() for x in every]) for every in zip(*pairs, strict=True))
    k = int(np.abs(of).argmax()) if of.size else 0
    if not of.size or of[k] == 0.0:
        return None
    factor = float(ours[k] / of[k])
    same = np.allclose(ours, factor * of, rtol=0.0, atol=SAME * float(np.abs(ours).max()))
    return factor if factor >= 0.0 and same else None


def pressed(gaps: GapOperator) -> bool:
    """Do channels press from the start?"""
    return bool(gaps.resting.any() or (gaps.gap0[gaps.can_press()] < 0.0).any())
