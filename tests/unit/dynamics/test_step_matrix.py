"""Factors of m M + c C + k K: what they solve, with modal damping as well, and what they refuse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.assembly.damping import Damping
from creak.dynamics.scheme import HHT
from creak.dynamics.step_matrix import PencilFactor, StepFactor, step_matrix
from creak.errors import NumericalError
from helpers_core import chain, system_of

N = 40
POLES = {"real": 2.5, "complex": 2.5 - 1.5j}


def damped(sparse: bool):
    """A chain with damping of each kind; two of its shapes have more of it, as modal damping has."""
    M, K = chain(N)
    system = system_of(M, K, alpha=3.0, beta=1e-3, extra=np.diag(np.linspace(0.1, 0.2, N)), sparse=sparse)
    given, shapes, values = system.damping, np.random.default_rng(3).standard_normal((N, 2)), np.array([0.7, 1.9])
    C = 3.0 * M + 1e-3 * K + np.diag(np.linspace(0.1, 0.2, N)) + shapes @ np.diag(values) @ shapes.T
    more = Damping(given.alpha, given.beta, given.extra, modal_shapes=shapes, modal_values=values)
    return replace(system, damping=more), (M, C, K)


@pytest.mark.parametrize("columns", [None, 3])
@pytest.mark.parametrize("pole", sorted(POLES))
@pytest.mark.parametrize("sparse", [True, False])
def test_solves_with_the_whole_matrix(sparse, pole, columns):
    system, (M, C, K) = damped(sparse)
    p, h = POLES[pole], 0.05
    S = M / p + h * C + h * h * p * K
    x = np.random.default_rng(1).standard_normal((N,) if columns is None else (N, columns))
    found = PencilFactor(system, 1.0 / p, h, h * h * p).solve((S @ x).astype(S.dtype))
    np.testing.assert_allclose(found, x, atol=1e-11)  # round-off times the condition of S, below 1e3


def test_step_of_a_scheme():
    """S = M + (1 + alpha) (gamma h C + beta h^2 K) of HHT; `step_matrix` leaves modal damping out."""
    system, (M, C, K) = damped(True)
    scheme, h = HHT(-0.1), 0.05
    S = M + 0.9 * (scheme.gamma * h * C + scheme.beta * h * h * K)
    x = np.random.default_rng(2).standard_normal(N)
    np.testing.assert_allclose(StepFactor(system, scheme, h).solve(S @ x), x, atol=1e-11)
    W, d = system.damping.modal_shapes, system.damping.modal_values
    without = S - 0.9 * scheme.gamma * h * (W * d) @ W.T
    np.testing.assert_allclose(step_matrix(system, scheme, h).toarray(), without, atol=1e-12 * np.abs(S).max())


@pytest.mark.parametrize("sparse", [True, False])
def test_a_coordinate_with_neither_mass_nor_stiffness_is_refused(sparse):
    M, K = np.diag([1.0, 0.0]), np.diag([100.0, 0.0])
    with pytest.raises(NumericalError, match=r"row 1|singular"):
        PencilFactor(system_of(M, K, sparse=sparse), 1.0, 0.1, 0.01)
