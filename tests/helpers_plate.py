"""A simply supported steel plate, and its lowest modes as a reduction has them."""

from __future__ import annotations

import numpy as np
from benchmarks import plates

from creak.assembly.system import System
from creak.model.mesh import Model
from creak.sound.answering import Modes
from helpers_core import STEEL

SIDES, THICK, ZETA = (0.5, 0.4), 2e-3, 0.02
"""m, m, share of critical of all modes."""


def supported_plate(n: tuple[int, int]) -> Model:
    """Of n elements along its sides."""
    return plates.supported_plate(SIDES, THICK, STEEL, n)


def kept(system: System, f_max: float) -> System:
    """The lowest modes, damped alike."""
    return plates.kept(system, ZETA, f_max)


def own_modes(high: float, at: tuple[float, float]) -> tuple[Modes, np.ndarray, np.ndarray]:
    """Kirchhoff's modes to `high` Hz, struck at a point, points of a grid and the volumes that they move."""
    rigidity = STEEL.youngs_modulus * THICK**3 / (12 * (1 - STEEL.poisson_ratio**2))
    areal, (a, b) = STEEL.density * THICK, SIDES
    i, j = (k.ravel() for k in np.meshgrid(np.arange(1, 60), np.arange(1, 60), indexing="ij"))
    omega = np.sqrt(rigidity / areal) * ((i * np.pi / a) ** 2 + (j * np.pi / b) ** 2)
    low = omega < 2 * np.pi * high
    i, j, omega = i[low], j[low], omega[low]

    def shape(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.sin(np.outer(x, i) * np.pi / a) * np.sin(np.outer(y, j) * np.pi / b)

    x, y = (k.ravel() for k in np.meshgrid((np.arange(90) + 0.5) * a / 90, (np.arange(72) + 0.5) * b / 72))
    m = np.full(omega.size, areal * a * b / 4)
    push = shape(np.array([at[0]]), np.array([at[1]]))
    return (
        Modes(m, 2 * ZETA * omega * m, omega**2 * m, push),
        np.column_stack([x, y, 0 * x]),
        shape(x, y) * a * b / x.size,
    )
