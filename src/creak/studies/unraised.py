"""Exceptions that compiled code meets and cannot hand on: Python prints them and goes on with a wrong result."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from creak.errors import NumericalError

_lock = threading.Lock()
_watching: list[tuple[int, list[str]]] = []
"""Thread of each `none_ignored` under way, and what was ignored there."""
_before: list[Any] = []
"""The hook that was there before the first of them."""


@contextmanager
def none_ignored() -> Iterator[None]:
    """What compiled code had to ignore inside, in this thread, is a failed analysis.

    Such code gives its name where Python code gives the function itself: a destructor's exception is none of these, no
    result hangs on it.

    Raises
    ------
    NumericalError : an exception was ignored; also in place of an error that came of it.
    """
    found: list[str] = []
    mine = (threading.get_ident(), found)
    with _lock:
        if not _watching:
            _before.append(sys.unraisablehook)
            sys.unraisablehook = _note
        _watching.append(mine)
    try:
        yield
    except Exception as error:
        if found:
            raise _failure(found) from error
        raise
    finally:
        with _lock:
            _watching[:] = [w for w in _watching if w is not mine]
            if not _watching:
                sys.unraisablehook = _before.pop()
    if found:
        raise _failure(found)


def _note(met: Any) -> None:
    if not isinstance(met.object, str):
        (_before or [sys.__unraisablehook__])[-1](met)
        return
    text = f"{met.object}: {met.exc_type.__name__}: {met.exc_value}"
    for thread, found in list(_watching):
        if thread == threading.get_ident():
            found.append(text)


def _failure(found: list[str]) -> NumericalError:
    return NumericalError(
        f"{found[0]}; compiled code went on with a wrong result, so none is given. Update the package that it names."
    )
