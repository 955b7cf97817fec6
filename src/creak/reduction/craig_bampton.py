"""Craig-Bampton reduction: constraint modes of the boundary plus fixed-interface modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.damping import Damping
from creak.assembly.system import Rows, System, momentum_fit, no_supports, symmetric, to_dense
from creak.errors import NumericalError
from creak.linalg.factor import Factor, regular_factor
from creak.linalg.modes import Modes, modes

COLUMNS = 128
"""Right-hand sides solved at a time."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Basis:
    """u_i = Psi u_b + Phi eta on the internal dofs."""

    Psi: FloatArray
    """(n_i, n_b) constraint modes, -K_ii^-1 K_ib."""
    fixed: Modes
    """Fixed-interface modes Phi (n_i, n_mode), K_ii Phi = M_ii Phi diag(omega^2)."""


def craig_bampton(
    system: System,
    boundary: IntArray,
    *,
    f_max: float | None = None,
    count: int | None = None,
    progress: Progress | None = None,
) -> System:
    """Reduce a System to its boundary coordinates and the fixed-interface modes below `f_max` (Hz).

    u = [I 0; Psi Phi] (u_b, eta), Psi = -K_ii^-1 K_ib. Reduced K = blkdiag(K_bb + K_bi Psi, diag(omega^2));
    reduced M has M_qq = I; Rayleigh damping keeps its two numbers. `count` = 0 is Guyan reduction.

    Parameters
    ----------
    boundary : (n_b,) coordinates (rows of the System) to retain.

    Returns
    -------
    System with coordinates (u_b, eta); `rows` also gives internal dofs back. stats: modes, retained,
    first_frequency_left_out is not computed here.

    Raises
    ------
    NumericalError : the boundary does not hold the part (K_ii is singular).

    Source: Craig and Bampton, AIAA J. 6(7), 1968. Accurate up to about f_max / 2 of the assembly.
    """
    b = np.sort(boundary)
    i = np.setdiff1d(np.arange(system.n), b)
    K, M = sp.csr_matrix(system.K), sp.csr_matrix(system.M)
    basis = _basis(system.name, K, M, i, b, f_max, count, progress)
    reduced_M, reduced_K = _reduced(K, M, i, b, basis)
    extra = _reduced_extra(system.damping.extra, i, b, basis)
    n = b.size + basis.fixed.omega2.size
    momentum = _project_vector(M @ system.velocity, i, b, basis)
    return System(
        name=system.name,
        M=reduced_M,
        K=reduced_K,
        damping=Damping(system.damping.alpha, system.damping.beta, extra),
        rows=_rows(system.rows, i, b, basis),
        supports=no_supports(n),
        coordinates=np.concatenate([system.coordinates[b], np.full(n - b.size, -1, dtype=np.int64)]),
        velocity=momentum_fit(reduced_M, momentum),
        M_alone=_alone(reduced_M, M, i, b, basis),
        stats={**system.stats, "retained": b.size, "modes": n - b.size, "internal": i.size},
    )


def _basis(
    name: str, K: Matrix, M: Matrix, i: IntArray, b: IntArray,
    f_max: float | None, count: int | None, progress: Progress | None,
) -> Basis:  # fmt: skip
    if i.size == 0:
        return Basis(np.zeros((0, b.size)), Modes(np.zeros(0), np.zeros((0, 0)), 0.0, True))
    K_ii, M_ii = K[i][:, i], M[i][:, i]
    K_ii_factor = regular_factor(K_ii)
    if K_ii_factor is None:
        raise NumericalError(
            f"part {name} cannot be reduced: its {b.size} retained dofs do not hold it (the stiffness of the "
            "others is singular). Couple or support it, or retain more nodes."
        )

    def report(stage: str) -> Callable[[int, int], None] | None:
        return None if progress is None else lambda done, total: progress(f"{name}: {stage}", done, total)

    if count == 0:
        fixed = Modes(np.zeros(0), np.zeros((i.size, 0)), 0.0, True)
    else:
        fixed = modes(K_ii, M_ii, f_max=f_max, count=count, stiffness_factor=K_ii_factor,
                      progress=report("fixed-interface modes"))  # fmt: skip
    return Basis(_constraint_modes(K_ii_factor, K[i][:, b], report("constraint modes")), fixed)


def _constraint_modes(
    K_ii: Factor, K_ib: Matrix, report: Callable[[int, int], None] | None
) -> FloatArray:
    """Psi = -K_ii^-1 K_ib, in blocks of columns."""
    columns = sp.csc_matrix(K_ib)
    n = int(columns.shape[1])
    Psi = np.zeros(columns.shape, order="F")
    for start in range(0, n, COLUMNS):
        stop = min(start + COLUMNS, n)
        block = columns[:, start:stop]
        used = np.flatnonzero(np.diff(block.indptr))
        if used.size:
            Psi[:, start + used] = -K_ii.solve(np.asfortranarray(block[:, used].toarray()))
        if report is not None:
            report(stop, n)
    return Psi


def _reduced(K: Matrix, M: Matrix, i: IntArray, b: IntArray, basis: Basis) -> tuple[FloatArray, FloatArray]:
    Psi, Phi = basis.Psi, basis.fixed.shapes
    n_b, n_m = b.size, Phi.shape[1]
    M_iiPsi = np.asarray(M[i][:, i] @ Psi)
    M_ib = to_dense(M[i][:, b])
    cross = Psi.T @ M_ib
    reduced_M = np.zeros((n_b + n_m, n_b + n_m))
    reduced_M[:n_b, :n_b] = to_dense(M[b][:, b]) + cross + cross.T + Psi.T @ M_iiPsi
    reduced_M[n_b:, :n_b] = Phi.T @ (M_iiPsi + M_ib)
    reduced_M[:n_b, n_b:] = reduced_M[n_b:, :n_b].T
    reduced_M[n_b:, n_b:] = np.eye(n_m)
    reduced_K = np.zeros_like(reduced_M)
    reduced_K[:n_b, :n_b] = to_dense(K[b][:, b]) + K[b][:, i] @ Psi
    reduced_K[n_b:, n_b:] = np.diag(basis.fixed.omega2)
    return symmetric(reduced_M), symmetric(reduced_K)


def _alone(reduced_M: FloatArray, M: Matrix, i: IntArray, b: IntArray, basis: Basis) -> FloatArray:
    """Reduced M whose boundary columns are V' M (u_b alone): [M_bb + Psi' M_ib; Phi' M_ib]."""
    alone = reduced_M.copy()
    M_ib = to_dense(M[i][:, b])
    alone[: b.size, : b.size] = to_dense(M[b][:, b]) + basis.Psi.T @ M_ib
    alone[b.size :, : b.size] = basis.fixed.shapes.T @ M_ib
    return alone


def _reduced_extra(C: Matrix | None, i: IntArray, b: IntArray, basis: Basis) -> FloatArray | None:
    if C is None:
        return None
    V = _dense_basis(i, b, basis)
    return symmetric(V.T @ np.asarray(C @ V))


def _dense_basis(i: IntArray, b: IntArray, basis: Basis) -> FloatArray:
    Phi = basis.fixed.shapes
    V = np.zeros((i.size + b.size, b.size + Phi.shape[1]))
    V[b, np.arange(b.size)] = 1.0
    V[i, : b.size] = basis.Psi
    V[i, b.size :] = Phi
    return V


def _project_vector(x: FloatArray, i: IntArray, b: IntArray, basis: Basis) -> FloatArray:
    return np.concatenate([x[b] + basis.Psi.T @ x[i], basis.fixed.shapes.T @ x[i]])


def _rows(full: Rows, i: IntArray, b: IntArray, basis: Basis) -> Rows:
    Phi = basis.fixed.shapes

    def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
        A, A_s = full(labels)
        A = sp.csr_matrix(A)
        A_b, A_i = A[:, b], A[:, i]
        if A_i.nnz == 0:
            return sp.hstack([A_b, sp.csr_matrix((labels.size, Phi.shape[1]))], format="csr"), A_s
        return sp.csr_matrix(np.hstack([A_b.toarray() + A_i @ basis.Psi, A_i @ Phi])), A_s

    return rows
