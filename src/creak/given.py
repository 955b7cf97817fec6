"""Numbers as a Python program gives them: plain ones or NumPy's, with one message where they are something else."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np

from creak.errors import InputError


def number(value: Any, name: str) -> float:
    """A real number of any type as float; nan and infinity too.

    Raises
    ------
    InputError : it is none, or several.
    """
    found = np.asarray(value)
    if found.shape != () or found.dtype.kind not in "iuf":
        raise InputError(f"{name} = {value!r}", expected="a number")
    return float(found)


def positive(value: Any, name: str) -> float:
    """A finite number above zero.

    Raises
    ------
    InputError : it is none.
    """
    found = number(value, name)
    if not 0.0 < found < math.inf:
        raise InputError(f"{name} = {found:g}", expected="a positive number")
    return found


def whole(value: Any, name: str, least: int, most: int | None = None) -> int:
    """A whole number within bounds.

    Raises
    ------
    InputError : it is none, or outside.
    """
    bounds = f"{least:,} or more" if most is None else f"{least:,} to {most:,}"
    try:
        found = operator.index(value)
    except TypeError as error:
        raise InputError(f"{name} = {value!r}", expected=f"a whole number, {bounds}") from error
    if found < least or (most is not None and found > most):
        raise InputError(f"{name} = {found}", expected=f"a whole number, {bounds}")
    return found
