"""Raw peak forces: the force of a damper is there at once when its channel touches, somewhere within a step."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History

COARSER = 1.5
"""Times the step of a touch from which the step before it is too long to tell how the gap closed in that."""


def peak_forces(history: History, gaps: GapOperator) -> FloatArray:
    """(n_time, m) forces, at least c v in the first row of a touch; those of the history where there is no damper.

    A damper c that meets what comes with the speed v presses with c v at the touch. A stiff one has lost much of that
    at the next instant. v is the slope of the gap in the step of the touch, or before it where that was steeper: in
    that step a march may slow it down already.
    """
    if not gaps.has_dampers:
        return history.force
    force, gap, step = history.force.copy(), history.gap, np.diff(history.time)
    for j in np.flatnonzero((gaps.damping > 0.0) & np.isfinite(gaps.stiffness)):
        shut = history.force[:, j] > 0.0
        touch = np.flatnonzero(shut[1:] & ~shut[:-1] & (gap[:-1, j] >= 0.0))
        speed = (gap[touch, j] - gap[touch + 1, j]) / step[touch]
        two = touch[(touch > 0) & (step[touch - 1] <= COARSER * step[touch]) & ~shut[touch - 1]]
        before = np.zeros(touch.size)
        before[np.isin(touch, two)] = (gap[two - 1, j] - gap[two, j]) / step[two - 1]
        force[touch + 1, j] = np.maximum(force[touch + 1, j], gaps.damping[j] * np.maximum(speed, before))
    return force
