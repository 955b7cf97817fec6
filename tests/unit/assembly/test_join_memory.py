"""Joining parts never puts their matrices side by side."""

from __future__ import annotations

import tracemalloc

import numpy as np

from creak.assembly.coupling import couple
from creak.assembly.part import part_system
from creak.model.constraints import Fixed
from helpers_core import NO_DAMPING, NONE, block, model_of, plate, shell


def test_the_peak_of_joining():
    """K and M of the whole and what meets dependents: 1.2 times K and M; 2.5 with one of them side by side."""
    coords, quads = plate(30, 30)
    model = model_of(
        np.vstack([coords, coords + [0.0, 0.0, 0.1]]),
        [block("quad4", quads, shell(0.001)), block("quad4", quads + len(coords), shell(0.001), 1, 10_000)],
        [("LOWER", range(len(coords))), ("UPPER", range(len(coords), 2 * len(coords)))],
        fixed=[Fixed(np.array([0, 1, len(coords)]), (1, 2, 3))],
    )
    parts = [part_system(model, k, NO_DAMPING) for k in range(2)]
    couple(parts, model, NONE, NO_DAMPING)
    tracemalloc.start()
    joined = couple(parts, model, NONE, NO_DAMPING)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    matrices = 12 * (joined.K.nnz + joined.M.nnz)
    assert peak < 1.35 * matrices
