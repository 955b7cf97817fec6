"""Fixed-interface modes that a superelement keeps: are they modes, and how much mass do they carry?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, to_dense
from creak.assembly.system import System
from creak.linalg.sparse_product import BlockProduct
from creak.reduction.health.rigid import RigidMotion, floats, motion
from creak.reduction.inside import Inside

CG_STEPS = 200
CG_TOLERANCE = 1e-16
"""Of the squared residual; the energy's own error is of that order."""
NO_MASS = 1e-12
"""A direction with a smaller share of the rigid mass inside has nothing to carry."""


@dataclass(frozen=True)
class FixedModes:
    """Fixed-interface modes."""

    frequencies: tuple[float, ...]
    """First kept ones, Hz."""
    residual: float
    """Largest |K_ii phi - omega^2 M_ii phi| / |K_ii phi| of these."""
    first_left_out: float
    """Hz; infinite where nothing is left out."""
    effective_mass: tuple[float, ...]
    """(6,) share of the rigid mass that fixed-interface modes can carry, all kept modes."""
    cumulative_mass: tuple[tuple[float, ...], ...]
    """(n_mode, 6) the same, mode by mode."""
    inside_mass: tuple[float, ...]
    """(6,) that mass as a share of the part's own."""


def fixed_modes(
    full: System, reduced: System, inside: Inside, rigid: RigidMotion, cut: float, count: int
) -> FixedModes:
    """Check the first `count` kept modes; `cut` is the first eigenvalue left out, (rad/s)^2."""
    share, total = effective_mass(full, reduced, inside, rigid)
    own = np.diag(rigid.mass)
    frequencies, residual = _first_kept(full, reduced, inside, count)
    return FixedModes(
        frequencies,
        residual,
        float(np.sqrt(cut) / (2.0 * np.pi)),
        floats(share[-1] if share.size else np.where(total > NO_MASS * own, 0.0, 1.0)),
        tuple(floats(row) for row in share),
        floats(np.divide(total, own, out=np.zeros(6), where=own > 0.0)),
    )


def _first_kept(full: System, reduced: System, inside: Inside, count: int) -> tuple[tuple[float, ...], float]:
    """Frequencies of the first kept modes as the reduced matrices say, and their residual in the full part."""
    first = reduced.stats.retained
    some = np.arange(first, first + min(count, reduced.stats.modes))
    if some.size == 0:
        return (), 0.0
    omega2 = reduced.K.diagonal()[some] / reduced.M.diagonal()[some]
    q = np.zeros((reduced.n, some.size))
    q[some, np.arange(some.size)] = 1.0
    phi = motion(full, reduced, q)[inside.i]
    force = inside.stiffness(phi)
    off = np.linalg.norm(force - inside.mass(phi) * omega2, axis=0)
    return floats(np.sqrt(omega2) / (2.0 * np.pi)), float((off / np.linalg.norm(force, axis=0)).max())


def effective_mass(full: System, reduced: System, inside: Inside, rigid: RigidMotion) -> tuple[FloatArray, FloatArray]:
    """Effective mass of the kept fixed-interface modes in the six rigid directions.

    Mode j carries L_j^2 / m_j with L = M_eta,b R_b, since -L s'' is the modal load when the boundary moves as
    R_b s. With all modes, Phi Phi' = M_ii^-1 and the sum is p' M_ii^-1 p, p = M_ib R_b + M_ii R_i: the rigid mass that
    fixed-interface modes can carry at all (R_i' M_ii R_i for a lumped mass; the rest of R' M R rides on the boundary).

    Returns
    -------
    cumulative (n_mode, 6) share of that mass, 0 to 1; total (6,) p' M_ii^-1 p. A share of nothing counts as 1.

    Source: Craig and Kurdila, Fundamentals of Structural Dynamics, 2nd ed., ch. 17; Wijker, Spacecraft Structures.
    """
    first = reduced.stats.retained
    modal = to_dense(reduced.M[first:])
    L = modal @ rigid.q
    L2 = L**2 / np.diag(modal[:, first:])[:, None]
    p = np.asarray(full.M @ rigid.u)[inside.i]
    total = _inverse_energy(inside, p)
    some = total > NO_MASS * np.diag(rigid.mass)
    share = np.divide(np.cumsum(L2, axis=0), total, out=np.ones_like(L2), where=some)
    return share, total


def _inverse_energy(inside: Inside, p: FloatArray) -> FloatArray:
    """p' M^-1 p per column by conjugate gradients; scaled by its diagonal a mass matrix is well conditioned
    whatever the mesh (Wathen, IMA J. Numer. Anal. 7, 1987). Massless rows drop out."""
    M = inside.M_ii
    d = M.diagonal()
    keep = np.flatnonzero(d > 0.0)
    times = inside.mass if keep.size == d.size else BlockProduct(M[keep][:, keep])
    d, r = d[keep][:, None], p[keep].copy()
    z = r / d
    s, rho = z.copy(), np.einsum("ij,ij->j", r, z)
    energy, start = np.zeros(p.shape[1]), rho.copy()
    for _ in range(CG_STEPS):
        if (rho <= CG_TOLERANCE * start).all():
            break
        w = times(s)
        curvature = np.einsum("ij,ij->j", s, w)
        step = np.divide(rho, curvature, out=np.zeros_like(rho), where=curvature > 0.0)
        energy += step * rho
        r -= step * w
        z = r / d
        rho, old = np.einsum("ij,ij->j", r, z), rho
        s = z + s * np.divide(rho, old, out=np.zeros_like(rho), where=old > 0.0)
    return energy
