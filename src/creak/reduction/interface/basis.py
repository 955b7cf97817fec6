"""Orthonormal bases of interface motion, where translations and rotations count alike."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.model.dofs import PER_NODE, dofs_of


def scale_of(n_dof: int, length: float, dofs: IntArray | None = None) -> FloatArray:
    """(n_dof,) 1 for translations and `length` for rotations; dofs 1..6, default node by node.

    Raises
    ------
    InputError : `length` is not positive; `dofs` missing though the rows are no whole nodes.
    """
    if not length > 0.0:
        raise InputError(f"length {length:g} that makes rotations comparable", expected="more than 0")
    if dofs is None and n_dof % PER_NODE:
        raise InputError(f"{n_dof} interface dofs are no whole nodes", fix="Give the dof 1..6 of every row.")
    which = dofs_of(np.arange(n_dof)) if dofs is None else dofs
    return np.where(which > 3, length, 1.0)


def orthonormal(A: FloatArray, tolerance: float, count: int | None = None) -> FloatArray:
    """(n, k) left singular vectors of A with singular values above `tolerance` times the largest, at most `count`."""
    U, sigma, _ = np.linalg.svd(A, full_matrices=False)
    enough = int(np.count_nonzero(sigma > tolerance * sigma.max(initial=0.0)))
    return np.ascontiguousarray(U[:, : enough if count is None else min(count, enough)])
