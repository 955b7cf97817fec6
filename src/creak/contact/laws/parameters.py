"""What the laws of the channels need beside stiffness and damper: pressure curves, friction, preload."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.channel_data import POOLED, per_channel


@dataclass(frozen=True)
class Curves:
    """Tabular pressure-overclosure: force of a channel = scale x curve(overclosure), piecewise linear."""

    of: IntArray = field(metadata=per_channel(-1, into="points"))
    """(m,) row in `points`; -1: the channel's own stiffness is its law."""
    scale: FloatArray = field(metadata=per_channel(1.0))
    """(m,) area for pressures, 1 for forces."""
    points: tuple[FloatArray, ...] = field(metadata=POOLED)
    """(k, 2) each: overclosure (rising, the first 0 with force 0) and pressure or force (rising). Beyond the last
    point the last slope goes on."""


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: |tau| <= mu p, against the sliding. mu(v) = kinetic + (static - kinetic) exp(-v / decay)."""

    static: FloatArray = field(metadata=per_channel(0.0))
    """(m,) 0: no friction."""
    kinetic: FloatArray = field(metadata=per_channel(0.0))
    """(m,) at most `static`."""
    decay: FloatArray = field(metadata=per_channel(0.0))
    """(m,) speed, length / time; 0: kinetic as soon as it slides."""

    @property
    def channels(self) -> IntArray:
        """Channels that rub."""
        return np.flatnonzero(self.static > 0.0)
