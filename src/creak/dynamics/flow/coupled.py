"""Exact flow of a System whose damping couples its modes: pairs of complex modes (`linalg.complex_modes`).

A pair moves by itself, z_j' = B_j z_j + load, exactly for any step by B_j's exponential and its integrals phi_r.
Channels see and push the modes; what they see of a pair, and how they push it, follows from that. So a
kick gives the structure just what it takes from the channels.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.flow.model import FlowForm, driven, flow_model, following
from creak.dynamics.flow.propagator import MEAN, Q0, UU, UV, VU, VV, phi, propagator
from creak.dynamics.state import LinearTerms
from creak.linalg.diagonal import Diagonal

MOST = 3_000
"""Modes that damping may couple: the eigenvectors of twice as many states are found once (3,000 states: 9 s; where few
dashpots couple them 1.4 s)."""


def can_couple(system: System) -> bool:
    """Has the System diagonal M and K, mass everywhere, and not too many modes that damping couples?"""
    if not (isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal)) or np.any(system.M.d <= 0.0):
        return False
    return system.coupled <= MOST


def coupled_modes(system: System, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator) -> FlowForm:
    """The System in pairs of complex modes.

    Raises
    ------
    NumericalError : no trustworthy eigenvectors were found.
    """
    pairs = system.complex_modes
    n, a, B = pairs.omega2.size, pairs.alone, pairs.blocks
    rows_u, loads, shared = driven(on, terms, gaps)
    rows, rates = rows_u @ pairs.basis, rows_u @ pairs.speeds
    c, scale = -B[3, :a], B[1, :a]
    omega = np.sqrt(-B[2, :a] * scale)
    speed = np.concatenate([np.hypot(scale, c) * (omega > 0.0), _block_norms(B[:, a:])])
    model = flow_model(
        shared,
        ((0, 2 * n), (0, 2 * n), (0, 2 * n)),
        (rows, rates, rates),
        (loads @ pairs.push.T, loads @ pairs.basis, loads @ pairs.speeds),
        (np.ones(n), np.zeros(n), np.zeros(n)),
        speed,
        _inverse_blocks(B),
    )

    def flow(h: float) -> FloatArray:
        return np.ascontiguousarray(np.hstack([_of_lone(c, scale, omega, h), _of_pairs(B[:, a:], h)]))

    def start(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.asarray(pairs.place @ u + pairs.push @ (system.M @ v)).reshape(2, n)

    root = 1.0 / np.sqrt(np.asarray(system.M.diagonal(), dtype=float))
    return FlowForm(model, rows_u, speed, pairs.omega2, pairs.damping, root, flow, start, following(terms), pairs)


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
