"""Products of blocks of columns agree with NumPy's, in place, with and without MKL."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.linalg import dense_product, sparse_product
from creak.linalg.diagonal import Diagonal
from creak.linalg.sparse_product import BlockProduct


@pytest.fixture(params=[True, False], ids=["as installed", "without MKL"])
def either_library(request, monkeypatch):
    if not request.param:
        monkeypatch.setattr(dense_product, "has_pardiso", lambda: False)
        monkeypatch.setattr(sparse_product, "has_pardiso", lambda: False)


def tall(n: int, k: int, seed: int) -> np.ndarray:
    return np.asfortranarray(np.random.default_rng(seed).standard_normal((n, k)))


@pytest.mark.usefixtures("either_library")
@pytest.mark.parametrize("k", [0, 1, 5])
def test_dense_products(k):
    A, B, C = tall(50, 7, 0), tall(7, k, 1), tall(50, k, 2)
    np.testing.assert_allclose(dense_product.inner(A, C), A.T @ C, atol=1e-13)  # 50 terms of round-off
    np.testing.assert_allclose(dense_product.product(A, B), A @ B, atol=1e-13)
    expected = C - A @ B
    dense_product.subtract_product(C, A, B)
    np.testing.assert_allclose(C, expected, atol=1e-13)


@pytest.mark.usefixtures("either_library")
def test_parts_of_larger_arrays():
    A, B = tall(60, 12, 3), tall(5, 4, 4)
    part = A[10:30, 3:8]
    np.testing.assert_allclose(dense_product.product(part, B), part @ B, atol=1e-13)
    rest = A.copy()
    dense_product.subtract_product(A[10:30, 8:], part, B)
    rest[10:30, 8:] -= rest[10:30, 3:8] @ B
    np.testing.assert_allclose(A, rest, atol=1e-13)


@pytest.mark.usefixtures("either_library")
def test_triangular_solve_from_the_right():
    C = tall(40, 6, 5)
    R = np.triu(np.random.default_rng(6).uniform(1.0, 2.0, (6, 6))) + 3.0 * np.eye(6)
    expected = C @ np.linalg.inv(R)
    dense_product.right_solve(C, R)
    np.testing.assert_allclose(C, expected, atol=1e-13)


def test_rows_out_of_order_are_refused():
    if not dense_product.has_pardiso():
        pytest.skip("NumPy takes any order")
    with pytest.raises(ValueError, match="not in Fortran order"):
        dense_product.inner(np.ones((5, 3)), np.ones((5, 3)))


@pytest.mark.usefixtures("either_library")
@pytest.mark.parametrize("k", [0, 1, 31, 70])
@pytest.mark.parametrize("rows", [333, 20])
@pytest.mark.parametrize("serial", [0, 10**9])
def test_sparse_product(monkeypatch, k, rows, serial):
    """Any number of columns and rows, one thread or several; the rows of a tile and the last, incomplete one."""
    monkeypatch.setattr(sparse_product, "SERIAL", serial)
    A = sp.random(rows, 333, 0.05, random_state=np.random.default_rng(7), format="csr")
    X = tall(333, k, 8)
    Y = BlockProduct(A)(X)
    assert Y.flags.f_contiguous
    np.testing.assert_allclose(Y, A @ X, atol=1e-13)


@pytest.mark.parametrize("A", [Diagonal(np.arange(1.0, 6.0)), np.diag(np.arange(1.0, 6.0))])
def test_other_matrices_multiply_themselves(A):
    X = tall(5, 3, 9)
    np.testing.assert_array_equal(BlockProduct(A)(X), np.arange(1.0, 6.0)[:, None] * X)
