"""A stand-in for nvmath.sparse.advanced 1.0 and cuDSS: SuperLU behind their interface, as strict as they are.

What is checked and raised is what the sources of nvmath-python 1.0 check and raise; of cuDSS that pivots below 1e-13 are
replaced without a word, and that the memory of a device has an end.
"""

from __future__ import annotations

import enum
import logging
import sys
import types
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.machinery import ModuleSpec
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from creak.linalg.cudss import no_cudss

SMALLEST = 1e-13
ESTIMATES = np.dtype(
    [(f"{when}_{where}_memory", "<u8") for where in ("device", "host") for when in ("permanent", "peak")]
)


class DirectSolverMatrixType(enum.IntEnum):
    GENERAL, SYMMETRIC, HERMITIAN, SPD, HPD = range(5)


class DirectSolverMatrixViewType(enum.IntEnum):
    FULL, LOWER, UPPER = range(3)


class cuDSSError(Exception):
    """Of nvmath.bindings.cudss."""


@dataclass
class DirectSolverOptions:
    sparse_system_type: int = DirectSolverMatrixType.GENERAL
    sparse_system_view: int = DirectSolverMatrixViewType.FULL
    multithreading_lib: str | None = None
    logger: Any = None
    blocking: Any = "auto"
    handle: int | None = None


@dataclass(frozen=True, kw_only=True)
class ExecutionCUDA:
    device_id: int = 0
    hybrid_memory_mode_options: object = None


@dataclass
class FakeGpu:
    """The device: what its memory holds, what it was asked for, and whether it still answers."""

    room: float = float("inf")
    held: float = 0.0
    most: float = 0.0
    solves: int = 0
    kinds: list[tuple[str, str]] = field(default_factory=list)
    """Of each factor: type of system, type of numbers."""
    fails_after: float = float("inf")
    """Solves that it lives."""

    def take(self, size: float) -> None:
        if self.held + size > self.room:
            raise cuDSSError("ALLOC_FAILED (2)")
        self.held += size
        self.most = max(self.most, self.held)


def solver_on(gpu: FakeGpu) -> type:
    """The class DirectSolver of a device."""

    class DirectSolver:
        def __init__(self, a: Any, b: Any, *, options: Any = None, execution: Any = None, stream: Any = None) -> None:
            self._options = options or DirectSolverOptions()
            if not (sp.issparse(a) and a.format == "csr" and a.shape[0] == a.shape[1]):
                raise TypeError("The LHS must be a CSR matrix of shape (N, N)")
            if str(a.dtype) not in ("float32", "float64", "complex64", "complex128"):
                raise TypeError(f"The dtype (value type) {a.dtype} is not supported.")
            if str(a.indices.dtype) not in ("int32", "int64") or a.indptr.dtype != a.indices.dtype:
                raise TypeError("The index type is not supported.")
            assert a.has_sorted_indices
            if self._options.sparse_system_view == DirectSolverMatrixViewType.UPPER:
                assert sp.tril(a, -1).nnz == 0
            self._check_layout(b)
            if b.shape[0] != a.shape[0]:
                raise TypeError("The extent N is not consistent between the LHS and RHS.")
            if b.dtype != a.dtype:
                raise TypeError(f"The LHS dtype {a.dtype} does not match the RHS dtype {b.dtype}.")
            assert execution.device_id == 0
            self._a, self._b, self._shape, self._strides = a.copy(), b.copy(), b.shape, b.strides
            logger = self._options.logger or logging.getLogger()
            logger.info("The sparse direct solver operation has been created.")
            logger.warning("No multithreading interface library was specified using the DirectSolverOptions.")
            self._planned = self._lu = None
            self._size, self._valid = 0.0, True
            self.factorization_info = types.SimpleNamespace(info=0, inertia=None)

        @staticmethod
        def _check_layout(b: Any) -> None:
            if type(b) is not np.ndarray:
                raise TypeError("The package for 'b' doesn't match.")
            if b.strides[0] != b.itemsize:
                raise TypeError("The RHS must be a matrix or vector with col-major layout")

        def _alive(self) -> None:
            if not self._valid:
                raise RuntimeError("The DirectSolver object cannot be used after resources are free'd")

        def plan(self, *, stream: Any = None) -> Any:
            self._alive()
            self._planned = True
            self._size = 24.0 * self._a.nnz
            estimates = np.zeros((), dtype=ESTIMATES).view(np.recarray)
            estimates.permanent_device_memory = int(self._size)
            return types.SimpleNamespace(memory_estimates=estimates)

        def factorize(self, *, stream: Any = None) -> Any:
            self._alive()
            if not self._planned:
                raise RuntimeError("Factorization cannot be performed before plan() has been called.")
            kind = DirectSolverMatrixType(self._options.sparse_system_type)
            assert kind in (DirectSolverMatrixType.SYMMETRIC, DirectSolverMatrixType.SPD)
            gpu.take(self._size)
            gpu.kinds.append((kind.name, str(self._a.dtype)))
            whole = sp.csc_matrix(self._a + self._a.T - sp.diags_array(self._a.diagonal()))
            self._lu, pivots = _without_pivoting(whole)
            negative = np.flatnonzero(pivots.real < 0.0)
            self.factorization_info.inertia = np.array([pivots.size - negative.size, negative.size], dtype=np.int32)
            if kind == DirectSolverMatrixType.SPD and negative.size:
                self.factorization_info.info = int(negative[0]) + 1
            return self.factorization_info

        def reset_operands(self, *, a: Any = None, b: Any = None, stream: Any = None) -> None:
            self._alive()
            assert a is None
            self._check_layout(b)
            if (b.shape, b.strides, b.dtype) != (self._shape, self._strides, self._b.dtype):
                raise TypeError("shape, strides or dtype of 'b' don't match the original ones")
            self._b = b.copy()

        def solve(self, *, stream: Any = None) -> Any:
            self._alive()
            if self._lu is None:
                raise RuntimeError("Solver cannot be performed before factorize() has been called.")
            gpu.solves += 1
            if gpu.solves > gpu.fails_after:
                raise cuDSSError("EXECUTION_FAILED (5)")
            return self._lu.solve(self._b)

        def free(self) -> None:
            if self._valid and self._lu is not None:
                gpu.held -= self._size
            self._valid, self._lu = False, None

    return DirectSolver


def _without_pivoting(A: Any) -> tuple[Any, Any]:
    """A factor and its pivots; where one is below `SMALLEST`, that of A with as much on its diagonal."""
    how = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    more = sp.csc_matrix(A + SMALLEST * sp.identity(A.shape[0]))
    try:
        lu = spla.splu(A, **how)
    except RuntimeError:  # a pivot of zero
        lu = spla.splu(more, **how)
    if np.abs(lu.U.diagonal()).min() < SMALLEST:
        lu = spla.splu(more, **how)
    return lu, lu.U.diagonal()


def stand_in(monkeypatch: pytest.MonkeyPatch) -> Iterator[FakeGpu]:
    """A device, and nvmath-python that knows it; for a fixture."""
    device = FakeGpu()
    advanced = _module("nvmath.sparse.advanced")
    for one in (DirectSolverMatrixType, DirectSolverMatrixViewType, DirectSolverOptions, ExecutionCUDA):
        setattr(advanced, one.__name__, one)
    advanced.DirectSolver = solver_on(device)
    sparse, core = _module("nvmath.sparse"), _module("cuda.core")
    sparse.advanced = advanced
    core.Device = lambda number: types.SimpleNamespace(name="a stand-in")
    for one in (_module("nvmath"), sparse, advanced, _module("cuda"), core):
        monkeypatch.setitem(sys.modules, one.__name__, one)
    no_cudss.cache_clear()
    assert no_cudss() == ""
    device.solves, device.kinds = 0, []
    yield device
    no_cudss.cache_clear()


def _module(name: str) -> Any:
    made = types.ModuleType(name)
    made.__spec__ = ModuleSpec(name, None)
    made.__path__ = []
    return made
