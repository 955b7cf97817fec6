"""All backends of `factor` give the same answer and name the row where a matrix is singular."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import SingularMatrixError, _PardisoFactor, _SuperLUFactor, factor, refactor, regular_factor
from creak.linalg.mkl import has_pardiso


def spd(n: int = 60, seed: int = 0) -> sp.csr_matrix:
    rng = np.random.default_rng(seed)
    B = sp.random(n, n, 0.1, random_state=rng, format="csr")
    return sp.csr_matrix(B @ B.T + sp.diags_array(rng.uniform(1.0, 2.0, n)))


def free_chain(n: int, stiffness: float = 1.0) -> sp.csr_matrix:
    """n masses in a row, held by nothing."""
    d = np.full(n, 2.0)
    d[[0, -1]] = 1.0
    return stiffness * sp.diags_array([d, -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1]).tocsr()


BACKENDS = {
    "sparse": lambda A, definite: factor(A, definite=definite),
    "superlu": _SuperLUFactor,
    "dense": lambda A, definite: factor(A.toarray(), definite=definite),
}
backends = pytest.mark.parametrize("backend", sorted(BACKENDS))


def test_pardiso_is_used_where_it_is_installed():
    name = type(factor(spd())).__name__
    assert name == ("_PardisoFactor" if has_pardiso() else "_SuperLUFactor")


@backends
@pytest.mark.parametrize("definite", [True, False])
@pytest.mark.parametrize("shape", [(60,), (60, 1), (60, 7)])
def test_backends_solve_alike(backend, definite, shape):
    A = spd()
    x = np.random.default_rng(1).standard_normal(shape)
    found = BACKENDS[backend](A, definite).solve(A @ x)
    assert found.shape == shape
    np.testing.assert_allclose(found, x, atol=1e-12)  # round-off of a well conditioned matrix


@backends
def test_small_numbers_are_no_small_pivots(backend):
    """Tonnes, mm and s: translations of a gram beside rotations of a thin shell."""
    units = sp.diags_array(np.where(np.arange(60) % 2, 1e-4, 1e-9))
    A = sp.csr_matrix(units @ spd() @ units)
    x = np.random.default_rng(2).standard_normal(60)
    np.testing.assert_allclose(BACKENDS[backend](A, True).solve(A @ x), x, atol=1e-9)


@backends
def test_inertia_counts_the_negative_eigenvalues(backend):
    A = spd()
    values = np.linalg.eigvalsh(A.toarray())
    for k in (0, 1, 17, 60):
        shift = 0.5 * (values[k - 1] + values[k]) if 0 < k < 60 else (values[0] - 1 if k == 0 else values[-1] + 1)
        shifted = sp.csr_matrix(A - shift * sp.identity(60))
        assert BACKENDS[backend](shifted, False).n_negative == k


@backends
def test_another_matrix_in_the_place_of_the_first(backend):
    """The inertia and the solution are those of a factor from the start; another pattern is no obstacle."""
    A, x = spd(), np.random.default_rng(1).standard_normal((60, 3))
    values = np.linalg.eigvalsh(A.toarray())
    found = BACKENDS[backend](A, False)
    for k, extra in ((20, 0.0), (41, 0.0), (41, 1e-3)):
        B = sp.csr_matrix(A - 0.5 * (values[k - 1] + values[k]) * sp.identity(60))
        B = B + sp.csr_matrix(([extra, extra], ([0, 59], [59, 0])), shape=B.shape) if extra else B
        found = refactor(found, B.toarray() if backend == "dense" else B)
        assert found.n_negative == k
        np.testing.assert_allclose(found.solve(B @ x), x, atol=1e-9)


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU analyses with the numbers")
def test_one_analysis_serves_a_pattern(monkeypatch):
    phases: list[int] = []
    call = _PardisoFactor._call
    monkeypatch.setattr(
        _PardisoFactor, "_call", lambda self, phase, *more: (phases.append(phase), call(self, phase, *more))
    )
    A = spd()
    first = factor(A, definite=False)
    assert refactor(first, sp.csr_matrix(A - 0.1 * sp.identity(60))) is first
    assert phases == [11, 22, 22]


@backends
def test_indefinite_matrix_is_refused_where_a_definite_one_is_needed(backend):
    A = spd().tolil()
    A[7, 7] = -5.0
    with pytest.raises(SingularMatrixError, match="not positive definite"):
        BACKENDS[backend](sp.csr_matrix(A), True)


def test_singular_row_is_named():
    K = np.diag([2.0, 3.0, 0.0, 1.0])
    with pytest.raises(SingularMatrixError, match="not positive definite") as dense:
        factor(K)
    assert dense.value.row == 2
    with pytest.raises(SingularMatrixError, match=r"pivot 0 in row 2"):
        factor(Diagonal(np.diag(K)))
    with pytest.raises(SingularMatrixError, match="matrix has an empty row 2"):
        factor(sp.csr_matrix(K))
    assert issubclass(SingularMatrixError, NumericalError)


@pytest.mark.parametrize("row", [0, 2, 29, 199])
def test_row_of_a_dense_matrix_is_that_of_the_first_bad_minor(row):
    """The minors before it are those of a positive definite matrix; LAPACK counts them, no text is read."""
    A = spd(200).toarray()
    A[row, row] = -1.0
    with pytest.raises(SingularMatrixError, match=rf"not positive definite at row {row}$") as found:
        factor(A)
    assert found.value.row == row


def test_dense_matrices_hold_finite_numbers():
    with pytest.raises(ValueError, match="infs or NaNs"):
        factor(np.array([[1.0, np.nan], [np.nan, 1.0]]))


def test_sparse_matrix_with_an_empty_row_is_named():
    A = sp.csr_matrix(np.diag([1.0, 0.0, 1.0]))
    A.eliminate_zeros()
    with pytest.raises(SingularMatrixError, match="matrix has an empty row 1") as found:
        factor(A)
    if has_pardiso():
        assert found.value.row == 1


def test_diagonal_matrix_solves_by_division():
    d = np.array([1.0, 4.0, -2.0])
    f = factor(Diagonal(d), definite=False)
    assert f.n_negative == 1
    np.testing.assert_array_equal(f.solve(np.array([2.0, 2.0, 2.0])), [2.0, 0.5, -1.0])
    np.testing.assert_array_equal(f.solve(np.ones((3, 2))), np.array([[1.0, 1], [0.25, 0.25], [-0.5, -0.5]]))
    D = Diagonal(d)
    np.testing.assert_array_equal(D @ np.ones((3, 2)), np.repeat(d[:, None], 2, axis=1))
    np.testing.assert_array_equal((2.0 * D + D).toarray(), 3 * np.diag(d))
    assert D.T is D
    assert D.shape == (3, 3)


@pytest.mark.parametrize("n", [50, 1000, 100_000])
@pytest.mark.parametrize("stiffness", [1.0, 0.3, 7.123e5])
def test_body_that_can_move_freely_is_found_singular_at_any_size(n, stiffness):
    """Round-off hides the zero pivot and a random trial vector holds only 1/sqrt(n) of the free motion."""
    assert regular_factor(free_chain(n, stiffness)) is None


@pytest.mark.parametrize("n", [50, 1000, 20_000])
def test_held_body_is_regular_although_badly_conditioned(n):
    """One end held: condition 4 n^2, up to 1.6e9."""
    K = free_chain(n)[1:][:, 1:]
    found = regular_factor(sp.csr_matrix(K))
    assert found is not None
    # Unit force at the free end: deflection n - 1 there.
    force = np.zeros(n - 1)
    force[-1] = 1.0
    assert found.solve(force)[-1] == pytest.approx(n - 1, rel=1e-6)


@pytest.mark.skipif(not has_pardiso(), reason="PARDISO is not installed")
def test_pardiso_tells_the_memory_of_its_factor():
    """A tridiagonal matrix fills nothing in: between the diagonal and a band of one, in any ordering of a tree."""
    n = 5000
    found = factor(free_chain(n + 1)[1:][:, 1:])
    assert 8 * n <= found.nbytes <= 8 * 20 * n  # supernodes are padded


@pytest.mark.parametrize("order", ["C", "F"])
def test_wide_blocks_come_back_in_fortran_order_and_leave_the_right_hand_side_alone(order):
    A = spd()
    b = np.array(np.random.default_rng(3).standard_normal((60, 9)), order=order)
    kept = b.copy()
    x = factor(A).solve(b)
    np.testing.assert_array_equal(b, kept)
    np.testing.assert_allclose(A @ x, b, atol=1e-12)
    if has_pardiso():
        assert x.flags.f_contiguous


def test_a_model_that_cannot_move_is_named():
    with pytest.raises(NumericalError, match="no degree of freedom that can move: supports hold every node"):
        factor(sp.csr_matrix((0, 0)))
