"""Whether a quiet run under an excitation that repeats has come to the motion that repeats with it."""

from __future__ import annotations

import math

import numpy as np

from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History

NOTHING = 1e-6
"""Of what a gap moves by, by which it moves otherwise in the next period by round-off alone."""
SLOWEST = 0.99
"""Largest share of a transient that is taken to be left after a period."""
DONE = 0.05
"""Share of the last one at which a transient is gone."""


def may_still_close(history: History, gaps: GapOperator, period: float | None) -> str:
    """Which gap would close in a longer run, in a sentence; empty where none would, or where something pressed lately.

    Without contact the motion is that which repeats and a transient that decays. A gap that differs by d1 from the
    period before, and then by d2 from the one before that, has d1 r / (1 - r) to go with r = d1 / d2, as a geometric
    series, the way of one mode or of several that decay alike.

    Parameters
    ----------
    period : s after which all excitations begin again; None: they do not.
    """
    time = history.time
    if period is None or not gaps.m or time[-1] < 3.0 * period * (1.0 - 1e-9):
        return ""
    if history.force[time >= time[-1] - 3.0 * period].any():
        return ""
    last = time[time > time[-1] - period * (1.0 - 1e-9)]
    rows = [np.searchsorted(time, last - k * period - NOTHING * period) for k in range(3)]
    if any(np.abs(time[at] - last + k * period).max() > 2.0 * NOTHING * period for k, at in enumerate(rows)):
        return ""  # instants that do not come again
    now, before, first = (history.gap[at] for at in rows)
    d1, d2 = np.abs(now - before).max(axis=0), np.abs(before - first).max(axis=0)
    still = d1 <= NOTHING * np.ptp(now, axis=0)
    r = np.where(still, 0.0, np.minimum(d1 / np.where(d2 > 0.0, d2, 1.0), SLOWEST))
    lowest = now.min(axis=0)
    in_the_end = lowest - d1 * r / (1.0 - r)
    k = int(np.argmin(np.where(lowest > 0.0, in_the_end, np.inf)))
    if lowest[k] <= 0.0 or in_the_end[k] > 0.0:
        return ""
    more = math.ceil(math.log(DONE) / math.log(r[k]))
    return (
        f"the motion does not repeat yet: gap {gaps.names[k]} came to {lowest[k]:.3g} in the last period, after "
        f"{before[:, k].min():.3g} in the one before, and may close in a longer run; make it {more} periods longer"
    )
