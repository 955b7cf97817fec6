"""What the text formats of results share: labels that tell nodes apart, values that a field can hold, plain titles."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray

SMALLEST = 1e-99
"""Smaller values are written as 0: their exponent has three digits, which the fields cannot hold."""


def unique_labels(ids: IntArray) -> IntArray:
    """Labels as they are, or 1, 2, ... where they repeat."""
    return ids if np.unique(ids).size == ids.size else np.arange(1, ids.size + 1)


def holdable(values: FloatArray) -> FloatArray:
    """The values with 0 for those that are too small for a field."""
    return np.where(np.abs(values) < SMALLEST, 0.0, values)


def plain_text(words: str, width: int) -> str:
    """In ASCII and on one line; the end of it where it is too long."""
    return " ".join(words.split()).encode("ascii", "replace").decode()[-width:]
