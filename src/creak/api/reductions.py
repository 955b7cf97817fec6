"""Reductions of Systems by labels and gap channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from creak.api.matrices import A_SYSTEM, known_labels
from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.errors import InputError
from creak.given import number, of_kind, whole
from creak.linalg.modes import DENSE_LIMIT
from creak.linalg.pencil import dense_pairs, require_positive
from creak.reduction import craig_bampton as cb
from creak.reduction import gap_modes as gm
from creak.reduction.diagonal import diagonalise as own_modes


def craig_bampton(
    system: System, boundary: ArrayLike, *, f_max: float | None = None, count: int | None = None
) -> System:
    """Reduce a System to boundary dofs and its fixed-interface modes.

    u_b = xi, u_i = -K_ii^-1 K_ib xi + Phi eta. The boundary holds what is touched, driven, held or joined.

    Parameters
    ----------
    system : not driven yet. boundary : labels to retain; they must hold the System.
    f_max : fixed-interface modes below this frequency (Hz) are kept. count : the lowest ones. One of them; `count=0`
        is Guyan's reduction.

    Returns
    -------
    System in (xi, eta); `recover` gives all dofs back; `stats` has retained, modes, first_left_out (Hz).

    Raises
    ------
    InputError : an unknown label, not one of f_max and count, or K is not positive.
    NumericalError : the boundary does not hold it.

    Source: Craig and Bampton, AIAA J. 6(7), 1968. Accurate up to about f_max / 2 of the assembly.
    """
    of_kind(system, System, "system", A_SYSTEM)
    _one_of(f_max, count)
    _require_positive(system)
    return cb.craig_bampton(system, _boundary(system, boundary), f_max=f_max, count=count)


def guyan(system: System, boundary: ArrayLike) -> System:
    """Reduce a System to boundary dofs, u_i = -K_ii^-1 K_ib u_b: `craig_bampton` without modes.

    Raises
    ------
    InputError : an unknown label. NumericalError : the boundary does not hold the System.

    Source: Guyan, AIAA J. 3(2), 1965. Exact in statics; frequencies soon useless.
    """
    return craig_bampton(system, boundary, count=0)


def gap_modes(system: System, gaps: GapOperator, *, f_max: float | None = None, count: int | None = None) -> System:
    """Reduce a System to its modes and the static answer to each gap channel; diagonal, it runs in compiled code.

    q = Phi eta + Z zeta + R s, Z the residual flexibility of the channels (their tangents too where they rub).

    Parameters
    ----------
    f_max : modes below this frequency, Hz. count : the lowest modes. One of them.

    Raises
    ------
    InputError : not one of f_max and count, or a channel at a label that the System does not have.
    NumericalError : the structure can move freely and not all its rigid-body modes are kept.

    Source: residual flexibility as in Rubin, AIAA J. 13(8), 1975. Good to about f_max / 2 between contacts.
    """
    of_kind(system, System, "system", A_SYSTEM)
    of_kind(gaps, GapOperator, "gaps", "channels of creak.gap_channels")
    _one_of(f_max, count)
    return gm.gap_modes(system, _rows(system, gaps), f_max=f_max, count=count)


def diagonalise(system: System) -> System:
    """A small System in its own modes, all of them: q = Phi eta, M = I, K = diag(omega^2); a step costs O(n).

    Directions N without mass are split off, N' K N = I. Damping may couple the modes (`creak.simulate` takes pairs of
    complex modes then).

    Raises
    ------
    InputError : K or M is not positive. NumericalError : a direction has neither mass nor stiffness.
    """
    of_kind(system, System, "system", A_SYSTEM)
    _require_positive(system)
    return own_modes(system)


SLOW = 1e-4
"""Largest -omega^2 that is none, 1 / time^2: a free body reduced to few dofs has nothing but round-off for K."""


def _require_positive(system: System) -> None:
    """Refuse a System of few physical dofs with omega^2 below round-off: modes would make rigid motion of it."""
    if system.n <= DENSE_LIMIT and (system.coordinates >= 0).all():
        K = to_dense(system.K)
        if _is_positive(K):
            return
        lam, X, _ = dense_pairs(K, to_dense(system.M))
        require_positive("K", K, X[:, lam < -SLOW])


def _is_positive(K: FloatArray) -> bool:
    """Positive definite, which costs a small share of modes to tell; False of what can move rigidly."""
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        return False
    return True


def _boundary(system: System, boundary: ArrayLike) -> IntArray:
    """Rows of the System."""
    if system.supports.count:
        raise InputError(
            "the System is driven already",
            expected="a System without prescribed motion",
            fix="Keep the driven dofs in the boundary, reduce, then couple(..., driven=...).",
        )
    own = system.coordinates[system.coordinates >= 0]
    wanted = known_labels(boundary, np.sort(own), "boundary")
    order = np.argsort(system.coordinates)
    return np.asarray(order[np.searchsorted(system.coordinates[order], wanted)], dtype=np.int64)


def _rows(system: System, gaps: GapOperator) -> Matrix:
    known_labels(gaps.labels, system.labels, "gaps")
    return channel_matrices(system, gaps).rows


def _one_of(f_max: float | None, count: int | None) -> None:
    if (f_max is None) == (count is None):
        raise InputError(f"f_max = {f_max}, count = {count}", expected="one of them")
    if f_max is not None and not number(f_max, "f_max") > 0.0:
        raise InputError(f"f_max = {f_max}", expected="a positive frequency")
    if count is not None:
        whole(count, "count", 0)
