"""Array type names used throughout creak."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]

Matrix = Any
"""A matrix that knows `@`, `.T` and `.shape`: ndarray, SciPy sparse array, or `linalg.Diagonal`."""
Csr = tuple[IntArray, IntArray, FloatArray]
"""Starts of rows, columns and entries of a sparse matrix, as compiled code takes them."""


def to_dense(A: Matrix) -> FloatArray:
    """A as an ndarray, whatever it was."""
    return np.asarray(A.toarray() if hasattr(A, "toarray") else A)


def brief(record: Any) -> str:
    """A record as a notebook shows it: arrays and matrices by their shape, functions not at all.

    >>> Modes(omega2 (3,), freq (3,))
    """

    def shown(value: Any) -> Any:
        return tuple(map(shown, value)) if type(value) is tuple else getattr(value, "shape", value)

    values = {f.name: getattr(record, f.name) for f in fields(record) if f.repr}
    said = [f"{k} {shown(v)}" for k, v in values.items() if v is not None and not callable(v)]
    return f"{type(record).__name__}({', '.join(said)})"
