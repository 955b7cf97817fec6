"""Sound of a vibrating surface in a baffle: Rayleigh's integral with retarded time.

    p(x, t) = rho / (2 pi) sum_i A_i a_i(t - r_i / c) / r_i,     a_i = sum_m phi_im q_m''

The nodes drop out once: what a mode sends to a listener is a filter as long as the surface is deep in time,
`pressure_weights` times the volume that each node moves in the mode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError

FALLEN = 120.0
"""dB by which the images of a delay between two samples are down."""
HIGHEST = 0.4
"""Of the sampling rate, up to which delays between samples are right, and means over its intervals tell a force."""
FULL = {True: 2.0, False: 4.0}
"""Solid angle over pi that a source sends into: half a space before a baffle, or all of it."""


@dataclass(frozen=True)
class Medium:
    """What carries the sound: air at 20 degrees and 1013 hPa unless given."""

    density: float = 1.204
    """kg/m^3."""
    speed: float = 343.2
    """m/s."""


AIR = Medium()


@dataclass(frozen=True)
class PressureRows:
    """What each mode's acceleration sends to each listener, sampled."""

    rows: FloatArray
    """(n_listener, n_tap, n_mode) Pa per unit of modal acceleration."""
    start: IntArray
    """(n_listener,) delay of the first tap in samples; below 0 where a listener is nearer than a delay is spread."""
    rate: float
    """Hz."""
    band: float
    """Hz, up to which they are right."""


def pressure_weights(
    points: FloatArray,
    listener: FloatArray,
    rate: float,
    band: float,
    *,
    baffled: bool = True,
    paths: FloatArray | None = None,
) -> tuple[sp.csr_array, int]:
    """(n_tap, n) what the volume acceleration of each point sends to a listener, and the delay of the first tap.

    Exact for a flat surface in a rigid baffle; for a gently curved one as far as its own shadow and echo are weak.
    Points must be closer than a sixth of the shortest wavelength, of sound and in the plate.

    Parameters
    ----------
    points : (n, 3) m. listener : (3,) m. rate : Hz of the accelerations.
    band : Hz, up to which delays between samples are right. A rate of a few times the band needs few taps.
    baffled : False: free in space, a sum of monopoles, for sources small beside the wavelength that breathe.
    paths : (n,) m that the sound goes from each point, where that is not straight: it is late by them.

    Raises
    ------
    InputError : a listener on the surface; a band that is not below half the rate.
    """
    distances = np.linalg.norm(listener - points, axis=1)
    if distances.min() <= 0.0:
        raise InputError(
            f"a listener at {listener.tolist()} is on the radiating surface",
            fix="Move it off, by a node spacing at least.",
        )
    if not 0.0 < band < 0.5 * rate:
        raise InputError(f"a band up to {band:g} Hz at {rate:g} Hz", expected="below half the rate")
    taps, beta = _kaiser(band / rate)
    delays = (distances if paths is None else paths) * (rate / AIR.speed)
    first = int(np.floor(delays.min())) - taps // 2 + 1
    count = int(np.floor(delays.max())) + taps // 2 - first + 1
    scale = AIR.density / (FULL[baffled] * math.pi)
    return (_spread(delays - first, count, taps, beta) @ sp.diags_array(scale / distances)).tocsr(), first


def _kaiser(band: float) -> tuple[int, float]:
    """Samples that a delay is spread over, an even number, and the window of their sinc, of a band over the rate.

    Kaiser's formula for images, from 1 - band on, that are `FALLEN` down.
    """
    taps = 1.0 + (FALLEN - 7.95) / (2.285 * 2.0 * math.pi * (1.0 - 2.0 * band))
    return 2 * math.ceil(0.5 * taps), 0.1102 * (FALLEN - 8.7)


def _spread(delay: FloatArray, count: int, taps: int, beta: float) -> sp.csr_array:
    """(count, n) weights that shift by each delay (n,), in samples: sinc under a Kaiser window."""
    whole = np.floor(delay).astype(np.int64)
    offset = np.arange(taps) - (taps // 2 - 1)
    x = offset[:, None] - (delay - whole)
    inside = np.sqrt(np.maximum(1.0 - (x / (taps / 2)) ** 2, 0.0))
    weight = np.sinc(x) * np.i0(beta * inside) / np.i0(beta)
    weight /= weight.sum(axis=0)
    column = np.broadcast_to(np.arange(delay.size), weight.shape)
    place = (weight.ravel(), ((whole + offset[:, None]).ravel(), column.ravel()))
    return sp.coo_array(place, shape=(count, delay.size)).tocsr()


def equivalent_power(areas: FloatArray, velocity: FloatArray) -> FloatArray:
    """Equivalent radiated power (n,) in W: rho c sum of area and normal velocity^2.

    As if every piece radiated like a piston much larger than the wavelength: a bound below coincidence, without
    direction or distance.

    Parameters
    ----------
    areas : (k,) m^2. velocity : (n, k) along the normals, m/s.
    """
    return np.asarray(AIR.density * AIR.speed * (velocity**2 @ areas))
