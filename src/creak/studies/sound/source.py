"""Contact forces as what makes the sound: sampled, with their work on the modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import modal_matrices
from creak.dynamics.history import History
from creak.signals.resampling import cell_means
from creak.sound.forced import Modes
from creak.sound.zwicker_tables import RATE

NO_GAPS = join([])


@dataclass(frozen=True)
class Source:
    """Forces of the channels that touched, less what rests on them: normal ones, then tangents."""

    modes: Modes
    force: FloatArray
    """(n, n_force) means over the intervals of 48 kHz."""
    channel: IntArray
    """(n_force,) the channel of each."""
    row: IntArray
    """(n_force,) of each into `channel_matrices`."""
    gaps: GapOperator = NO_GAPS
    """The channels; none where no contact makes the forces."""

    def groups(self, places: Sequence[IntArray]) -> list[IntArray]:
        """Columns of each place's channels; last those of all other channels."""
        own = [np.flatnonzero(np.isin(self.channel, place)) for place in places]
        rest = np.setdiff1d(np.arange(self.channel.size), np.concatenate([*own, np.zeros(0, dtype=np.int64)]))
        return [*own, rest]


def source_of(system: System, gaps: GapOperator, history: History) -> Source:
    """The forces of a run on its System, which is diagonal."""
    touched = np.flatnonzero((history.force > 0.0).any(axis=0)).astype(np.int64)
    rubbing = np.zeros(0, dtype=np.int64) if gaps.friction is None else gaps.friction.channels
    along = np.flatnonzero(np.repeat(np.isin(rubbing, touched), 2))
    n = max(2, int(np.floor((history.time[-1] - history.time[0]) * RATE * (1.0 + 1e-12))) + 1)
    at = np.minimum(history.time[0] + np.arange(n) / RATE, history.time[-1])
    resting = gaps.resting[touched]
    normal = cell_means(history.time, history.force[:, touched], at) - resting
    force = np.hstack([normal, cell_means(history.time, history.tangential[:, along], at)]) if along.size else normal
    row = np.concatenate([touched, gaps.m + along])
    channel = np.concatenate([touched, np.repeat(rubbing, 2)[along]])
    return Source(_modes(system, gaps, row), force, channel, row, gaps)


def on_system(source: Source, system: System) -> Source:
    """The same forces on another System of the structure, diagonal too."""
    return replace(source, modes=_modes(system, source.gaps, source.row))


def _modes(system: System, gaps: GapOperator, row: IntArray) -> Modes:
    return Modes(*modal_matrices(system), to_dense(channel_matrices(system, gaps).rows[row]))


def of_modes(system: System, A: Matrix, labels: IntArray) -> FloatArray:
    """(k, n_mode) of combinations A (k, n_label) of the motion of dof labels; what is held does not move."""
    moves = np.isin(labels, system.labels)
    return to_dense(system.combined(sp.csr_matrix(sp.csr_matrix(A)[:, np.flatnonzero(moves)]), labels[moves])[0])
