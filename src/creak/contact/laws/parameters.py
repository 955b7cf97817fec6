"""Laws on m channels: pressure curves and friction, a contact law laid over channels, and arrays for compiled code."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.channel_data import POOLED, per_channel
from creak.model.contact_law import ContactLaw, check_curve, check_friction


@dataclass(frozen=True)
class Curves:
    """Tabular pressure-overclosure: force of a channel = scale x curve(overclosure), piecewise linear.

    Raises
    ------
    InputError : a curve that does not rise from zero.
    """

    of: IntArray = field(metadata=per_channel(-1, into="points"))
    """(m,) row in `points`; -1: the channel's own stiffness is its law."""
    scale: FloatArray = field(metadata=per_channel(1.0))
    """(m,) area for pressures, 1 for forces."""
    points: tuple[FloatArray, ...] = field(metadata=POOLED)
    """(k, 2) each: overclosure (rising, the first 0 with force 0) and pressure or force (rising). Beyond the last
    point the last slope goes on."""

    def __post_init__(self) -> None:
        for number, points in enumerate(self.points):
            check_curve(points, f"overclosure curve {number + 1}")


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: |tau| <= mu p, against the sliding. mu(v) = kinetic + (static - kinetic) exp(-v / decay).

    Raises
    ------
    InputError : coefficients out of order.
    """

    static: FloatArray = field(metadata=per_channel(0.0))
    """(m,) 0: no friction."""
    kinetic: FloatArray = field(metadata=per_channel(0.0))
    """(m,) at most `static`."""
    decay: FloatArray = field(metadata=per_channel(0.0))
    """(m,) speed, length / time; 0: kinetic as soon as it slides."""

    def __post_init__(self) -> None:
        check_friction(self.static, self.kinetic, self.decay, "friction of the channels")

    @property
    def channels(self) -> IntArray:
        """Channels that rub."""
        return np.flatnonzero(self.static > 0.0)


def laid_over(law: ContactLaw, scale: FloatArray, elements: FloatArray | None = None) -> dict[str, Any]:
    """The fields of a GapOperator that say how m channels press and rub: one law for all.

    Parameters
    ----------
    scale : (m,) what turns the law's numbers into those of a channel: its area, or 1.
    elements : (m,) stiffness over scale where the law leaves it to the parent elements.
    """
    m = scale.size
    own = elements if law.steepest is None else np.full(m, law.steepest)
    if own is None:
        raise ValueError("a law without stiffness on channels without elements")
    return {
        "stiffness": own * scale,
        "damping": law.damping * scale,
        "step_limited": np.full(m, law.automatic),
        "curves": None if law.curve is None else Curves(np.zeros(m, dtype=np.int64), scale.copy(), (law.curve,)),
        "friction": Friction(*(np.full(m, x) for x in law.friction)) if law.friction.static > 0.0 else None,
        "preload": law.preload * scale if law.preload else None,
    }


class LawArrays(NamedTuple):
    """Laws of m channels, f of which rub, as arrays for compiled code."""

    stiffness: FloatArray
    """(m,) inf: hard; 0 (and no damper): watched only."""
    damping: FloatArray
    """(m,)"""
    curve: IntArray
    """(m,) curve of the channel, -1: its stiffness."""
    start: IntArray
    """(n_curve + 1,) where the points of a curve begin in x, y."""
    x: FloatArray
    """Overclosures of all points, length."""
    y: FloatArray
    """Pressure or force there."""
    scale: FloatArray
    """(m,) force of a channel = scale y."""
    rubs: IntArray
    """(f,) channels with friction, rising."""
    mu_static: FloatArray
    """(f,)"""
    mu_kinetic: FloatArray
    decay: FloatArray
    """(f,) length / time; 0: kinetic as soon as it slides."""


def law_arrays(
    stiffness: FloatArray, damping: FloatArray, curves: Curves | None, friction: Friction | None
) -> LawArrays:
    """The same laws for compiled code; None: no channel has a curve, none rubs."""
    m = stiffness.size
    curves = curves or Curves(np.full(m, -1, dtype=np.int64), np.ones(m), ())
    points = np.concatenate([np.zeros((0, 2)), *curves.points])
    friction = friction or Friction(np.zeros(m), np.zeros(m), np.zeros(m))
    rubs = friction.channels.astype(np.int64)
    return LawArrays(
        stiffness=np.array(stiffness, dtype=np.float64),
        damping=np.array(damping, dtype=np.float64),
        curve=np.array(curves.of, dtype=np.int64),
        start=np.cumsum([0, *[len(c) for c in curves.points]]).astype(np.int64),
        x=points[:, 0].copy(),
        y=points[:, 1].copy(),
        scale=np.array(curves.scale, dtype=np.float64),
        rubs=rubs,
        mu_static=np.array(friction.static[rubs], dtype=np.float64),
        mu_kinetic=np.array(friction.kinetic[rubs], dtype=np.float64),
        decay=np.array(friction.decay[rubs], dtype=np.float64),
    )
