"""What a run would cost here: one factorisation and a few back-substitutions of the model itself, and steps counted."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla

from creak.assembly.system import System
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import StepFactor
from creak.linalg.modes import dense_is_faster
from creak.linalg.threads import one_blas_thread
from creak.studies.advise.size import Counted, PartSize
from creak.studies.run.foretold import median_s

CONTACT_STEP = 2.0
"""Step with contact over a back-substitution (1.4 to 2.0 measured, docs/evidence.md)."""
COLUMNS_PER_MODE, LANCZOS, STATIC = 3.8, 4.0, 1.5
"""Lanczos columns for a mode (door at 40 mm, 238 modes), and time over that of blocked back-substitutions: modes 3.6 to
4.5, constraint modes 1.3 to 1.6 (docs/reduction.md, a million dofs)."""
EIGEN = 300
"""Size of the dense eigenproblem that is timed."""


@dataclass(frozen=True)
class UnreducedCost:
    """The unreduced model at one step length."""

    dofs: int
    factor_s: float
    solve_s: float
    """A back-substitution."""
    channels: int

    def run_s(self, steps: int) -> float:
        """Factorisation, the channels' responses, and every step as if it had contact: an upper estimate."""
        return self.factor_s + (self.channels + CONTACT_STEP * steps) * self.solve_s


def unreduced_cost(system: System, scheme: Scheme, h: float, channels: int) -> UnreducedCost:
    """Time one factorisation and the median of a few back-substitutions of the step matrix."""
    started = time.perf_counter()
    solver = StepFactor(system, scheme, h)
    made = time.perf_counter() - started
    b = np.random.default_rng(3).standard_normal(system.n)
    with one_blas_thread():
        return UnreducedCost(system.n, made, median_s(lambda: solver.solve(b)), channels)


def superelements_s(parts: Sequence[PartSize], f_max: float, unknowns: int, cube_s: float) -> float:
    """Offline time of a Craig-Bampton model: factors, two back-substitutions a retained dof, Lanczos, diagonalising."""
    total = cube_s * float(unknowns) ** 3
    for part in parts:
        total += part.modes.factor_s + 2.0 * STATIC * part.boundary * part.modes.column_s
        dense = dense_is_faster(part.inner, part.modes.below.get(f_max, 0))
        total += cube_s * float(part.inner) ** 3 if dense else lanczos_s(part.modes, f_max)
    return total


def lanczos_s(counted: Counted, f_max: float) -> float:
    """Time for the modes below `f_max` (one of the frequencies counted)."""
    return LANCZOS * COLUMNS_PER_MODE * counted.below.get(f_max, 0) * counted.column_s


def assembly_modes_s(counted: Counted, f_max: float, rows: int) -> float:
    """Offline time of gap modes: modes of the assembly, a static shape per channel row."""
    return counted.factor_s + lanczos_s(counted, f_max) + STATIC * rows * counted.column_s


def eigen_cube_s() -> float:
    """Seconds per n^3 of the dense symmetric eigenproblem."""
    A = np.random.default_rng(1).standard_normal((EIGEN, EIGEN))
    A = A @ A.T + EIGEN * np.eye(EIGEN)
    started = time.perf_counter()
    sla.eigh(A, np.eye(EIGEN))
    return (time.perf_counter() - started) / EIGEN**3
