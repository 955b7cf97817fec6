"""All backends of `complex_factor` give the same answer."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.linalg import complex_factor as module
from creak.linalg.complex_factor import complex_factor, complex_refactor
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import SingularMatrixError
from creak.linalg.mkl import has_pardiso


def accretive(n: int = 80) -> sp.csr_matrix:
    rng = np.random.default_rng(3)
    B, C = (sp.random(n, n, 0.08, random_state=rng, format="csr") for _ in range(2))
    return sp.csr_matrix(B @ B.T + sp.diags_array(rng.uniform(0.5, 1.0, n)) + 1j * (C + C.T))


BACKENDS = {"sparse": complex_factor, "superlu": module._SuperLU, "dense": lambda A: complex_factor(A.toarray())}


@pytest.mark.parametrize("backend", sorted(BACKENDS))
@pytest.mark.parametrize("columns", [None, 1, 5])
def test_solves(backend, columns):
    A = accretive()
    shape = (80,) if columns is None else (80, columns)
    rng = np.random.default_rng(1)
    x = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    b = A @ x
    before = b.copy()
    found = BACKENDS[backend](A).solve(b)
    np.testing.assert_allclose(found, x, atol=1e-10)
    np.testing.assert_array_equal(b, before)
    # A real right side is as good.
    np.testing.assert_allclose(A @ BACKENDS[backend](A).solve(np.ones(shape)), np.ones(shape), atol=1e-10)


def test_pardiso_is_used_where_it_is_installed():
    assert type(complex_factor(accretive())).__name__ == ("_Pardiso" if has_pardiso() else "_SuperLU")


def test_diagonal():
    d = np.array([1.0 + 1j, 2.0, -1j])
    found = complex_factor(Diagonal(d))
    np.testing.assert_allclose(found.solve(d), 1.0)
    np.testing.assert_allclose(found.solve(np.outer(d, [1.0, 2.0])), np.outer(np.ones(3), [1.0, 2.0]))


@pytest.mark.parametrize("backend", sorted(BACKENDS))
def test_singular(backend):
    A = sp.lil_matrix(accretive(10))
    A[3, :] = 0.0
    A[:, 3] = 0.0
    with pytest.raises(SingularMatrixError, match=r"is singular|has an empty row 3"):
        BACKENDS[backend](sp.csr_matrix(A))


def test_singular_diagonal():
    with pytest.raises(SingularMatrixError, match="row 1"):
        complex_factor(Diagonal(np.array([1.0, 0.0, 1j])))


@pytest.mark.parametrize("backend", sorted(BACKENDS))
def test_another_matrix_in_the_place_of_the_first(backend):
    """The solution is that of a factor from the start; another pattern is no obstacle."""
    A, x = accretive(), np.random.default_rng(1).standard_normal((80, 3)) + 1j
    found, further = BACKENDS[backend](A), sp.csr_matrix(([0.1, 0.1], ([0, 79], [79, 0])), shape=A.shape)
    for B in (A + 0.5j * sp.identity(80), A + further):
        found = complex_refactor(found, B.toarray() if backend == "dense" else sp.csr_matrix(B))
        np.testing.assert_allclose(found.solve(B @ x), x, atol=1e-10)


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU analyses with the numbers")
def test_one_analysis_serves_a_pattern():
    first = complex_factor(accretive())
    assert complex_refactor(first, sp.csr_matrix(2.0 * accretive())) is first


@pytest.mark.parametrize("pardiso", [True, False])
def test_one_triangle_is_enough(pardiso, monkeypatch):
    if not pardiso:
        monkeypatch.setattr(module, "has_pardiso", lambda: False)
    A = accretive()
    b = np.arange(1.0, A.shape[0] + 1.0)
    found = complex_factor(sp.csr_matrix(sp.triu(A)), upper=True).solve(b)
    np.testing.assert_allclose(A @ found, b, atol=1e-9 * np.abs(b).max())
