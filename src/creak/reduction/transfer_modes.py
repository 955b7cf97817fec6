"""Modes, and the unreduced model's answers at few frequencies: a modal model of the transfer between few places.

With Phi the modes up to somewhat above the band, and V = [Phi, X], X the real and imaginary parts of A(s)^-1 B at a few
s = 2 pi i f, the Galerkin model V' A(s) V meets A(s)^-1 B there: what modes above the band add, which is smooth in it,
is interpolated. (At f = 0 alone it would be the static correction, or residual vectors, of modal superposition.) Each
frequency shows first how far the model is off there.

Sources: Craig and Kurdila, Fundamentals of structural dynamics, 2006, ch. 11 and 14; Grimme, Krylov projection methods
for model reduction, thesis, Univ. of Illinois, 1997.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import ComplexArray, FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.linalg.complex_factor import complex_factor, complex_refactor
from creak.linalg.dense_product import symmetric
from creak.progress import Progress, silent
from creak.reduction.band_modes import new_shapes

SHARES = (1.0, 0.1, 0.6, 0.85, 0.35, 0.95)
"""Of the top of the band, near which the unreduced model is solved, as many of them as are needed."""
CLOSE = 1e-6
"""Error, of the largest transfer, at which no further frequency is taken."""
BEYOND = 1.3
"""Times the band: where the next mode is taken to be above all that are known."""
DIAGONAL = 1e-13
"""Coupling of two modes by damping, relative to the largest damping, that is none."""
AWAY = 0.25
"""Of the distance between two modes: how far off both the unreduced model is solved, that they do not hide the rest."""
NARROW = 1e-4
"""Of the band: two modes closer together have no frequency between them."""
AT_A_TIME = 4_000_000
"""Numbers of the matrices that are solved together."""


@dataclass(frozen=True)
class TransferModel:
    """Forces at channels and motion at channels, in modes: q'' + C q' + omega2 q = rows' f, u = rows q."""

    omega2: FloatArray
    """(r,) rad^2/s^2; those of the modes come first."""
    rows: FloatArray
    """(n_channel, r)"""
    C: FloatArray
    """(r, r) 1/s"""
    freq: FloatArray
    """(k,) Hz at which the unreduced model was solved."""
    error: float
    """Difference from the unreduced model at the last of these, before it was taken in, of its largest transfer."""


def transfer_model(
    system: System,
    modes: tuple[FloatArray, FloatArray],
    channels: Matrix,
    loads: IntArray,
    top: float,
    progress: Progress = silent,
) -> TransferModel:
    """A model of the motion of all channels that forces at a few of them make, from 0 to `top` Hz.

    Parameters
    ----------
    system : unreduced; its damping is taken.
    modes : omega2 (m,), rising, and mass-normalised shapes (n, m) of the undamped system, all up to above `top`.
    channels : (n_channel, n) rows of motion. loads : rows of `channels`.

    Raises
    ------
    SingularMatrixError : a dof has neither mass nor stiffness.
    """
    places = sp.csr_array(channels)
    push, extra = places[loads].toarray().T, system.damping.extra
    response, reference = np.repeat(np.arange(places.shape[0]), loads.size), np.tile(loads, places.shape[0])
    added, used = np.zeros((system.n, 0)), list[float]()
    model, held = modal_transfer(system, modes, added, places), None
    for step, share in enumerate(SHARES):
        freq = between_modes(modes[0], share * top, BEYOND * top)
        if freq in used:
            continue
        progress("solve the unreduced model at few frequencies", step, len(SHARES))
        s = 2j * np.pi * freq
        A = (1.0 + s * system.damping.beta) * system.K + (s**2 + s * system.damping.alpha) * system.M
        A = sp.csr_array(A if extra is None else A + s * extra)
        held = complex_factor(A) if held is None else complex_refactor(held, A)
        X = np.asarray(held.solve(push.astype(np.complex128)))
        true, found = (places @ X).ravel(), receptances(model, np.array([freq]), response, reference)[0]
        error = float(np.abs(found - true).max() / max(np.abs(true).max(), np.finfo(float).tiny))
        used.append(freq)
        Y = np.hstack([X.real, X.imag])
        beyond = Y - modes[1] @ (modes[1].T @ np.asarray(system.M @ Y))  # small: what is new is told by its own size
        added = np.hstack([added, new_shapes(np.hstack([modes[1], added]), system.M, beyond)[1]])
        model = replace(modal_transfer(system, modes, added, places), freq=np.array(used), error=error)
        if len(used) > 1 and error <= CLOSE:
            break
    progress("solve the unreduced model at few frequencies", 1, 1)
    return model


def receptances(model: TransferModel, freq: FloatArray, response: IntArray, reference: IntArray) -> ComplexArray:
    """Displacement over force, (k, p), at k frequencies, Hz, of p pairs of channels.

    H = w' (omega2 - omega^2 + i omega C)^-1 b
    """
    omega, r = 2.0 * np.pi * freq, model.omega2.size
    d = np.diagonal(model.C)
    if np.abs(model.C - np.diag(d)).max(initial=0.0) <= DIAGONAL * np.abs(d).max(initial=0.0):
        both = model.rows[response] * model.rows[reference]
        return np.asarray((1.0 / (model.omega2 - omega[:, None] ** 2 + 1j * omega[:, None] * d)) @ both.T)
    inputs, of = np.unique(reference, return_inverse=True)
    found = np.zeros((freq.size, response.size), dtype=np.complex128)
    few = max(1, AT_A_TIME // r**2)
    for start in range(0, freq.size, few):
        w = omega[start : start + few, None, None]
        A = np.diag(model.omega2) - w**2 * np.eye(r) + 1j * w * model.C
        q = np.linalg.solve(A, np.broadcast_to(model.rows[inputs].T.astype(np.complex128), (w.size, r, inputs.size)))
        found[start : start + few] = np.einsum("pr,krp->kp", model.rows[response], q[:, :, of])
    return found


def between_modes(omega2: FloatArray, near: float, above: float) -> float:
    """The frequency, Hz, nearest to another one that keeps `AWAY` from the modes on both sides of it."""
    freq = np.sqrt(np.maximum(omega2, 0.0)) / (2.0 * np.pi)
    edges = np.unique(np.concatenate([[0.0], freq, [max(above, BEYOND * float(freq.max(initial=0.0)))]]))
    wide = np.diff(edges)
    inside = np.clip(near, edges[:-1] + AWAY * wide, edges[1:] - AWAY * wide)[wide > NARROW * edges[-1]]
    return float(inside[np.abs(inside - near).argmin()])


def modal_transfer(
    system: System, modes: tuple[FloatArray, FloatArray], added: FloatArray, places: Matrix
) -> TransferModel:
    """The transfer that mass-normalised modes and further shapes give.

    Parameters
    ----------
    modes : omega2 (m,) and shapes (n, m). places : (n_channel, n) rows of motion.
    added : (n, k) orthogonal to the modes in M, and so in K: they do not act on these.
    """
    more, Q = sla.eigh(symmetric(added.T @ np.asarray(system.K @ added))) if added.size else (np.zeros(0), added)
    V = np.hstack([modes[1], added @ Q]) if added.size else modes[1]
    omega2, damping = np.concatenate([modes[0], more]), system.damping
    C = np.diag(damping.alpha + damping.beta * omega2)
    if not damping.is_rayleigh:
        C = C + symmetric(V.T @ np.asarray(damping.other(V)))
    return TransferModel(omega2, np.asarray(places @ V), C, np.zeros(0), np.inf)
