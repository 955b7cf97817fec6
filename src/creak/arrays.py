"""Array type names used throughout creak."""

from __future__ import annotations

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
