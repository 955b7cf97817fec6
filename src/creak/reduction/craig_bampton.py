"""Craig-Bampton reduction: constraint modes of the boundary plus fixed-interface modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.damping import Damping
from creak.assembly.system import Combine, Recover, Rows, System, momentum_fit, no_supports
from creak.linalg.dense_product import symmetric
from creak.linalg.memory import SPARE, blocks_that_fit, rows_of
from creak.linalg.modes import Modes, lowest, modes
from creak.linalg.sparse_product import BlockProduct
from creak.progress import Progress, Steps
from creak.reduction.constraint_modes import Terms, blocks, static_terms
from creak.reduction.inside import Inside

MOSTLY_FULL = 0.3
"""Reduced matrices with a larger share of entries are stored dense."""
COLUMNS = 64
"""Motions that are recovered at a time."""
COPIES = 4
"""Of these, that are held meanwhile."""


@dataclass(frozen=True)
class Basis:
    """u_b = P xi on the boundary, u_i = Psi P xi + Phi eta inside, Psi = -K_ii^-1 K_ib.

    Psi itself is never stored: what is needed of it is a back-substitution away.
    """

    inside: Inside
    P: Matrix
    """(n_b, n_xi) shapes of the boundary; the identity where every boundary dof is kept."""
    fixed: Modes
    """Fixed-interface modes, K_ii Phi = M_ii Phi diag(omega^2), Phi' M_ii Phi = I."""

    @property
    def n_boundary(self) -> int:
        return int(self.P.shape[1])

    @property
    def n(self) -> int:
        return self.n_boundary + int(self.fixed.omega2.size)

    def expand(self, q: FloatArray) -> FloatArray:
        """Coordinates (n, k) of the reduced System -> coordinates of the full one."""
        inside, u_b = self.inside, self.P @ q[: self.n_boundary]
        u = np.empty((inside.b.size + inside.i.size, q.shape[1]), order="F")
        u[inside.b] = u_b
        u[inside.i] = inside.follow(u_b) + self.fixed.shapes @ q[self.n_boundary :]
        return u

    def project(self, x: FloatArray) -> FloatArray:
        """V' x for x (n_full, k)."""
        inside, x_i = self.inside, x[self.inside.i]
        boundary = self.P.T @ (x[inside.b] - inside.K_ib.T @ inside.solve(x_i))
        return np.vstack([boundary, self.fixed.shapes.T @ x_i])


def craig_bampton(
    system: System,
    boundary: IntArray,
    *,
    f_max: float | None = None,
    count: int | None = None,
    shape: Matrix | None = None,
    inside: Inside | None = None,
    progress: Progress | None = None,
) -> System:
    """Reduce a System to its boundary coordinates and the fixed-interface modes below `f_max` (Hz).

    u_b = P xi, u_i = Psi P xi + Phi eta with Psi = -K_ii^-1 K_ib. Reduced K = blkdiag(P'(K_bb + K_bi Psi)P,
    diag(omega^2)); reduced M has M_eta,eta = I; Rayleigh damping keeps its two numbers, other damping is projected.

    Constraint modes are streamed `COLUMNS` at a time and not kept: with X = Psi P, the part of the reduced mass
    that needs them twice is X' M_ii X = -(K_ib P)' K_ii^-1 (M_ii X), a second back-substitution of the same block.
    Memory is that of the factor and the modes, however many dofs are retained; time is two back-substitutions a
    column. Boundary dofs that do not touch the inside keep their own sparse entries and
    cost nothing: that is how elements stay unreduced.

    Parameters
    ----------
    boundary : (n_b,) coordinates (rows of the System) to retain.
    shape : P, (n_b, n_xi) where the boundary itself is reduced; default: the identity. Rows follow sorted `boundary`.
    inside : blocks and factor, where the caller has them already for this boundary.

    Returns
    -------
    System with coordinates (xi, eta); `rows` and `recover` give internal dofs back. stats: retained, modes,
    internal, first_left_out (Hz), columns.

    Raises
    ------
    NumericalError : the boundary does not hold the part (K_ii is singular).

    Source: Craig and Bampton, AIAA J. 6(7), 1968. Accurate up to about f_max / 2 of the assembly.
    """
    inside = inside if inside is not None else Inside(system, boundary)
    basis = fixed_interface_basis(inside, shape, f_max, count, progress)
    matrices = reduced_matrices(system, basis, progress)
    inside.release()
    return reduced_system(system, basis, matrices)


def fixed_interface_basis(
    inside: Inside,
    shape: Matrix | None,
    f_max: float | None,
    count: int | None,
    progress: Progress | None = None,
    *,
    further: bool = False,
    found: Modes | None = None,
) -> Basis:
    """The boundary's shapes and the fixed-interface modes; `further` and `found` as `linalg.modes` has them."""
    P = sp.csr_matrix(shape) if shape is not None else sp.identity(inside.b.size, format="csr")
    report = _stage(progress, inside.name, "fixed-interface modes")
    return Basis(inside, P, _fixed_modes(inside, f_max, count, report, further=further, found=found))


@dataclass(frozen=True)
class StaticRows:
    """Rows of Psi P that were kept as the constraint modes went by: motion there needs no factor later."""

    at: IntArray
    """(k,) positions among the inner coordinates, rising."""
    values: FloatArray
    """(k, n_xi)"""
    modes: FloatArray | None = None
    """(k, n_mode) the fixed-interface modes there; None: they are read from the basis."""


@dataclass(frozen=True)
class Matrices:
    """What a reduction computes, (n, n) each; with the basis it makes the reduced System."""

    K: Matrix
    M: Matrix
    M_alone: Matrix
    C: Matrix | None
    static: StaticRows


def _stage(progress: Progress | None, name: str, stage: str) -> Steps | None:
    return None if progress is None else lambda done, total: progress(f"{name}: {stage}", done, total)


def _fixed_modes(
    inside: Inside, f_max: float | None, count: int | None, report: Steps | None, *, further: bool, found: Modes | None
) -> Modes:
    n = inside.i.size
    if n == 0 or count == 0:
        return Modes(np.zeros(0), np.zeros((n, 0)), 0.0, True, next_omega2=np.inf if n == 0 else np.nan)
    K, M, held = inside.K_ii, inside.M_ii, inside.factor
    own = inside.pieces
    return modes(
        K,
        M,
        f_max=f_max,
        count=count,
        further=further,
        found=found,
        stiffness_factor=held,
        pieces=own,
        progress=report,
    )


def reduced_matrices(
    system: System, basis: Basis, progress: Progress | None = None, *, watched: IntArray | None = None
) -> Matrices:
    """K, M, the momentum of the boundary alone, and damping that is not Rayleigh, in the coordinates of the basis.

    `watched`: physical dof labels of the System whose motion will be asked for; it is kept on the way.
    """
    inside, P, omega2 = basis.inside, basis.P, basis.fixed.omega2
    extra = None if system.damping.extra is None else sp.csr_matrix(system.damping.extra)
    keep = _inner(system, inside, watched)
    terms = static_terms(inside, P, basis.fixed, extra, keep, _stage(progress, inside.name, "constraint modes"))
    c, unit = terms.columns, np.eye(omega2.size)

    def own(A_bb: Matrix) -> Matrix:
        return sp.csr_matrix(P.T @ A_bb @ P)

    side = mode_rows(basis, inside.M_ib)
    to_modes = _plus(side, c, terms.modal[0])
    K = _joined(own(inside.K_bb), c, terms.stiffness, np.zeros_like(side), np.diag(omega2))
    M = _joined(own(inside.M_bb), c, terms.cross[0] + terms.cross[0].T + terms.inner[0], to_modes, unit)
    alone = _joined(own(inside.M_bb), c, terms.cross[0].T, side, unit, upper=to_modes.T)
    static = np.zeros((keep.size, P.shape[1]))
    static[:, c] = terms.kept
    damping = None if extra is None else _reduced_damping(basis, terms, extra, own)
    return Matrices(K, M, alone, damping, StaticRows(keep, static))


def truncated(basis: Basis, matrices: Matrices, kept: int) -> tuple[Basis, Matrices]:
    """The same with the `kept` lowest fixed-interface modes alone: what a reduction to these gives."""
    fixed = basis.fixed
    if kept == fixed.omega2.size:
        return basis, matrices
    n = basis.n_boundary + kept
    K, M, alone = (A[:n, :n] for A in (matrices.K, matrices.M, matrices.M_alone))
    C = None if matrices.C is None else matrices.C[:n, :n]
    there = None if matrices.static.modes is None else matrices.static.modes[:, :kept]
    return replace(basis, fixed=lowest(fixed, kept)), Matrices(K, M, alone, C, replace(matrices.static, modes=there))


def _inner(system: System, inside: Inside, labels: IntArray | None) -> IntArray:
    """Inner coordinates that the motion at these labels depends on."""
    if labels is None or labels.size == 0:
        return np.zeros(0, dtype=np.int64)
    return np.unique(sp.csr_matrix(system.rows(labels)[0])[:, inside.i].indices).astype(np.int64)


def reduced_system(system: System, basis: Basis, matrices: Matrices) -> System:
    """The reduced System of a basis and its matrices, however they came about."""
    inside, n_xi, n_m = basis.inside, basis.n_boundary, basis.fixed.omega2.size
    labels = system.coordinates[inside.b] if _is_identity(basis.P) else np.full(n_xi, -1, dtype=np.int64)
    velocity = np.zeros(basis.n)
    if system.velocity.any():
        momentum = np.asarray(system.M @ system.velocity)
        velocity = momentum_fit(to_dense(matrices.M), basis.project(momentum[:, None])[:, 0])
    beyond = basis.fixed.next_omega2
    beyond = np.inf if np.isnan(beyond) else np.sqrt(beyond) / (2.0 * np.pi)
    return System(
        name=system.name,
        M=matrices.M,
        K=matrices.K,
        damping=Damping(system.damping.alpha, system.damping.beta, matrices.C),
        rows=_rows(system.rows, basis, matrices.static),
        combine=_combined(system, basis, matrices.static),
        supports=no_supports(basis.n),
        coordinates=np.concatenate([labels, np.full(n_m, -1, dtype=np.int64)]),
        velocity=velocity,
        M_alone=matrices.M_alone,
        stats=replace(system.stats, retained=n_xi, modes=n_m, internal=inside.i.size, first_left_out=beyond),
        labels=system.labels,
        whole=_recovering(system, basis),
        interface=_joinable(system, inside),
        of_shells=system.of_shells,
        bear=system.bear,
    )


def _recovering(system: System, basis: Basis) -> Recover:
    """A few motions at a time; where memory is short the factor does not stay until the next ones."""
    inside = basis.inside

    def whole(q: FloatArray, _: FloatArray, at: IntArray | None) -> FloatArray:
        if q.size:
            inside.solve_only()
        u = rows_of(system.labels.size if at is None else at.size, q.shape[1], SPARE).T
        for some in blocks_that_fit(q.shape[1], inside.b.size + inside.i.size, COPIES, COLUMNS, 1):
            u[:, some] = system.recover(basis.expand(q[:, some]), at=at)
        inside.spare()
        return u

    return whole


def mode_rows(basis: Basis, A_ib: Matrix) -> FloatArray:
    """Phi' A_ib P, (n_mode, n_xi); only rows of Phi that A_ib reaches are read."""
    near = np.flatnonzero(np.diff(A_ib.indptr))
    return np.asarray((A_ib[near] @ basis.P).T @ np.ascontiguousarray(basis.fixed.shapes[near])).T


def _plus(A: FloatArray, columns: IntArray, more: FloatArray) -> FloatArray:
    B = A.copy()
    B[:, columns] += more
    return B


def _reduced_damping(basis: Basis, terms: Terms, extra: Matrix, own: Callable[[Matrix], Matrix]) -> Matrix:
    inside, Phi = basis.inside, basis.fixed.shapes
    rows = extra[inside.i]
    to_modes = _plus(mode_rows(basis, rows[:, inside.b]), terms.columns, terms.modal[1])
    boundary = terms.cross[1] + terms.cross[1].T + terms.inner[1]
    modal = symmetric(Phi.T @ BlockProduct(rows[:, inside.i])(Phi))
    return _joined(own(extra[inside.b][:, inside.b]), terms.columns, boundary, to_modes, modal)


def _joined(
    own: Matrix,
    columns: IntArray,
    boundary: FloatArray,
    low: FloatArray,
    inner: FloatArray,
    upper: FloatArray | None = None,
) -> Matrix:
    """[own + boundary at `columns`, low'; low, inner], dense where it is mostly full, else sparse."""
    n_xi, n_m = own.shape[0], inner.shape[0]
    up = low.T if upper is None else upper
    share = (columns.size**2 + own.nnz + 2 * np.count_nonzero(low)) / max((n_xi + n_m) ** 2, 1)
    if share > MOSTLY_FULL:
        A = np.zeros((n_xi + n_m, n_xi + n_m))
        A[:n_xi, :n_xi] = own.toarray()
        A[np.ix_(columns, columns)] += boundary
        A[n_xi:, :n_xi], A[:n_xi, n_xi:], A[n_xi:, n_xi:] = low, up, inner
        return A
    at = np.repeat(columns, columns.size), np.tile(columns, columns.size)
    static = sp.coo_matrix((boundary.ravel(), at), shape=(n_xi, n_xi))
    blocks = [[own + static, sp.csr_matrix(up)], [sp.csr_matrix(low), sp.csr_matrix(inner)]]
    return sp.csr_matrix(sp.bmat(blocks, format="csr"))


def _is_identity(P: Matrix) -> bool:
    return P.shape[0] == P.shape[1] and (sp.identity(P.shape[0], format="csr") != P).nnz == 0


def _joinable(system: System, inside: Inside) -> IntArray:
    """Labels that depend on boundary dofs alone."""
    if system.labels.size == 0:
        return system.labels
    internal = np.zeros(inside.b.size + inside.i.size)
    internal[inside.i] = 1.0
    A = abs(sp.csr_matrix(system.rows(~system.labels if system.of_shells else system.labels)[0]))
    return np.intersect1d(system.joins, system.labels[(A @ internal == 0.0) & (np.diff(A.indptr) > 0)])


def _static_rows(basis: Basis, A_i: Matrix) -> FloatArray:
    """A_i Psi P (k, n_xi), a back-substitution a row."""
    out = np.zeros((A_i.shape[0], basis.n_boundary))
    if A_i.shape[0]:
        F = sp.csr_matrix((basis.inside.K_ib @ basis.P).T)
        for block in blocks(A_i.shape[0], A_i.shape[1]):
            out[block] = -np.asarray(F @ basis.inside.solve(A_i[block].T.toarray(order="F"))).T
    return out


def _rows(full: Rows, basis: Basis, static: StaticRows) -> Rows:
    def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
        A, A_s = full(labels)
        return sp.csr_matrix(_through(sp.csr_matrix(A), basis, static)), A_s

    return rows


def _combined(system: System, basis: Basis, static: StaticRows) -> Combine:
    """Combinations first: a back-substitution for each, not for each row that goes into it."""

    def combine(B: Matrix, labels: IntArray) -> tuple[Matrix, Matrix]:
        A, A_s = system.combined(B, labels)
        return _through(sp.csr_matrix(A), basis, static), A_s

    return combine


def _through(A: Matrix, basis: Basis, static: StaticRows) -> Matrix:
    """A (k, n_full) times the basis: (k, n)."""
    inside, n_m = basis.inside, basis.fixed.omega2.size
    A_b, A_i = A[:, inside.b] @ basis.P, sp.csr_matrix(A[:, inside.i])
    inner = np.flatnonzero(np.diff(A_i.indptr))
    if inner.size == 0:
        return sp.hstack([A_b, sp.csr_matrix((A.shape[0], n_m))], format="csr")
    R = np.zeros((A.shape[0], basis.n))
    R[:, : basis.n_boundary] = A_b.toarray()
    known = np.isin(A_i.indices, static.at)
    lacking = np.add.reduceat(~known, A_i.indptr[inner]) > 0
    kept, new = inner[~lacking], inner[lacking]
    R[kept, : basis.n_boundary] += A_i[kept][:, static.at] @ static.values
    R[new, : basis.n_boundary] += _static_rows(basis, A_i[new])
    near = np.unique(A_i.indices)
    R[inner, basis.n_boundary :] = A_i[inner][:, near] @ _modes_at(near, basis, static)
    return R


def _modes_at(near: IntArray, basis: Basis, static: StaticRows) -> FloatArray:
    """(k, n_mode) fixed-interface modes at inner coordinates."""
    if static.modes is not None and np.isin(near, static.at).all():
        return np.ascontiguousarray(static.modes[np.searchsorted(static.at, near)])
    return np.ascontiguousarray(basis.fixed.shapes[near])
