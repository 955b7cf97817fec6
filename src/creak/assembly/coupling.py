"""Parts, full or reduced, joined into one System by links, supports and prescribed motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, to_dense
from creak.assembly.congruent import SideBySide, congruent
from creak.assembly.dampers import bearing, led_by_dampers, place_of
from creak.assembly.damping import Damping
from creak.assembly.elimination import (
    LinearEquation,
    eliminate,
    fixed_equations,
    linear_equations,
    principal,
    through,
    transformation,
)
from creak.assembly.part import (
    PartMatrices,
    Rayleigh,
    assemble_blocks,
    bare_system,
    split_constraints,
    started_labels,
)
from creak.assembly.system import Stats, Supports, System, dense_if_full, fitted_velocity, rows_with_entries
from creak.errors import InputError
from creak.linalg.dense_product import symmetric
from creak.linalg.memory import SPARE, rows_of
from creak.model.dofs import dofs_of, node_dofs, nodes_of
from creak.model.mesh import Model

NEGATIVE = 1e-9
"""Share of the largest mass on the diagonal down to which a negative one is round-off."""


@dataclass(frozen=True)
class Driven:
    """Prescribed motion: name -> the physical dof labels that follow it."""

    labels: Mapping[str, IntArray]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.labels)

    @property
    def nodes_idx(self) -> IntArray:
        """Node rows that follow any of it."""
        return np.unique(nodes_of(self.every))

    def dofs_at(self, node_idx: int) -> list[int]:
        """Dofs 1..6 of a node row that follow any of it."""
        return dofs_of(self.every[nodes_of(self.every) == node_idx]).tolist()

    @property
    def every(self) -> IntArray:
        """Sorted physical dof labels that follow any of it."""
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *self.labels.values()]))


def couple(
    systems: Sequence[System], model: Model, driven: Driven, common: Rayleigh, *, override: bool = False
) -> System:
    """Join part Systems into one: q_all = T q + T_s s(t), M = T' blkdiag(M_p) T.

    The same call joins unreduced parts into the reference model and Craig-Bampton parts into the reduced
    one (primal assembly: Klerk, Rixen, Voormeeren, AIAA J. 46, 2008). Systems that share a physical dof are tied
    there where both offer it (`System.joins`); where one does not, its copy stays loose, and the motion of the
    first unreduced System that has the dof counts as the physical one. Dofs without stiffness and mass are left out;
    those of them that dampers hold follow the others (`assembly.dampers`), and driven ones follow what drives them.

    Raises
    ------
    InputError : a driven dof is also held, or tied to another driven one; a negative mass; Systems that share a dof
        which only dampers hold in one that was joined before.
    """
    rows, names = _Stacked(systems), driven.names
    bare = _bare(model, driven, rows)
    if bare.size:
        systems = [*systems, bare_system(model, bare, common, "(driven dofs without stiffness)")]
        rows = _Stacked(systems)
    n_q = sum(s.n for s in systems)
    equations = _equations(model, driven, rows, n_q, rows.ties())
    ends = frozenset(range(n_q, n_q + len(names)))
    T_all, independent = transformation(np.arange(n_q + len(names)), eliminate(equations, ends))
    is_support = independent >= n_q
    T, T_s = T_all[:n_q, ~is_support], T_all[:n_q, is_support]
    own = independent[~is_support]
    between = _between_parts(model, common, override)
    R = None if between is None else rows(between.labels)

    def side_by_side(matrices: Sequence[Matrix], B: Matrix | None) -> SideBySide:
        return SideBySide(matrices, None if R is None or B is None else sp.csr_matrix(R.T @ B @ R))

    M = side_by_side([s.M for s in systems], between and between.M)
    M_t, M_side, M_corner = congruent(T, M, own), _side(T, M, T_s), _corner(T_s, M)
    alone = [s.M if s.M_alone is None else s.M_alone for s in systems]
    same = all(s.M_alone is None for s in systems)
    M_start = M_side if same else _side(T, side_by_side(alone, between and between.M), T_s)
    K = side_by_side([s.K for s in systems], between and between.K)
    K_t, K_side, K_corner = congruent(T, K, own), _side(T, K, T_s), _corner(T_s, K)
    C, C_between = _extras(systems), between and between.C
    if C is None and C_between is not None:
        C = [sp.csr_matrix((s.n, s.n)) for s in systems]
    extra = None if C is None else side_by_side(C, C_between)
    C_t = None if extra is None else congruent(T, extra, own)
    # Coordinates without stiffness and mass, unused rotations, are left out; those with dampers follow the others.
    held = (K_t.diagonal() > 0.0) | (M_t.diagonal() > 0.0)
    active, left = np.flatnonzero(held), np.flatnonzero(~held)
    damped = np.zeros(left.size, dtype=bool) if C_t is None else C_t.diagonal()[left] > 0.0
    bear = bearing(rows, T[:, left], damped, model)
    M_t, K_t = principal(M_t, active), principal(K_t, active)
    if extra is not None and damped.any():
        led = left[damped]
        X, X_s, C_t = led_by_dampers(C_t, _side(T, extra, T_s), led, active)
        T, T_s = T[:, active] + T[:, led] @ X, T_s + T[:, led] @ X_s
        C_t = C_t if C_t.nnz else None
    else:
        T, C_t = T[:, active], None if C_t is None else principal(C_t, active)
    coordinates = np.concatenate([s.coordinates for s in systems])[own[active]]
    _positive(M_t.diagonal(), coordinates, model)
    supports = Supports(
        names,
        M_side[active],
        K_side[active],
        np.zeros((T.shape[1], T_s.shape[1])) if extra is None else _side(T, extra, T_s),
        M_corner,
        K_corner,
        _extra_corner(T_s, extra, len(names)),
        M_start[active],
    )

    def physical(labels: IntArray) -> tuple[Matrix, Matrix]:
        A = rows(labels)
        return A @ T, to_dense(A @ T_s)

    def combine(B: Matrix, labels: IntArray) -> tuple[Matrix, Matrix]:
        A = rows.combined(sp.csc_matrix(B), labels)
        return A @ T, to_dense(A @ T_s)

    def whole(q: FloatArray, s: FloatArray, at: IntArray | None) -> FloatArray:
        return rows.recover(np.asarray(T @ q + T_s @ s), at)

    velocity = fitted_velocity(T, M.times, M_t, own[active], _given(systems, model))
    M_t, K_t, *more = _of_one_kind([_dense_if_full(A) for A in (M_t, K_t, *([] if C_t is None else [C_t]))])
    damping = Damping(common.alpha, common.beta, more[0] if more else None)
    return System(
        "assembly",
        M_t,
        K_t,
        damping,
        physical,
        supports,
        coordinates,
        velocity,
        stats=Stats(sum(s.stats.mass for s in systems)),
        labels=rows.labels,
        whole=whole,
        combine=combine,
        of_shells=True,
        bear=bear,
    )


def _bare(model: Model, driven: Driven, rows: _Stacked) -> IntArray:
    """Sorted driven dofs of the Systems that are coordinates of none, having neither stiffness nor mass there, and that
    no support and no link holds."""
    known = np.intersect1d(driven.every, rows.labels)
    bare = np.setdiff1d(known, known[rows_with_entries(rows(known))]) if known.size else known
    if not bare.size:
        return bare
    links = [x for c in model.constraints for e in linear_equations(c, model.nodes.coords) for x in e.labels]
    held = [node_dofs(fixed.nodes_idx, fixed.dofs) for fixed in model.fixed]
    return np.setdiff1d(bare, np.concatenate([np.array(links, dtype=np.int64), *held]))


def _given(systems: Sequence[System], model: Model) -> FloatArray:
    """Initial velocities of all coordinates; in a model with parts those that it neither names nor moves have none."""
    v = np.concatenate([s.velocity for s in systems])
    coordinates = np.concatenate([s.coordinates for s in systems])
    free = (v == 0.0) & ~np.isin(coordinates, started_labels(model))
    return np.where(free & bool(model.parts), np.nan, v)


def _positive(mass: FloatArray, coordinates: IntArray, model: Model) -> None:
    """Raise InputError for a coordinate whose mass is negative beyond round-off."""
    if not mass.size or mass.min() >= -NEGATIVE * np.abs(mass).max():
        return
    label = int(coordinates[mass.argmin()])
    at = place_of(label, model) if label >= 0 else "a coordinate of a superelement"
    raise InputError(
        f"the mass at {at} is {mass.min():.4g}, with what is tied to it",
        expected="zero or more",
        where=str(model.source or ""),
        fix="Look at point masses (*MASS, CONM2) and densities there.",
    )


class _Stacked:
    """Rows of all Systems side by side: u[labels] = R [q_1; q_2; ...]."""

    def __init__(self, systems: Sequence[System]) -> None:
        self.systems = systems
        order = sorted(range(len(systems)), key=lambda k: systems[k].interface is not None)  # unreduced first
        every = np.concatenate([systems[k].labels for k in order])
        self.labels, first, count = np.unique(every, return_index=True, return_counts=True)
        self._owner = np.repeat(order, [systems[k].labels.size for k in order])[first]
        shared = self.labels[count > 1]
        self._offered = [_with_motion(s, np.intersect1d(shared, s.joins)) for s in systems]
        self._prefer_joined()

    def _prefer_joined(self) -> None:
        """A shared dof belongs to the first System that offers it, if any does."""
        for k in sorted(range(len(self.systems)), key=lambda k: self.systems[k].interface is not None, reverse=True):
            self._owner[np.searchsorted(self.labels, self._offered[k])] = k

    def owner(self, labels: IntArray) -> IntArray:
        """The System that each label's motion is taken from, -1 for unknown labels."""
        labels = np.where(labels < 0, ~labels, labels)
        at = np.minimum(np.searchsorted(self.labels, labels), max(self.labels.size - 1, 0))
        known = self.labels[at] == labels if self.labels.size else np.zeros(labels.size, dtype=bool)
        return np.where(known, self._owner[at] if self.labels.size else -1, -1)

    def __call__(self, labels: IntArray) -> Matrix:
        owner = self.owner(labels)
        return sp.hstack([self.of(k, labels, owner == k) for k in range(len(self.systems))], format="csr")

    def of(self, k: int, labels: IntArray, mine: BoolArray) -> Matrix:
        """Rows of one System at those labels that are `mine`, empty rows elsewhere."""
        at = np.flatnonzero(mine)
        R = sp.coo_matrix(sp.csr_matrix(self.systems[k].rows(_known_to(self.systems[k], labels[at]))[0]))
        return sp.csr_matrix((R.data, (at[R.row], R.col)), shape=(labels.size, self.systems[k].n))

    def combined(self, B: Matrix, labels: IntArray) -> Matrix:
        """B (m, k) times the rows of k labels, each System's combinations by itself: its rows may be dear."""
        owner = self.owner(labels)
        each = [s.combined(B[:, owner == k], labels[owner == k])[0] for k, s in enumerate(self.systems)]
        return sp.hstack([sp.csr_matrix(A) for A in each], format="csr")

    def ties(self) -> Matrix:
        """E with E q_all = 0: the owner's motion minus that of every other System that offers the dof.

        Between Systems that have held drilling rotations (`assembly.drilling`) it is that of their shells.

        Where the owner's dofs are coordinates of their own, each row has one to eliminate. Where both sides follow
        fewer coordinates, the rows repeat each other and are brought to echelon form first.
        """
        pieces = [sp.csr_matrix((0, sum(s.n for s in self.systems)))]
        for k, system in enumerate(self.systems):
            labels = self._offered[k]
            labels = labels[self.owner(labels) != k]
            if labels.size:
                for each in (system, *(self.systems[j] for j in np.unique(self.owner(labels)))):
                    if each.bear is not None:
                        each.bear(labels)
                shells = np.array([s.of_shells for s in self.systems])[self.owner(labels)] & system.of_shells
                labels = np.where(shells, ~labels, labels)
                other = [self.of(j, labels, np.full(labels.size, j == k)) for j in range(len(self.systems))]
                mine = self(labels)
                E = mine - sp.hstack(other, format="csr")
                plain = np.diff(mine.indptr).max() == 1 and np.unique(mine.indices).size == labels.size
                pieces.append(E if plain else _echelon(E))
        return sp.csr_matrix(sp.vstack(pieces, format="csr"))

    def recover(self, q_all: FloatArray, at: IntArray | None = None) -> FloatArray:
        """(n_label, k) motion of all labels, or of those `at` some places; Systems that have none of them are left."""
        labels = self.labels if at is None else self.labels[at]
        owner = self._owner if at is None else self._owner[at]
        u, start = rows_of(labels.size, q_all.shape[1], SPARE).T, 0
        for k, system in enumerate(self.systems):
            mine = np.flatnonzero(owner == k)
            if mine.size:
                own = np.searchsorted(system.labels, labels[mine])
                u[mine] = system.recover(q_all[start : start + system.n], at=own)
            start += system.n
        return u


def _with_motion(system: System, labels: IntArray) -> IntArray:
    """Those of the labels at which the System moves: what has no stiffness of its own, as the rotations of solids, is
    no coordinate of it and holds no other System."""
    return labels[rows_with_entries(system.rows(labels)[0])] if labels.size else labels


def _known_to(system: System, labels: IntArray) -> IntArray:
    """The labels as the System's rows take them."""
    return labels if system.of_shells else np.where(labels < 0, ~labels, labels)


DEPENDENT = 1e-9
"""Equations whose remainder is below this share of the largest coefficient repeat others."""


def _echelon(E: Matrix) -> Matrix:
    """Independent rows with the same null space, [I, R] on pivot columns that come first in each row.

    QR with column pivoting, E P = Q [R_1, R_2], gives x_pivot + R_1^-1 R_2 x_rest = 0.
    """
    columns = np.unique(E.indices)
    size = np.sqrt(np.asarray(E.multiply(E).sum(axis=1)).ravel())
    A = E[:, columns].toarray() / np.maximum(size, 1e-300)[:, None]
    R, order = sla.qr(A, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank = int(np.count_nonzero(diagonal > DEPENDENT * diagonal.max(initial=0.0)))
    rest = sla.solve_triangular(R[:rank, :rank], R[:rank, rank:])
    rest[np.abs(rest) < DEPENDENT] = 0.0
    indices = [np.concatenate([[p], np.flatnonzero(row) + rank]) for p, row in enumerate(rest)]
    data = [np.concatenate([[1.0], row[row != 0.0]]) for row in rest]
    indptr = np.concatenate([[0], np.cumsum([i.size for i in indices])])
    where = columns[order][np.concatenate([np.zeros(0, dtype=np.int64), *indices]).astype(np.int64)]
    return sp.csr_matrix((np.concatenate([np.zeros(0), *data]), where, indptr), shape=(rank, E.shape[1]))


def _extras(systems: Sequence[System]) -> list[Matrix] | None:
    """Each System's damping beyond Rayleigh's, None where no one has any."""
    if all(s.damping.extra is None for s in systems):
        return None
    return [s.damping.extra if s.damping.extra is not None else sp.csr_matrix((s.n, s.n)) for s in systems]


def _between_parts(model: Model, common: Rayleigh, override: bool) -> PartMatrices | None:
    blocks = [b for b in model.blocks if b.part < 0]
    if not blocks:
        return None
    nodes = np.unique(np.concatenate([b.nodes_idx.ravel() for b in blocks]))
    return assemble_blocks(model, blocks, node_dofs(nodes), common, override)


def _equations(model: Model, driven: Driven, rows: _Stacked, n_q: int, ties: Matrix) -> list[LinearEquation]:
    """All ties and constraints between parts, supports and driven dofs, in coordinates instead of labels."""
    across = split_constraints(model)[1]
    physical = [e for c in across for e in linear_equations(c, model.nodes.coords)]
    physical += [e for f in model.fixed for e in fixed_equations(f)]
    ends = [-1] * len(physical)
    for j, (name, labels) in enumerate(driven.labels.items()):
        physical += [LinearEquation([x], [1.0], f"[excitation.{name}], {place_of(x, model)}") for x in labels.tolist()]
        ends += [j] * labels.size
    labels = np.unique(np.array([x for e in physical for x in e.labels], dtype=np.int64))
    R = rows(labels)
    place = {label: i for i, label in enumerate(labels.tolist())}
    out = [
        LinearEquation(ties.indices[a:b].tolist(), ties.data[a:b].tolist(), "shared nodes")
        for a, b in zip(ties.indptr[:-1], ties.indptr[1:], strict=True)
    ]
    for equation, end in zip(physical, ends, strict=True):
        columns, values = through(equation, R, place)
        if end >= 0:
            columns, values = [*columns, n_q + end], [*values, -1.0]
        out.append(LinearEquation(columns, values, equation.where))
    return [e for e in out if e.labels]


def _dense_if_full(A: Matrix) -> Matrix:
    """A, or its symmetric part as an ndarray where it is mostly full (reduced parts)."""
    B = dense_if_full(A)
    return B if sp.issparse(B) else symmetric(B)


def _of_one_kind(matrices: list[Matrix]) -> list[Matrix]:
    """All sparse, or all dense as soon as one is (their sums are np.matrix otherwise)."""
    return matrices if all(sp.issparse(A) for A in matrices) else [to_dense(A) for A in matrices]


def _side(T: Matrix, A: SideBySide, T_s: Matrix) -> FloatArray:
    return to_dense(T.T @ A.times(T_s))


def _corner(T_s: Matrix, A: SideBySide) -> FloatArray:
    return to_dense(T_s.T @ A.times(T_s))


def _extra_corner(T_s: Matrix, C: SideBySide | None, n: int) -> FloatArray:
    return np.zeros((n, n)) if C is None else _corner(T_s, C)


def labels_of(nodes_idx: IntArray, dof: int) -> IntArray:
    """Labels of one dof at several nodes."""
    return node_dofs(nodes_idx, (dof,))
