"""Loads at times between their samples."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.loads import Loads

WIDTH = 6
"""Samples that a polynomial of degree 5 goes through."""


class StageLoads:
    """Prescribed motion and forces at the stages of a step, by polynomials through the samples around each.

    Displacement, velocity and acceleration are interpolated each by itself, by polynomials of degree 5: a sine with ten
    samples a period is met to some 3e-4, with 50 to 2e-8.
    """

    def __init__(self, loads: Loads, c: FloatArray, stride: int) -> None:
        self._loads, self._at = loads, c * stride
        self._width = min(WIDTH, loads.time.size)
        self._known: dict[tuple[int, int], FloatArray] = {}

    def __call__(self, row: int) -> tuple[FloatArray, FloatArray]:
        """(3, n_stage, n_support) motion and (n_stage, n_force) forces of the step that begins at sample `row`."""
        motion, force = [], []
        for i, share in enumerate(self._at):
            first = int(np.clip(row + int(share) - self._width // 2 + 1, 0, self._loads.time.size - self._width))
            rows = slice(first, first + self._width)
            weights = self._weights(i, row - first + share)
            motion.append(np.einsum("j,djs->ds", weights, self._loads.support[:, rows]))
            force.append(weights @ self._loads.force[rows])
        return np.stack(motion, axis=1), np.stack(force)

    def _weights(self, stage: int, x: float) -> FloatArray:
        """Lagrange's polynomials through 0, 1 ... at x."""
        key = (stage, int(x))
        if key not in self._known:
            nodes = np.arange(self._width)
            others = [np.delete(nodes, j) for j in nodes]
            self._known[key] = np.array([np.prod((x - o) / (j - o)) for j, o in zip(nodes, others, strict=True)])
        return self._known[key]
