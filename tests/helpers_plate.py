"""A simply supported steel plate, and its lowest modes as a reduction has them."""

from __future__ import annotations

from functools import cache

import numpy as np
from benchmarks import plates

from creak.assembly.system import System
from creak.model.mesh import Model
from creak.sound.answering import Modes
from creak.sound.rayleigh import PressureRows
from helpers_core import STEEL
from helpers_sound import pressure_rows

SIDES, THICK, ZETA = (0.5, 0.4), 2e-3, 0.02
"""m, m, share of critical of all modes."""


def supported_plate(n: tuple[int, int]) -> Model:
    """Of n elements along its sides."""
    return plates.supported_plate(SIDES, THICK, STEEL, n)


def kept(system: System, f_max: float) -> System:
    """The lowest modes, damped alike."""
    return plates.kept(system, ZETA, f_max)


def own_modes(high: float, at: tuple[float, float]) -> Modes:
    """Kirchhoff's modes to `high` Hz, struck at a point."""
    (a, b), (i, j, omega) = SIDES, _own(high)
    m = np.full(omega.size, STEEL.density * THICK * a * b / 4)
    return Modes(m, 2 * ZETA * omega * m, omega**2 * m, _shapes(i, j, *(np.array([x]) for x in at)))


@cache
def own_rows(high: float, listener: tuple[float, float, float], rate: float) -> PressureRows:
    """What accelerations of these modes send to a listener: by the volumes that points of a grid move."""
    (a, b), (i, j, _) = SIDES, _own(high)
    x, y = (k.ravel() for k in np.meshgrid((np.arange(90) + 0.5) * a / 90, (np.arange(72) + 0.5) * b / 72))
    volumes = _shapes(i, j, x, y) * a * b / x.size
    return pressure_rows(np.column_stack([x, y, 0 * x]), volumes, [listener], rate)


def _own(high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half waves along the sides, and rad/s."""
    rigidity = STEEL.youngs_modulus * THICK**3 / (12 * (1 - STEEL.poisson_ratio**2))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(1, 60), np.arange(1, 60), indexing="ij"))
    squares = (i * np.pi / SIDES[0]) ** 2 + (j * np.pi / SIDES[1]) ** 2
    omega = np.sqrt(rigidity / (STEEL.density * THICK)) * squares
    low = omega < 2 * np.pi * high
    return i[low], j[low], omega[low]


def _shapes(i: np.ndarray, j: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.sin(np.outer(x, i) * np.pi / SIDES[0]) * np.sin(np.outer(y, j) * np.pi / SIDES[1])
