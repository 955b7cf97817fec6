"""A matrix in pieces, one factor at a time: held to the factor of the whole."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from threadpoolctl import threadpool_limits

from creak.errors import NumericalError
from creak.linalg.factor import SingularMatrixError, factor, regular_factor
from creak.linalg.memory import OVERRIDE, OutOfMemory
from creak.linalg.mkl import has_pardiso
from creak.linalg.modes import modes
from creak.linalg.pieces import factor as module
from creak.linalg.pieces import factor as schur
from creak.linalg.pieces.dissection import Dissection, cut_once_more, whole
from creak.linalg.pieces.factor import PieceFactor, Pieces, Shifted, SymmetricFactor, cut_to_fit

SIDE = 40


def grid(side: int = SIDE, dofs: int = 1) -> sp.csr_matrix:
    """Five-point Laplacian on a square, with several dofs a node that all couple."""
    line = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(side, side))
    plane = sp.kronsum(line, line)
    block = np.full((dofs, dofs), 0.1) + 0.9 * np.eye(dofs)
    return sp.csr_matrix(sp.kron(plane, block))


def cut(A: sp.csr_matrix, count: int) -> Dissection:
    found = whole(A.shape[0])
    while len(found.pieces) < count:
        further = cut_once_more(A, found, len)
        assert further is not None
        found = further
    return found


def in_pieces(A: sp.csr_matrix, count: int, held: int = 1) -> Pieces:
    """Room for the factors of so many pieces."""
    return Pieces(cut(A, count), (1.0,) * count, float(held))


@pytest.mark.parametrize("dofs", [1, 3])
@pytest.mark.parametrize("count", [2, 5])
def test_no_entry_joins_two_pieces_and_the_separator_is_a_line_of_the_grid(count, dofs):
    A = grid(dofs=dofs)
    found = cut(A, count)
    every = np.concatenate([*found.pieces, found.separator])
    np.testing.assert_array_equal(np.sort(every), np.arange(A.shape[0]))
    side = np.full(A.shape[0], -1)
    for k, rows in enumerate(found.pieces):
        side[rows] = k
    where = A.tocoo()
    a, b = side[where.row], side[where.col]
    assert not ((a != b) & (a >= 0) & (b >= 0)).any()
    sizes = [rows.size for rows in found.pieces]
    assert max(sizes) < 3.5 * min(sizes)
    assert found.separator.size <= (count - 1) * 1.6 * SIDE * dofs


def test_bodies_that_nothing_joins_need_no_separator():
    A = sp.block_diag([grid(12)] * 5, format="csr")
    found = cut(A, 2)
    assert found.separator.size == 0
    assert sorted(rows.size for rows in found.pieces) == [288, 432]


def test_what_has_no_separator_is_not_cut():
    full = sp.csr_matrix(np.ones((200, 200)) + 200.0 * np.eye(200))
    assert cut_once_more(full, whole(200), len) is None
    few = sp.csr_matrix(grid(9))
    assert cut_once_more(few, whole(81), len) is None


@pytest.mark.parametrize("held", [1, 3])
@pytest.mark.parametrize("count", [1, 2, 6])
def test_solutions_are_those_of_the_whole(count, held):
    A = grid(dofs=2)
    made, b = PieceFactor(A, in_pieces(A, count, held)), np.random.default_rng(3).standard_normal((A.shape[0], 7))
    expected = factor(A).solve(np.asfortranarray(b))
    for _ in range(3):  # from either end
        np.testing.assert_allclose(made.solve(np.asfortranarray(b)), expected, rtol=1e-10, atol=1e-12)
    out = np.empty(b.shape, order="F")
    assert np.shares_memory(made.solve(np.asfortranarray(b), out), out)
    np.testing.assert_allclose(out, expected, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(made.solve(b[:, 0]), expected[:, 0], rtol=1e-10, atol=1e-12)
    assert made.n_negative == 0


@pytest.mark.parametrize("count", [2, 5])
def test_the_inertia_is_that_of_the_whole(count):
    A, unit = grid(), sp.identity(SIDE**2, format="csr")
    values = np.sort(
        np.add.outer(*[4.0 * np.sin(np.arange(1, SIDE + 1) * np.pi / (2.0 * (SIDE + 1))) ** 2] * 2).ravel()
    )
    shift = 0.5 * (values[36] + values[37])
    made = PieceFactor(A - shift * unit, in_pieces(A, count), definite=False)
    assert made.n_negative == np.count_nonzero(values < shift)
    b = np.random.default_rng(4).standard_normal(SIDE**2)
    np.testing.assert_allclose((A - shift * unit) @ made.solve(b), b, atol=1e-9)
    made.replace(Shifted(A, unit, 2.0 * shift))
    assert made.n_negative == np.count_nonzero(values < 2.0 * shift)
    np.testing.assert_allclose((A - 2.0 * shift * unit) @ made.solve(b), b, atol=1e-9)


@pytest.mark.parametrize("held", [1, 3])
def test_one_factor_is_there_at_a_time_and_the_last_one_serves_again(held, monkeypatch):
    A, made_of = grid(), list[int]()
    monkeypatch.setattr(module, "factor", lambda A, definite=True: made_of.append(A.shape[0]) or factor(A))
    made = PieceFactor(A, in_pieces(A, 4, held))
    assert len(made_of) == 1  # S alone: the pieces give their share in it and are not kept
    b = np.ones(A.shape[0])
    for first in (held, 0, 0):  # nothing is held at first
        before = len(made_of)
        made.solve(b)
        assert len(made_of) - before == 2 * (4 - held) + first
        assert len(made._held) == held
    nothing = np.zeros(A.shape[0])
    nothing[made._list[0].rows[0]] = 1.0  # one piece is loaded
    before = len(made_of)
    made.solve(nothing)
    assert len(made_of) - before <= 4


def test_a_body_that_can_move_freely_is_singular():
    A = grid().tolil()
    A.setdiag(0.0)
    free = sp.csr_matrix(A)
    free.setdiag(-np.asarray(free.sum(axis=1)).ravel())
    pieces = in_pieces(sp.csr_matrix(free), 3)
    assert regular_factor(free, lambda A, definite=True: PieceFactor(A, pieces, definite=definite)) is None
    indefinite = -grid()
    with pytest.raises(SingularMatrixError, match="not positive definite"):
        PieceFactor(indefinite, in_pieces(indefinite, 3))


@pytest.mark.parametrize("count", [3, 4])
def test_modes_are_those_of_the_whole(count):
    K, M = grid(), sp.csr_matrix(sp.diags(1.0 + 0.5 * np.sin(np.arange(SIDE**2))))
    f_max = 0.11
    expected = modes(K, M, f_max=f_max)
    found = modes(K, M, f_max=f_max, pieces=in_pieces(K, count))
    assert 40 < found.omega2.size == expected.omega2.size
    np.testing.assert_allclose(found.omega2, expected.omega2, rtol=1e-10)
    assert found.next_omega2 == pytest.approx(expected.next_omega2, rel=1e-10)
    assert found.residual < 1e-6


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU does not tell what it will need")
def test_pieces_are_cut_until_they_fit_and_least_is_made_again(monkeypatch):
    A = grid(64, dofs=6)
    with threadpool_limits(1):  # PARDISO's work space grows with its threads: at this size to half of the factor
        needed = factor(A).memory
        two = cut_to_fit(A, needed, 0.95 * needed)
        more = cut_to_fit(A, needed, 0.7 * needed)
        least = cut_to_fit(A, needed, 0.02 * needed)
        none = cut_to_fit(A, needed, -needed)
    assert two is not None
    assert more is not None
    assert 1 < two.count <= 6
    assert two.bytes <= 0.95 * needed
    assert more.bytes <= 0.7 * needed
    assert two.made_again < 0.6 * needed  # halves: all of it
    assert two.made_again < more.made_again
    assert least is not None
    assert not least.fits
    assert least.bytes <= more.bytes
    assert none is not None
    assert none.bytes == least.bytes
    monkeypatch.setenv(OVERRIDE, "1e-7")
    with pytest.raises(OutOfMemory, match=r"what joins \d pieces of 24,576 equations: .* GB are needed"):
        PieceFactor(A, two)
    assert issubclass(OutOfMemory, NumericalError)


@pytest.mark.parametrize("pardiso", [True, False])
@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_the_schur_complement(shift, pardiso, monkeypatch):
    """By PARDISO and column by column: equal to the dense formula, with the inertia of the inner block alone."""
    if pardiso and not has_pardiso():
        pytest.skip("no MKL")
    monkeypatch.setattr(schur, "has_pardiso", lambda: pardiso)
    A = (grid(12) - shift * sp.identity(144)).tocsr()
    side = sp.random(144, 21, 0.1, random_state=5, format="csr")
    S, below = schur.schur_complement(A, side, definite=shift == 0.0)
    dense = A.toarray()
    np.testing.assert_allclose(S, -side.T @ np.linalg.solve(dense, side.toarray()), atol=1e-12)
    assert below == np.count_nonzero(np.linalg.eigvalsh(dense) < 0.0)
    assert (below > 0) == (shift > 0.0)


@pytest.mark.parametrize("definite", [True, False])
def test_bodies_that_nothing_joins_are_solved_one_by_one(definite):
    A = sp.block_diag([grid(12)] * 5, format="csr")
    made, b = PieceFactor(A, in_pieces(A, 3), definite=definite), np.random.default_rng(6).standard_normal(A.shape[0])
    assert made.n_negative == 0
    np.testing.assert_allclose(A @ made.solve(b), b, atol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3, 40, 120])
@pytest.mark.parametrize("hollow", [False, True])
def test_a_dense_indefinite_matrix_in_its_own_memory(n, hollow):
    """Without a diagonal pivots come in blocks of two rows."""
    A = np.random.default_rng(n).standard_normal((n, n))
    A += A.T
    if hollow and n > 1:
        np.fill_diagonal(A, 0.0)
    found = SymmetricFactor(np.asfortranarray(A))
    b = np.random.default_rng(1).standard_normal((n, 3))
    np.testing.assert_allclose(A @ found.solve(b), b, atol=1e-9)
    np.testing.assert_allclose(A @ found.solve(b[:, 0]), b[:, 0], atol=1e-9)
    assert found.n_negative == np.count_nonzero(np.linalg.eigvalsh(A) < 0.0)


def test_a_dense_singular_matrix_is_refused():
    with pytest.raises(SingularMatrixError, match="dense matrix is singular at row 0"):
        SymmetricFactor(np.zeros((3, 3), order="F"))
