"""Are motions small enough for contact that keeps its partners and normals, and for rotations taken as small?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.words import first_few

SHARE = 0.5
"""Slip of this share of an element still leaves a point over or beside the facet that it was paired with."""
SHOWN = 5
"""Channels that a warning names."""
TURN = np.radians(10.0)
"""rad: a rotation theta taken as small lengthens an arm by theta^2 / 2, here by 1.5 %."""


def slip_warnings(gaps: GapOperator, slip_max: FloatArray, unit: str, at: FloatArray | None = None) -> list[str]:
    """One warning for each contact whose channels slip by more than half an element.

    Every channel keeps the facet and the normal that it has at the start (small sliding), which holds while the
    tangential motion is small against the elements. Channels whose size is not known (connectors) are passed over.

    Parameters
    ----------
    gaps : m channels with their `size`.
    slip_max : (m,) largest relative tangential motion of each channel over a run, length. at : (m,) when, s.
    """
    if gaps.size is None or not gaps.m:
        return []
    share = np.asarray(slip_max, dtype=np.float64) / gaps.size
    far = np.flatnonzero(share > SHARE)
    group = np.array(gaps.group, dtype=object)[far]
    return [_warning(gaps, gaps.size, share, far[group == name], name, unit, at) for name in dict.fromkeys(group)]


def turn_warnings(names: Sequence[str], turn: FloatArray, at: FloatArray) -> list[str]:
    """One warning where anything turns by more than `TURN`.

    Parameters
    ----------
    names, turn, at : (k,) places, their largest rotations (rad), and when (s).
    """
    far = np.flatnonzero(turn > TURN)
    if not far.size:
        return []
    i = int(far[np.argmax(turn[far])])
    what = f"and {far.size - 1} more parts or nodes turn" if far.size > 1 else "turns"
    return [
        f"{names[i]} {what} by more than {np.degrees(TURN):.2g} degrees, farthest by "
        f"{np.degrees(turn[i]):.3g} at t = {at[i]:.4g} s; creak takes rotations as small, which lengthens what turns "
        f"by {50.0 * turn[i] ** 2:.2g} %, so where and when it touches is not to be trusted."
    ]


def _warning(
    gaps: GapOperator,
    size: FloatArray,
    share: FloatArray,
    far: IntArray,
    name: str,
    unit: str,
    at: FloatArray | None,
) -> str:
    worst = far[np.argsort(-share[far], kind="stable")]
    names = first_few((gaps.names[i] for i in worst), worst.size, SHOWN)
    i = int(worst[0])
    when = "" if at is None else f" at t = {at[i]:.4g} s"
    return (
        f"[contact.{name}] {worst.size} channel(s) slip by more than half an element: {names}. {gaps.names[i]} slips "
        f"farthest, by {share[i] * size[i]:.3g} {unit}{when} on elements {size[i]:.3g} {unit} wide; contact keeps the "
        "partners and normals that it has at the start (small sliding), so where and how it presses there is not to be "
        "trusted."
    )
