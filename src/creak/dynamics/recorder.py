"""Turns the motion of a System into the output that was asked for, block by block."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.dynamics.condensed import ChannelMatrices
from creak.dynamics.loads import Loads

BUFFER_MEMORY = 64_000_000
"""Bytes of motion kept before it is turned into output."""


class Recorder:
    """Keeps gaps and forces of every step and turns blocks of motion into output."""

    def __init__(
        self, system: System, on: ChannelMatrices, observed: IntArray, loads: Loads, output_every: int,
        whole_at: IntArray,
    ) -> None:  # fmt: skip
        n_time, m = loads.time.size, on.G.shape[0]
        self._loads, self._every = loads, output_every
        R, R_s = system.rows(observed)
        wanted = [(R, R_s), *on.tangents]
        self._needed = _columns([A for A, _ in wanted], system.n)
        self._rows = [(A[:, self._needed], A_s) for A, A_s in wanted]
        self.gap, self.force = np.zeros((n_time, m)), np.zeros((n_time, m))
        self.index = np.arange(0, n_time, output_every, dtype=np.int64)
        self._displacement = np.zeros((self.index.size, observed.size))
        self._slip = np.zeros((self.index.size, m))
        width = int(np.clip(BUFFER_MEMORY // (8 * max(self._needed.size, 1)), 1, self.index.size))
        self._buffer = np.zeros((width, self._needed.size))
        self._filled = self._done = 0
        self.whole_at = whole_at
        self.coordinates = np.zeros((system.n, whole_at.size), order="F")

    def keep(self, step: int, gap: FloatArray, p: FloatArray, u: FloatArray) -> None:
        """Keep gaps and forces of a step, its motion where output is due, all coordinates where asked for."""
        self.gap[step], self.force[step] = gap, p
        at = np.searchsorted(self.whole_at, step)
        if at < self.whole_at.size and self.whole_at[at] == step:
            self.coordinates[:, at] = u
        if step % self._every:
            return
        self._buffer[self._filled] = u[self._needed]
        self._filled += 1
        if self._filled == self._buffer.shape[0]:
            self._flush()

    def _flush(self) -> None:
        here = slice(self._done, self._done + self._filled)
        Q = self._buffer[: self._filled].T
        S = self._loads.support[0, self.index[here]].T
        motion, slip1, slip2 = (np.asarray(A @ Q + A_s @ S) for A, A_s in self._rows)
        self._displacement[here] = motion.T
        self._slip[here] = np.hypot(slip1, slip2).T
        self._done, self._filled = here.stop, 0

    def motion_kept(self) -> tuple[FloatArray, FloatArray]:
        """Displacement (n_out, n_label) and slip (n_out, m) so far."""
        if self._filled:
            self._flush()
        return self._displacement, self._slip


def _columns(matrices: list[Matrix], n: int) -> IntArray:
    """Coordinates that any of the rows needs: few for a sparse System, all for a dense one."""
    if any(not sp.issparse(A) for A in matrices):
        return np.arange(n, dtype=np.int64)
    return np.unique(np.concatenate([sp.csr_matrix(A).indices for A in matrices])).astype(np.int64)
