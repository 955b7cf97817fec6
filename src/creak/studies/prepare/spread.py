"""Courses that change within less than a step, spread over one so that samples of them hold their impulse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.flow.march import SAMPLES
from creak.signals.signal import Motion

MotionOf = Callable[[FloatArray], Motion]
CELLS = 8
"""Pieces into which a step is cut."""
LOST = 0.02
"""Of the range of a velocity: what its accelerations at the samples may miss of it in a step."""


def resolved(motion_of: MotionOf, t: FloatArray) -> Motion:
    """The motion at even instants (n,), `SAMPLES` intervals a step, spread where they do not follow it.

    Accelerations count by a rule of cubics, 3/8 h (a_0 + 3 a_1 + 3 a_2 + a_3) = v_3 - v_0. A rise of velocity within
    less than a step is missed by it, or counts many times, as samples fall. Where more than `LOST` is, the motion is
    averaged over a step, by which any samples have the right sum; what begins at t = 0 comes half a step later.
    """
    motion = motion_of(t)
    n = (t.size - 1) // SAMPLES
    if n < 1 or _lost(motion, t, n) <= LOST * float(np.ptp(motion.velocity)):
        return motion
    step = SAMPLES * float(t[1] - t[0])
    found = _averaged(motion_of, t, step)
    moves_early = abs(found.velocity[0] - motion.velocity[0]) > LOST * float(np.ptp(motion.velocity))
    return _averaged(motion_of, t - 0.5 * step, step) if moves_early else found


def _lost(motion: Motion, t: FloatArray, steps: int) -> float:
    """Largest change of the velocity in a step that its accelerations do not tell."""
    ends = SAMPLES * np.arange(steps + 1)
    v, a, h = motion.velocity[ends], motion.acceleration, float(t[1] - t[0])
    told = 0.375 * h * (a[ends[:-1]] + 3.0 * a[ends[:-1] + 1] + 3.0 * a[ends[:-1] + 2] + a[ends[1:]])
    return float(np.abs(np.diff(v) - told).max())


def _averaged(motion_of: MotionOf, t: FloatArray, step: float) -> Motion:
    """Means over a step around t: those of derivatives are differences, that of the displacement is Simpson's."""
    first, last = (_from_rest(motion_of, t + d) for d in (-0.5 * step, 0.5 * step))
    weights, within = [4.0, 2.0] * (CELLS - 1) + [4.0], np.linspace(-0.5, 0.5, 2 * CELLS + 1)[1:-1] * step
    mean = first.displacement + last.displacement
    for w, d in zip(weights, within.tolist(), strict=True):
        mean += w * _from_rest(motion_of, t + d).displacement
    moved, faster = (getattr(last, x) - getattr(first, x) for x in ("displacement", "velocity"))
    return Motion(mean / (6.0 * CELLS), moved / step, faster / step)


def _from_rest(motion_of: MotionOf, t: FloatArray) -> Motion:
    """Before t = 0 it stands where it begins."""
    motion = motion_of(np.maximum(t, 0.0))
    return Motion(
        motion.displacement, np.where(t < 0.0, 0.0, motion.velocity), np.where(t < 0.0, 0.0, motion.acceleration)
    )
