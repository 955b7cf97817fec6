"""Panels without a wall: what flows around their edges is not heard.

By reciprocity a point of a rigid panel sends to a listener as much as a source at the listener makes the pressure
differ between both sides there. In a wall that is twice the pressure p that arrives. At d from the edge of a half plane
it is, for a wave that falls on it squarely (Sommerfeld; Born and Wolf, Principles of Optics, section 11.5),

    E(k d) 2 p,     E(x) = 2 / sqrt(pi) e^(-i pi / 4) int_0^sqrt(x) e^(i t^2) dt

and E(k d) E(k (2 a - d)) of a panel as far from edge to edge as 2 a. For long waves this is 4 / pi k sqrt(d (2 a - d)),
which is `FLAT` too much: 1.27 for a strip and 2 for a disc (Lamb, Hydrodynamics, sections 71 and 108). There the slope
of the pressure counts, and not the pressure itself: cos(theta) (1 + 1 / (i k r)) at r from the source, theta off the
normal. Valid within some 3 dB; above k a = 3 a wall changes little.
"""

from __future__ import annotations

import numpy as np
from scipy.special import fresnel

from creak.arrays import ComplexArray, FloatArray
from creak.sound.rayleigh import AIR

FLAT = 1.6
"""Between a strip and a disc."""


def half_plane(x: FloatArray) -> ComplexArray:
    """E(x), time as e^(i omega t)."""
    z = np.sqrt(2.0 * x / np.pi)
    S, C = fresnel(z)
    return np.asarray(np.sqrt(2.0) * np.exp(0.25j * np.pi) * (C - 1j * S))


def around_edges(
    freq: FloatArray, to_edge: FloatArray | float, half_width: float, away: float, cosine: float
) -> ComplexArray:
    """Pressure from a point of a panel without a wall, over that in a wall.

    Parameters
    ----------
    freq : Hz. to_edge : m, d; at most half_width, a. away : m to the listener, r. cosine : of its angle off the normal.
    """
    k = 2.0 * np.pi * np.maximum(freq, 1e-3) / AIR.speed
    d = np.minimum(to_edge, half_width)
    both = half_plane(k * d) * half_plane(k * (2.0 * half_width - d))
    long = 1.0 / (1.0 + (k * half_width) ** 2)
    return np.asarray(both * (1.0 + long * (abs(cosine) / FLAT * (1.0 - 1j / (k * away)) - 1.0)))
