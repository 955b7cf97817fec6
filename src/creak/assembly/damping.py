"""Viscous damping in the forms that stay cheap: Rayleigh, an explicit matrix, or a few modes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, Matrix, to_dense
from creak.model.constraints import KinematicCoupling, RigidLink
from creak.model.materials import Discrete, Section, Structural, has_dashpot, rayleigh
from creak.model.mesh import Model

MOSTLY = 0.5
"""Share of the elements from which on a structure counts as undamped although some of it is damped."""


@dataclass(frozen=True)
class Damping:
    """C = alpha M + beta K + C_extra + W diag(d) W'.

    The first two are the same numbers for the unreduced and any reduced System, so these share C exactly.
    """

    alpha: float = 0.0
    """1/s"""
    beta: float = 0.0
    """s"""
    extra: Matrix | None = None
    """(n, n)"""
    modal_shapes: FloatArray | None = None
    """W = M Phi, (n, n_mode)."""
    modal_values: FloatArray | None = None
    """d = 2 zeta omega, (n_mode,), rad/s."""

    @property
    def is_rayleigh(self) -> bool:
        return self.extra is None and self.modal_shapes is None

    def other(self, v: FloatArray) -> FloatArray | float:
        """(C_extra + W diag(d) W') v, the part that is not Rayleigh."""
        total: FloatArray | float = 0.0
        if self.extra is not None:
            total = self.extra @ v
        if self.modal_shapes is not None and self.modal_values is not None:
            weights = self.modal_shapes.T @ v
            total = total + self.modal_shapes @ (
                self.modal_values * weights if v.ndim == 1 else self.modal_values[:, None] * weights
            )
        return total

    def matrix(self, m: FloatArray, k: FloatArray) -> FloatArray:
        """(n, n) C of diagonal M and K, m and k (n,)."""
        C = np.diag(self.alpha * m + self.beta * k)
        if self.extra is not None:
            C += to_dense(self.extra)
        if self.modal_shapes is not None and self.modal_values is not None:
            C += (self.modal_shapes * self.modal_values) @ self.modal_shapes.T
        return np.asarray(0.5 * (C + C.T))

    def projected(self, V: Matrix) -> Damping:
        """V' C V of the parts that are not Rayleigh (those follow M and K)."""
        extra = None if self.extra is None else V.T @ (self.extra @ V)
        shapes = None if self.modal_shapes is None else np.asarray(V.T @ self.modal_shapes)
        return replace(self, extra=extra, modal_shapes=shapes)


def is_damped(model: Model) -> bool:
    """Whether a material, a point mass, a spring or a dashpot of the model damps anything."""
    return any(_damps(block.section) for block in model.blocks)


def undamped_words(model: Model) -> str:
    """`900 of 1,000 shells, solids and beams`: those that no material damps where something else of the model is
    damped; empty where these are few. Elements that move as rigid bodies do not count."""
    if not is_damped(model):
        return ""
    rigid = np.zeros(model.nodes.count, dtype=bool)
    for c in model.constraints:
        if isinstance(c, KinematicCoupling | RigidLink):
            rigid[c.nodes] = True
    bare = every = 0
    for b in model.blocks:
        if isinstance(b.section, Structural):
            elastic = int((~rigid[b.nodes_idx].all(axis=1)).sum())
            every += elastic
            bare += 0 if _damps(b.section) else elastic
    return f"{bare:,} of {every:,} shells, solids and beams" if bare > MOSTLY * every else ""


def _damps(section: Section) -> bool:
    return any(rayleigh(section)) or (isinstance(section, Discrete) and has_dashpot(section))
