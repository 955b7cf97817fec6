"""What the massless-boundary integrator needs of a System: residual flexibility, and a step that resolves it."""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse.linalg as spla

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.modal.coefficients import modal_matrices
from creak.errors import InputError

FRACTION = 0.1
"""Step near contact times the contact frequency: energy then stays within some 1e-4 of that of an impact (it is an
oscillation, not a loss, and falls with the square of the step)."""
LIMIT = 1.0
"""Largest product that is marched at all; the scheme is unstable from 2 on."""
RIGID = 1e-10
"""Residual flexibility below this share of the channel's whole one counts as none."""
SMALL = 400
"""Matrices up to this size are taken densely."""


def contact_frequency(system: System, gaps: GapOperator) -> float:
    """omega_c (rad/s), the highest frequency of the System with all its channels closed.

    omega_c^2 = largest eigenvalue of diag(omega^2) + Phi' G' (R + 1/k)^-1 G Phi (masses 1), R = G_z K_z^-1 G_z' the
    flexibility of the coordinates without mass, k the stiffness of the channels (hard: none). Tabular laws count as
    hard, sticking tangents as closed channels.

    Raises
    ------
    InputError : a channel that presses, or a tangent that rubs, has no residual flexibility.
    """
    m, _, k = modal_matrices(system)
    rows, soft = _closing_rows(system, gaps)
    light, heavy = m <= 0.0, m > 0.0
    if not rows.shape[0] or not heavy.any():
        return 0.0
    R = (rows[:, light] / k[light]) @ rows[:, light].T
    _check_flexibility(system, gaps, rows, m, k, R)
    B = rows[:, heavy] / np.sqrt(m[heavy])
    values, Q = np.linalg.eigh(R + np.diag(soft))
    keep = values > 1e-12 * values[-1]
    B = (Q[:, keep] / np.sqrt(values[keep])).T @ B
    return math.sqrt(_largest(k[heavy] / m[heavy], B))


def massless_substeps(system: System, gaps: GapOperator, h: float, least: int = 1) -> int:
    """Parts into which a step h (s) is divided near contact: the smallest number with omega_c h / N <= `FRACTION`.

    Parameters
    ----------
    least : at least as many.

    Raises
    ------
    InputError : as `contact_frequency`.
    """
    return max(1, least, math.ceil(contact_frequency(system, gaps) * h / FRACTION * (1.0 - 1e-9)))


def check_step(system: System, gaps: GapOperator, h: float) -> None:
    """Raise InputError unless the step h follows the contact springs."""
    product = contact_frequency(system, gaps) * h
    if product > LIMIT:
        raise InputError(
            f"the step near contact ({h:.3g} s) is {product:.3g} times the time scale of the contact springs",
            expected=f"at most {LIMIT:g}, {FRACTION:g} for an accurate energy",
            where="[time] substeps",
            fix=f"Take {math.ceil(product / FRACTION)} times as many substeps.",
        )


def _closing_rows(system: System, gaps: GapOperator) -> tuple[FloatArray, FloatArray]:
    """Rows (r, n) of the channels that have a law, then of the rubbing tangents; compliance (r,) of their laws."""
    on = channel_matrices(system, gaps)
    acts, curved = _acting(gaps)
    soft = np.zeros(acts.size)
    plain = ~curved[acts] & np.isfinite(gaps.stiffness[acts])
    soft[plain] = 1.0 / gaps.stiffness[acts][plain]
    rows = np.vstack([to_dense(on.G)[acts], to_dense(on.T)])
    return rows, np.concatenate([soft, np.zeros(rows.shape[0] - acts.size)])


def _check_flexibility(
    system: System, gaps: GapOperator, rows: FloatArray, m: FloatArray, k: FloatArray, R: FloatArray
) -> None:
    """Every row needs a massless coordinate of its own."""
    elastic = (m > 0.0) & (k > 1e-12 * k.max(initial=0.0))
    modal = (rows[:, elastic] ** 2) @ (1.0 / k[elastic])
    stiff = np.flatnonzero((R.diagonal() <= RIGID * (modal + R.diagonal())) & rows.any(axis=1))
    if not stiff.size:
        return
    raise InputError(
        f"{stiff.size} channels have no residual flexibility, the first {_name(gaps, int(stiff[0]))}",
        where=system.name,
        expected="a massless coordinate for every channel that presses and every tangent that rubs",
        fix="Reduce by massless_boundary with the rows of all of them, or take another integrator.",
    )


def _acting(gaps: GapOperator) -> tuple[IntArray, BoolArray]:
    """Channels that have a law, and (m,) whether it is a table."""
    curved = np.zeros(gaps.m, dtype=bool) if gaps.curves is None else gaps.curves.of >= 0
    return np.flatnonzero((gaps.stiffness > 0.0) | curved), curved


def _name(gaps: GapOperator, row: int) -> str:
    """Of a row of `_closing_rows`."""
    acts, _ = _acting(gaps)
    if row < acts.size or gaps.friction is None:
        return gaps.names[acts[row]]
    return f"{gaps.names[gaps.friction.channels[(row - acts.size) // 2]]} (tangent)"


def _largest(diagonal: FloatArray, B: FloatArray) -> float:
    """Largest eigenvalue of diag(diagonal) + B' B."""
    n = diagonal.size
    if n <= SMALL:
        return float(np.linalg.eigvalsh(np.diag(diagonal) + B.T @ B)[-1])

    def product(x: FloatArray) -> FloatArray:
        x = x.ravel()
        return np.asarray(diagonal * x + B.T @ (B @ x))

    operator = spla.LinearOperator((n, n), matvec=product, dtype=np.float64)
    start = np.linspace(1.0, 2.0, n)
    return float(spla.eigsh(operator, 1, which="LA", v0=start, tol=1e-4, return_eigenvectors=False)[0]) * 1.001
