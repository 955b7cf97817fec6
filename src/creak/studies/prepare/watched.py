"""What a run looks at at every whole step, and whether its motions are small enough: slip of channels, rotations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.record.watch import Extremes, Watched
from creak.model.dofs import ROTATIONS, TRANSLATIONS, node_dofs
from creak.model.mesh import Model
from creak.words import first_few

DIRECTIONS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])[14:]
"""One of each two opposite: a part is followed at the nodes that lie farthest along them."""
FLAT = 1e-6
"""Share of the largest moment of the nodes' places below which they do not tell a rotation."""
SHARE = 0.5
"""Slip of this share of an element still leaves a point over or beside the facet that it was paired with."""
SHOWN = 5
"""Channels that a warning names."""
TURN = np.radians(10.0)
"""rad: a rotation theta taken as small lengthens an arm by theta^2 / 2, here by 1.5 %."""


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


def doubtful_channels(contacts: GapOperator, seen: Extremes) -> GapOperator:
    """Those of the contacts that a run had without force, and that may have closed between its steps."""
    return contacts.select(np.array([contacts.names.index(seen.silent[k]) for k in seen.doubtful], dtype=np.int64))


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


def slip_warnings(gaps: GapOperator, slip_max: FloatArray, unit: str, at: FloatArray | None = None) -> list[str]:
    """One warning for each contact whose channels slip by more than half an element.

    Every channel keeps the facet and the normal that it has at the start (small sliding), which holds while the
    tangential motion is small against the elements. Channels whose size is not known (connectors) are passed over.

    Parameters
    ----------
    gaps : m channels with their `size`.
    slip_max : (m,) largest relative tangential motion of each channel over a run, length. at : (m,) when, s.
    """
    if gaps.size is None or not gaps.m:
        return []
    share = np.asarray(slip_max, dtype=np.float64) / gaps.size
    far = np.flatnonzero(share > SHARE)
    group = np.array(gaps.group, dtype=object)[far]
    return [_warning(gaps, gaps.size, share, far[group == name], name, unit, at) for name in dict.fromkeys(group)]


def turn_warnings(names: Sequence[str], turn: FloatArray, at: FloatArray) -> list[str]:
    """One warning where anything turns by more than `TURN`.

    Parameters
    ----------
    names, turn, at : (k,) places, their largest rotations (rad), and when (s).
    """
    far = np.flatnonzero(turn > TURN)
    if not far.size:
        return []
    i = int(far[np.argmax(turn[far])])
    what = f"and {far.size - 1} more parts or nodes turn" if far.size > 1 else "turns"
    return [
        f"{names[i]} {what} by more than {np.degrees(TURN):.2g} degrees, farthest by "
        f"{np.degrees(turn[i]):.3g} at t = {at[i]:.4g} s; creak takes rotations as small, which lengthens what turns "
        f"by {50.0 * turn[i] ** 2:.2g} %, so where and when it touches is not to be trusted."
    ]


def _warning(
    gaps: GapOperator,
    size: FloatArray,
    share: FloatArray,
    far: IntArray,
    name: str,
    unit: str,
    at: FloatArray | None,
) -> str:
    worst = far[np.argsort(-share[far], kind="stable")]
    names = first_few([gaps.names[i] for i in worst], SHOWN)
    i = int(worst[0])
    when = "" if at is None else f" at t = {at[i]:.4g} s"
    return (
        f"[contact.{name}] {worst.size} channel(s) slip by more than half an element: {names}. {gaps.names[i]} slips "
        f"farthest, by {share[i] * size[i]:.3g} {unit}{when} on elements {size[i]:.3g} {unit} wide; contact keeps the "
        "partners and normals that it has at the start (small sliding), so where and how it presses there is not to be "
        "trusted."
    )
