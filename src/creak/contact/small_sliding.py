"""Are the partners of small sliding still the right ones after a run?"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator

SHARE = 0.5
"""Slip of this share of an element still leaves a point over or beside the facet that it was paired with."""
SHOWN = 5
"""Channels that a warning names."""


def slip_warnings(gaps: GapOperator, slip_max: FloatArray) -> list[str]:
    """One warning for each contact whose channels slip by more than half an element.

    Every channel keeps the facet and the normal that it has at the start (small sliding), which holds while the
    tangential motion is small against the elements. Channels whose size is not known (connectors) are passed over.

    Parameters
    ----------
    gaps : m channels with their `size`.
    slip_max : (m,) largest relative tangential motion of each channel over a run, length.
    """
    if gaps.size is None or not gaps.m:
        return []
    share = np.asarray(slip_max, dtype=np.float64) / gaps.size
    far = np.flatnonzero(share > SHARE)
    group = np.array(gaps.group, dtype=object)[far]
    return [_warning(gaps, gaps.size, share, far[group == name], name) for name in dict.fromkeys(group)]


def _warning(gaps: GapOperator, size: FloatArray, share: FloatArray, far: IntArray, name: str) -> str:
    worst = far[np.argsort(-share[far], kind="stable")]
    names = ", ".join(gaps.names[i] for i in worst[:SHOWN])
    names += f" and {worst.size - SHOWN} more" if worst.size > SHOWN else ""
    i = int(worst[0])
    return (
        f"[contact.{name}] {worst.size} channel(s) slip by more than half an element: {names}. {gaps.names[i]} slips "
        f"farthest, by {share[i] * size[i]:.3g} on elements {size[i]:.3g} wide; contact keeps the partners and normals "
        "that it has at the start (small sliding), so where and how it presses there is not to be trusted."
    )
