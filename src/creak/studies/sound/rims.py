"""Panels that stand free: how far each facet is from where the air flows around, and what that takes away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import fresnel

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from creak.model.skin import Skin, panels, sides_of
from creak.sound.forced import Gain
from creak.sound.rayleigh import AIR

DEPTHS = np.array([0.08, 0.25, 0.5, 0.75, 1.0])
"""Shares of half a panel's width at which its facets are told apart; between them weights are linear."""
MOST = 12
"""Panels, the largest that a listener hears, whose edges are looked at."""
FLAT = 1.6
"""Between a strip and a disc."""


@dataclass(frozen=True)
class Rim:
    """A panel without a wall, as a listener hears it."""

    facets: IntArray
    """(k,) rows into the listener's skin."""
    to_edge: FloatArray
    """(k,) m from their middles to the nearest edge."""
    half_width: float
    """m, the farthest that a point of the panel is from its edges."""
    away: float
    """m from its middle to the listener."""
    cosine: float
    """Of the angle between its mean normal and the way to the listener."""

    def gain(self, freq: FloatArray, to_edge: float) -> ComplexArray:
        """Of a point so many m from the edge, over that in a wall."""
        return around_edges(freq, to_edge, self.half_width, self.away, self.cosine)

    def classes(self, n: int) -> list[tuple[Gain, FloatArray]]:
        """Gains, and weights (n,) of the skin's facets with which they count: sums of weights are one on its own."""
        x, found = np.clip(self.to_edge / self.half_width, DEPTHS[0], 1.0), list[tuple[Gain, FloatArray]]()
        for depth, hat in zip(DEPTHS.tolist(), np.eye(DEPTHS.size), strict=True):
            weight = np.zeros(n)
            weight[self.facets] = np.interp(x, DEPTHS, hat)
            found.append((partial(self.gain, to_edge=depth * self.half_width), weight))
        return found


def rims_of(skin: Skin, heard: BoolArray, position: FloatArray, metre: float) -> tuple[Rim, ...]:
    """Panels with edges of which a listener hears some facets, the largest first.

    Parameters
    ----------
    skin : of the whole model. heard : (n,) of its facets. position : of the listener, length.
    """
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    shell, areas, centres, row = np.flatnonzero(~skin.solid), skin.areas, skin.centres, np.cumsum(heard) - 1
    if not heard[shell].any():
        return ()
    facet, ends, _, count = sides = sides_of(skin.nodes_idx[shell])
    panel = panels(skin.nodes_idx[shell], sides)[1]
    size, alone, found = np.linalg.norm(areas[shell], axis=1), count == 1, list[Rim]()
    edged = np.unique(panel[facet[alone]])
    heard_size = np.bincount(panel, size * heard[shell])
    where = np.zeros((int(skin.nodes_idx.max()) + 1, 3))
    where[skin.nodes_idx] = skin.corners
    for k in edged[np.argsort(-heard_size[edged], kind="stable")][:MOST].tolist():
        own = panel == k
        whole, rim = shell[own], where[ends[alone & own[facet]]]
        if not heard[whole].any():
            break
        to_edge = cKDTree(np.concatenate([rim[:, 0], rim.mean(axis=1)])).query(centres[whole])[0]
        way = position - size[own] @ centres[whole] / size[own].sum()
        far, normal, mine = float(np.linalg.norm(way)), areas[whole].sum(axis=0), heard[whole]
        cosine = float(abs(way @ normal) / max(far * np.linalg.norm(normal), np.finfo(float).tiny))
        width = float(to_edge.max())
        found.append(Rim(row[whole[mine]], metre * to_edge[mine], metre * width, metre * far, cosine))
    return tuple(found)


def without_wall(rims: Sequence[Rim], rows: Sequence[tuple[Gain, FloatArray]]) -> list[tuple[Gain, FloatArray]]:
    """Rows of a gain and areas (n, 3) of facets: those of panels that stand free in a row of each class."""
    if not rims:
        return list(rows)
    n = rows[0][1].shape[0]
    walled = np.ones(n, dtype=bool)
    for rim in rims:
        walled[rim.facets] = False
    found = [(gain, np.where(walled[:, None], areas, 0.0)) for gain, areas in rows]
    for own, weight in (one for rim in rims for one in rim.classes(n)):
        found += [(partial(product, gain, own), weight[:, None] * areas) for gain, areas in rows]
    return found


def product(one: Gain, other: Gain, freq: FloatArray) -> ComplexArray:
    """Of two gains."""
    return np.asarray(one(freq) * other(freq))


def half_plane(x: FloatArray) -> ComplexArray:
    """E(x) of `around_edges`, time as e^(i omega t)."""
    z = np.sqrt(2.0 * x / np.pi)
    S, C = fresnel(z)
    return np.asarray(np.sqrt(2.0) * np.exp(0.25j * np.pi) * (C - 1j * S))


def around_edges(
    freq: FloatArray, to_edge: FloatArray | float, half_width: float, away: float, cosine: float
) -> ComplexArray:
    """Pressure from a point of a panel without a wall, over that in a wall: what flows around its edges is not heard.

    By reciprocity a point of a rigid panel sends to a listener as much as a source at the listener makes the pressure
    differ between both sides there. In a wall that is twice the pressure p that arrives. At d from the edge of a half
    plane it is, for a wave that falls on it squarely (Sommerfeld; Born and Wolf, Principles of Optics, section 11.5),

        E(k d) 2 p,     E(x) = 2 / sqrt(pi) e^(-i pi / 4) int_0^sqrt(x) e^(i t^2) dt

    and E(k d) E(k (2 a - d)) of a panel as far from edge to edge as 2 a. For long waves this is
    4 / pi k sqrt(d (2 a - d)), which is `FLAT` too much: 1.27 for a strip and 2 for a disc (Lamb, Hydrodynamics,
    sections 71 and 108). There the slope of the pressure counts, and not the pressure itself:
    cos(theta) (1 + 1 / (i k r)) at r from the source, theta off the normal. Valid within some 3 dB; above k a = 3 a
    wall changes little.

    Parameters
    ----------
    freq : Hz. to_edge : m, d; at most half_width, a. away : m to the listener, r. cosine : of its angle off the normal.
    """
    k = 2.0 * np.pi * np.maximum(freq, 1e-3) / AIR.speed
    d = np.minimum(to_edge, half_width)
    both = half_plane(k * d) * half_plane(k * (2.0 * half_width - d))
    long = 1.0 / (1.0 + (k * half_width) ** 2)
    return np.asarray(both * (1.0 + long * (abs(cosine) / FLAT * (1.0 - 1j / (k * away)) - 1.0)))
