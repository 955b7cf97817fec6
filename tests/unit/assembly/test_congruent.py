"""T' A T without putting the parts' matrices together: held to dense products.

Joining parts never puts their matrices side by side.
"""

from __future__ import annotations

import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.sparse as sp

from creak.assembly import congruent as at
from creak.assembly.congruent import SideBySide, congruent
from creak.assembly.coupling import couple
from creak.assembly.elimination import transformation
from creak.assembly.part import part_system
from creak.model.constraints import Fixed
from helpers_core import NO_DAMPING, NONE, block, model_of, plate, shell


def symmetric(n: int, seed: int) -> sp.csr_matrix:
    """Sparse, symmetric to the last bit, rows with and without entries."""
    A = sp.random(n, n, density=0.3, random_state=seed, format="csr")
    return sp.csr_matrix(A + A.T)


BLOCKS = [symmetric(n, n) for n in (7, 1, 12)]
SOLVED = {0: {3: 1.0}, 9: {2: 0.5, 19: -2.0}, 10: {19: 1.0}, 14: {}}
"""Dependents follow an independent as it is, two of two parts, one of another part, and nothing."""


@pytest.fixture(scope="module")
def eliminated():
    return transformation(np.arange(20), SOLVED)


@pytest.mark.parametrize("extra", [None, symmetric(20, 5)], ids=["", "springs between parts"])
def test_it_is_the_dense_product(eliminated, extra):
    T, own = eliminated
    A = SideBySide(BLOCKS, extra)
    found = congruent(T, A, own)
    dense = sp.block_diag(BLOCKS).toarray() + (0.0 if extra is None else extra.toarray())
    np.testing.assert_allclose(found.toarray(), T.toarray().T @ dense @ T.toarray(), rtol=0, atol=1e-14)
    assert (found != found.T).nnz == 0
    column_sorted = sp.csr_matrix((found.data, found.indices, found.indptr), shape=found.shape)
    assert column_sorted.has_canonical_format
    X = sp.random(20, 3, density=0.4, random_state=1, format="csr")
    np.testing.assert_allclose(A.times(X).toarray(), dense @ X.toarray(), rtol=0, atol=1e-14)


def test_columns_that_were_left_out(eliminated):
    """Coordinates without stiffness and mass are dropped after the elimination; damping follows."""
    T, own = eliminated
    keep = np.delete(np.arange(own.size), [0, 5])
    found = congruent(T[:, keep], SideBySide(BLOCKS), own[keep])
    dense = T[:, keep].toarray()
    np.testing.assert_allclose(found.toarray(), dense.T @ sp.block_diag(BLOCKS).toarray() @ dense, atol=1e-14)


def test_the_same_to_the_last_bit_on_any_number_of_cores(eliminated, monkeypatch):
    T, own = eliminated
    found = []
    for cores in (1, 3):
        pool = ThreadPoolExecutor(cores)
        monkeypatch.setattr(at, "cores", lambda cores=cores: cores)
        monkeypatch.setattr(at, "pool", lambda pool=pool: pool)
        found.append(congruent(T, SideBySide(BLOCKS, symmetric(20, 5)), own))
    for name in ("data", "indices", "indptr"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


def test_blocks_with_unsorted_columns(eliminated):
    T, own = eliminated
    A = BLOCKS[2]
    mixed = sp.csr_matrix((A.data.copy(), A.indices.copy(), A.indptr), shape=A.shape)
    for row in range(A.shape[0]):
        span = slice(A.indptr[row], A.indptr[row + 1])
        mixed.indices[span], mixed.data[span] = A.indices[span][::-1].copy(), A.data[span][::-1].copy()
    found = congruent(T, SideBySide([*BLOCKS[:2], mixed]), own)
    assert (found != congruent(T, SideBySide(BLOCKS), own)).nnz == 0


def test_the_peak_of_joining():
    """K and M of the whole and what meets dependents: 1.2 times K and M; 2.5 with one of them side by side."""
    coords, quads = plate(30, 30)
    model = model_of(
        np.vstack([coords, coords + [0.0, 0.0, 0.1]]),
        [block("quad4", quads, shell(0.001)), block("quad4", quads + len(coords), shell(0.001), 1, 10_000)],
        [("LOWER", range(len(coords))), ("UPPER", range(len(coords), 2 * len(coords)))],
        fixed=[Fixed(np.array([0, 1, len(coords)]), (1, 2, 3))],
    )
    parts = [part_system(model, k, NO_DAMPING) for k in range(2)]
    couple(parts, model, NONE, NO_DAMPING)
    tracemalloc.start()
    joined = couple(parts, model, NONE, NO_DAMPING)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    matrices = 12 * (joined.K.nnz + joined.M.nnz)
    assert peak < 1.35 * matrices
