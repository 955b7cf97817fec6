"""Gap channels: the scalar contacts g = g0 + G u that are the only nonlinearity."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, brief
from creak.contact.channel_data import joined, per_channel, taken
from creak.contact.laws.parameters import Curves, Friction, LawArrays, law_arrays
from creak.model.dofs import TRANSLATIONS, dofs_of, nodes_of

STILL = 1e-9
"""Share of its gap at rest by which a channel may be off and still press as at rest."""


@dataclass(frozen=True)
class GapOperator:
    """m channels, each open for g > 0 and pressing with p >= 0 for g < 0.

    g = gap0 + G u[labels]; the force on the structure is G' p.
    """

    __repr__ = brief

    labels: IntArray
    """(n_label,) physical dof labels that any channel touches."""
    G: Matrix
    """(m, n_label) sparse."""
    tangents: tuple[Matrix, Matrix]
    """(m, n_label) each: relative motion along two tangents (zero for connectors without friction)."""
    gap0: FloatArray = field(metadata=per_channel(0.0))
    """(m,) initial clearance, length."""
    stiffness: FloatArray = field(metadata=per_channel(0.0))
    """(m,) penalty, force / length; inf: no penetration at all (exact unilateral contact)."""
    damping: FloatArray = field(metadata=per_channel(0.0))
    """(m,) force time / length, acts while closed."""
    step_limited: BoolArray = field(metadata=per_channel(False))
    """(m,) the penalty is creak's own choice and may be lowered to what the time step resolves."""
    area: FloatArray = field(metadata=per_channel(0.0))
    """(m,) tributary area, length^2; 0 for connectors and nodes without facets."""
    names: tuple[str, ...] = field(metadata=per_channel(""))
    """Channel names: `flange:1017`, `HOOK1:upper`."""
    nodes_idx: IntArray = field(metadata=per_channel(0))
    """(m,) node row of the secondary node."""
    group: tuple[str, ...] = field(metadata=per_channel(""))
    """(m,) the contact or connector that each channel belongs to."""
    curves: Curves | None = field(default=None, metadata=per_channel(Curves))
    """Tabular laws; None: stiffness only."""
    friction: Friction | None = field(default=None, metadata=per_channel(Friction))
    """None: no channel rubs."""
    preload: FloatArray | None = field(default=None, metadata=per_channel(0.0))
    """(m,) force with which a channel presses at rest, balanced by the rest of the structure; None: 0."""
    held: FloatArray | None = field(default=None, metadata=per_channel((0.0, 0.0)))
    """(m, 2) friction force along both tangents at rest, balanced likewise; None: 0."""
    size: FloatArray | None = field(default=None, metadata=per_channel(np.inf))
    """(m,) width of the facets at the channel, the smaller of both sides', length; inf or None: not known."""

    @property
    def m(self) -> int:
        return int(self.gap0.size)

    @property
    def presses(self) -> bool:
        """Any channel can carry a force."""
        return bool(self.stiffness.any()) or self.curves is not None

    @property
    def has_dampers(self) -> bool:
        """Any channel damps while it is closed."""
        return bool(self.damping.any())

    @property
    def rubbing(self) -> int:
        """f, the number of channels with friction."""
        return 0 if self.friction is None else int(self.friction.channels.size)

    @cached_property
    def laws(self) -> LawArrays:
        """The laws of all channels for compiled code."""
        return law_arrays(self.stiffness, self.damping, self.curves, self.friction)

    @cached_property
    def resting(self) -> FloatArray:
        """(m + 2 f,) channel forces that the preload balances at rest."""
        normal = np.zeros(self.m) if self.preload is None else self.preload
        if self.held is None or self.friction is None:
            return np.concatenate([normal, np.zeros(2 * self.rubbing)])
        return np.concatenate([normal, self.held[self.friction.channels].ravel()])

    def at_start(self, gap: FloatArray, rate: FloatArray) -> FloatArray:
        """(m + 2 f,) channel forces at t = 0: springs and dampers of closed channels, and what already holds there.

        Exact contact that starts closed without a preload presses from the first step on.
        """
        rest, force = self.resting, np.zeros(self.m + 2 * self.rubbing)
        k = np.where(np.isfinite(self.stiffness), self.stiffness, 0.0)
        p = np.where(gap < 0.0, np.maximum(0.0, -k * gap - self.damping * rate), 0.0)
        still = (rest[: self.m] > 0.0) & (np.abs(gap - self.gap0) <= STILL * np.abs(self.gap0))
        force[: self.m] = np.where(still, np.maximum(rest[: self.m] - self.damping * rate, 0.0), p)
        if self.friction is not None:
            force[self.m :] = np.where(np.repeat(still[self.friction.channels], 2), rest[self.m :], 0.0)
        return force

    def with_stiffness(self, stiffness: FloatArray) -> GapOperator:
        """Other springs (m,): a channel that presses at rest does so with the same force, squeezed by more or less."""
        if self.preload is None:
            return replace(self, stiffness=stiffness)
        other = (self.preload > 0.0) & (stiffness != self.stiffness) & (stiffness > 0.0) & np.isfinite(stiffness)
        gap0 = np.where(other, -self.preload / np.where(other, stiffness, 1.0), self.gap0)
        return replace(self, stiffness=stiffness, gap0=gap0)

    def can_press(self) -> BoolArray:
        """(m,) channels that can carry a force at rest; the others are only watched, or damp."""
        curved = np.zeros(self.m, dtype=bool) if self.curves is None else self.curves.of >= 0
        return np.asarray(curved | (self.stiffness > 0.0))

    def of_groups(self, names: Container[str]) -> BoolArray:
        """(m,) channels of these contacts and connectors."""
        return np.array([name in names for name in self.group], dtype=bool)

    def without_force(self) -> GapOperator:
        """The same gaps, watched but never pressing."""
        zero = np.zeros(self.m)
        return replace(self, stiffness=zero, damping=zero, curves=None, friction=None, preload=None, held=None)

    def moves_as(self, other: GapOperator) -> bool:
        """Whether the channels of another one follow the same motion: only their numbers may differ."""
        same = self.G.shape == other.G.shape and np.array_equal(self.labels, other.labels)
        pairs = zip((self.G, *self.tangents), (other.G, *other.tangents), strict=True)
        return same and all(a is b or (a != b).nnz == 0 for a, b in pairs)

    @cached_property
    def retained_nodes(self) -> IntArray:
        """Node rows whose motion the channels need."""
        return np.unique(nodes_of(self.labels))

    def select(self, keep: IntArray) -> GapOperator:
        """The operator with only the channels in `keep`."""
        G, t1, t2 = (A[keep] for A in (self.G, *self.tangents))
        used = np.unique(np.concatenate([G.indices, t1.indices, t2.indices])).astype(np.int64)
        matrices = {"labels": self.labels[used], "G": G[:, used], "tangents": (t1[:, used], t2[:, used])}
        return replace(taken(self, keep), **matrices)


@dataclass(frozen=True)
class ChannelRows:
    """Rows of new channels: (channel, label, value) triplets of the normal and both tangents."""

    channel: IntArray
    label: IntArray
    normal: FloatArray
    tangent1: FloatArray
    tangent2: FloatArray

    def turning(self, channel: IntArray, label: IntArray, tangent1: FloatArray, tangent2: FloatArray) -> ChannelRows:
        """With what rotations move along the tangents; entries of nothing are left out."""
        used = (tangent1 != 0.0) | (tangent2 != 0.0)
        more = channel[used], label[used], np.zeros(np.count_nonzero(used)), tangent1[used], tangent2[used]
        own = self.channel, self.label, self.normal, self.tangent1, self.tangent2
        return ChannelRows(*(np.concatenate(both) for both in zip(own, more, strict=True)))

    def without_rotations(self) -> ChannelRows:
        """Motion of the nodes alone: what nothing rubs on takes no rotation."""
        k = dofs_of(self.label) <= TRANSLATIONS[-1]
        return ChannelRows(self.channel[k], self.label[k], self.normal[k], self.tangent1[k], self.tangent2[k])

    def motion(self, m: int) -> dict[str, Any]:
        """The fields of a GapOperator that say how m channels follow the motion: labels, G and tangents."""
        labels, column = np.unique(self.label, return_inverse=True)

        def matrix(values: FloatArray) -> Matrix:
            A = sp.coo_matrix((values, (self.channel, column)), shape=(m, labels.size)).tocsr()
            A.eliminate_zeros()
            return A

        tangents = matrix(self.tangent1), matrix(self.tangent2)
        return {"labels": labels.astype(np.int64), "G": matrix(self.normal), "tangents": tangents}


def join(operators: Sequence[GapOperator]) -> GapOperator:
    """All channels of several operators as one (possibly with no channels)."""
    labels = np.unique(np.concatenate([o.labels for o in operators])) if operators else np.zeros(0, dtype=np.int64)

    columns = [np.searchsorted(labels, o.labels) for o in operators]

    def stacked(pick: int) -> Matrix:
        pieces = [sp.csr_matrix((o.G, *o.tangents)[pick]) for o in operators]
        if not pieces:
            return sp.csr_matrix((0, 0))
        ends = np.concatenate([[0], *(np.diff(A.indptr) for A in pieces)]).cumsum()
        at = np.concatenate([own[A.indices] for own, A in zip(columns, pieces, strict=True)])
        found = sp.csr_matrix((np.concatenate([A.data for A in pieces]), at, ends), shape=(ends.size - 1, labels.size))
        found.sum_duplicates()
        return found

    matrices = {"labels": labels.astype(np.int64), "G": stacked(0), "tangents": (stacked(1), stacked(2))}
    return GapOperator(**matrices, **joined(GapOperator, operators, [o.m for o in operators]))
