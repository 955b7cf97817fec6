"""Turns the motion of a System into the output that was asked for, block by block."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.history import ENERGIES, History, split_columns
from creak.dynamics.instant import Instant
from creak.dynamics.watch import Watch, Watched

BUFFER_MEMORY = 64_000_000
"""Bytes of motion kept before it is turned into output."""


class Recorder:
    """Keeps channel quantities and energies of every instant and turns blocks of motion into output."""

    def __init__(
        self,
        system: System,
        gaps: GapOperator,
        on: ChannelMatrices,
        observed: IntArray,
        n_step: int,
        output_every: int,
        whole_at: IntArray,
        watched: Watched | None = None,
    ) -> None:
        self._m, f2 = gaps.m, on.T.shape[0]
        self._every, self._whole_at = output_every, whole_at
        R, R_s = system.rows(observed)
        self._watch = None if watched is None else Watch(system, gaps, on, watched)
        wanted = [(R, R_s), *on.tangents]
        if self._watch is not None:
            wanted += [(A, A_s) for A, A_s in self._watch.rows[2:] if A.shape[0]]
        self._needed = _columns([A for A, _ in wanted], system.n)
        self._rows = [(A[:, self._needed], A_s) for A, A_s in ((R, R_s), *on.tangents)]
        self._watched_rows = [] if self._watch is None else [(A[:, self._needed], A_s) for A, A_s in self._watch.rows]
        self._kept = Growing(1 + self._m + self._m + f2 + f2 + len(ENERGIES), n_step + 1)
        n_out = n_step // output_every + 1
        self._index = np.zeros(n_out, dtype=np.int64)
        self._displacement, self._slip = np.zeros((n_out, observed.size)), np.zeros((n_out, self._m))
        width = int(np.clip(BUFFER_MEMORY // (8 * max(self._needed.size, 1)), 1, n_step + 1))
        self._buffer, self._support = np.zeros((width, self._needed.size)), np.zeros((width, system.supports.count))
        self._ends, self._pressed = np.zeros(width), np.zeros((width, self._m), dtype=bool)
        self._since = np.zeros(self._m, dtype=bool)
        self._steps = self._filled = self._done = self._contact_steps = 0
        self._coordinates = np.zeros((system.n, whole_at.size), order="F")

    def keep(self, time: float, now: Instant, energy: FloatArray, step: int | None) -> None:
        """Keep an instant; `step`: the output step that it ends, None within one."""
        self._kept.append(np.concatenate([[time], now.gap, now.force, now.sliding, energy]))
        self._contact_steps += bool(now.p.any())
        self._since |= now.p > 0.0
        if step is None:
            return
        at = np.searchsorted(self._whole_at, step)
        if at < self._whole_at.size and self._whole_at[at] == step:
            self._coordinates[:, at] = now.x.u
        if step % self._every == 0:
            self._index[step // self._every] = self._kept.used - 1
        elif self._watch is None:
            return
        k = self._filled
        self._buffer[k], self._support[k], self._ends[k] = now.x.u[self._needed], now.support[0], time
        self._pressed[k] = self._since
        self._since[:] = False
        self._filled += 1
        if self._filled == self._buffer.shape[0]:
            self._flush()

    def _flush(self) -> None:
        k = self._filled
        if self._watch is not None:
            Q, S = self._buffer[:k].T, self._support[:k].T
            motions = [np.asarray(A @ Q + A_s @ S) for A, A_s in self._watched_rows]
            self._watch.see(self._ends[:k], self._pressed[:k], motions)
            first = -self._steps % self._every
            rows = slice(first, k, self._every)
        else:
            rows = slice(0, k)
        self._steps += k
        Q, S = self._buffer[rows].T, self._support[rows].T
        here = slice(self._done, self._done + Q.shape[1])
        motion, slip1, slip2 = (np.asarray(A @ Q + A_s @ S) for A, A_s in self._rows)
        self._displacement[here] = motion.T
        self._slip[here] = np.hypot(slip1, slip2).T
        self._done, self._filled = here.stop, 0

    def history(self, setup_s: float, residual: float = 0.0) -> History:
        """All that was kept so far."""
        if self._filled:
            self._flush()
        m, f2 = self._m, (self._kept.width - 1 - 2 * self._m - len(ENERGIES)) // 2
        time, gap, force, tangential, sliding, energy = split_columns(self._kept.rows, m, f2)
        n, reached = self._done, int(np.searchsorted(self._whole_at, self._every * self._done))
        return History(
            time,
            gap,
            force,
            self._slip[:n],
            self._index[:n],
            self._displacement[:n],
            energy,
            self._contact_steps,
            setup_s,
            self._whole_at[:reached],
            self._coordinates[:, :reached],
            tangential,
            sliding,
            residual,
            None if self._watch is None else self._watch.extremes,
        )


class Growing:
    """Rows (used, width) appended one by one."""

    def __init__(self, width: int, capacity: int) -> None:
        self.width, self.used = width, 0
        self._table = np.empty((capacity, width))

    def append(self, row: FloatArray) -> None:
        """One more row."""
        if self.used == self._table.shape[0]:
            self._table.resize((2 * self.used + 1, self.width), refcheck=False)
        self._table[self.used] = row
        self.used += 1

    @property
    def rows(self) -> FloatArray:
        """(used, width)"""
        return self._table[: self.used]


def _columns(matrices: list[Matrix], n: int) -> IntArray:
    """Coordinates that any of the rows needs: few for a sparse System, all for a dense one."""
    if any(not sp.issparse(A) for A in matrices):
        return np.arange(n, dtype=np.int64)
    return np.unique(np.concatenate([sp.csr_matrix(A).indices for A in matrices])).astype(np.int64)
