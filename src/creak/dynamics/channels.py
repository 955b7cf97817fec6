"""The gap operator in the coordinates of a System."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator


@dataclass(frozen=True)
class ChannelMatrices:
    """g = gap0 + G q + G_s s, tangential motion w = T q + T_s s of the channels that rub."""

    G: Matrix
    """(m, n)"""
    G_s: FloatArray
    """(m, n_support)"""
    tangents: tuple[tuple[Matrix, FloatArray], ...]
    """Both tangents of all channels, as G and G_s."""
    T: Matrix
    """(2 f, n): both tangents of each rubbing channel in turn."""
    T_s: FloatArray
    """(2 f, n_support)"""

    @cached_property
    def rows(self) -> Matrix:
        """(m + 2 f, n) G above T: channel forces act through its transpose."""
        if self.T.shape[0] == 0:
            return self.G
        if sp.issparse(self.G):
            return sp.vstack([self.G, self.T], format="csr")
        return np.vstack([self.G, self.T])

    @cached_property
    def _touched(self) -> tuple[IntArray, Matrix]:
        """Coordinates that any channel acts on, and the columns of `rows` that belong to them, transposed."""
        if not sp.issparse(self.G):
            return np.arange(self.G.shape[1]), self.rows.T
        touched = np.unique(self.rows.indices)
        return touched, self.rows[:, touched].T

    def push(self, r: FloatArray, force: FloatArray, weight: float = 1.0) -> FloatArray:
        """r + weight [G; T]' f, in place."""
        if force.any():
            touched, columns = self._touched
            r[touched] += weight * np.asarray(columns @ force)
        return r


def channel_matrices(system: System, gaps: GapOperator) -> ChannelMatrices:
    """The rows of all channels on the coordinates and on the prescribed motion.

    Raises
    ------
    InputError : a channel presses on a dof that has neither stiffness nor mass.
    """
    if system.bear is not None and gaps.presses:
        system.bear(gaps.labels[np.unique(sp.csr_matrix(gaps.G).nonzero()[1])])
    B, B_s = on_coordinates(system, sp.vstack([gaps.G, *gaps.tangents], format="csr"), gaps.labels)
    (G, G_s), *tangents = [(B[k * gaps.m :][: gaps.m], B_s[k * gaps.m :][: gaps.m]) for k in range(3)]
    rubs = np.zeros(0, dtype=np.int64) if gaps.friction is None else gaps.friction.channels
    order = np.arange(2 * rubs.size).reshape(2, -1).T.ravel()
    first, second = (t[rubs] for t, _ in tangents)
    T = sp.vstack([first, second], format="csr") if sp.issparse(first) else np.vstack([first, second])
    T_s = np.vstack([t_s[rubs] for _, t_s in tangents])
    return ChannelMatrices(G, G_s, tuple(tangents), T[order], T_s[order])


def on_coordinates(system: System, A: Matrix, labels: IntArray) -> tuple[Matrix, FloatArray]:
    """Combinations A (m, k) of the motion at k labels: on the coordinates (m, n) and the supports (m, n_support)."""
    if not A.shape[0]:
        return np.zeros((0, system.n)), np.zeros((0, system.supports.count))
    B, B_s = system.combined(A, labels)
    return (sp.csr_matrix(B) if sp.issparse(B) else np.asarray(B)), to_dense(B_s)
