"""What a run looks at at every whole step: gaps of channels that carry no force, and rotations of parts and nodes."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.contact.gap_operator import GapOperator
from creak.contact.small_sliding import slip_warnings, turn_warnings
from creak.dynamics.history import History
from creak.dynamics.record.watch import Watched
from creak.model.dofs import ROTATIONS, TRANSLATIONS, node_dofs
from creak.model.mesh import Model

DIRECTIONS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])[14:]
"""One of each two opposite: a part is followed at the nodes that lie farthest along them."""
FLAT = 1e-6
"""Share of the largest moment of the nodes' places below which they do not tell a rotation."""


def watched(model: Model, contacts: GapOperator, gaps: GapOperator) -> Watched:
    """The channels of the contacts that are not among `gaps`, and the rotations of parts and of channel nodes."""
    return Watched(_silent(contacts, gaps), *_turns(model, np.unique(gaps.nodes_idx)))


def silent_channels(contacts: GapOperator, gaps: GapOperator) -> Watched:
    """Those channels alone."""
    return Watched(_silent(contacts, gaps), np.zeros((0, 0)), np.zeros(0, dtype=np.int64), (), slip=False)


def _silent(contacts: GapOperator, gaps: GapOperator) -> GapOperator:
    kept = set(gaps.names)
    silent = np.array([k for k, name in enumerate(contacts.names) if name not in kept], dtype=np.int64)
    return contacts.select(silent).without_force()


def watched_labels(model: Model, contacts: GapOperator) -> IntArray:
    """Dofs that what is watched follows from, whatever channels are kept."""
    turns = _turns(model, np.unique(contacts.nodes_idx))
    return np.union1d(contacts.labels, turns[1]).astype(np.int64)


def _turns(model: Model, nodes: IntArray) -> tuple[Matrix, IntArray, tuple[str, ...]]:
    """Rotation vectors (3 k, n_label) of parts, as far as they move as rigid bodies, and of single nodes; the labels;
    the names.

    theta = I^-1 sum r x u over a few nodes of a part, r from their middle, I = sum (r.r 1 - r r').
    """
    blocks = [_rigid(model.nodes.coords, part.nodes_idx) for part in model.parts]
    blocks += [(np.eye(3), node_dofs(np.array([node]), ROTATIONS)) for node in nodes.tolist()]
    labels = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(own for _, own in blocks)]))
    turns = sp.lil_matrix((3 * len(blocks), labels.size))
    for k, (A, own) in enumerate(blocks):
        turns[3 * k : 3 * k + 3, np.searchsorted(labels, own)] = A
    names = (*(f"part {p.name}" for p in model.parts), *(f"node {model.nodes.label(int(i))}" for i in nodes))
    return sp.csr_matrix(turns), labels, names


def _rigid(coords: FloatArray, nodes: IntArray) -> tuple[FloatArray, IntArray]:
    """(3, 3 k) and the labels of the translations of k nodes."""
    along = coords[nodes] @ DIRECTIONS.T
    ends = np.unique(nodes[np.concatenate([along.argmin(axis=0), along.argmax(axis=0)])])
    r = coords[ends] - coords[ends].mean(axis=0)
    moment = np.einsum("kx,kx->", r, r) * np.eye(3) - r.T @ r
    cross = np.cross(r[:, None, :], np.eye(3)[None]).transpose(2, 0, 1).reshape(3, -1)
    inverse = np.linalg.pinv(moment, rcond=FLAT, hermitian=True)
    return inverse @ cross, node_dofs(ends, TRANSLATIONS)


def motion_warnings(gaps: GapOperator, history: History, unit: str) -> list[str]:
    """Slip, in this unit of length, and rotations for which contact and kinematics do not hold, seen at every step."""
    seen = history.extremes
    if seen is None:
        return []
    slips = slip_warnings(gaps, seen.slip, unit, seen.slip_at)
    return [*slips, *turn_warnings(seen.turn_names, seen.turn, seen.turn_at)]
