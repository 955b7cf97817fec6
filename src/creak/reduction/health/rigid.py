"""Rigid motion of a part and of its superelement: mass, centre of gravity, inertia, grounding."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.errors import InputError
from creak.model.dofs import dofs_of, nodes_of
from creak.model.mesh import Nodes, rigid_vectors
from creak.reduction.inside import Inside

GROUNDING = 1e-10
"""Largest relative strain energy of a rigid motion that counts as round-off; that itself is some 1e-14 on plates and
2e-13 on a strip of 300 elements held at one end."""


@dataclass(frozen=True)
class RigidCheck:
    """Rigid-body properties of the part, and how far the reduced matrices are off."""

    mass: float
    cog: tuple[float, ...]
    """(3,) centre of gravity."""
    inertia: tuple[float, ...]
    """(6,) J_xx, J_yy, J_zz, J_xy, J_yz, J_zx about the centre of gravity."""
    mass_error: float
    """|m_r - m| / m"""
    cog_error: float
    """Distance of the two centres of gravity over the radius of gyration."""
    inertia_error: float
    """|J_r - J| / |J| (Frobenius)."""
    boundary_misfit: float
    """How far the boundary is from moving rigidly, relative to that motion; 0 where its dofs are kept as they are."""
    inside_misfit: float
    """How far the inside is from following a rigid boundary rigidly, relative to that motion."""
    strain_energy: tuple[float, ...]
    """(6,) strain energy that the reduction adds to each rigid motion, relative to r_b' diag(K_bb) r_b."""
    grounding_frequency: float
    """Largest frequency, Hz, that this strain energy gives to a rigid motion."""
    grounded: bool
    """The full part itself is tied to ground."""

    @property
    def passes_grounding(self) -> bool:
        return max(self.strain_energy) <= GROUNDING


@dataclass(frozen=True)
class RigidMotion:
    """The six rigid motions about the centre of gravity: three translations, three rotations."""

    R: FloatArray
    """(n_full, 6) in the full part's coordinates."""
    q: FloatArray
    """(n_reduced, 6) in the superelement's: the boundary moves rigidly, generalised coordinates are 0."""
    u: FloatArray
    """(n_full, 6) full-field motion of q."""
    mass: FloatArray
    """(6, 6) R' M R."""
    mass_reduced: FloatArray
    """(6, 6) q' M_r q."""
    cog: FloatArray
    boundary_misfit: float


def motion(full: System, reduced: System, q: FloatArray) -> FloatArray:
    """Full-field motion u = V q (n_full, k) in the full part's coordinates, q (n_reduced, k)."""
    u = reduced.recover(q)[np.searchsorted(reduced.labels, full.coordinates)]
    if reduced.of_shells:  # where a support holds a node's drilling rotation the coordinate is that of its shells
        apart = abs(sp.csr_matrix(full.rows(full.coordinates)[0]) - sp.eye_array(full.n, format="csr"))
        held = np.flatnonzero(apart.sum(axis=1) > 0.0)
        u[held] = reduced.rows(~full.coordinates[held])[0] @ q
    return u


def needs_physical(full: System) -> None:
    """Raise InputError where the full part has coordinates that are no physical dofs."""
    if (full.coordinates < 0).any():
        raise InputError(
            f"part {full.name} has {np.count_nonzero(full.coordinates < 0)} generalised coordinates",
            expected="a part whose coordinates are all degrees of freedom of nodes",
            fix="Ask for the health of the superelement before it is reduced again.",
        )


def centre_of_gravity(mass: FloatArray, about: FloatArray) -> FloatArray:
    """From the (6, 6) rigid-body mass about a point: S = m [c]x' couples translation and rotation."""
    m = np.trace(mass[:3, :3]) / 3.0
    moment = 0.5 * np.array([mass[1, 5] - mass[2, 4], mass[2, 3] - mass[0, 5], mass[0, 4] - mass[1, 3]])
    return about + (moment / m if m > 0.0 else 0.0)


def rigid_motion(full: System, reduced: System, nodes: Nodes) -> RigidMotion:
    """The six rigid motions of the full part and of its superelement."""
    about = nodes.coords[np.unique(nodes_of(full.coordinates))].mean(axis=0)
    R = rigid_vectors(full.coordinates, nodes, about)
    cog = centre_of_gravity(R.T @ np.asarray(full.M @ R), about)
    R = rigid_vectors(full.coordinates, nodes, cog)
    q, misfit = _reduced_rigid(reduced, nodes, cog)
    return RigidMotion(
        R, q, motion(full, reduced, q), R.T @ np.asarray(full.M @ R), q.T @ np.asarray(reduced.M @ q), cog, misfit
    )


def _reduced_rigid(reduced: System, nodes: Nodes, about: FloatArray) -> tuple[FloatArray, float]:
    """Boundary coordinates by their labels; generalised boundary coordinates by least squares at the joins."""
    boundary = np.arange(reduced.stats.retained)
    named = boundary[reduced.coordinates[boundary] >= 0]
    shapes = np.setdiff1d(boundary, named)
    q = np.zeros((reduced.n, 6))
    q[named] = rigid_vectors(reduced.coordinates[named], nodes, about)
    if shapes.size == 0:
        return q, 0.0
    labels = reduced.joins
    A = sp.csr_matrix(reduced.rows(labels)[0])
    target = rigid_vectors(labels, nodes, about)
    size = max(float(np.linalg.norm(nodes.coords[nodes_of(labels)] - about, axis=1).max(initial=0.0)), 1e-300)
    scale = np.where(dofs_of(labels) <= 3, 1.0, size)[:, None]
    rest = target - np.asarray(A[:, named] @ q[named])
    q[shapes] = np.linalg.lstsq(scale * A[:, shapes].toarray(), scale * rest, rcond=None)[0]
    miss = np.linalg.norm(scale * (target - np.asarray(A @ q)), axis=0)
    return q, float((miss / np.linalg.norm(scale * target, axis=0)).max())


def rigid_check(full: System, reduced: System, inside: Inside, rigid: RigidMotion) -> RigidCheck:
    """Mass properties and ground check.

    Ground check (as Nastran's GROUNDCHECK): a rigid motion strains nothing. What counts is the strain energy
    q' K_r q above that of the same motion in the full part, u' K u with u = V q, so that springs to ground which
    the part really has are not held against the reduction. The scale r_b' diag(K_bb) r_b is that of the terms whose
    difference K_bb - K_bi K_ii^-1 K_ib must vanish on rigid motion; the tolerance is GROUNDING.
    """
    u_b = rigid.u[inside.b]
    scale = np.einsum("ij,i,ij->j", u_b, inside.K_bb.diagonal(), u_b)
    own = np.einsum("ij,ij->j", rigid.R, np.asarray(full.K @ rigid.R))
    same = np.einsum("ij,ij->j", rigid.u, np.asarray(full.K @ rigid.u))
    energy = np.einsum("ij,ij->j", rigid.q, np.asarray(reduced.K @ rigid.q))
    added = np.maximum(energy - np.minimum(own, same), 0.0)
    mass = np.diag(rigid.mass)
    omega2 = np.divide(added, mass, out=np.zeros(6), where=mass > 0.0)
    # max_j |u_i - r_i| / |r_i| over the six motions.
    off = np.linalg.norm((rigid.u - rigid.R)[inside.i], axis=0)
    size = np.linalg.norm(rigid.R[inside.i], axis=0)
    return RigidCheck(
        *_mass_properties(rigid),
        boundary_misfit=rigid.boundary_misfit,
        inside_misfit=float(np.divide(off, size, out=np.zeros(6), where=size > 0.0).max()),
        strain_energy=floats(np.divide(added, scale, out=np.zeros(6), where=scale > 0.0)),
        grounding_frequency=float(np.sqrt(omega2.max()) / (2.0 * np.pi)),
        grounded=bool((own > GROUNDING * scale).any()),
    )


def _mass_properties(
    rigid: RigidMotion,
) -> tuple[float, tuple[float, ...], tuple[float, ...], float, float, float]:
    """Mass, centre of gravity, inertia, and the errors of the three."""
    m, J = float(np.trace(rigid.mass[:3, :3]) / 3.0), rigid.mass[3:, 3:]
    m_r, c = float(np.trace(rigid.mass_reduced[:3, :3]) / 3.0), centre_of_gravity(rigid.mass_reduced, np.zeros(3))
    J_r = rigid.mass_reduced[3:, 3:] - m_r * (c @ c * np.eye(3) - np.outer(c, c))
    gyration = float(np.sqrt(max(np.trace(J), 0.0) / (2.0 * m))) if m > 0.0 else 0.0
    return (
        m,
        floats(rigid.cog),
        floats(J[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]),
        _relative(abs(m_r - m), m),
        _relative(float(np.linalg.norm(c)), gyration),
        _relative(float(np.linalg.norm(J_r - J)), float(np.linalg.norm(J))),
    )


def _relative(a: float, b: float) -> float:
    return a / b if b > 0.0 else 0.0


def floats(values: FloatArray) -> tuple[float, ...]:
    """Plain numbers."""
    return tuple(float(v) for v in values)
