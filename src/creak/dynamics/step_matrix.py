"""S = (1 - am) M + (1 - af)(gamma h C + beta h^2 K), factored once for a step length."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.assembly.system import System
from creak.dynamics.scheme import Scheme
from creak.linalg.factor import Factor, factor


def step_matrix(system: System, scheme: Scheme, h: float) -> Matrix:
    """S without the low-rank modal damping (see `StepFactor`)."""
    d = system.damping
    c_M, c_K = rayleigh_weights(system, scheme, h)
    S = c_M * system.M + c_K * system.K
    return S if d.extra is None else S + (1.0 - scheme.alpha_f) * scheme.gamma * h * d.extra


def rayleigh_weights(system: System, scheme: Scheme, h: float) -> tuple[float, float]:
    """c_M and c_K of S = c_M M + c_K K, damping that is not Rayleigh left out."""
    d = system.damping
    w_C = (1.0 - scheme.alpha_f) * scheme.gamma * h
    w_K = (1.0 - scheme.alpha_f) * scheme.beta * h * h
    return 1.0 - scheme.alpha_m + w_C * d.alpha, w_K + w_C * d.beta


class StepFactor:
    """Solves with S; modal damping enters as a low-rank update (Woodbury)."""

    def __init__(self, system: System, scheme: Scheme, h: float) -> None:
        S = step_matrix(system, scheme, h)
        self._factor: Factor = factor(sp.csr_matrix(S) if sp.issparse(S) else S)
        W, d = system.damping.modal_shapes, system.damping.modal_values
        self._U: FloatArray | None = None
        if W is not None and d is not None and W.shape[1]:
            self._W = W
            self._U = self._factor.solve(W)
            weight = (1.0 - scheme.alpha_f) * scheme.gamma * h * d
            self._core = np.linalg.inv(np.diag(1.0 / weight) + W.T @ self._U)

    def solve(self, b: FloatArray) -> FloatArray:
        """x with S x = b; b is (n,) or (n, k)."""
        x = self._factor.solve(b)
        if self._U is not None:
            x = x - self._U @ (self._core @ (self._W.T @ x))
        return x
