"""A small dense System in its own modes: all of them kept, so nothing is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, to_dense
from creak.assembly.system import System, project
from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.pencil import MASSLESS, regular_pairs, require_positive

NO_MASS = 1e-13
"""Directions with less mass than this, each coordinate scaled by its own, count as massless."""


Split = tuple[FloatArray, FloatArray, FloatArray]
"""omega^2 and Phi of the modes with mass, and the massless directions N."""


def diagonalise(system: System, modes_of: Callable[[FloatArray, FloatArray], Split] | None = None) -> System:
    """K Phi = M Phi diag(omega^2), q = Phi eta with all modes: M = I, K = diag(omega^2); damping may couple them.

    Where M is singular its null space N is split off: N' K N = I, and the other modes are those of the statically
    condensed rest (static condensation is exact without mass). Then M = diag(1.., 0..) and
    K = diag(omega^2.., 1..).

    Parameters
    ----------
    modes_of : K, M (dense) -> their modes; None: `all_modes`.

    Raises
    ------
    InputError : M is not positive beyond round-off.
    NumericalError : a direction has neither mass nor stiffness.
    """
    K, M = to_dense(system.K), to_dense(system.M)
    omega2, Phi, N = (modes_of or all_modes)(K, M)
    own = (
        Diagonal(np.concatenate([np.ones(omega2.size), np.zeros(N.shape[1])])),
        Diagonal(np.concatenate([np.maximum(omega2, 0.0), np.ones(N.shape[1])])),
    )
    modal = project(replace(system, velocity=np.zeros(system.n)), np.hstack([Phi, N]), known=own)
    v = system.velocity
    return replace(
        modal,
        velocity=np.concatenate([Phi.T @ (M @ v), N.T @ (K @ v)]),
        stats=system.stats,
    )


def all_modes(K: FloatArray, M: FloatArray) -> Split:
    """All modes of dense K and M.

    Raises
    ------
    InputError : M is not positive.
    NumericalError : a direction has neither mass nor stiffness.
    """
    if _singular(M):
        return _split_modes(K, M)
    omega2, Phi, _ = regular_pairs(K, M)
    return omega2, Phi, np.zeros((K.shape[0], 0))


def _singular(M: FloatArray) -> bool:
    """No Cholesky factor, or one with a pivot of round-off only."""
    # 1 / sqrt(M_ii), so that translations and rotations weigh alike; 1 where there is no mass.
    m = M.diagonal()
    d = np.where(m > 0.0, 1.0 / np.sqrt(np.where(m > 0.0, m, 1.0)), 1.0)
    try:
        pivots = np.linalg.cholesky(d[:, None] * M * d).diagonal() ** 2
    except np.linalg.LinAlgError:
        return True
    return bool(pivots.min(initial=1.0) < NO_MASS)


def _split_modes(K: FloatArray, M: FloatArray) -> Split:
    """omega^2 and Phi of the finite modes (Phi' M Phi = I), and the massless directions N (N' K N = I).

    M x = mu (K + s M) x, with mu of round-off where there is no mass. The mass of a coordinate may be round-off too, as
    that of a static shape in which massless rotations alone move: held against its stiffness it is none.
    """
    shift = float(np.trace(K) / np.trace(M) if np.trace(M) > 0.0 else 0.0) or 1.0
    try:
        mu, X = sla.eigh(M, K + shift * M)
    except np.linalg.LinAlgError as error:
        raise NumericalError("a degree of freedom has neither mass nor stiffness") from error
    require_positive("M", M, X[:, mu < 0.0])
    light = mu <= MASSLESS * mu.max(initial=0.0)
    N, rest = X[:, light], X[:, ~light] / np.sqrt(mu[~light])
    omega2, Y, _ = regular_pairs(rest.T @ K @ rest, rest.T @ M @ rest)
    return omega2, rest @ Y, N
