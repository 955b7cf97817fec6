"""Contact that the highest modes kept take part in less and less, so that a cut-off basis does not chatter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System, to_dense
from creak.dynamics.modal.coefficients import modal_matrices
from creak.errors import InputError
from creak.linalg.diagonal import Diagonal

RANK = 1e-12
"""Shapes with less than this share of the largest flexibility are left out."""


def participation(omega: FloatArray, cut: float) -> FloatArray:
    """sigma = sqrt(1 - (omega / cut)^2), 0 beyond the cut: the density of modes seen at the end of a spring-mass chain.

    With it a rod of evenly spaced modes up to `cut` answers a blow like the semi-infinite chain with that cut-off
    frequency, which carries every wave away from its end; modes of full weight up to a sharp cut send ringing back.
    """
    return np.asarray(np.sqrt(np.maximum(0.0, 1.0 - (omega / cut) ** 2)))


def tapered(system: System, rows: Matrix, cut: float | None = None) -> System:
    """A diagonal System of modes and massless coordinates whose modes fade out towards `cut` (rad/s).

    Each mode phi is split into two independent parts that add up to it in statics: sqrt(sigma) phi with its mass and
    frequency, and sqrt(1 - sigma) phi without mass. The second parts are kept as far as channel forces reach them: at
    most one massless shape per row. Exact under static channel forces, passive, diagonal; vibration at omega falls
    short by 1 - sigma, about (omega / cut)^2 / 2, of the mode's share (2 % at a fifth of the cut). Supports act on the
    parts with mass. Modal damping stays with its modes, Rayleigh's beta acts on all.

    Parameters
    ----------
    rows : (r, n) channel rows, tangents of rubbing channels included, in the coordinates of the System.
    cut : default: the first frequency left out where the System knows it, else the mean spacing above its highest mode.

    Raises
    ------
    InputError : the System is not diagonal; rows of the wrong size; a cut that is not positive.
    """
    m, _, k = modal_matrices(system)
    C = to_dense(rows)
    if C.shape[1] != system.n:
        raise InputError(f"the channel rows have {C.shape[1]} columns", expected=f"{system.n}", where=system.name)
    heavy = np.flatnonzero(m > 0.0)
    omega = np.sqrt(np.maximum(k[heavy], 0.0) / m[heavy])
    cut = _next_frequency(system, omega) if cut is None else cut
    if not cut > 0.0:
        raise InputError(f"a cut of {cut} rad/s", expected="a positive frequency", where=system.name)
    sigma = participation(omega, cut)
    keep = np.ones(system.n)
    keep[heavy] = np.sqrt(sigma)
    fades = heavy[sigma < 1.0]
    rest = np.sqrt(1.0 - sigma[sigma < 1.0])
    V = np.zeros((system.n, 0))
    if fades.size and C.shape[0]:
        V = _shapes(C[:, fades] * rest, k[fades], rest, fades, system.n)
    return _split(system, keep, V)


def _shapes(C: FloatArray, k: FloatArray, rest: FloatArray, fades: IntArray, n: int) -> FloatArray:
    """(n, r) motion of the faded parts under the channel forces, in the coordinates, with unit stiffness each."""
    values, vectors = np.linalg.eigh((C / k) @ C.T)
    good = values > RANK * values[-1]
    inside = (C / k).T @ (vectors[:, good] / np.sqrt(values[good]))
    V = np.zeros((n, inside.shape[1]))
    V[fades] = rest[:, None] * inside
    return V


def _split(system: System, keep: FloatArray, V: FloatArray) -> System:
    """q = diag(keep) eta + V zeta with unit stiffness and no mass for zeta."""
    r, n = V.shape[1], system.n
    sup, d = system.supports, system.damping

    def side(A: Matrix) -> FloatArray:
        return np.vstack([keep[:, None] * to_dense(A), np.zeros((r, sup.count))])

    def split(A: Matrix, A_s: Matrix) -> tuple[Matrix, Matrix]:
        return np.hstack([to_dense(A) * keep, np.asarray(A @ V)]), A_s

    def whole(q: FloatArray, s: FloatArray) -> FloatArray:
        return system.recover(keep[:, None] * q[:n] + V @ q[n:], s)

    W = None if d.modal_shapes is None else np.vstack([d.modal_shapes, np.zeros((r, d.modal_shapes.shape[1]))])
    return replace(
        system,
        name=f"{system.name}, faded",
        rows=lambda labels: split(*system.rows(labels)),
        whole=whole,
        combine=lambda B, labels: split(*system.combined(B, labels)),
        M=Diagonal(np.concatenate([system.M.diagonal(), np.zeros(r)])),
        K=Diagonal(np.concatenate([system.K.diagonal(), np.ones(r)])),
        damping=replace(d, modal_shapes=W),
        supports=replace(sup, M_qs=side(sup.M_qs), K_qs=side(sup.K_qs), C_qs=side(sup.C_qs), M_start=side(sup.M_start)),
        coordinates=np.full(n + r, -1, dtype=np.int64),
        velocity=np.concatenate([keep * system.velocity, np.zeros(r)]),
        stats=replace(system.stats, retained=system.stats.retained + r),
    )


def _next_frequency(system: System, omega: FloatArray) -> float:
    """rad/s"""
    left_out = 2.0 * np.pi * system.stats.first_left_out
    if np.isfinite(left_out) and omega.size and left_out > omega.max():
        return float(left_out)
    elastic = np.count_nonzero(omega > 0.0)
    return float(omega.max(initial=0.0) * (1.0 + 1.0 / elastic)) if elastic else 0.0
