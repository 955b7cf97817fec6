"""`numba.njit` whose cache on disk knows all that went into a function, not its own file alone.

Numba takes machine code from its cache as long as the function's own file is what it was. Functions that it calls, and
numbers that it takes, stand in other files as well: after an update of those it would go on with the old ones, without
a word. Here code is taken only where all of that is the same, by content: copies and checkouts change nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from hashlib import blake2b
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core.caching import IndexDataCacheFile

OWN = __name__.partition(".")[0]
"""The package whose files count; those of others count by the version of numba."""
_stamps: dict[Any, str] = {}
_contents: dict[str, bytes] = {}


def njit(**options: Any) -> Callable[[Any], Any]:
    """`numba.njit(cache=True, **options)` with such a cache."""
    compile_ = numba.njit(cache=True, **options)

    def decorate(function: Any) -> Any:
        compiled = compile_(function)
        index = getattr(compiled._cache, "_cache_file", None)
        if isinstance(index, IndexDataCacheFile):
            index.__class__ = _Index
            index.function = compiled.py_func  # type: ignore[attr-defined]
        return compiled

    return decorate


def is_cached(function: Any) -> bool:
    """Whether the cache holds a function of `njit`, for some arguments, as it is now."""
    index: Any = getattr(function._cache, "_cache_file", None)
    return isinstance(index, IndexDataCacheFile) and bool(index._load_index())  # type: ignore[no-untyped-call]


class _Index(IndexDataCacheFile):
    """Where numba looks up which machine code there is; all of it is stale where the stamp is another one."""

    function: Any

    @property
    def _source_stamp(self) -> str:
        if self.function not in _stamps:
            _stamps[self.function] = _stamp(self.function)
        return _stamps[self.function]

    @_source_stamp.setter
    def _source_stamp(self, value: Any) -> None:
        """Numba's own: of the function's file."""

    def _load_index(self) -> dict[Any, Any]:
        """Empty where some of it is of types of another program, as of tests, that this one cannot import."""
        try:
            found: dict[Any, Any] = super()._load_index()  # type: ignore[no-untyped-call]
        except (ImportError, AttributeError):
            return {}
        return found


def _stamp(function: Any) -> str:
    """Of the files of a function and all that it calls, and of the numbers that they take from elsewhere."""
    files, values, todo, seen = set[str](), set[str](), [function], {function}
    while todo:
        one = todo.pop()
        files.add(one.__code__.co_filename)
        for name, value in _taken(one):
            called = getattr(value, "py_func", None)
            if called is not None:
                if called not in seen:
                    seen.add(called)
                    todo.append(called)
            elif isinstance(value, np.ndarray):
                values.add(f"{name} {value.dtype} {value.shape} {blake2b(value.tobytes()).hexdigest()}")
            elif isinstance(value, bool | int | float | complex | str | tuple | np.generic):
                values.add(f"{name} {value!r}")
            else:
                files |= _file_of(value)
    made = blake2b(digest_size=16)
    for content in sorted(map(_content, files)):
        made.update(content)
    made.update(repr(sorted(values)).encode())
    return made.hexdigest()


def _taken(function: Any) -> Iterator[tuple[str, Any]]:
    """Name and value of all that a function takes from around it."""
    codes = [function.__code__]
    for code in codes:
        codes += [x for x in code.co_consts if isinstance(x, CodeType)]
        for name in code.co_names:
            if name in function.__globals__:
                yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def _file_of(value: Any) -> set[str]:
    """The file of a class, an intrinsic or a module of the package."""
    name = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    if not isinstance(name, str) or name.partition(".")[0] != OWN:
        return set()
    file = getattr(sys.modules.get(name), "__file__", None)
    return set() if file is None else {file}


def _content(path: str) -> bytes:
    """Digest of a file; of one that is not there, as in frozen programs, none."""
    if path not in _contents:
        try:
            _contents[path] = blake2b(Path(path).read_bytes(), digest_size=16).digest()
        except OSError:
            _contents[path] = b""
    return _contents[path]
