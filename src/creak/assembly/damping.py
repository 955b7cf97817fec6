"""Viscous damping in the forms that stay cheap: Rayleigh, an explicit matrix, or a few modes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, Matrix


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

    def projected(self, V: Matrix) -> Damping:
        """V' C V of the parts that are not Rayleigh (those follow M and K)."""
        extra = None if self.extra is None else V.T @ (self.extra @ V)
        shapes = None if self.modal_shapes is None else np.asarray(V.T @ self.modal_shapes)
        return replace(self, extra=extra, modal_shapes=shapes)
