"""Courses that change within less than a step, spread over one so that samples of them hold their impulse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.signals.sources import Motion

MotionOf = Callable[[FloatArray], Motion]
CELLS = 8
"""Pieces into which a step is cut."""
LOST = 0.02
"""Of the range of a velocity: what its accelerations at the samples may miss of it in a step."""
SAMPLES = 3
"""Intervals of a step between whose samples the march puts a cubic."""


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
    end = SAMPLES * steps
    v, a, h = motion.velocity, motion.acceleration, float(t[1] - t[0])
    told = 0.375 * h * (a[0:end:3] + 3.0 * a[1:end:3] + 3.0 * a[2:end:3] + a[3 : end + 1 : 3])
    return float(np.abs(v[3 : end + 1 : 3] - v[0:end:3] - told).max())


def _averaged(motion_of: MotionOf, t: FloatArray, step: float) -> Motion:
    """Means over a step around t: those of derivatives are differences, that of the displacement is Simpson's."""
    ends = [_from_rest(motion_of, t + d) for d in (-0.5 * step, 0.5 * step)]
    cut = np.linspace(-0.5, 0.5, 2 * CELLS + 1)
    weights = np.array([1.0, *[4.0, 2.0] * (CELLS - 1), 4.0, 1.0]) / (6.0 * CELLS)
    mean = np.zeros(t.size)
    for w, d in zip(weights.tolist(), (cut * step).tolist(), strict=True):
        mean += w * _from_rest(motion_of, t + d).displacement
    differences = ((getattr(ends[1], x) - getattr(ends[0], x)) / step for x in ("displacement", "velocity"))
    return Motion(mean, *differences)


def _from_rest(motion_of: MotionOf, t: FloatArray) -> Motion:
    """Before t = 0 it stands where it begins."""
    motion = motion_of(np.maximum(t, 0.0))
    return Motion(
        motion.displacement, np.where(t < 0.0, 0.0, motion.velocity), np.where(t < 0.0, 0.0, motion.acceleration)
    )
