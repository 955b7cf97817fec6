"""A simply supported steel plate, and its lowest modes as a reduction has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.assembly.damping import Damping
from creak.assembly.system import System, project
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import modes
from creak.model.constraints import Fixed
from creak.model.mesh import Model
from creak.sound.forced import Modes
from helpers_core import STEEL, block, model_of, plate, shell

SIDES, THICK, ZETA = (0.5, 0.4), 2e-3, 0.02
"""m, m, share of critical of all modes."""


def supported_plate(n: tuple[int, int]) -> Model:
    """Of n elements along its sides."""
    coords, elements = plate(*n, SIDES)
    x, y, _ = coords.T
    across, along = (x < 1e-9) | (x > SIDES[0] - 1e-9), (y < 1e-9) | (y > SIDES[1] - 1e-9)
    held = [(np.arange(len(coords)), (1, 2, 6)), (np.flatnonzero(across), (3, 4)), (np.flatnonzero(along), (3, 5))]
    return model_of(coords, [block("quad4", elements, shell(THICK))], fixed=[Fixed(*one) for one in held])


def kept(system: System, f_max: float) -> System:
    """The lowest modes, damped alike."""
    found = modes(system.K, system.M, f_max=f_max)
    one, k = Diagonal(np.ones(found.omega2.size)), Diagonal(found.omega2)
    damping = Damping(0.0, 0.0, None, np.eye(found.omega2.size), 2 * ZETA * np.sqrt(found.omega2))
    small = project(replace(system, damping=Damping()), found.shapes, known=(one, k))
    return replace(small, M=one, K=k, damping=damping)


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
