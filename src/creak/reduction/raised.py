"""A Craig-Bampton reduction with more fixed-interface modes than before: what it has stays, new rows are added."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.assembly.system import System
from creak.progress import Progress
from creak.reduction.constraint_modes import alike
from creak.reduction.craig_bampton import Basis, Matrices, fixed_interface_basis, mode_rows, reduced_matrices


def raised(
    system: System, basis: Basis, matrices: Matrices, f_max: float, progress: Progress | None = None
) -> tuple[Basis, Matrices]:
    """The basis with the further modes of `f_max` (Hz), beside all that it has, and its matrices.

    K_ii^-1 M_ii Phi = Phi omega^-2, so the rows of M between new modes and the boundary are Phi' (M_ib P) - omega^-2
    Phi' (K_ib P): no back-substitution, to within the residual of the modes. One motion of the boundary tells whether
    that holds: it does not where all modes were found anew, which turns those that there were, or with round-off.
    Then, and with damping that is not Rayleigh, which has no such rows, the matrices are made anew.
    """
    before, inside, P = basis.fixed.omega2.size, basis.inside, basis.P
    more = fixed_interface_basis(inside, P, f_max, None, progress, further=True, found=basis.fixed)
    basis = replace(basis, fixed=more.fixed)
    if matrices.C is not None:
        return basis, _anew(system, basis, matrices, progress)
    omega2 = basis.fixed.omega2[before:]
    side, stiff = (mode_rows(basis, A)[before:] for A in (inside.M_ib, inside.K_ib))
    low, unit = side - stiff / omega2[:, None], np.eye(omega2.size)
    M = _bordered(matrices.M, low, low, unit)
    if not _holds(basis, M):
        return basis, _anew(system, basis, matrices, progress)
    K = _bordered(matrices.K, np.zeros_like(low), np.zeros_like(low), np.diag(omega2))
    alone = _bordered(matrices.M_alone, side, low, unit)
    return basis, Matrices(K, M, alone, None, replace(matrices.static, modes=None))


def _anew(system: System, basis: Basis, before: Matrices, progress: Progress | None) -> Matrices:
    made = reduced_matrices(system, basis, progress)
    return replace(made, static=replace(before.static, modes=None))


def _holds(basis: Basis, M: Matrix) -> bool:
    """Whether the rows of M between modes and boundary, Phi' (M_ib + M_ii Psi) P, are those of one motion, any."""
    inside, n = basis.inside, basis.n_boundary
    xi = np.random.default_rng(1968).standard_normal((n, 1))
    u_b = basis.P @ xi
    momentum = inside.mass(np.asfortranarray(inside.follow(u_b))) + inside.M_ib @ u_b
    return alike(np.asarray(M[n:, :n] @ xi), basis.fixed.shapes.T @ momentum)


def _bordered(A: Matrix, low: FloatArray, upper: FloatArray, inner: FloatArray) -> Matrix:
    """[A, (upper, 0)'; (low, 0), inner]: new modes meet the boundary, which comes first, and none of the old modes."""
    n, beside = A.shape[0], np.zeros((low.shape[0], A.shape[0] - low.shape[1]))
    low, upper = np.hstack([low, beside]), np.hstack([upper, beside])
    if sp.issparse(A):
        return sp.csr_matrix(sp.bmat([[A, sp.csr_matrix(upper.T)], [sp.csr_matrix(low), sp.csr_matrix(inner)]]))
    out = np.empty((n + low.shape[0],) * 2)
    out[:n, :n], out[n:, :n], out[:n, n:], out[n:, n:] = A, low, upper.T, inner
    return out
