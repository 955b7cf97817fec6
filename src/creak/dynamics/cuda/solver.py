"""Factors of unreduced runs on what is there: a GPU where it can, else the cores."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import scipy.sparse as sp

from creak.arrays import Matrix
from creak.errors import InputError
from creak.linalg.cudss import NOT_INSTALLED, CudssFactor, DeviceFailed, device_name, no_cudss

if TYPE_CHECKING:
    from creak.dynamics.cuda.device import Device

LARGE = 100_000
"""Unknowns from which on a GPU is taken by itself: of fewer a back-substitution is below 20 ms on two cores, of which
launches and copies would take a good part. Not measured on a device."""
HOW = "pip install 'creak[gpu]' 'nvmath-python[cu12]' (or cu13), and a driver of CUDA 12 or newer."


def check_solver(device: Device) -> None:
    """Refuse a GPU that is not there.

    Raises
    ------
    InputError : `device` is "gpu" and none can solve.
    """
    reason = no_cudss() if device == "gpu" else ""
    if reason:
        expected = "a GPU of NVIDIA with nvmath-python and cuDSS"
        raise InputError(f"device gpu: {reason}", expected=expected, fix=f"{HOW} Or: cpu.")


class Solver:
    """Makes the factors of a run, a `step_matrix.Maker`, and counts which were made where.

    Sparse matrices go to the GPU where that is asked for, or where they are large. What it cannot do the cores do, and
    what it can no longer do they take over in the course of a run.
    """

    def __init__(self, device: Device = "cpu") -> None:
        self._device = device
        self._there, self._name = 0, ""
        self._reasons: Counter[str] = Counter()

    def __call__(self, matrix: Callable[[], Matrix], on_cores: Callable[[Matrix], Any]) -> Any:
        S = matrix()
        if not self._wanted(S):
            return on_cores(S)
        why = no_cudss()
        if not why:
            try:
                self._name = self._name or device_name()
                found = OnGpu(CudssFactor(S), lambda: on_cores(matrix()), self._lost)
            except DeviceFailed as problem:
                why = str(problem)
            else:
                self._there += 1
                return found
        if why != NOT_INSTALLED:
            self._reasons[why] += 1
        return on_cores(S)

    def _wanted(self, S: Matrix) -> bool:
        if self._device == "cpu" or not sp.issparse(S):
            return False
        return S.shape[0] >= (1 if self._device == "gpu" else LARGE)

    def _lost(self, why: str) -> None:
        self._reasons[f"the GPU failed in the run, {why}"] += 1

    def told(self) -> tuple[str, ...]:
        """Which factors were made where, and why; nothing where there was no GPU to choose."""
        there = (f"factors on the GPU: {self._there} ({self._name})",) if self._there else ()
        return (*there, *(f"factors on the cores: {n} ({why})" for why, n in self._reasons.items()))


class OnGpu:
    """A factor on a GPU; from the moment on that it fails one on the cores."""

    def __init__(self, found: CudssFactor, again: Callable[[], Any], lost: Callable[[str], None]) -> None:
        self._factor: Any = found
        self._again, self._lost = again, lost

    @property
    def memory(self) -> float:
        """Bytes that it holds."""
        return float(self._factor.memory)

    def solve(self, b: Any) -> Any:
        try:
            return self._factor.solve(b)
        except DeviceFailed as problem:
            why = str(problem)
        self._lost(why)
        self._factor = None
        self._factor = self._again()
        return self._factor.solve(b)
