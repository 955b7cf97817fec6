"""Effective mass and participation of the modes of an assembly in the six rigid-body directions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.linalg.dense_product import symmetric
from creak.model.mesh import Nodes, rigid_vectors

NOTHING = 1e-12
"""A direction with a smaller inertia, relative to the largest of its kind, has none."""


@dataclass(frozen=True)
class EffectiveMass:
    """How the modes take part in rigid motion of the base: three translations, three rotations about a point."""

    about: FloatArray
    """(3,) point that the rotations turn about."""
    participation: FloatArray
    """(n_mode, 6) L = Phi' M R for mass-normalised modes: sqrt(mass), and sqrt(mass) length in rotation."""
    rigid_mass: FloatArray
    """(6, 6) R' M R: the model's mass, its moments and inertia about the point, held nodes included."""

    @property
    def effective(self) -> FloatArray:
        """(n_mode, 6) L^2: mass, and mass length^2."""
        return self.participation**2

    @property
    def total(self) -> FloatArray:
        """(6,) what all of the model would give: diagonal of R' M R, 0 where that is round-off."""
        own = np.diag(self.rigid_mass).copy()
        for kind in (slice(0, 3), slice(3, 6)):
            own[kind] = np.where(own[kind] > NOTHING * own[kind].max(), own[kind], 0.0)
        return own

    @property
    def share(self) -> FloatArray:
        """(n_mode, 6) L^2 / total; 0 in a direction without inertia."""
        total = self.total
        return np.divide(self.effective, total, out=np.zeros_like(self.participation), where=total > 0.0)

    @property
    def cumulative(self) -> FloatArray:
        """(n_mode, 6) sum of the shares up to each mode."""
        return np.cumsum(self.share, axis=0)


def effective_mass(
    system: System,
    shapes: FloatArray,
    carriers: Iterable[tuple[IntArray, Matrix]],
    nodes: Nodes,
    about: FloatArray,
) -> EffectiveMass:
    """Effective mass L^2 of mass-normalised modes, L = Phi' M R.

    R is the rigid motion of the whole model, held nodes included: when the base moves as R s'', the modal load is
    -L s''. Over all modes L^2 sums to the part of R' M R that does not ride on held nodes alone; for a free model the
    rigid-body modes carry all of it and elastic modes nothing.

    Parameters
    ----------
    system : the assembly. shapes : (n, n_mode) in its coordinates.
    carriers : physical dof labels (k,) and mass (k, k) of each part before it was joined, independent dofs.
    nodes : all of the model. about : (3,) point of the rotations.

    Exact where constraints inside a part allow rigid motion, as couplings, ties and rigid bodies do; an equation
    that resists it (u_x = 0 at one of two nodes) leaves out what it blocks.

    Source: Craig and Kurdila, Fundamentals of Structural Dynamics, 2nd ed., ch. 17; Wijker, Spacecraft Structures.
    """
    mass, load = np.zeros((6, 6)), np.zeros((system.n, 6))
    for labels, M in carriers:
        R = rigid_vectors(labels, nodes, about)
        MR = np.asarray(M @ R)
        mass += R.T @ MR
        load += np.asarray(system.rows(labels)[0].T @ MR)
    return EffectiveMass(np.asarray(about, dtype=np.float64), shapes.T @ load, symmetric(mass))
