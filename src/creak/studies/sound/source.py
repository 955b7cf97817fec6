"""Contact forces as what makes the sound: sampled, with their work on the modes and the radiation of each mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.fft import rfft

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.history import History
from creak.dynamics.modal_coefficients import modal_matrices
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.skin import Skin
from creak.signals.resampling import cell_means
from creak.sound.forced import LOWEST, Modes
from creak.sound.rayleigh import PressureRows, pressure_weights
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.listeners import Listener

SAMPLES = 24
"""Facets of each part at which its motion is looked at."""
INSTANTS = 256
"""Frequencies at which it is."""
PER_BAND = 4.0
"""Samples per second of a listener's rows over the band: few, as each costs a back-substitution in every part."""


@dataclass(frozen=True)
class Source:
    """Forces of the channels that touched, less what rests on them: normal ones, then tangents."""

    modes: Modes
    force: FloatArray
    """(n, n_force) means over the intervals of 48 kHz."""
    channel: IntArray
    """(n_force,) the channel of each."""

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
    rows = to_dense(channel_matrices(system, gaps).rows[np.concatenate([touched, gaps.m + along])])
    modes = Modes(*modal_matrices(system), rows)
    return Source(modes, force, np.concatenate([touched, np.repeat(rubbing, 2)[along]]))


def radiation(system: System, listener: Listener, metre: float, band: float) -> PressureRows:
    """What each mode's acceleration sends to a listener, Pa, up to the end of the band, Hz."""
    skin = listener.skin
    nodes, row = np.unique(skin.nodes_idx, return_inverse=True)
    points = np.zeros((nodes.size, 3))
    points[row.ravel()] = skin.corners.reshape(-1, 3)
    rate = PER_BAND * band
    weights, start = pressure_weights(points * metre, listener.position * metre, rate, band)
    areas = np.zeros((nodes.size, 3))
    each = skin.shares[:, :, None] * skin.toward(listener.position)[:, None]
    np.add.at(areas, row.ravel(), each.reshape(-1, 3))
    labels = node_dofs(nodes, TRANSLATIONS)
    # Areas in m^2, motion in m.
    out = sp.csr_array((areas.ravel() * metre**3, (np.repeat(np.arange(nodes.size), 3), np.arange(3 * nodes.size))))
    moves = np.isin(labels, system.labels)
    A = sp.csr_matrix((weights @ out)[:, np.flatnonzero(moves)])
    return PressureRows(to_dense(system.combined(A, labels[moves])[0])[None], np.array([start]), rate, band)


def loudest(system: System, source: Source, skin: Skin, band: float) -> int | None:
    """The part that radiates most in the band by area and normal velocity, each piece a piston; None: none moves."""
    n = source.force.shape[0]
    pick = np.unique((np.geomspace(LOWEST, band, INSTANTS) * n / RATE).astype(np.int64))
    F = rfft(source.force, axis=0)[pick]
    s = 2j * np.pi * (pick[:, None] * RATE / n)
    m, c, k = source.modes.m, source.modes.c, source.modes.k
    velocity = (F @ source.modes.push) * (s / ((m * s + c) * s + k + 1e-300))
    looked = np.zeros(skin.count, dtype=bool)
    parts = np.unique(skin.part[skin.part >= 0])
    for part in parts.tolist():
        own = np.flatnonzero(skin.part == part)
        looked[own[np.linspace(0, own.size - 1, SAMPLES).astype(np.int64)]] = True
    few, area = skin.select(looked), np.linalg.norm(skin.areas, axis=1)
    labels, column = np.unique(node_dofs(few.nodes_idx[:, 0], TRANSLATIONS), return_inverse=True)
    normal = (few.areas / np.maximum(area[looked], 1e-300)[:, None]).ravel()
    across = sp.csc_matrix((normal, (np.repeat(np.arange(few.count), 3), column.ravel())), (few.count, labels.size))
    moves = np.isin(labels, system.labels)
    A = sp.csr_matrix(across[:, np.flatnonzero(moves)])
    power = (np.abs(velocity @ to_dense(system.combined(A, labels[moves])[0]).T) ** 2).mean(axis=0)
    each = np.array([area[skin.part == p].sum() * power[few.part == p].mean() for p in parts])
    return int(parts[each.argmax()]) if each.size and each.max() > 0.0 else None
