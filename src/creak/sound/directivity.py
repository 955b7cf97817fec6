"""Where a plate sends what its waves radiate: at one point, over the mean of all directions.

Waves of all directions d run over the plate, v = v0 e^(i k_b d x), each as strong as any other. Set in a wall it has,
with Rayleigh's integral,

    p^2 = (rho omega v0 / 2 pi)^2 A,            A = mean over d of |int e^(i k_b d x - i k r) / r dS|^2,
    P   = rho omega^2 v0^2 B / (2 pi c),        B = int int J0(k_b s) sin(k s) / (k s) dS dS',    s = |x - x'|,

and the share of a point is A / (B mean(1 / r^2)): 1 of what is small beside the wavelength. Below coincidence the edges
send, to all sides; above it waves leave at the angle asin(k_b / k) off the normal, and just above they graze the plate,
so that little is heard in front of it. Source: mean square of diffuse waves, Cremer, Heckl and Petersson,
Structure-Borne Sound, 2005, section 6.4. Valid for a sheet that is nearly flat; what its edges hold is not in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2
from scipy.special import j0

from creak.arrays import FloatArray
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import across_third

PER_WAVE = 3.0
"""Cells to the shortest wave, in plate and air."""
MOST = 400
"""Cells along the longer side of a sheet."""
FLAT = 0.9
"""Mean square of the cosine of the angle to the mean normal, from which on a sheet is nearly flat."""
DEEP = 0.1
"""Of the root of its area: standard deviation of the height, up to which it is."""
PER_THIRD = 3
"""Frequencies of a third octave."""
FINEST = 24
"""Points along the side of a facet, at most."""


@dataclass(frozen=True)
class FlatSheet:
    """A sheet laid on a plane, cell by cell."""

    x: FloatArray
    y: FloatArray
    """(n_x,), (n_y,) m, middles of the cells."""
    area: FloatArray
    """(n_x, n_y) m^2 in each."""
    offset: FloatArray
    """(n_x, n_y, 3) m, mean of what is in each."""
    overlap: FloatArray
    """Of the areas with themselves, shifted by 0, 1, ... cells and back, as an FFT has it."""

    @property
    def step(self) -> float:
        """m, side of a cell."""
        return float(self.x[1] - self.x[0])

    def share(self, point: FloatArray, freq: float, wavenumber: float) -> float:
        """Square of the pressure at a point (3,), m, over that of the same power sent alike to all sides, around a
        frequency, Hz. wavenumber: of bending at that frequency, rad/m; as the root of the frequency besides.
        """
        r = np.linalg.norm(self.offset - point, axis=2)
        used = self.area > 0.0
        weight = np.divide(self.area, r, out=np.zeros_like(r), where=used)
        spread = float((weight[used] ** 2 / self.area[used]).sum() / self.area.sum())
        there, everywhere = 0.0, 0.0
        for by in across_third(PER_THIRD).tolist():
            k, k_b = 2.0 * math.pi * freq * by / AIR.speed, min(wavenumber * math.sqrt(by), 0.9 * math.pi / self.step)
            there += by**2 * self._at(weight * np.exp(-1j * k * r), k_b)
            everywhere += by**2 * self._power(k, k_b)
        return there / (everywhere * spread)

    def _at(self, sent: np.ndarray, k_b: float) -> float:
        """A: mean over as many directions as tell each from the next."""
        apart = math.hypot(self.x[-1] - self.x[0], self.y[-1] - self.y[0])
        angle = np.arange(n := int(1.1 * k_b * apart) + 16) * (2.0 * math.pi / n)
        along = np.exp(1j * k_b * np.outer(np.cos(angle), self.x))
        across = np.exp(1j * k_b * np.outer(np.sin(angle), self.y))
        return float(np.mean(np.abs(((along @ sent) * across).sum(axis=1)) ** 2))

    def _power(self, k: float, k_b: float) -> float:
        """B"""
        along, across = (self.step * np.fft.fftfreq(n, 1.0 / n) for n in self.overlap.shape)
        s = np.hypot(along[:, None], across)
        return float((self.overlap * j0(k_b * s) * np.sinc(k * s / math.pi)).sum())


def plane_of(areas: FloatArray) -> tuple[float, FloatArray]:
    """How flat facets of areas (n, 3) are, mean square of the cosine of their angle to one normal, and axes (3, 3) in
    columns, of which the last is that normal."""
    size = np.linalg.norm(areas, axis=1)
    squares, axes = np.linalg.eigh((areas / np.maximum(size, 1e-300)[:, None]).T @ areas)
    return float(squares[-1] / max(size.sum(), 1e-300)), axes


def flat_sheet(corners: FloatArray, shortest: float) -> FlatSheet | None:
    """The sheet of some facets; None: it is not nearly flat.

    Parameters
    ----------
    corners : (n, 4, 3) m; a triangle repeats its third. shortest : m, wave that is to be told.
    """
    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    size = np.linalg.norm(areas, axis=1)
    whole = float(size.sum())
    flatness, axes = plane_of(areas)
    middle = size @ corners.mean(axis=1) / max(whole, 1e-300)
    height = (corners.mean(axis=1) - middle) @ axes[:, -1]
    if flatness < FLAT or math.sqrt(size @ height**2 / whole) > DEEP * math.sqrt(whole):
        return None
    plane = axes[:, :2]
    span = np.ptp((corners.reshape(-1, 3) - middle) @ plane, axis=0)
    step = max(shortest / PER_WAVE, float(span.max()) / MOST)
    points, weight = _points(corners, step)
    at = (points - middle) @ plane
    low = at.min(axis=0)
    cell = np.floor((at - low) / step).astype(np.int64)
    n_x, n_y = (max(int(n) + 1, 2) for n in cell.max(axis=0))
    flat = cell[:, 0] * n_y + cell[:, 1]
    area = np.asarray(np.bincount(flat, weight, n_x * n_y), dtype=np.float64)
    mean = np.stack([np.bincount(flat, weight * x, n_x * n_y) for x in points.T], axis=1)
    offset = (mean / np.maximum(area, 1e-300)[:, None]).reshape(n_x, n_y, 3)
    area = area.reshape(n_x, n_y)
    full = next_fast_len(2 * n_x), next_fast_len(2 * n_y, real=True)
    overlap = irfft2(np.abs(rfft2(area, full)) ** 2, full)
    x, y = (np.asarray(low[j] + (np.arange(n) + 0.5) * step) for j, n in enumerate((n_x, n_y)))
    return FlatSheet(x, y, area, offset, np.asarray(overlap, dtype=np.float64))


def _points(corners: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Points (n, 3) on facets, a quarter of a step apart where that takes not too many, and the area (n,) of each."""
    longest = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max())
    count = min(max(1, math.ceil(4.0 * longest / step)), FINEST)
    u, v = (k.ravel() for k in np.meshgrid(*2 * [(np.arange(count) + 0.5) / count]))
    N = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    by_u = np.stack([v - 1, 1 - v, v, -v], axis=1)
    by_v = np.stack([u - 1, -u, u, 1 - u], axis=1)
    points, along, across = (np.einsum("pc,ncx->npx", w, corners).reshape(-1, 3) for w in (N, by_u, by_v))
    return points, np.linalg.norm(np.cross(along, across), axis=1) / count**2
