"""A diagonal matrix that behaves like the matrices around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np

from creak.arrays import FloatArray


@dataclass(frozen=True)
class Diagonal:
    """diag(d): `@`, `.T`, `.shape` and `.diagonal()` as for a SciPy matrix, O(n) each."""

    d: FloatArray

    @property
    def shape(self) -> tuple[int, int]:
        return (self.d.size, self.d.size)

    @property
    def T(self) -> Diagonal:
        return self

    def diagonal(self) -> FloatArray:
        return self.d

    def __matmul__(self, x: FloatArray) -> FloatArray:
        return self.d * x if x.ndim == 1 else self.d[:, None] * x

    def __mul__(self, scalar: float) -> Diagonal:
        return Diagonal(self.d * scalar)

    __rmul__ = __mul__

    @overload
    def __add__(self, other: Diagonal) -> Diagonal: ...
    @overload
    def __add__(self, other: FloatArray) -> FloatArray: ...
    def __add__(self, other: Diagonal | FloatArray) -> Diagonal | FloatArray:
        return Diagonal(self.d + other.d) if isinstance(other, Diagonal) else np.diag(self.d) + other

    def toarray(self) -> FloatArray:
        return np.diag(self.d)
