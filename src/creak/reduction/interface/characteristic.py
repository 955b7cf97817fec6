"""Characteristic constraint modes: the boundary in the modes of its own Craig-Bampton matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System, project
from creak.errors import NumericalError
from creak.linalg.dense_product import symmetric

MASSLESS = 1e-13
"""Share of the largest mu below which a mode counts as massless."""


def characteristic_modes(K_bb: Matrix, M_bb: Matrix, *, count: int) -> FloatArray:
    """Lowest eigenvectors of the boundary partition of Craig-Bampton matrices, K_bb Phi = M_bb Phi diag(omega^2).

    With them the boundary coordinates of the coupled assembly (system level) become a few wave-like ones.

    Rigid-body modes of a free part are among the lowest and stay. M_bb may be singular: what is solved is
    M v = mu (K + sigma M) v with mu = 1 / (omega^2 + sigma), sigma > 0.

    Parameters
    ----------
    K_bb, M_bb : (n_b, n_b) symmetric, constraint modes included.
    count : the number of modes.

    Returns
    -------
    (n_b, k); Phi' M_bb Phi = I but for massless modes (the last ones), for which Phi' K_bb Phi = I.

    Raises
    ------
    NumericalError : a boundary coordinate (or a combination) has neither stiffness nor mass.

    Source: Castanier, Tan and Pierre, AIAA J. 39(6), 2001. Frequencies of the assembly are upper bounds, good well
    below the frequency of the first mode left out; forces at single points of the boundary (contact) converge more
    slowly than frequencies: keep dofs of contact as they are. A free plate cut in two, 78 dofs in the cut, error of
    the first six elastic frequencies: 16 modes 0.1 %, 24 modes 0.008 %.
    """
    K, M = symmetric(to_dense(K_bb)), symmetric(to_dense(M_bb))
    n = K.shape[0]
    if n == 0 or count == 0:
        return np.zeros((n, 0))
    sigma = _shift(K, M)
    B = K + sigma * M
    scale = 1.0 / np.sqrt(_positive(np.diag(B)))
    highest = [max(n - count, 0), n - 1]
    try:
        mu, V = sla.eigh(scale[:, None] * M * scale, scale[:, None] * B * scale, subset_by_index=highest)
    except np.linalg.LinAlgError as error:
        raise NumericalError("the boundary can move in a way that has neither stiffness nor mass") from error
    mu, V = mu[::-1], scale[:, None] * V[:, ::-1]
    heavy = mu > MASSLESS / sigma
    return V / np.where(heavy, np.sqrt(np.where(heavy, mu, 1.0)), 1.0)


def _shift(K: FloatArray, M: FloatArray) -> float:
    """A positive sigma between the lowest and the highest omega^2: the median of K_ii / M_ii."""
    k, m = np.diag(K), np.diag(M)
    has_both = (m > 0.0) & (k > 0.0)
    return float(np.median(k[has_both] / m[has_both])) if has_both.any() else 1.0


def _positive(diagonal: FloatArray) -> FloatArray:
    bad = np.flatnonzero(diagonal <= 0.0)
    if bad.size:
        raise NumericalError(f"boundary coordinate {bad[0]} has neither stiffness nor mass")
    return diagonal


def second_level(system: System, columns: IntArray, *, count: int) -> System:
    """The interface coordinates `columns` replaced by `count` characteristic constraint modes.

    u_c = Psi u_r + Phi xi: Psi = -K_cc^-1 K_cr follows the coordinates r that are left alone (contact, supports,
    loads, fixed-interface modes) statically, Phi are the lowest eigenvectors of (K_cc, M_cc), r held. Statics for
    loads on r therefore stay exact, and all modes kept change nothing.

    Parameters
    ----------
    system : a reduced part (local level) or the coupled assembly (system level), dense or sparse.
    columns : (n_c,) coordinates. count : modes kept, at most n_c.

    Returns
    -------
    System in the coordinates r in their old order, then xi (labels -1). Matrices are dense.

    Source: Castanier, Tan and Pierre, AIAA J. 39(6), 2001, with the static part of Craig and Bampton so that dofs
    left alone keep their accuracy. Upper bounds; good well below the first characteristic mode left out.
    """
    rest = np.setdiff1d(np.arange(system.n), columns)
    K, M = to_dense(system.K), to_dense(system.M)
    K_cc = K[np.ix_(columns, columns)]
    Phi = characteristic_modes(K_cc, M[np.ix_(columns, columns)], count=count)
    V = np.zeros((system.n, rest.size + Phi.shape[1]))
    V[rest, np.arange(rest.size)] = 1.0
    V[columns, : rest.size] = -_solved(K_cc, K[np.ix_(columns, rest)])
    V[columns, rest.size :] = Phi
    alone = None if system.M_alone is None else V.T @ np.asarray(to_dense(system.M_alone) @ V)
    labels = np.concatenate([system.coordinates[rest], np.full(Phi.shape[1], -1, dtype=np.int64)])
    retained = (system.stats.retained or system.n) - columns.size + Phi.shape[1]
    return replace(
        project(system, V), coordinates=labels, M_alone=alone, stats=replace(system.stats, retained=retained)
    )


def _solved(K: FloatArray, F: FloatArray) -> FloatArray:
    """K^-1 F; the smallest of all solutions where the rest does not hold the interface."""
    try:
        return np.asarray(sla.cho_solve(sla.cho_factor(K), F))
    except np.linalg.LinAlgError:
        return np.asarray(sla.pinvh(K) @ F)
