"""S = m M + c C + k K of an implicit step, real or complex, factored once for a step length."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import Matrix
from creak.assembly.system import System
from creak.dynamics.scheme import Scheme
from creak.linalg.complex_factor import complex_factor
from creak.linalg.factor import factor


def step_matrix(system: System, scheme: Scheme, h: float) -> Matrix:
    """S = (1 - am) M + (1 - af)(gamma h C + beta h^2 K) without the low-rank modal damping (see `PencilFactor`)."""
    return pencil(system, *_weights(scheme, h))


def _weights(scheme: Scheme, h: float) -> tuple[float, float, float]:
    """Of M, C and K in S."""
    return 1.0 - scheme.alpha_m, (1.0 - scheme.alpha_f) * scheme.gamma * h, (1.0 - scheme.alpha_f) * scheme.beta * h * h


def rayleigh_weights(system: System, scheme: Scheme, h: float) -> tuple[float, float]:
    """c_M and c_K of S = c_M M + c_K K, damping that is not Rayleigh left out."""
    m, c, k = _weights(scheme, h)
    return m + c * system.damping.alpha, k + c * system.damping.beta


def pencil(system: System, m: complex, c: complex, k: complex) -> Matrix:
    """m M + c C + k K without the low-rank modal damping."""
    d = system.damping
    S = (m + c * d.alpha) * system.M + (k + c * d.beta) * system.K
    return S if d.extra is None else S + c * d.extra


class PencilFactor:
    """Solves with m M + c C + k K; complex where m or k are. Modal damping enters as a low-rank update (Woodbury)."""

    def __init__(self, system: System, m: complex, c: float, k: complex) -> None:
        factorise: Callable[[Any], Any] = complex_factor if isinstance(m, complex) or isinstance(k, complex) else factor
        S = pencil(system, m, c, k)
        self._factor = factorise(sp.csr_matrix(S) if sp.issparse(S) else S)
        del S  # large, and not needed for the solutions below
        W, d = system.damping.modal_shapes, system.damping.modal_values
        self._U: Any = None
        if W is not None and d is not None and W.shape[1]:
            self._W = W
            self._U = self._factor.solve(W)
            self._core = np.linalg.inv(np.diag(1.0 / (c * d)) + W.T @ self._U)

    @property
    def memory(self) -> float:
        """Bytes that the factor holds."""
        return float(self._factor.memory)

    def solve(self, b: Any) -> Any:
        """x with S x = b; b is (n,) or (n, k)."""
        x = self._factor.solve(b)
        if self._U is not None:
            x = x - self._U @ (self._core @ (self._W.T @ x))
        return x


class StepFactor(PencilFactor):
    """Solves with S of a scheme of the generalised-alpha family."""

    def __init__(self, system: System, scheme: Scheme, h: float) -> None:
        super().__init__(system, *_weights(scheme, h))
