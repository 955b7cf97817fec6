"""Sound of a vibrating surface in a baffle: Rayleigh's integral with retarded time, a row per mode and listener.

    p(x, t) = rho / (2 pi) sum_i A_i a_i(t - r_i / c) / r_i,     a_i = sum_m phi_im q_m''

The nodes drop out once: what a mode sends to a listener is a filter as long as the surface is deep in time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError

FALLEN = 120.0
"""dB by which the images of a delay between two samples are down."""
HIGHEST = 0.4
"""Of the sampling rate, up to which delays between samples are right, and means over its intervals tell a force."""
BLOCK = 4
"""Length of a block of the running convolution, in filter lengths."""
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


def area_vectors(points: FloatArray, faces: IntArray) -> FloatArray:
    """(n, 3) area of each node along its normal, m^2: its share, a third or a quarter, of the faces around it.

    Parameters
    ----------
    points : (n, 3) m. faces : (n_face, 3) or (n_face, 4) rows of `points`, anticlockwise seen from the listener's side.
    """
    corners = points[faces]
    across = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    if faces.shape[1] == 3:
        across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    share = 0.5 * np.cross(*across) / faces.shape[1]
    found = np.zeros(points.shape)
    for column in faces.T:
        np.add.at(found, column, share)
    return found


def volume_shapes(areas: FloatArray, shapes: FloatArray) -> FloatArray:
    """(n, n_mode) volume that each node moves per unit of each mode, of `area_vectors` and shapes (n, 3, n_mode)."""
    return np.asarray(np.einsum("nd,ndm->nm", areas, shapes))


def pressure_rows(
    points: FloatArray,
    volumes: FloatArray,
    listeners: FloatArray,
    rate: float,
    *,
    medium: Medium = AIR,
    baffled: bool = True,
) -> PressureRows:
    """Filters from modal accelerations to pressure.

    Exact for a flat surface in a rigid baffle; for a gently curved one as far as its own shadow and echo are weak.
    Nodes must be closer than a sixth of the shortest wavelength, of sound and in the plate.

    Parameters
    ----------
    points : (n, 3) m. volumes : (n, n_mode) from `volume_shapes`. listeners : (n_listener, 3) m. rate : Hz of the
        accelerations. Frequencies up to .4 of it.
    baffled : False: free in space, a sum of monopoles, for sources small beside the wavelength that breathe.

    Raises
    ------
    InputError : a listener on the surface; shapes that do not fit; no finite numbers.
    """
    at = np.atleast_2d(np.asarray(listeners, dtype=np.float64))
    if points.ndim != 2 or points.shape[1] != 3 or volumes.shape[:1] != points.shape[:1] or at.shape[1] != 3:
        raise InputError(
            f"points {points.shape}, volumes {volumes.shape}, listeners {at.shape}",
            expected="(n, 3), (n, n_mode) and (n_listener, 3)",
        )
    if not points.size or not all(np.isfinite(given).all() for given in (points, volumes, at)):
        raise InputError("points, volumes or listeners without or with infinite numbers", expected="finite numbers")
    band = HIGHEST * rate
    weights = [pressure_weights(points, here, rate, band, medium=medium, baffled=baffled) for here in at]
    count = max(w.shape[0] for w, _ in weights)
    rows = np.zeros((at.shape[0], count, volumes.shape[1]))
    for k, (w, _) in enumerate(weights):
        rows[k, : w.shape[0]] = w @ volumes
    first = np.array([start for _, start in weights], dtype=np.int64)
    return PressureRows(rows, first, rate, band)


def pressure_weights(
    points: FloatArray,
    listener: FloatArray,
    rate: float,
    band: float,
    *,
    medium: Medium = AIR,
    baffled: bool = True,
) -> tuple[sp.csr_array, int]:
    """(n_tap, n) what the volume acceleration of each point sends to a listener, and the delay of the first tap.

    Parameters as `pressure_rows`, which multiplies it with the volumes of modes; a large model does so by itself. The
    fewer taps, the lower the `rate`: a few times the `band`, Hz, up to which delays between samples are right.

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
    delays = distances * (rate / medium.speed)
    first = int(np.floor(delays.min())) - taps // 2 + 1
    count = int(np.floor(delays.max())) + taps // 2 - first + 1
    scale = medium.density / (FULL[baffled] * math.pi)
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


def pressure(rows: PressureRows, acceleration: FloatArray) -> FloatArray:
    """Pressure (n_listener, n) in Pa at the instants of the modal accelerations (n, n_mode), at rest before.

    Runs in blocks in the frequency domain: each mode is transformed once, for all listeners.

    Raises
    ------
    InputError : another number of modes.
    """
    n, modes = acceleration.shape
    listeners, taps, expected = rows.rows.shape
    if modes != expected:
        raise InputError(f"accelerations of {modes} modes", expected=f"{expected}, as the rows have")
    size = next_fast_len(max(BLOCK * taps, 256), real=True)
    step = size - taps + 1
    H = rfft(rows.rows, size, axis=1)
    ends = np.maximum(rows.start, 0)
    arrived = np.zeros((listeners, n + size))
    for at in range(0, n, step):
        Q = rfft(acceleration[at : at + step], size, axis=0)
        part = irfft(np.einsum("lfm,fm->lf", H, Q), size, axis=1)
        arrived[:, at : at + size] += part
    found = np.zeros((listeners, n))
    for k, start in enumerate(rows.start):
        ahead = max(-int(start), 0)
        late = min(int(ends[k]), n)
        found[k, late:] = arrived[k, ahead : ahead + n - late]
    return found


def equivalent_power(areas: FloatArray, velocity: FloatArray, *, medium: Medium = AIR) -> FloatArray:
    """Equivalent radiated power (n,) in W: rho c sum of area and normal velocity^2.

    As if every piece radiated like a piston much larger than the wavelength: a bound below coincidence, without
    direction or distance.

    Parameters
    ----------
    areas : (k,) m^2. velocity : (n, k) along the normals, m/s.
    """
    return np.asarray(medium.density * medium.speed * (velocity**2 @ areas))
