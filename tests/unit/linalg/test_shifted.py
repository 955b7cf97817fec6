"""K - s M: the entries are those of a subtraction, at the places of K."""

import numpy as np
import pytest
import scipy.sparse as sp

from creak.linalg.pencil import shifted


def some(seed, places=None):
    A = sp.random(60, 60, 0.1, random_state=seed, format="csr") if places is None else places.copy()
    A.data = np.random.default_rng(seed).standard_normal(A.nnz)
    return A


@pytest.mark.parametrize("inside", [True, False])
def test_the_difference_is_that_of_a_subtraction(inside):
    K = some(1) + sp.identity(60, format="csr")
    M = sp.csr_matrix(some(2, K).multiply(some(3))) if inside else some(3)
    assert M.nnz
    found = shifted(K, M, 2.5)
    np.testing.assert_array_equal(found.toarray(), (K - 2.5 * M).toarray())
    assert np.shares_memory(found.indices, K.indices) == inside


def test_places_that_are_not_in_order_are_put_so():
    K = sp.csr_matrix((np.array([1.0, 2.0, 3.0]), np.array([1, 0, 1]), np.array([0, 2, 3])), shape=(2, 2))
    M = sp.identity(2, format="csr")
    np.testing.assert_array_equal(shifted(K, M, 1.0).toarray(), [[1.0, 1.0], [0.0, 2.0]])
