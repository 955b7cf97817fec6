"""A part too large for memory, reduced in pieces: the superelement that the part gives in one."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.arrays import to_dense
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.factor import factor, factor_bytes
from creak.linalg.memory import OVERRIDE, OutOfMemory
from creak.linalg.mkl import has_pardiso
from creak.linalg.pieces.dissection import cut_once_more, whole
from creak.linalg.pieces.factor import Pieces
from creak.model.constraints import RigidLink
from creak.reduction import inside as limits
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.health import health
from creak.reduction.inside import Inside
from helpers_core import NO_DAMPING, block, model_of, nodes_of, part_system, plate, point_mass, shell

LONG, WIDE = 26, 9
F_MAX = 1500.0
COUNT = 4


def in_pieces(K: sp.csr_matrix, M: sp.csr_matrix, count: int = COUNT) -> Pieces:
    A = sp.csr_matrix(abs(K) + abs(M))
    found = whole(A.shape[0])
    while len(found.pieces) < count:
        further = cut_once_more(A, found, len)
        assert further is not None
        found = further
    return Pieces(found, (1.0,) * count, 1.0)


def refused(A: sp.csr_matrix, **_: object) -> None:
    raise OutOfMemory("too large")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory holds a factor of a piece alone."""
    monkeypatch.setattr("creak.reduction.inside.factor", refused)
    monkeypatch.setattr("creak.reduction.inside.pieces_of", in_pieces)


@pytest.fixture(scope="module")
def part() -> System:
    """A plate, free in space, with a rigid link across it, and a mass that has no inertia about its axes on an arm."""
    coords, quads = plate(LONG, WIDE, (0.52, 0.17))
    n = len(coords)
    coords = np.vstack([coords, [0.3, 0.05, 0.06]])
    blocks = [
        block("quad4", quads, shell(1e-3)),
        block("mass", np.array([[n]]), point_mass(0.05), 0, 1000),
    ]
    links = [RigidLink("tie", n, at(15, 3)), RigidLink("tie", at(20, 2), at(20, 7))]
    return part_system(model_of(coords, blocks, [("A", range(n + 1))], constraints=links), 0, NO_DAMPING)


def at(i: int, j: int) -> int:
    return i * (WIDE + 1) + j


def boundary(part: System) -> np.ndarray:
    """Three corners, and two nodes on a line of the plate that may be a separator."""
    return np.flatnonzero(np.isin(part.coordinates // 6, [at(0, 0), at(0, WIDE), at(LONG, 0), at(13, 4), at(13, 5)]))


def test_the_superelement_is_the_same(part, short, monkeypatch):
    b = boundary(part)
    found = craig_bampton(part, b, f_max=F_MAX)
    monkeypatch.setattr("creak.reduction.inside.factor", factor)
    expected = craig_bampton(part, b, f_max=F_MAX)
    n = expected.stats.retained
    assert found.stats.modes == expected.stats.modes > 40
    assert found.stats.first_left_out == pytest.approx(expected.stats.first_left_out, rel=1e-8)
    K, M, K0, M0 = (to_dense(A) for A in (found.K, found.M, expected.K, expected.M))
    for A, A0 in ((K, K0), (M, M0)):
        np.testing.assert_allclose(A[:n, :n], A0[:n, :n], atol=1e-9 * np.abs(A0[:n, :n]).max())  # round-off
    np.testing.assert_allclose(np.diag(K)[n:], np.diag(K0)[n:], rtol=1e-8)
    np.testing.assert_allclose(np.abs(M[n:, :n]), np.abs(M0[n:, :n]), atol=1e-6 * np.abs(M0[n:, :n]).max())  # signs
    q = np.zeros((found.n, n))
    q[:n] = np.eye(n)
    moved = expected.recover(q)
    np.testing.assert_allclose(found.recover(q), moved, atol=1e-9 * np.abs(moved).max())
    labels = part.labels[5::97]
    np.testing.assert_allclose(
        to_dense(found.rows(labels)[0])[:, :n], to_dense(expected.rows(labels)[0])[:, :n], atol=1e-9
    )


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU does not tell what it will need")
def test_memory_alone_decides(part, monkeypatch):
    """Too little for a factor in one, modes window by window besides: frequencies the same to 1e-8."""
    b = boundary(part)
    inside = Inside(part, b)
    expected = craig_bampton(part, b, f_max=F_MAX, inside=inside)
    K, M = inside.K_ii, inside.M_ii
    monkeypatch.setattr(limits, "PLENTY", 0.0)
    free = limits.beside_pieces(K.shape[0], M.nnz) + 0.95 * factor_bytes(K)
    monkeypatch.setenv(OVERRIDE, f"{free / 1e9:.9f}")
    inside = Inside(part, b)
    found = craig_bampton(part, b, f_max=F_MAX, inside=inside)
    assert inside.pieces is not None
    assert inside.pieces.bytes < 0.95 * factor_bytes(K)
    n = expected.stats.retained
    np.testing.assert_allclose(found.K.diagonal()[n:], expected.K.diagonal()[n:], rtol=1e-8)


def test_its_health_is_that_of_the_part_in_one(part, short, monkeypatch):
    b = boundary(part)
    inside = Inside(part, b)
    reduced = craig_bampton(part, b, f_max=F_MAX, inside=inside)
    nodes = nodes_of(np.vstack([plate(LONG, WIDE, (0.52, 0.17))[0], [0.3, 0.05, 0.06]]))
    told = health(part, reduced, inside, nodes, f_excitation=100.0, own_modes=False)
    assert inside.pieces is not None
    monkeypatch.setattr("creak.reduction.inside.factor", factor)
    whole = Inside(part, b)
    expected = health(part, craig_bampton(part, b, f_max=F_MAX, inside=whole), whole, nodes, own_modes=False)
    assert told.good, told.verdict
    assert told.fixed.residual < 1e-6
    np.testing.assert_allclose(told.free.reduced, expected.free.reduced, rtol=1e-7)
    np.testing.assert_allclose(told.free.estimate, expected.free.estimate, rtol=1e-4, atol=1e-9)


def test_without_modes(part, short):
    """Guyan: no eigenproblem, the constraint modes alone."""
    b = boundary(part)
    found = craig_bampton(part, b, count=0)
    K, i = part.K.toarray(), np.setdiff1d(np.arange(part.n), b)
    condensed = K[np.ix_(b, b)] - K[np.ix_(b, i)] @ np.linalg.solve(K[np.ix_(i, i)], K[np.ix_(i, b)])
    np.testing.assert_allclose(to_dense(found.K), condensed, atol=1e-9 * np.abs(condensed).max())


def test_a_part_that_its_retained_dofs_do_not_hold_is_told_so(part, short):
    with pytest.raises(NumericalError, match="its 3 retained dofs do not hold it"):
        craig_bampton(part, np.flatnonzero(part.coordinates // 6 == 0)[:3], f_max=F_MAX)
