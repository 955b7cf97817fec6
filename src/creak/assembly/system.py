"""The System: the one form in which every linear model, full or reduced, meets the rest of creak."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, brief, to_dense
from creak.assembly.damping import Damping
from creak.linalg.complex_modes import ComplexModes, complex_modes, coupled
from creak.linalg.dense_product import symmetric
from creak.model.dofs import dofs_of, nodes_of

Rows = Callable[[IntArray], tuple[Matrix, Matrix]]
"""Physical dof labels (k,) -> (R, R_s) with u[labels] = R q + R_s s; (k, n) and (k, n_support)."""
Recover = Callable[[FloatArray, FloatArray, IntArray | None], FloatArray]
"""q (n, k), s (n_support, k) and places in the labels of a System, or None -> u (n_label, k) there, or of all."""
Combine = Callable[[Matrix, IntArray], tuple[Matrix, Matrix]]
"""A (m, k), physical dof labels (k,) -> A R and A R_s of `Rows`."""

Bear = Callable[[IntArray], None]
"""Physical dof labels (k,) at which forces act; see `System.bear`."""


@dataclass(frozen=True)
class Supports:
    """Coordinates whose motion s(t) is prescribed, and how they act on the free ones.

    The equation of motion is M q'' + C q' + K q = f - M_qs s'' - C_qs s' - K_qs s.
    """

    __repr__ = brief

    names: tuple[str, ...]
    """One per prescribed coordinate; several physical dofs may follow the same one."""
    M_qs: Matrix
    K_qs: Matrix
    C_qs: Matrix
    """(n, n_support), damping that is not Rayleigh."""
    M_ss: FloatArray
    K_ss: FloatArray
    C_ss: FloatArray
    """(n_support, n_support)"""
    M_start: Matrix
    """(n, n_support) momentum of the coordinates when a support moves and nothing else does. Equal to M_qs in a
    full model; in a reduced one M_qs counts the inside that follows the support, which is at rest at t = 0."""

    @property
    def count(self) -> int:
        return len(self.names)


def no_supports(n: int) -> Supports:
    """Supports of a System with no prescribed motion."""
    empty = np.zeros((0, 0))
    side = np.zeros((n, 0))
    return Supports((), side, side, side, empty, empty, empty, side)


@dataclass(frozen=True)
class Stats:
    """What a System holds, and how it came about."""

    mass: float = 0.0
    elements: int = 0
    retained: int = 0
    """Physical coordinates that a reduction kept, or residual vectors."""
    modes: int = 0
    """Modes that it kept."""
    internal: int = 0
    """Coordinates that it replaced."""
    dropped: int = 0
    """Residual vectors left out as nearly dependent."""
    first_left_out: float = np.inf
    """First frequency of a mode that was left out, Hz; infinite where none is known."""


@dataclass(frozen=True)
class System:
    """M q'' + C q' + K q = f in coordinates q; `rows` gives the physical motion back.

    A full-order System is sparse, a Craig-Bampton one dense, a diagonalised one diagonal: nobody asks.
    """

    __repr__ = brief

    name: str
    M: Matrix
    K: Matrix
    damping: Damping
    rows: Rows
    supports: Supports
    coordinates: IntArray
    """(n,) physical dof label of each coordinate, -1 for generalised ones."""
    velocity: FloatArray
    """(n,) initial velocity."""
    M_alone: Matrix | None = None
    """(n, n) momentum of the coordinates when one boundary coordinate moves without its constraint mode; None: M."""
    stats: Stats = Stats()
    labels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n_label,) sorted physical dof labels that the System moves."""
    whole: Recover | None = None
    """The motion of many labels at once, as `recover`, where that is cheaper than through `rows`."""
    interface: IntArray | None = None
    """Sorted labels at which the System is joined to others that share them; None: all."""
    combine: Combine | None = None
    """Few combinations of many rows, where that is cheaper than through `rows`."""
    of_shells: bool = False
    """Whether `rows` takes ~label besides: what shells have in that dof where a support holds the node's rotation about
    their normal (`assembly.drilling`), elsewhere the same as `label`."""
    bear: Bear | None = None
    """Raises InputError for labels at which a force would press on nothing, or on dampers alone; None: on none."""

    @property
    def n(self) -> int:
        return int(self.coordinates.size)

    @cached_property
    def coupled(self) -> int:
        """How many coordinates damping couples; M and K are diagonal."""
        m, k = (np.asarray(A.diagonal(), dtype=float) for A in (self.M, self.K))
        root = np.sqrt(np.where(m > 0.0, m, 1.0))
        return int(np.count_nonzero(coupled(self.damping.matrix(m, k) / np.outer(root, root))))

    @cached_property
    def complex_modes(self) -> ComplexModes:
        """Of a System with diagonal M and K and mass everywhere, found once.

        Raises
        ------
        NumericalError : no trustworthy eigenvectors were found.
        """
        m, k = (np.asarray(A.diagonal(), dtype=float) for A in (self.M, self.K))
        d = self.damping
        shared = None if d.extra is None else to_dense(d.extra)
        return complex_modes(m, k, d.matrix(m, k), shared)

    def combined(self, A: Matrix, labels: IntArray) -> tuple[Matrix, Matrix]:
        """A R (m, n) and A R_s (m, n_support): combinations A (m, k) of the motion at `labels` (k,)."""
        if self.combine is not None:
            return self.combine(A, labels)
        R, R_s = self.rows(labels)
        return A @ R, A @ R_s

    def displacement(self, labels: IntArray, q: FloatArray, s: FloatArray) -> FloatArray:
        """Physical motion u[labels] = R q + R_s s for q (n,) or (n, n_time)."""
        R, R_s = self.rows(labels)
        return np.asarray(R @ q + R_s @ s)

    def recover(self, q: FloatArray, s: FloatArray | None = None, at: IntArray | None = None) -> FloatArray:
        """Full-field motion (n_label,) or (n_label, k) of `labels` for q (n,) or (n, k) and s likewise.

        For many instants call it block by block (`creak.assembly.system`): a block costs its own size only.

        Parameters
        ----------
        at : where in `labels` those are whose motion is asked for; default: all.
        """
        one = q.ndim == 1
        Q = q[:, None] if one else q
        S = np.zeros((self.supports.count, Q.shape[1])) if s is None else (s[:, None] if one else s)
        if self.whole is not None:
            u = self.whole(Q, S, at)
        else:
            u = self.displacement(self.labels if at is None else self.labels[at], Q, S)
        return u[:, 0] if one else u

    @property
    def joins(self) -> IntArray:
        """(k,) sorted labels at which other Systems may be joined."""
        return self.labels if self.interface is None else self.interface


def project(
    system: System,
    V: FloatArray,
    *,
    static: FloatArray | None = None,
    name: str = "",
    known: tuple[Matrix, Matrix] | None = None,
) -> System:
    """The System in coordinates eta, q = V eta + R s (Galerkin).

    M' = V' M V, M'_qs = V' (M R + M_qs), M'_ss = R' M R + R' M_qs + M_qs' R + M_ss; K and C alike.

    Parameters
    ----------
    V : (n, r) basis. static : R, (n, n_support), motion that follows the supports; default 0.
    known : M' and K' of the basis where they need not be made, as for modes.
    """
    sup = system.supports
    R = np.zeros((system.n, sup.count)) if static is None else static

    def side(A: Matrix, A_qs: Matrix) -> FloatArray:
        return np.asarray(V.T @ (np.asarray(A @ R) + to_dense(A_qs)))

    def corner(A: Matrix, A_qs: Matrix, A_ss: FloatArray) -> FloatArray:
        cross = R.T @ to_dense(A_qs)
        return np.asarray(R.T @ np.asarray(A @ R) + cross + cross.T + A_ss)

    damping = system.damping
    CR = np.zeros_like(R) if damping.is_rayleigh else np.asarray(damping.other(R))
    cross = R.T @ sup.C_qs
    supports = Supports(
        sup.names,
        side(system.M, sup.M_qs),
        side(system.K, sup.K_qs),
        np.asarray(V.T @ (CR + sup.C_qs)),
        corner(system.M, sup.M_qs, sup.M_ss),
        corner(system.K, sup.K_qs, sup.K_ss),
        R.T @ CR + cross + cross.T + sup.C_ss,
        np.asarray(V.T @ to_dense(sup.M_start)),
    )

    def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
        A, A_s = system.rows(labels)
        A = dense_if_full(A)
        return np.asarray(A @ V), np.asarray(A @ R) + to_dense(A_s)

    def combine(A: Matrix, labels: IntArray) -> tuple[Matrix, Matrix]:
        B, B_s = system.combined(A, labels)
        B = dense_if_full(B)
        return np.asarray(B @ V), np.asarray(B @ R) + to_dense(B_s)

    def whole(q: FloatArray, s: FloatArray, at: IntArray | None) -> FloatArray:
        return system.recover(np.asarray(V @ q) + R @ s, s, at)

    M, K = known or (symmetric(V.T @ np.asarray(A @ V)) for A in (system.M, system.K))
    velocity = np.zeros(V.shape[1])
    if system.velocity.any():
        velocity = momentum_fit(to_dense(M), V.T @ np.asarray(system.M @ system.velocity))
    coordinates = np.full(V.shape[1], -1, dtype=np.int64)
    return System(
        name or system.name,
        M,
        K,
        damping.projected(V),
        rows,
        supports,
        coordinates,
        velocity,
        labels=system.labels,
        whole=whole,
        interface=system.interface,
        combine=combine,
        bear=system.bear,
    )


def momentum_fit(M: Matrix, momentum: FloatArray) -> FloatArray:
    """Reduced initial velocity with the generalised momentum V' M v of the unreduced one: M' q' = V' M v.

    Coordinates without mass (rotations of a point mass) get none. A sparse M' may be singular.
    """
    velocity, heavy = np.zeros(M.shape[0]), np.flatnonzero(M.diagonal() > 0.0)
    if not momentum.any():
        return velocity
    if not sp.issparse(M):
        velocity[heavy] = np.linalg.solve(M[np.ix_(heavy, heavy)], momentum[heavy])
        return velocity
    scale = sp.diags(1.0 / np.sqrt(M.diagonal()[heavy]))
    found, _ = cg(scale @ M[heavy][:, heavy] @ scale, scale @ momentum[heavy], rtol=ROUND_OFF)
    velocity[heavy] = scale @ found
    return velocity


ROUND_OFF = 1e-13
"""Of an initial velocity that is fitted, and of one that needs no fit."""


def fitted_velocity(T: Matrix, M: Callable[[Matrix], Matrix], M_t: Matrix, own: IntArray, v: FloatArray) -> FloatArray:
    """Velocity q' (k,) of what follows fewer coordinates, u = T q, with the momentum of the given one v (n,).

    T' M T q' = T' M v; exactly v where T has it. What follows no coordinate (supports) has no part in it.

    Parameters
    ----------
    M : x (n, 1) sparse -> M x. M_t : T' M T, sparse. own : (k,) rows of T that are the coordinates.
    v : (n,), not a number where none is given: what follows others has theirs, the others none.
    """
    q = np.nan_to_num(v[own])
    differs = v - T @ q
    differs[~(np.abs(differs) > ROUND_OFF * np.abs(q).max(initial=0.0)) | ~rows_with_entries(T)] = 0.0
    return q if not differs.any() else q + momentum_fit(M_t, to_dense(T.T @ M(sp.csr_matrix(differs[:, None])))[:, 0])


MOSTLY_FULL = 0.1
"""A sparse matrix with a larger share of entries is slower than a dense one."""


def dense_if_full(A: Matrix) -> Matrix:
    """A as it is, or as an ndarray where it is sparse in name only."""
    full = sp.issparse(A) and A.nnz > MOSTLY_FULL * A.shape[0] * A.shape[1]
    return A.toarray() if full else A


def entries_of(A: Matrix) -> int:
    """How many numbers a matrix stores."""
    return int(A.nnz) if sp.issparse(A) else int(A.size)


def rows_with_entries(A: Matrix) -> BoolArray:
    """(n,) whether anything but 0 stands in a row."""
    if sp.issparse(A):
        return np.asarray(np.bincount(sp.csr_matrix(A).nonzero()[0], minlength=A.shape[0]) > 0)
    return np.asarray(np.any(to_dense(A) != 0.0, axis=1))


MEMORY = 500_000_000
"""Bytes of motion recovered at a time."""


def recovered(
    system: System, q: FloatArray, s: FloatArray, *, block: int | None = None
) -> Iterator[tuple[slice, FloatArray]]:
    """Full-field motion u (n_label, k_block) of all `system.labels`, block by block: u = V q + R s.

    Inside a superelement a block is one back-substitution, u_i = -K_ii^-1 K_ib u_b + Phi eta; memory is that of a
    block, however many instants there are.

    Parameters
    ----------
    q : (n, k) coordinates. s : (n_support, k) prescribed motion. block : instants at a time.
    """
    width = block or int(np.clip(MEMORY // (8 * max(system.labels.size, 1)), 1, 256))
    for start in range(0, q.shape[1], width):
        here = slice(start, min(start + width, q.shape[1]))
        yield here, system.recover(q[:, here], s[:, here])


def by_node(u: FloatArray, labels: IntArray, n_node: int, dofs: int = 3) -> FloatArray:
    """(k, n_node, dofs) motion of all nodes from (n_label, k) motion; zero where a node has no such dof.

    Parameters
    ----------
    dofs : 3: translations; 6: rotations too.
    """
    out = np.zeros((u.shape[1], n_node, dofs))
    moves = dofs_of(labels) <= dofs
    out[:, nodes_of(labels[moves]), dofs_of(labels[moves]) - 1] = u[moves].T
    return out


def row_names(system: System, node_ids: IntArray) -> tuple[IntArray, IntArray]:
    """Node label and dof of each coordinate, 0 for generalised ones."""
    c = system.coordinates
    ids = np.where(c >= 0, node_ids[nodes_of(np.maximum(c, 0))], 0)
    return ids.astype(np.int64), np.where(c >= 0, dofs_of(np.maximum(c, 0)), 0).astype(np.int64)
