"""Factors of cuDSS, on a stand-in that is as strict as nvmath-python, and the names of the real one where it is there."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import scipy.sparse as sp

from creak.linalg import cudss
from creak.linalg.cudss import CudssFactor, DeviceFailed, no_cudss
from helpers_cudss import stand_in

N = 80


def random(rng: np.random.Generator) -> sp.csr_matrix:
    return sp.random(N, N, 0.08, random_state=rng, format="csr")


def definite() -> sp.csr_matrix:
    B = random(np.random.default_rng(3))
    return sp.csr_matrix(B @ B.T + sp.diags_array(np.random.default_rng(4).uniform(0.5, 1.0, N)))


def indefinite() -> sp.csr_matrix:
    return sp.csr_matrix(definite() - 1.2 * sp.identity(N))


def accretive() -> sp.csr_matrix:
    C = random(np.random.default_rng(5))
    return sp.csr_matrix(definite() + 1j * (C + C.T))


KINDS = {"definite": definite, "indefinite": indefinite, "complex": accretive}
SYSTEMS = {
    "definite": ("SPD", "float64"),
    "indefinite": ("SYMMETRIC", "float64"),
    "complex": ("SYMMETRIC", "complex128"),
}


@pytest.fixture
def gpu(monkeypatch):
    yield from stand_in(monkeypatch)


@pytest.mark.parametrize("columns", [None, 1, 5])
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_solves(kind, columns, gpu, caplog):
    A = KINDS[kind]()
    x = np.random.default_rng(1).standard_normal((N,) if columns is None else (N, columns))
    b = A @ x  # in C order
    before = b.copy()
    found = CudssFactor(A, definite=kind != "indefinite")
    np.testing.assert_allclose(found.solve(b), x, atol=1e-10)
    np.testing.assert_array_equal(b, before)
    np.testing.assert_allclose(A @ found.solve(np.ones(x.shape)), np.ones(x.shape), atol=1e-10)
    assert gpu.kinds == [SYSTEMS[kind]]
    assert caplog.records == []


def test_inertia(gpu):
    negative = np.count_nonzero(np.linalg.eigvalsh(indefinite().toarray()) < 0.0)
    assert 0 < negative < N
    assert CudssFactor(indefinite(), definite=False).n_negative == negative
    assert CudssFactor(definite()).n_negative == 0


@pytest.mark.parametrize("kind", ["definite", "complex"])
def test_small_numbers_are_no_small_pivots(kind, gpu):
    """Tonnes, mm and s: translations of a gram, rotations of a thin shell. cuDSS would put 1e-13 in their place."""
    units = sp.diags_array(np.where(np.arange(N) % 2, 1e-4, 1e-9))
    A = sp.csr_matrix(units @ KINDS[kind]() @ units)
    x = np.random.default_rng(2).standard_normal(N)
    np.testing.assert_allclose(CudssFactor(A).solve(A @ x), x, atol=1e-9)


def test_memory_is_given_back(gpu):
    found = CudssFactor(definite())
    assert found.memory == gpu.held > 0.0
    del found
    assert gpu.held == 0.0


def test_too_little_memory(gpu):
    gpu.room = 100.0
    with pytest.raises(DeviceFailed, match=r"^its memory is too small$"):
        CudssFactor(definite())
    assert gpu.held == 0.0


def without_row(A: sp.csr_matrix) -> sp.csr_matrix:
    A = sp.lil_matrix(A)
    A[3, :], A[:, 3] = 0.0, 0.0
    return sp.csr_matrix(A)


def free_in_space() -> sp.csr_matrix:
    """A chain that nothing holds."""
    ones = np.ones(N - 1)
    K = sp.diags_array([ones, ones], offsets=[1, -1])
    return sp.csr_matrix(sp.diags_array(np.asarray(K.sum(axis=1)).ravel()) - K)


@pytest.mark.parametrize("A", [without_row(definite()), without_row(accretive()), free_in_space()], ids=str)
def test_what_cudss_says_nothing_of_is_found(A, gpu):
    """A pivot that vanished and was replaced."""
    with pytest.raises(DeviceFailed, match=r"a trial solution was wrong by|a pivot vanished"):
        CudssFactor(A)
    assert gpu.held == 0.0


def test_a_matrix_that_is_not_definite_is_refused(gpu):
    with pytest.raises(DeviceFailed, match="a pivot vanished or was negative"):
        CudssFactor(indefinite())
    assert gpu.held == 0.0


def test_a_device_that_is_lost(gpu):
    found = CudssFactor(definite())
    gpu.fails_after = gpu.solves
    with pytest.raises(DeviceFailed, match=r"EXECUTION_FAILED"):
        found.solve(np.ones(N))


def test_what_is_told_of_this_machine(monkeypatch):
    monkeypatch.setattr(cudss, "find_spec", lambda name: None)
    assert no_cudss.__wrapped__() == "nvmath-python is not installed"

    def broken(*_):
        raise OSError("libcudss.so.0: cannot open shared object file\nmore of it")

    monkeypatch.setattr(cudss, "find_spec", lambda name: name)
    monkeypatch.setattr(cudss, "_factorised", broken)
    assert no_cudss.__wrapped__() == "cuDSS cannot be used: libcudss.so.0: cannot open shared object file"


# --- the real package ------------------------------------------------------------------------------------------------


def test_the_real_package_has_what_is_used():
    """It can be imported without a GPU; its host side takes the operands that are handed over."""
    advanced = pytest.importorskip("nvmath.sparse.advanced", reason="nvmath-python is not installed")
    parameters = {
        name: list(inspect.signature(getattr(advanced.DirectSolver, name)).parameters)[1:]
        for name in ("__init__", "plan", "factorize", "reset_operands", "solve", "free")
    }
    assert parameters["__init__"][:4] == ["a", "b", "options", "execution"]
    assert "b" in parameters["reset_operands"]
    advanced.DirectSolverOptions(
        sparse_system_type=advanced.DirectSolverMatrixType.SPD,
        sparse_system_view=advanced.DirectSolverMatrixViewType.UPPER,
        logger=cudss._Quiet(),
        blocking=True,
    )
    assert advanced.ExecutionCUDA(device_id=0).name == "cuda"
    assert "permanent_device_memory" in advanced.memory_estimates_dtype.names
    assert {"info", "inertia"} <= set(dir(advanced.DirectSolverFactorizationInfo))
    assert "memory_estimates" in dir(advanced.DirectSolverPlanInfo)
    from nvmath.bindings.cudss import cuDSSError

    assert str(cuDSSError(2)) == "ALLOC_FAILED (2)"
    wrap = inspect.getmodule(advanced.DirectSolver).wrap_cudss_supported_lhs
    for A in (definite(), accretive()):
        held = wrap(cudss._upper(A))
        assert (held.format_name, held.index_type, held.dtype) == ("CSR", "int32", str(A.dtype))
