"""Factors on a GPU as `factor` and `complex_factor` make them: by cuDSS, through nvmath-python (the extra `gpu`).

`nvmath.sparse.advanced.DirectSolver` takes a CSR matrix of SciPy and a right side of NumPy, copies both to the device,
plans, factorises, and then solves for each right side that `reset_operands` hands over. A right side keeps the shape
that it had at first, so blocks are solved column by column. Written for nvmath-python 1.0.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix
from creak.errors import NumericalError, first_line
from creak.linalg.factor import _upper

T = TypeVar("T")

NOT_INSTALLED = "nvmath-python is not installed"
NO_ROOM = ("ALLOC_FAILED", "OUT_OF_MEMORY", "out of memory")
"""What cuDSS and the driver say where the memory of the device is too small."""
TRIAL = 1e-8
"""Largest error of a trial solution that a factor may have, over its largest entry."""


class DeviceFailed(NumericalError):
    """The GPU did not do what it was asked for; says why in a few words."""


def _asked(what: Callable[[], T]) -> T:
    """What is asked of the device; whatever goes wrong becomes a `DeviceFailed`."""
    try:
        return what()
    except Exception as problem:  # cuDSS, the driver and nvmath-python each have errors of their own
        said = first_line(problem)
        small = isinstance(problem, MemoryError) or any(word in said for word in NO_ROOM)
        raise DeviceFailed("its memory is too small" if small else said) from problem


@lru_cache(maxsize=1)
def no_cudss() -> str:
    """Why cuDSS cannot be used; empty where it has solved two equations."""
    if find_spec("nvmath") is None:
        return NOT_INSTALLED
    try:
        CudssFactor(sp.csr_matrix(np.array([[2.0, 1.0], [1.0, 2.0]])))
    except DeviceFailed as problem:
        return f"cuDSS cannot be used: {problem}"
    return ""


def device_name() -> str:
    """What the device is called.

    Raises
    ------
    DeviceFailed : there is none.
    """

    def asked() -> str:
        from cuda.core import Device

        return str(Device(0).name)

    return _asked(asked)


class _Quiet:
    """In place of a logger, which would write hints of nvmath-python to the terminal."""

    def isEnabledFor(self, level: int) -> bool:
        return False

    def info(self, *said: object, **more: object) -> None:
        """Not told."""

    debug = warning = error = critical = info


class CudssFactor:
    """A sparse symmetric matrix on the first GPU: L L', or L D L' where it is complex or not `definite`.

    Its equations are scaled to a diagonal of ones, for cuDSS takes pivots below 1e-13 for that number, whatever the
    units, and says so of none: a trial solution shows whether that, or anything else, has spoilt the factor.

    `memory` is what it holds on the device, bytes; `n_negative` counts negative eigenvalues where it is not `definite`.

    Parameters
    ----------
    A : (n, n) SciPy sparse, real or complex; both triangles stored.

    Raises
    ------
    DeviceFailed : no device, not enough memory there, a pivot vanished or was negative although `definite`.
    """

    def __init__(self, A: Matrix, definite: bool = True) -> None:
        upper = _upper(A)
        size = np.abs(upper.diagonal())
        self._scale: FloatArray = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
        upper.data = upper.data * np.repeat(self._scale, np.diff(upper.indptr))
        upper.data *= self._scale[upper.indices]
        self._type = upper.dtype
        definite = definite and self._type == np.float64
        self._solver, self.memory = _asked(lambda: _factorised(upper, definite))
        indefinite = not definite and self._type == np.float64
        self.n_negative = int(_asked(lambda: self._solver.factorization_info.inertia)[1]) if indefinite else 0
        self._try(upper)

    def _try(self, upper: Any) -> None:
        x = np.random.default_rng(7).standard_normal(upper.shape[0]).astype(self._type)
        b = upper @ x + upper.T @ x - upper.diagonal() * x
        error = np.abs(self._solved(b) - x).max() / np.abs(x).max()
        if not error <= TRIAL:
            raise DeviceFailed(f"a trial solution was wrong by {error:.0e}")

    def _solved(self, b: Any) -> Any:
        """Of the scaled equations."""
        _asked(lambda: self._solver.reset_operands(b=b))
        return _asked(self._solver.solve)

    def solve(self, b: Any, out: Any = None) -> Any:
        """x with A x = b, (n,) or (n, k), in Fortran order.

        Raises
        ------
        DeviceFailed : the device is lost.
        """
        if b.ndim == 1:
            return self._scale * self._solved(np.multiply(self._scale, b, dtype=self._type))
        x = np.empty(b.shape, dtype=self._type, order="F")
        for j in range(b.shape[1]):
            x[:, j] = self.solve(b[:, j])
        return x

    def __del__(self) -> None:
        if hasattr(self, "_solver") and not sys.is_finalizing():
            with suppress(Exception):  # of a device that is lost the memory is, too
                self._solver.free()


def _factorised(upper: Any, definite: bool) -> tuple[Any, float]:
    """The solver of an upper triangle, ready for right sides, and the bytes that it holds on the device."""
    from nvmath.sparse import advanced

    kinds = advanced.DirectSolverMatrixType
    options = advanced.DirectSolverOptions(
        sparse_system_type=kinds.SPD if definite else kinds.SYMMETRIC,
        sparse_system_view=advanced.DirectSolverMatrixViewType.UPPER,
        logger=_Quiet(),
        blocking=True,
    )
    b = np.zeros(upper.shape[0], dtype=upper.dtype)
    solver = advanced.DirectSolver(upper, b, options=options, execution=advanced.ExecutionCUDA(device_id=0))
    try:
        memory = float(solver.plan().memory_estimates.permanent_device_memory)
        wrong = solver.factorize().info
        if wrong:
            raise DeviceFailed(f"a pivot vanished or was negative (cuDSS code {wrong})")
    except BaseException:
        solver.free()
        raise
    return solver, memory
