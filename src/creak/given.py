"""What a Python program gives: numbers, plain ones or NumPy's, and things of one kind, with one message where they are
something else."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from creak.errors import InputError, shortened


def number(value: Any, name: str) -> float:
    """A real number of any type as float; nan and infinity too.

    Raises
    ------
    InputError : it is none, or several.
    """
    found = array_of(value)
    if found.shape != () or found.dtype.kind not in "iuf":
        raise InputError(f"{name} = {shortened(repr(value))}", expected="a number")
    return float(found)


def array_of(value: Any) -> NDArray[Any]:
    """`np.asarray`; objects where that makes nothing: rows of unequal length."""
    try:
        return np.asarray(value)
    except ValueError:
        return np.asarray(value, dtype=np.object_)


def not_negative(value: Any, name: str, expected: str = "zero or more") -> float:
    """A number of zero or more, infinity too.

    Raises
    ------
    InputError : it is none.
    """
    found = number(value, name)
    if not found >= 0.0:
        raise InputError(f"{name} = {found:g}", expected=expected)
    return found


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


def finite(value: Any, name: str) -> float:
    """A finite number.

    Raises
    ------
    InputError : it is none.
    """
    found = number(value, name)
    if not math.isfinite(found):
        raise InputError(f"{name} = {found:g}", expected="a finite number")
    return found


def table_of(value: Any, name: str) -> NDArray[np.float64]:
    """Real numbers of any shape, nan and infinity too.

    Raises
    ------
    InputError : it holds something else.
    """
    try:
        if not np.iscomplexobj(value):
            return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        pass
    raise InputError(f"{name} = {shortened(repr(value))}", expected="a number or more")


def row_of(value: Any, name: str, least: int = 0) -> NDArray[np.float64]:
    """(n,) finite numbers, so many or more.

    Raises
    ------
    InputError : it is no such row.
    """
    found = table_of(value, name)
    odd = found[~np.isfinite(found)]
    if found.ndim != 1 or odd.size or found.size < least:
        what = f"holds {odd[0]}" if odd.size else f"is of shape {found.shape}"
        raise InputError(f"{name} {what}", expected=f"a row of {f'{least} or more ' * (least > 0)}finite numbers")
    return found


def spectra_of(value: Any, name: str, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    """Finite numbers, real or complex, of a shape where one is given.

    Raises
    ------
    InputError : it is something else.
    """
    found = array_of(value)
    if found.dtype.kind not in "iufc" or not np.isfinite(found).all():
        raise InputError(f"{name} = {shortened(repr(value))}", expected="finite numbers")
    if shape is not None and found.shape != shape:
        raise InputError(f"{name} is of shape {found.shape}", expected=f"{shape}, as the other")
    return found


def indices_of(value: Any, name: str, count: int) -> NDArray[np.int64]:
    """(n,) numbers of things from 0 to below `count`.

    Raises
    ------
    InputError : they are none, or beyond.
    """
    found = array_of(value)
    if found.ndim != 1 or (found.size and found.dtype.kind not in "iu"):
        raise InputError(f"{name} = {shortened(repr(value))}", expected="a row of whole numbers")
    if found.size and not 0 <= found.min() <= found.max() < count:
        raise InputError(f"{name} from {found.min()} to {found.max()}", expected=f"0 to {count - 1}")
    return found.astype(np.int64)


def check_fields(record: object, rules: Mapping[str, Callable[[Any, str], object]]) -> None:
    """Take each field of a frozen record through its rule, `positive` for instance: what that returns is kept."""
    for field, rule in rules.items():
        object.__setattr__(record, field, rule(getattr(record, field), f"{type(record).__name__}: {field}"))


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
    found = (None,) if isinstance(value, str | Mapping) or not isinstance(value, Iterable) else tuple(value)
    if not all(isinstance(one, str) for one in found):
        raise InputError(
            f"{name} = {shortened(repr(value))}",
            expected="a list of texts",
            fix=f"Write {name}=[{value!r}]." if isinstance(value, str) else "",
        )
    return found


def pairs_of(value: Any, name: str, pair: str) -> list[Any]:
    """Pairs in a list.

    Raises
    ------
    InputError : it is something else.
    """
    found = [None] if isinstance(value, Mapping) or not isinstance(value, Iterable) else list(value)
    if any(not isinstance(one, list | tuple) or len(one) != 2 for one in found):
        raise InputError(f"{name} = {shortened(repr(value))}", expected=f"a list of pairs: [{pair}, ...]")
    return found


def one_of(value: Any, known: Sequence[Any], name: str) -> None:
    """Raise InputError for what is none of the known values."""
    if getattr(value, "ndim", 0) or value not in known:
        raise InputError(f"{name} = {shortened(repr(value))}", expected=" or ".join(map(repr, known)))


def items_of(value: Any, kind: type, name: str, expected: str) -> list[Any]:
    """Things of one kind in a list.

    Raises
    ------
    InputError : it is something else.
    """
    of_kind(value, Iterable, name, expected)
    found = list(value)
    for one in found:
        of_kind(one, kind, f"one of {name}", expected)
    return found


LARGEST = 1e60
SMALLEST = 1e-60


def computable(value: float) -> float:
    """The number; 0 where it is nearer to it than `SMALLEST`, nan where it is not finite or beyond `LARGEST`."""
    if not abs(value) <= LARGEST:
        return math.nan
    return value if abs(value) >= SMALLEST else 0.0
