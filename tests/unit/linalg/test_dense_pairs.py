"""All modes at once by the dense eigensolver: what round-off of the highest leaves of the lowest.

K - s M: the entries are those of a subtraction, at the places of K.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

from creak.linalg.modes import modes
from creak.linalg.pencil import regular_pairs, shifted
from helpers_core import NO_DAMPING, block, model_of, part_system, plate, shell


@pytest.mark.parametrize("light", [1e-13, 1e-9, 1e-3])
def test_rotations_with_next_to_no_inertia_blur_no_low_mode(light):
    """A free chain of 40 masses of 1, to ten of which a light one m is tied by a stiff spring k: k / m is 1e19 at most.

    The inverse problem M x = mu (K + s M) x has its largest eigenvalues, which round-off blurs least, where the pencil
    has its lowest.
    """
    n, k, stiff = 40, np.arange(0, 40, 4), 1e6
    K, M = np.zeros((50, 50)), np.diag(np.concatenate([np.ones(n), np.full(10, light)]))
    chain = np.diag([1.0, *[2.0] * (n - 2), 1.0]) - np.eye(n, k=1) - np.eye(n, k=-1)
    K[:n, :n] = 1e6 * chain
    for i, j in zip(k, np.arange(n, 50), strict=True):
        K[np.ix_([i, j], [i, j])] += stiff * np.array([[1.0, -1.0], [-1.0, 1.0]])
    exact = np.sort(1.0 / sla.eigh(M, K + 1e3 * M)[0] - 1e3)[:12]
    found = modes(K, M, count=12, free=True)
    assert found.omega2[0] == 0.0
    np.testing.assert_allclose(found.omega2[1:], exact[1:], rtol=1e-9)
    lam, shapes, _ = regular_pairs(K, M)
    np.testing.assert_allclose(lam[1:12], exact[1:], rtol=1e-9)
    np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(50), atol=1e-9)


@pytest.mark.parametrize("thick", [1e-3, 1e-4, 5e-6])
def test_dense_modes_of_a_foil_are_those_of_the_inverse_problem(thick):
    """M x = mu K x has its largest eigenvalues, which round-off blurs least, where the pencil has its lowest.

    The rotations' inertia is m t^2 / 12: of a foil the highest eigenvalue is 1e16 times the lowest.
    """
    coords, quads = plate(6, 5, (0.4, 0.25))
    part = part_system(model_of(coords, [block("quad4", quads, shell(thick))]), 0, NO_DAMPING)
    K, M = (A.toarray()[24:, 24:] for A in (part.K, part.M))
    lam, shapes, blur = regular_pairs(K, M)
    mu, Y = sla.eigh(M, K)
    np.testing.assert_allclose(lam[:40], 1.0 / mu[:-41:-1], rtol=1e-8)
    x, y = shapes[:, 0], Y[:, -1] / np.sqrt(mu[-1])
    np.testing.assert_allclose(abs(x @ M @ y), 1.0, rtol=1e-9)
    assert blur < 1e-4 * lam[0]


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
