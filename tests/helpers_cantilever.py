"""The uniform cantilever: 80 Euler-Bernoulli elements, cut at mid-span, bending in one plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import to_dense
from creak.assembly.system import System
from creak.model.constraints import Fixed, RigidLink
from creak.model.materials import BeamSection, Material
from creak.model.mesh import Model
from creak.reduction.craig_bampton import craig_bampton
from helpers_core import NO_DAMPING, NONE, block, couple, model_of, part_system

N = 80
HALF = N // 2
TIP = 2 * HALF + 1
"""Node row of the free end; the clamp is row 0, the cut lies between rows HALF and HALF + 1."""
SECTION = BeamSection("B", Material("M", 1.0, 0.0, 420.0), 1.0, 1.0, 1.0, 1.0)
"""Unit elements with E I = 1 and rho A = 420: the element matrices are whole numbers, exact in binary."""


def cantilever() -> Model:
    x = np.concatenate([np.arange(HALF + 1), HALF + np.arange(HALF + 1)])
    coords = np.column_stack([x, 0.0 * x, 0.0 * x])
    first = np.column_stack([np.arange(HALF), np.arange(1, HALF + 1)])
    return model_of(
        coords,
        [block("beam2", first, SECTION, 0), block("beam2", first + HALF + 1, SECTION, 1, HALF + 1)],
        [("ROOT", range(HALF + 1)), ("FREE", range(HALF + 1, 2 * HALF + 2))],
        constraints=[RigidLink("tie", HALF + 1, HALF)],
        fixed=[Fixed(np.array([0]), (1, 2, 3, 4, 5, 6))],
    )


def planar(part: System) -> System:
    """The part with only the deflection y and the rotation about z of each node."""
    keep = np.flatnonzero(np.isin(part.coordinates % 6, (1, 5)))

    def rows(labels: np.ndarray) -> tuple:
        R, R_s = part.rows(labels)
        return R[:, keep], R_s

    return replace(
        part,
        M=part.M[keep][:, keep],
        K=part.K[keep][:, keep],
        rows=rows,
        coordinates=part.coordinates[keep],
        velocity=part.velocity[keep],
    )


def halves(model: Model) -> list[System]:
    return [planar(part_system(model, i, NO_DAMPING)) for i in range(2)]


def full(model: Model) -> System:
    return couple(halves(model), model, NONE, NO_DAMPING)


def reduced(
    model: Model, count: int | None = None, retain: tuple[int, ...] = (0, HALF, HALF + 1), f_max: float | None = None
) -> System:
    """Both halves reduced to the cut (and `retain`) and `count` fixed-interface modes each (or to f_max), then joined."""
    parts = []
    for part in halves(model):
        boundary = np.flatnonzero(np.isin(part.coordinates // 6, retain))
        parts.append(craig_bampton(part, boundary, count=count, f_max=f_max))
    return couple(parts, model, NONE, NO_DAMPING)


def accurate_frequencies(system: System, count: int) -> np.ndarray:
    """omega of the lowest modes, good to some 1e-12 although K has a condition number of 1e9.

    Dense eigenvectors are improved by inverse iteration with residuals in extended precision; the Rayleigh
    quotient is then formed in extended precision too (its error is the square of the vector's).
    """
    K, M = to_dense(system.K), to_dense(system.M)
    x = sla.eigh(K, M)[1][:, :count]
    cholesky = sla.cho_factor(K)
    K_long, M_long = K.astype(np.longdouble), M.astype(np.longdouble)
    for _ in range(3):
        b = M_long @ x.astype(np.longdouble)
        y = np.zeros_like(b)
        for _ in range(4):
            y = y + sla.cho_solve(cholesky, (b - K_long @ y).astype(float))
        _, mix = sla.eigh((y.T @ (K_long @ y)).astype(float), (y.T @ (M_long @ y)).astype(float))
        y = y @ mix
        x = (y / np.sqrt((y * y).sum(axis=0))).astype(float)
    return np.sqrt((y * (K_long @ y)).sum(axis=0) / (y * (M_long @ y)).sum(axis=0)).astype(float)
