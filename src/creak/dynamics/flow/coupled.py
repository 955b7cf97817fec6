"""Exact flow of a System whose damping couples its modes: pairs of complex modes, found once.

In coordinates x = (S q, q') of the undamped modes, S = diag(omega), the motion x' = A x + load with

    A = [[0, S], [-S, -C]]

is skew but for the damping, so that its eigenvectors are nearly orthogonal where damping is light. x = X z, z two real
numbers for each pair of conjugate or real eigenvalues; a pair moves by itself, z_j' = B_j z_j + (Y load)_j, Y = X^-1,
exactly for any step by B_j's exponential and its integrals phi_r. Modes that C does not couple stay as they are,
rigid ones among them. Where X is ill-conditioned (damping near critical: eigenvectors that nearly coincide) C is
changed by `NUDGE` of itself, which separates them: Davies, Approximate diagonalization, SIAM J. Matrix Anal. Appl. 29,
2007. Channels see and push the modes; what they see of a pair, and how they push it, follows from that (`Pairs`). So a
kick gives the structure just what it takes from the channels.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg as sla

from creak.arrays import BoolArray, FloatArray, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.diagonal import OFF_DIAGONAL
from creak.dynamics.flow.model import FlowForm, Pairs, driven, flow_model, following
from creak.dynamics.flow.propagator import MEAN, Q0, UU, UV, VU, VV, phi, propagator
from creak.dynamics.state import LinearTerms
from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal

MOST = 1500
"""Modes that damping may couple: the eigenvalues of twice as many states are found once (2,400 states: 91 s)."""
ILL = 1e6
"""Condition of the eigenvectors above which the damping is nudged."""
NUDGE = 1e-11
"""Share of itself: motion is off by as much for each radian, and round-off times 1 / sqrt(NUDGE)."""
TRUSTED = 1e-6
"""Largest residual of the eigenvectors: |A X - X B| and |X Y - 1|."""


def coupled_damping(system: System) -> FloatArray:
    """(n, n) C of a System with diagonal M and K."""
    d = system.damping
    C = np.diag(d.alpha * np.asarray(system.M.diagonal()) + d.beta * np.asarray(system.K.diagonal()))
    if d.extra is not None:
        C += to_dense(d.extra)
    if d.modal_shapes is not None and d.modal_values is not None:
        C += (d.modal_shapes * d.modal_values) @ d.modal_shapes.T
    return np.asarray(0.5 * (C + C.T))


def can_couple(system: System) -> bool:
    """Has the System diagonal M and K, mass everywhere, and not too many modes that damping couples?"""
    if not (isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal)) or np.any(system.M.d <= 0.0):
        return False
    return int(np.count_nonzero(_coupled(coupled_damping(system) / _mass_products(system)))) <= MOST


def coupled_modes(system: System, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator) -> FlowForm:
    """The System in pairs of complex modes.

    Raises
    ------
    NumericalError : no trustworthy eigenvectors were found.
    """
    mass = np.sqrt(np.asarray(system.M.diagonal(), dtype=float))
    C, omega = coupled_damping(system) / _mass_products(system), np.sqrt(np.maximum(system.K.diagonal(), 0.0)) / mass
    turn, alone_damped = _rigid_apart(C, omega), C.diagonal().copy()
    C = turn.T @ C @ turn
    together = _coupled(C)
    alone, pairs = np.flatnonzero(~together), np.flatnonzero(together)
    scale = _scales(omega)
    X, Y, B = _eigenpairs(scale[pairs], omega[pairs], C[np.ix_(pairs, pairs)])
    n, p = omega.size, pairs.size
    whole, inverse = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    # z: first members of the lone modes and of the pairs, then their second members; x: displacements, velocities.
    of_x, of_z = (
        np.concatenate([pairs, n + pairs]),
        np.concatenate([alone.size + np.arange(p), n + alone.size + np.arange(p)]),
    )
    lone_x, lone_z = (
        np.concatenate([alone, n + alone]),
        np.concatenate([np.arange(alone.size), n + np.arange(alone.size)]),
    )
    whole[np.ix_(of_x, of_z)], inverse[np.ix_(of_z, of_x)] = X, Y
    whole[lone_x, lone_z] = inverse[lone_z, lone_x] = 1.0
    # Modal coordinates q = turn (x / scale) / mass.
    back = turn / mass[:, None]
    basis, speeds = (back / scale) @ whole[:n], back @ whole[n:]
    rows_u, loads, shared = driven(on, terms, gaps)
    push = inverse[:, n:] @ back.T
    rows, rates = rows_u @ basis, rows_u @ speeds
    own = C.diagonal()[alone]
    blocks = np.hstack([np.stack([0.0 * own, scale[alone], -(omega[alone] ** 2) / scale[alone], -own]), B])
    still = _inverse_blocks(blocks)
    speed = np.concatenate([np.hypot(scale[alone], own) * (omega[alone] > 0.0), _block_norms(B)])
    model = flow_model(
        shared,
        ((0, 2 * n), (0, 2 * n), (0, 2 * n)),
        (rows, rates, rates),
        (loads @ push.T, loads @ basis, loads @ speeds),
        (np.ones(n), np.zeros(n), np.zeros(n)),
        speed,
        (whole[n:], (omega / scale)[:, None] * whole[:n], still),
    )

    def flow(h: float) -> FloatArray:
        lone = _of_lone(own, scale[alone], omega[alone], h)
        return np.ascontiguousarray(np.hstack([lone, _of_pairs(B, h)]))

    def start(u: FloatArray, v: FloatArray) -> FloatArray:
        x = np.concatenate([scale * (turn.T @ (mass * u)), turn.T @ (mass * v)])
        return np.asarray(inverse @ x).reshape(2, n)

    held = Pairs(basis, speeds, push)
    return FlowForm(model, rows_u, speed, omega**2, alone_damped, 1.0 / mass, flow, start, following(terms), held)


def _mass_products(system: System) -> FloatArray:
    m = np.sqrt(np.asarray(system.M.diagonal(), dtype=float))
    return np.outer(m, m)


def _coupled(C: FloatArray) -> BoolArray:
    """(n,) modes that share damping with others, beyond `OFF_DIAGONAL` of their own."""
    d = np.maximum(C.diagonal(), 0.0)
    size = np.sqrt(d)
    off = np.abs(C) > OFF_DIAGONAL * np.maximum(np.outer(size, size), OFF_DIAGONAL * d.max(initial=0.0))
    np.fill_diagonal(off, False)
    return np.asarray(off.any(axis=1))


def _rigid_apart(C: FloatArray, omega: FloatArray) -> FloatArray:
    """(n, n) orthogonal: turns the rigid modes so that damping does not couple them with each other."""
    turn, rigid = np.eye(omega.size), np.flatnonzero(omega == 0.0)
    if rigid.size:
        turn[np.ix_(rigid, rigid)] = np.linalg.eigh(C[np.ix_(rigid, rigid)])[1]
    return turn


def _scales(omega: FloatArray) -> FloatArray:
    """S: omega, and the lowest of them for rigid modes."""
    moving = omega > 0.0
    return np.where(moving, omega, omega[moving].min() if moving.any() else 1.0)


def _eigenpairs(scale: FloatArray, omega: FloatArray, C: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """X (2 p, 2 p), its inverse, and the blocks B (4, p); columns j and p + j belong to block j.

    The eigensolver gets the fastest modes first, velocities before displacements: it is off by round-off of the largest
    number only in rows as large then (of a matrix that falls from its first row to its last).
    """
    p = omega.size
    if p == 0:
        return np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((4, 0))
    A = np.block([[np.zeros((p, p)), np.diag(scale)], [-np.diag(omega**2 / scale), -C]])
    noise = np.random.default_rng(1).standard_normal((p, p))
    size = np.sqrt(np.maximum(C.diagonal(), 0.0))
    fastest = np.argsort(-omega, kind="stable")
    order = np.stack([p + fastest, fastest], axis=1).ravel()
    for nudge, ill in ((0.0, ILL), (NUDGE, ILL**2), (100.0 * NUDGE, ILL**2)):
        A[p:, p:] = -C - nudge * size[:, None] * (noise + noise.T) * size
        values, vectors = sla.eig(A[np.ix_(order, order)])
        X, B = _real_pairs(values, vectors[np.argsort(order)])
        try:
            Y = np.asarray(np.linalg.inv(X), dtype=float)
        except np.linalg.LinAlgError:
            continue
        if np.linalg.norm(X, 1) * np.linalg.norm(Y, 1) > ill * p:
            continue
        moved = np.hstack([X[:, :p] * B[0] + X[:, p:] * B[2], X[:, :p] * B[1] + X[:, p:] * B[3]])
        if np.all(np.abs(A @ X - moved).max(axis=1) <= TRUSTED * np.abs(A).max(axis=1)):
            return X, Y, B
    raise NumericalError("the complex modes of the damped System cannot be told apart")


def _real_pairs(values: FloatArray, vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Real columns and blocks: rotations of conjugate pairs, diagonal ones of two neighbouring real eigenvalues."""
    upper = np.flatnonzero(values.imag > 0.0)
    real = np.flatnonzero(values.imag == 0.0)
    real = real[np.argsort(values[real].real)]
    one, two = real[0::2], real[1::2]
    X = vectors[:, upper]
    # Each conjugate pair turned so that its real and imaginary parts are orthogonal: the best conditioned choice.
    angle = 0.5 * np.angle(np.sum(X * X, axis=0))
    X = X * np.exp(-1j * angle) * math.sqrt(2.0)
    first = np.hstack([X.real, vectors[:, one].real])
    second = np.hstack([X.imag, vectors[:, two].real])
    a, b, none = values[upper].real, values[upper].imag, np.zeros(one.size)
    turning = np.stack([a, b, -b, a])
    growing = np.stack([values[one].real, none, none, values[two].real])
    return np.hstack([first, second]), np.hstack([turning, growing])


def _inverse_blocks(B: FloatArray) -> FloatArray:
    """(4, n) -B^-1: where a pair rests under a load; 0 where it rests nowhere."""
    a, b, c, d = B
    determinant = a * d - b * c
    rests = np.abs(determinant) > 1e-14 * (np.abs(a * d) + np.abs(b * c))
    return np.asarray(np.where(rests, np.stack([-d, b, c, -a]) / np.where(rests, determinant, 1.0), 0.0))


def _block_norms(B: FloatArray) -> FloatArray:
    """|B_j|: of rotations that of their eigenvalue, of diagonal ones the larger."""
    return np.asarray(np.maximum(np.hypot(B[0], B[1]), np.hypot(B[2], B[3])))


def _of_lone(c: FloatArray, scale: FloatArray, omega: FloatArray, h: float) -> FloatArray:
    """(40, n) in (S q, q') of modes that are damped by themselves."""
    P = propagator(np.ones(c.size), c, omega**2, h)
    out = np.zeros((40, c.size))
    out[0], out[1], out[2], out[3] = P[UU], P[UV] * scale, P[VU] / scale, P[VV]
    out[20], out[21], out[22], out[23] = P[MEAN], P[MEAN + 1] * scale, (P[UU] - 1.0) / (scale * h), P[UV] / h
    for r in range(1, 5):
        out[4 * r + 1], out[4 * r + 3] = scale * P[Q0 + r], P[Q0 + r - 1]
        out[20 + 4 * r + 1], out[20 + 4 * r + 3] = scale * P[MEAN + 1 + r], P[Q0 + r] / h
    return out


def _of_pairs(B: FloatArray, h: float) -> FloatArray:
    """(40, n) exponential of B h and h^r phi_r(B h), r = 1 to 4, each as (00, 01, 10, 11); the same of phi_(r+1)."""
    turns = B[1] != 0.0
    first, second = B[0] + 1j * B[1], np.where(turns, B[3] - 1j * B[1], B[3])
    out = np.zeros((40, B.shape[1]))
    both = list(zip(phi(first * h, 6), phi(second * h, 6), strict=True))
    for r in range(5):
        for at, (f, g) in ((4 * r, both[r]), (20 + 4 * r, both[r + 1])):
            out[at] = h**r * f.real
            out[at + 1] = np.where(turns, h**r * f.imag, 0.0)
            out[at + 2] = np.where(turns, -(h**r) * f.imag, 0.0)
            out[at + 3] = np.where(turns, h**r * f.real, h**r * g.real)
    return out
