"""What a Python program gives: numbers, plain ones or NumPy's, and things of one kind, with one message where they are
something else."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import UnionType
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


def of_kind(value: Any, kind: type | tuple[type, ...] | UnionType, name: str, expected: str, fix: str = "") -> None:
    """Raise InputError for what is of another kind."""
    if not isinstance(value, kind):
        raise InputError(
            f"{name} is {'None' if value is None else f'of type {type(value).__name__}'}", expected=expected, fix=fix
        )


def path_of(value: Any, name: str, expected: str = "a path", fix: str = "") -> Path:
    """A path, as text or as any object that stands for one.

    Raises
    ------
    InputError : it is none.
    """
    of_kind(value, (str, os.PathLike), name, expected, fix)
    return Path(value)


def texts(value: Any, name: str) -> tuple[str, ...]:
    """Several texts; one alone would be taken letter by letter.

    Raises
    ------
    InputError : it is one text, or nothing of the kind.
    """
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise InputError(f"{name} = {value!r}", expected="a list of texts", fix=f"Write {name}=[{str(value)!r}].")
    return tuple(value)


def one_of(value: Any, known: Sequence[Any], name: str) -> None:
    """Raise InputError for what is none of the known values."""
    if value not in known:
        raise InputError(f"{name} = {value!r}", expected=" or ".join(map(repr, known)))
