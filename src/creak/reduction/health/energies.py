"""Energies of a superelement against those of its own motion in the full part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, Matrix
from creak.assembly.system import System
from creak.reduction.health.rigid import motion

ROUND_OFF = 1e-9
"""Of the terms of an energy, which they lose to each other: smaller energies are none."""
MOTIONS = 3
"""Random motions that are looked at."""


@dataclass(frozen=True)
class Energies:
    """How far q' M_r q and q' K_r q are off those of the motion u = V q, relative; random q."""

    kinetic: float
    strain: float


def energies(full: System, reduced: System) -> Energies:
    """The reduced matrices are V' M V and V' K V, so that every motion has the energies that it has in the full part.

    Boundary and modes move at random, both with the same kinetic energy: rows between them that belong to other modes,
    or to modes of other signs, show in full.
    """
    boundary, rng = reduced.stats.retained, np.random.default_rng(1968)
    q = rng.standard_normal((reduced.n, MOTIONS))
    mass = np.asarray(reduced.M.diagonal())
    heavy = mass > 0.0
    q *= np.where(heavy, 1.0 / np.sqrt(np.where(heavy, mass, 1.0)), 0.0)[:, None]
    own = [_energy(reduced.M, _only(q, some)) for some in (slice(0, boundary), slice(boundary, None))]
    if all((e > 0.0).all() for e in own):
        q[boundary:] *= np.sqrt(own[0] / own[1])
    u = motion(full, reduced, q)
    both = ((reduced.M, full.M), (reduced.K, full.K))
    return Energies(*(_apart(_energy(A, q), _energy(B, u), _terms(B, u)) for A, B in both))


def _only(q: FloatArray, some: slice) -> FloatArray:
    out = np.zeros_like(q)
    out[some] = q[some]
    return out


def _energy(A: Matrix, q: FloatArray) -> FloatArray:
    """(k,) q' A q of each column."""
    return np.asarray(np.einsum("ij,ij->j", q, np.asarray(A @ q)))


def _terms(A: Matrix, u: FloatArray) -> FloatArray:
    """(k,) |u|' |A| |u|: what the terms of the energy are, which may cancel, as those of rigid motion do."""
    return _energy(abs(A), np.abs(u))


def _apart(a: FloatArray, b: FloatArray, terms: FloatArray) -> float:
    size = np.maximum(np.maximum(np.abs(a), np.abs(b)), ROUND_OFF * terms).max(initial=0.0)
    return float(np.abs(a - b).max() / size) if size else 0.0
