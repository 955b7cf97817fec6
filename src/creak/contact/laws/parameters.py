"""What the laws of the channels need beside stiffness and damper: pressure curves, friction, preload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Curves:
    """Tabular pressure-overclosure: force of a channel = scale x curve(overclosure), piecewise linear."""

    of: IntArray
    """(m,) row in `points`; -1: the channel's own stiffness is its law."""
    scale: FloatArray
    """(m,) area for pressures, 1 for forces."""
    points: tuple[FloatArray, ...]
    """(k, 2) each: overclosure (rising, the first 0 with force 0) and pressure or force (rising). Beyond the last
    point the last slope goes on."""


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: |tau| <= mu p, against the sliding. mu(v) = kinetic + (static - kinetic) exp(-v / decay)."""

    static: FloatArray
    """(m,) 0: no friction."""
    kinetic: FloatArray
    """(m,) at most `static`."""
    decay: FloatArray
    """(m,) speed, length / time; 0: kinetic as soon as it slides."""

    @property
    def channels(self) -> IntArray:
        """Channels that rub."""
        return np.flatnonzero(self.static > 0.0)


def select_curves(curves: Curves | None, keep: IntArray) -> Curves | None:
    """Those of the channels in `keep`."""
    return None if curves is None else Curves(curves.of[keep], curves.scale[keep], curves.points)


def select_friction(friction: Friction | None, keep: IntArray) -> Friction | None:
    """That of the channels in `keep`."""
    return None if friction is None else Friction(friction.static[keep], friction.kinetic[keep], friction.decay[keep])


def join_curves(pieces: Sequence[tuple[Curves | None, int]]) -> Curves | None:
    """Of several operators with their numbers of channels; None where no channel has a curve."""
    if all(c is None for c, _ in pieces):
        return None
    of: list[IntArray] = []
    scale: list[FloatArray] = []
    points: list[FloatArray] = []
    for curves, m in pieces:
        if curves is None:
            of.append(np.full(m, -1, dtype=np.int64))
            scale.append(np.ones(m))
            continue
        of.append(np.where(curves.of >= 0, curves.of + len(points), -1))
        scale.append(curves.scale)
        points.extend(curves.points)
    return Curves(np.concatenate(of), np.concatenate(scale), tuple(points))


def join_friction(pieces: Sequence[tuple[Friction | None, int]]) -> Friction | None:
    """Of several operators with their numbers of channels; None where no channel rubs."""
    if all(f is None for f, _ in pieces):
        return None

    def joined(name: str) -> FloatArray:
        return np.concatenate([np.zeros(m) if f is None else getattr(f, name) for f, m in pieces])

    return Friction(joined("static"), joined("kinetic"), joined("decay"))
