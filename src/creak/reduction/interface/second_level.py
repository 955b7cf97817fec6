"""A second Craig-Bampton reduction, of interface coordinates against all that is left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System, project, to_dense
from creak.reduction.interface.characteristic import characteristic_modes


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
