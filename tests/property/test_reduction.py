"""What Craig-Bampton keeps, whatever the mesh, the retained nodes and the number of modes."""

from __future__ import annotations

import numpy as np
import scipy.linalg as sla
from hypothesis import given, settings
from hypothesis import strategies as st

from creak.arrays import to_dense
from creak.assembly.part import part_system
from creak.assembly.system import System
from creak.reduction.craig_bampton import craig_bampton
from helpers_core import NO_DAMPING, block, model_of, plate, shell
from helpers_fem import rigid_modes

RECORDED = {"section": "reduction", "source": "full model"}

ROUND_OFF = 1e-6
"""eps times the condition of K_ii (some 1e9 for these shells), with room."""


@st.composite
def parts(draw: st.DrawFn) -> tuple[System, np.ndarray, np.ndarray]:
    """A free, warped plate with its inner nodes moved at random, its coordinates and some retained nodes."""
    nx, ny = draw(st.integers(2, 5)), draw(st.integers(2, 4))
    coords, quads = plate(nx, ny, (0.1 * nx, 0.1 * ny))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    coords = coords + 0.02 * rng.standard_normal(coords.shape).clip(-1, 1)
    nodes = rng.choice(coords.shape[0], size=draw(st.integers(3, 6)), replace=False)
    part = part_system(model_of(coords, [block("quad4", quads, shell(5e-3))]), 0, NO_DAMPING)
    return part, coords, np.flatnonzero(np.isin(part.coordinates // 6, nodes))


def omega2(system: System) -> np.ndarray:
    return sla.eigh(to_dense(system.K), to_dense(system.M), eigvals_only=True)


@settings(max_examples=15, deadline=None)
@given(parts(), st.integers(1, 8))
def test_bounds_statics_and_mass(measured, given_part, count):
    part, coords, boundary = given_part
    exact, scale = omega2(part), np.abs(omega2(part)[6:12]).min()
    before = None
    for kept in (0, count, 2 * count, 10_000):
        small = craig_bampton(part, boundary, count=kept)
        values = omega2(small)
        bound = exact[: values.size]
        # Rayleigh-Ritz
        measured(
            "any plate: omega^2 below the full model's",
            ((bound - values) / np.maximum(bound, scale)).max(initial=0.0),
            at_most=ROUND_OFF,
            source="Rayleigh, Ritz",
        )
        if before is not None:  # nested spaces: more modes are never worse
            assert (values[: before.size] <= before + ROUND_OFF * np.maximum(before, scale)).all()
        before = values
        r = rigid_modes(coords)[part.coordinates]
        mass = r.T @ (part.M @ r)
        small_r = np.vstack([r[boundary], np.zeros((small.n - boundary.size, 6))])
        error = np.abs(small_r.T @ (small.M @ small_r) - mass).max() / np.abs(mass).max()
        measured("any plate: rigid-body mass, centre of gravity, inertia, relative error", error, at_most=ROUND_OFF)
        f = np.random.default_rng(3).standard_normal(boundary.size)
        ground = 1e-3 * np.diag(to_dense(part.K)).mean()
        K = to_dense(part.K).copy()
        K[boundary, boundary] += ground
        K_small = to_dense(small.K).copy()
        at = np.arange(boundary.size)
        K_small[at, at] += ground
        load, load_small = np.zeros(part.n), np.zeros(small.n)
        load[boundary], load_small[at] = f, f
        answer = np.linalg.solve(K, load)[boundary]
        error = np.abs(np.linalg.solve(K_small, load_small)[at] - answer).max() / np.abs(answer).max()
        measured("any plate: static answer to boundary loads, relative error", error, at_most=ROUND_OFF)
    # all modes kept: the full model
    measured(
        "any plate, all modes: omega^2, error over the largest",
        np.abs(before - exact).max() / exact.max(),
        at_most=ROUND_OFF,
    )
