"""A driven assembly of two beams with two gap channels, for tests of reductions with channels."""

from __future__ import annotations

import numpy as np

from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.loads import Loads
from creak.model.constraints import Fixed
from creak.model.mesh import Model
from helpers_core import Driven, beam_section, block, channels, couple, model_of, part_system, spring

N = 8
"""Elements of each beam."""
LABELS = 6 * (2 * N + 2)


def two_cantilevers(dashpot: float = 0.0, held: bool = True) -> Model:
    """Two beams side by side, their tips joined by a spring, roots driven along y together (or held nowhere)."""
    a = np.column_stack([np.linspace(0.0, 0.5, N + 1), np.zeros(N + 1), np.zeros(N + 1)])
    b = a * [0.9, 1.0, 1.0] + [0.0, 0.02, 0.0]
    e = np.column_stack([np.arange(N), np.arange(1, N + 1)])
    return model_of(
        np.vstack([a, b]),
        [
            block("beam2", e, beam_section(), 0),
            block("beam2", e + N + 1, beam_section(i=2e-9), 1, 100),
            block("spring2", [[N, 2 * N + 1]], spring(2e3, 2, damping=dashpot), -1, 200),
        ],
        [("A", range(N + 1)), ("B", range(N + 1, 2 * N + 2))],
        fixed=[Fixed(np.array([0, N + 1]), (1, 3, 4, 5, 6))] if held else [],
    )


def cantilevers(rayleigh: Rayleigh, *, dashpot: float = 0.0, driven: bool = True) -> System:
    """The unreduced assembly; undriven it is free in space."""
    model = two_cantilevers(dashpot, driven)
    drive = Driven({"base": np.array([1, 6 * (N + 1) + 1])} if driven else {})
    return couple(
        [part_system(model, i, rayleigh, override=True) for i in range(2)], model, drive, rayleigh, override=True
    )


def gaps_between(gap0: float = 0.02, stiffness: float = 0.0, damping: float = 0.0) -> GapOperator:
    """Two channels between the beams along y, in the middle and at the tips; without stiffness they only watch."""
    G = np.zeros((2, LABELS))
    for row, node in enumerate((N // 2, N)):
        G[row, 6 * node + 1], G[row, 6 * (N + 1 + node) + 1] = -1.0, 1.0
    return channels(G, gap0, stiffness, damping)


def gap_rows(system: System, gaps: GapOperator) -> np.ndarray:
    """G in the coordinates of the System."""
    G = gaps.G @ system.rows(gaps.labels)[0]
    return G.toarray() if hasattr(G, "toarray") else G


def multisine_base(time: np.ndarray, f_min: float, f_max: float, amplitude: float, seed: int = 2) -> Loads:
    """Roots driven by 24 lines of equal speed and random phase, starting from rest over the first tenth."""
    f = np.linspace(f_min, f_max, 24)
    w = 2.0 * np.pi * f
    arg = np.outer(time, w) + np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, f.size)
    A = amplitude * f_min / f
    s, v, a = (A * np.cos(arg)).sum(1), (-A * w * np.sin(arg)).sum(1), (-A * w * w * np.cos(arg)).sum(1)
    x, rate = np.clip(10.0 * time / time[-1], 0.0, 1.0), 10.0 / time[-1]
    r, r1, r2 = (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2 * rate,
        60 * x * (1 - x) * (1 - 2 * x) * rate**2,
    )
    motion = np.stack([r * s, r1 * s + r * v, r2 * s + 2 * r1 * v + r * a])
    return Loads(time, motion[:, :, None], np.zeros((time.size, 0)))
