"""Constraint modes of a part, streamed: what the reduced matrices need of Psi P, Psi = -K_ii^-1 K_ib."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.linalg.dense_product import symmetric
from creak.linalg.memory import blocks_that_fit
from creak.linalg.modes import Modes
from creak.linalg.sparse_product import BlockProduct
from creak.progress import Steps
from creak.reduction.inside import Inside

COLUMNS = 128
"""Right-hand sides solved at a time."""
FEWEST, STREAMED = 16, 6
"""Where memory is short: columns at least, and copies of them that are there at a time."""

EXACT = 1e-7
"""Modes from Lanczos tell their products with the constraint modes, unless those of the first block differ by more than
this share (measured: 1e-11 to 1e-9); those of dense eigensolvers carry the round-off of the highest one."""


@dataclass(frozen=True)
class Terms:
    """Static terms on the boundary columns that touch the inside."""

    columns: IntArray
    """(n_c,) columns of P that reach the inside."""
    stiffness: FloatArray
    """(n_c, n_c) P' K_bi Psi P."""
    cross: list[FloatArray]
    """(n_c, n_c) P' A_bi Psi P for A = M and, where there is one, C."""
    inner: list[FloatArray]
    """(n_c, n_c) P' Psi' A_ii Psi P."""
    modal: list[FloatArray]
    """(n_mode, n_c) Phi' A_ii Psi P."""
    kept: FloatArray
    """(k, n_c) the rows of Psi P that were asked for."""


def static_terms(
    inside: Inside, P: Matrix, fixed: Modes, extra: Matrix | None, keep: IntArray, report: Steps | None
) -> Terms:
    """One pass over the constraint modes; `keep`: inner coordinates whose motion is kept."""
    F, H = sp.csc_matrix(inside.K_ib @ P), sp.csc_matrix(inside.M_ib @ P)
    sides, products = [H], [inside.mass]
    if extra is not None:
        rows = extra[inside.i]
        sides.append(sp.csc_matrix(rows[:, inside.b] @ P))
        products.append(BlockProduct(rows[:, inside.i]))
    touched = sum((np.diff(A.indptr) for A in (F, *sides)), np.zeros(P.shape[1], dtype=np.int64))
    columns = np.flatnonzero(touched)
    n = columns.size
    F, sides = F[:, columns], [A[:, columns] for A in sides]
    near = np.unique(np.concatenate([A.indices for A in (F, *sides)]))
    F_near, sides_near = sp.csr_matrix(F)[near].T, [sp.csr_matrix(A)[near].T for A in sides]
    stiffness, cross = np.zeros((n, n)), [np.zeros((n, n)) for _ in sides]
    inner = [np.zeros((n, n)) for _ in sides]
    modal = [np.zeros((fixed.omega2.size, n)) for _ in sides]
    told = _modal_mass(fixed, F_near, near) if fixed.columns > fixed.omega2.size else None
    kept = np.zeros((keep.size, n))
    if n and report is not None:
        report(0, n)
    if n and inside.i.size:
        _ = inside.factor  # what is free is what is left beside it
    load = np.zeros((inside.i.size, 0))
    for block in blocks(n, inside.i.size):
        width = block.stop - block.start
        if width > load.shape[1]:
            load = np.empty((inside.i.size, width), order="F")
        momentum = F[:, block].toarray(out=load[:, :width])  # new memory has to be cleared by the system first
        X = inside.solve(momentum)
        np.negative(X, out=X)
        X_near, kept[:, block] = X[near], X[keep]
        stiffness[:, block] = F_near @ X_near
        for k, times in enumerate(products):
            cross[k][:, block] = sides_near[k] @ X_near
            momentum = times(X, momentum)
            if k or told is None or block.start == 0:
                modal[k][:, block] = fixed.shapes.T @ momentum
            last = times is products[-1]
            inner[k][:, block] = -(F_near @ inside.solve(momentum, X if last else None)[near])
        if told is not None and block.start == 0 and not alike(told[:, block], modal[0][:, block]):
            told = None
        if report is not None:
            report(block.stop, n)
    modal[0] = modal[0] if told is None else told
    return Terms(columns, symmetric(stiffness), cross, [symmetric(A) for A in inner], modal, kept)


def _modal_mass(fixed: Modes, F_near: Matrix, near: IntArray) -> FloatArray:
    """Phi' M_ii Psi P = -Phi' K_ib P / omega^2, from the rows of Phi `near` the boundary alone: K_ii Phi = M_ii Phi
    omega^2."""
    return np.asarray(F_near @ np.ascontiguousarray(fixed.shapes[near])).T / -fixed.omega2[:, None]


def alike(told: FloatArray, found: FloatArray) -> bool:
    """Whether products of modes and constraint modes are `told` by the modes as they were `found`."""
    return bool(np.abs(told - found).max(initial=0.0) <= EXACT * np.abs(found).max(initial=0.0))


def blocks(n: int, rows: int) -> Iterator[slice]:
    """Of `COLUMNS`, or fewer where those of so many rows would take more than a share of the free memory."""
    return blocks_that_fit(n, rows, STREAMED, COLUMNS, FEWEST)
