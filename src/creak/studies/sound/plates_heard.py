"""Plates that contact pushes, as a listener hears them: how far, from which side, and around which edges."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from creak.model.skin import Skin
from creak.sound.head import Head
from creak.studies.sound.listeners import Listener
from creak.studies.sound.rims import Rim
from creak.studies.sound.sheets import PartPlates, Push
from creak.studies.sound.transfers import Transfer

WHOLE = 1.0 - 1e-9
"""Share of a part's area from which on all of it is heard."""


@dataclass(frozen=True)
class PlateHeard:
    """A part as a listener hears it."""

    push: Push
    spread: float
    """1/m^2, mean of 1 / r^2 over its faces that are heard."""
    share: float
    """Of its area that is heard."""
    away: float
    """m, mean distance of its faces."""
    middle: FloatArray
    """(3,) m from the listener to the middle of its faces."""
    head: Head | None
    """Of the listener, at whose ear it is heard; None: nothing is there."""
    sine: FloatArray
    """(k,) of the angle between the plate's normal and the way from each force to the listener."""
    far: FloatArray
    """(k,) m of that way."""
    side: FloatArray
    """(k,) 1 where the normal points to the listener, -1 where away, 0 where the plate is not heard there."""
    way: Transfer | None = None
    """What was measured from the part."""
    rims: tuple[Rim, ...] = ()
    """Of its panels, where they stand free."""
    at_rim: tuple[tuple[int, float], ...] = ()
    """Of each force the row of its panel in `rims`, and m to the edge."""
    beams: FloatArray | None = None
    """(n_plate, n_band) share of the listener in what each of its plates sends in each of `BANDS`; None: of all alike.
    """

    def around(self, freq: float) -> ComplexArray:
        """(k,) what is left of each force's own sound where the air flows around the panel's edges."""
        found = np.ones(len(self.push.point), dtype=np.complex128)
        for k, (rim, to_edge) in enumerate(self.at_rim):
            if rim >= 0:
                found[k] = self.rims[rim].gain(np.array([freq]), to_edge)[0]
        return found

    def at_edges(self, freq: float, to_edge: float) -> float:
        """What is left of a mean square that comes from so many m off the edges."""
        if not self.rims:
            return 1.0
        mine = sorted({rim for rim, _ in self.at_rim if rim >= 0})
        found = [abs(self.rims[k].gain(np.array([freq]), to_edge)[0]) ** 2 for k in mine]
        return float(np.mean(found)) if found else 1.0

    def reach(self, freq: float) -> float:
        """1/m^2, `spread` with what head or measured way make of its square at a frequency, Hz."""
        if self.way is not None:
            return self.spread * self.way.square(freq)
        if self.head is None:
            return self.spread
        return self.spread * float(np.abs(self.head.gain(np.array([freq]), self.middle))[0]) ** 2

    def of(self, columns: IntArray) -> PlateHeard:
        """Of some of the forces, numbered among these."""
        mine = np.isin(self.push.column, columns)
        push = self.push.of(mine, np.searchsorted(columns, self.push.column[mine]))
        at = tuple(self.at_rim[k] for k in np.flatnonzero(mine).tolist()) if self.at_rim else ()
        return replace(self, push=push, sine=self.sine[mine], far=self.far[mine], side=self.side[mine], at_rim=at)


def plate_heard(push: Push, listener: Listener, metre: float) -> PlateHeard:
    """What contact pushes of a part, as a listener hears it; `spread` is 0 where it does not."""
    own, nothing = shells_of(listener, push.part), np.zeros(len(push.point))
    if not own.count:
        return PlateHeard(
            push=push,
            spread=0.0,
            share=0.0,
            away=0.0,
            middle=np.zeros(3),
            head=None,
            sine=nothing,
            far=nothing,
            side=nothing,
        )
    area, whole = np.linalg.norm(own.areas, axis=1) * metre**2, float(push.part.areas.sum())
    offset = (own.centres - listener.position) * metre
    r = np.linalg.norm(offset, axis=1)
    spread, away = float(area @ r**-2 / area.sum()), float(area @ r / area.sum())
    way, to = listener.way(push.part.part), listener.position * metre - push.point
    far, middle = np.linalg.norm(to, axis=1), np.asarray(area @ offset / area.sum())
    cosine = np.einsum("nx,nx->n", to, push.normal) / far
    sine, share = np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), float(area.sum()) / whole if whole else 1.0
    side = np.where(cosine < 0.0, -1.0, 1.0)
    found = PlateHeard(
        push=push,
        spread=spread,
        share=share,
        away=away,
        middle=middle,
        head=listener.head,
        sine=sine,
        far=far,
        side=side,
        way=way,
    )
    return found if share >= WHOLE and not listener.rims else _by_faces(found, own, listener, metre)


def _by_faces(heard: PlateHeard, own: Skin, listener: Listener, metre: float) -> PlateHeard:
    """With what hangs on the face that is pushed: whether it is heard, and how far from a free edge it is."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    apart, nearest = cKDTree(own.centres).query(heard.push.point / metre)
    side = heard.side if heard.share >= WHOLE else heard.side * (apart <= own.size[nearest])
    if not listener.rims:
        return replace(heard, side=side)
    rim, to_edge = np.full(listener.skin.count, -1), np.zeros(listener.skin.count)
    for k, one in enumerate(listener.rims):
        rim[one.facets], to_edge[one.facets] = k, one.to_edge
    pushed = np.flatnonzero(_shells(listener, heard.push.part))[nearest]
    at = tuple(zip(rim[pushed].tolist(), to_edge[pushed].tolist(), strict=True))
    return replace(heard, side=side, rims=listener.rims, at_rim=at)


def shells_of(listener: Listener, part: PartPlates) -> Skin:
    """Of a part, as far as the listener hears it."""
    return listener.skin.select(_shells(listener, part))


def _shells(listener: Listener, part: PartPlates) -> BoolArray:
    return np.asarray(~listener.skin.solid & (listener.skin.part == part.part))
