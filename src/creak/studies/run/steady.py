"""Whether the gaps of a run under an excitation that repeats have come to the motion that repeats with it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History

NOTHING = 1e-6
"""Of what a gap moves by, by which it moves otherwise in the next period by round-off alone."""
SLOWEST = 0.99
"""Largest share of a transient that is taken to be left after a period."""
DONE = 0.05
"""Share of the last one at which a transient is gone."""
NUMBERS = 2**22
"""Gaps that are compared at a time."""


FULL = 0.5
"""Share of a quiet run that must have the level asked for."""


@dataclass(frozen=True)
class Growth:
    """Gaps of the last periods of a run without contact, and how they go on."""

    lowest: FloatArray
    """(m,) in the last period."""
    before: FloatArray
    """(m,) lowest in the one before."""
    in_the_end: FloatArray
    """(m,) lowest in the motion that repeats; of a gap whose lowest rises from period to period that of the last: its
    transient has been larger before."""
    left: FloatArray
    """(m,) share of the transient that a period leaves."""


def growth(time: FloatArray, gap: FloatArray, period: float | None) -> Growth | None:
    """How gaps (n_time, m) that nothing pressed go on; None: the excitation does not repeat, or not three times.

    Without contact the motion is that which repeats and a transient that decays. A gap that differs by d1 from the
    period before, and then by d2 from the one before that, has d1 r / (1 - r) to go with r = d1 / d2, as a geometric
    series, the way of one mode or of several that decay alike.

    Parameters
    ----------
    period : s after which all excitations begin again; None: they do not.
    """
    if period is None or time[-1] < 3.0 * period * (1.0 - 1e-9):
        return None
    last = time[time > time[-1] - period * (1.0 - 1e-9)]
    rows = [np.searchsorted(time, last - k * period - NOTHING * period) for k in range(3)]
    if any(np.abs(time[at] - last + k * period).max() > 2.0 * NOTHING * period for k, at in enumerate(rows)):
        return None  # instants that do not come again
    lowest, before, third, d1, d2, moved = np.empty((6, gap.shape[1]))
    step = max(1, NUMBERS // last.size)
    for first in range(0, gap.shape[1], step):
        some = slice(first, first + step)
        now, then, first_of_all = (gap[at, some] for at in rows)
        lowest[some], before[some], third[some] = (of.min(axis=0) for of in (now, then, first_of_all))
        moved[some] = np.ptp(now, axis=0)
        d1[some], d2[some] = np.abs(now - then).max(axis=0), np.abs(then - first_of_all).max(axis=0)
    r = np.where(d1 <= NOTHING * moved, 0.0, np.minimum(d1 / np.where(d2 > 0.0, d2, 1.0), SLOWEST))
    rises = (third <= before) & (before <= lowest)
    return Growth(lowest, before, np.where(rises, lowest, lowest - d1 * r / (1.0 - r)), r)


def faded_in(history: History, fade: float) -> str:
    """That a quiet run hardly has the level that its study asks for, in a sentence; empty where it has, or something
    pressed.

    Parameters
    ----------
    fade : s over which prescribed motion fades in.
    """
    end = float(history.time[-1])
    if fade <= (1.0 - FULL) * end or history.force.any():
        return ""
    return (
        f"the prescribed motion fades in for {fade:.3g} s and the run ends at {end:.3g} s, so most of it is below the "
        f"level that the study asks for: let it end after {2.0 * fade:.3g} s or more"
    )


def may_still_close(history: History, gaps: GapOperator, period: float | None, unit: str) -> str:
    """Which gap would close in a longer run, in a sentence; empty where none would, or where something pressed lately.

    Parameters
    ----------
    period : as for `growth`. unit : of length.
    """
    time = history.time
    if period is None or not gaps.m or history.force[time >= time[-1] - 3.0 * period].any():
        return ""
    seen = growth(time, history.gap, period)
    if seen is None:
        return ""
    k = int(np.argmin(np.where(seen.lowest > 0.0, seen.in_the_end, np.inf)))
    if seen.lowest[k] <= 0.0 or seen.in_the_end[k] > 0.0:
        return ""
    more = math.ceil(math.log(DONE) / math.log(seen.left[k]))
    return (
        f"the motion does not repeat yet: gap {gaps.names[k]} came to {seen.lowest[k]:.3g} {unit} in the last period, "
        f"after {seen.before[k]:.3g} {unit} in the one before, and may close in a longer run; make it {more} periods "
        "longer"
    )
