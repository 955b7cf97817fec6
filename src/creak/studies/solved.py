"""Modes and checks that an earlier run of the same matrices has left beside its superelements."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import CreakError, InputError
from creak.formats.stored.solved import read_solved, write_solved
from creak.version import edition

SOLVED = "solved"
"""Folder in that of the superelements where runs keep what the next one may need; it may be deleted."""
LARGEST = 200_000_000
"""Bytes above which nothing is kept."""
KEPT = 4
"""Files of a kind that are kept, those written last."""


@contextmanager
def opened(store: Path | None) -> Iterator[None]:
    """The folder is there for what is kept, and gone again where nothing was, or where bad input made it in vain.

    One that cannot be made keeps nothing.
    """
    try:
        if store is not None:
            store.mkdir(parents=True)
    except OSError:  # there already, perhaps by another run that has just begun, or not to be made
        store = None
    if store is None:
        yield
        return
    try:
        yield
    except InputError:
        shutil.rmtree(store, ignore_errors=True)
        raise
    finally:
        with suppress(OSError):  # not empty, or not there
            store.rmdir()


def solved(
    store: Path | None,
    kind: str,
    made_from: Sequence[str],
    make: Callable[[], dict[str, FloatArray]],
    most: int | None = None,
) -> dict[str, FloatArray]:
    """Arrays by name, from the store or made now; a damaged file, or one that cannot be written, costs time alone.

    Parameters
    ----------
    store : folder of saved superelements; None, or a folder that is not there: nothing is looked for or kept.
    kind : first word of the file's name. made_from : all that the arrays depend on but the version of creak.
    most : files of the kind that are kept; default: `KEPT`.
    """
    if store is None or not store.is_dir():
        return make()
    key = hashlib.blake2b("\n".join([edition(), kind, *made_from]).encode(), digest_size=16).hexdigest()
    path = store / SOLVED / f"{kind}.{key}.h5"
    found = read_solved(path, key)
    if found is not None:
        return found
    found = {name: np.ascontiguousarray(array) for name, array in make().items()}  # as they are read: the same sums
    if sum(array.nbytes for array in found.values()) <= LARGEST:
        try:
            write_solved(path, key, found)
            forget(path.parent, f"{kind}.*.h5", KEPT if most is None else most)
        except (OSError, CreakError):  # a folder that may only be read, a full disk
            if path.parent.is_dir() and not any(path.parent.iterdir()):
                path.parent.rmdir()
    return found


def keep_in(
    store: Path | None, kind: str
) -> Callable[[Sequence[FloatArray | IntArray], Callable[[], dict[str, FloatArray]]], dict[str, FloatArray]]:
    """`solved` for what depends on arrays alone."""
    return lambda arrays, make: solved(store, kind, [digest_of_record(list(arrays))] if store else [], make)


def forget(folder: Path, pattern: str, most: int) -> list[Path]:
    """Remove the files of a pattern but the last ones written; returns those."""
    files = sorted(folder.glob(pattern), key=lambda p: p.stat().st_mtime)
    gone = files[: max(len(files) - most, 0)]
    for old in gone:
        old.unlink(missing_ok=True)
    return gone


def digest_of(A: Matrix | IntArray) -> str:
    """Of the entries of a matrix or an array."""
    digest = hashlib.blake2b(digest_size=16)
    if sp.issparse(A):
        B = sp.csr_matrix(A)
        B.sort_indices()
        for part in (B.data, B.indices.astype(np.int64), B.indptr.astype(np.int64)):
            digest.update(np.ascontiguousarray(part).data)
    else:
        digest.update(np.ascontiguousarray(A).data)
    return digest.hexdigest()


PLACES = ("where",)
"""Fields that only say where in its file something stands."""


def digest_of_record(value: Any) -> str:
    """Of plain data: records, their fields in turn but `PLACES`, arrays with shape and type, tables, texts, numbers.

    Raises
    ------
    TypeError : it holds something else, of which no digest says all.
    """
    digest = hashlib.blake2b(digest_size=16)
    _feed(digest, value)
    return digest.hexdigest()


def _feed(digest: Any, value: Any) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.str} {value.shape} ".encode())
        digest.update(value.tobytes())
    elif sp.issparse(value):
        _feed(digest, ["sparse", value.shape, digest_of(value)])
    elif is_dataclass(value) and not isinstance(value, type):
        digest.update(f"record {type(value).__name__} ".encode())
        _feed(digest, {f.name: getattr(value, f.name) for f in fields(value) if f.name not in PLACES})
    elif isinstance(value, Mapping):
        digest.update(f"table {len(value)} ".encode())
        for pair in value.items():
            _feed(digest, pair)
    elif isinstance(value, list | tuple):
        digest.update(f"list {len(value)} ".encode())
        for one in value:
            _feed(digest, one)
    elif value is None or isinstance(value, str | int | float | np.generic):
        text = repr(value).encode()
        digest.update(f"{len(text)} ".encode() + text)
    else:
        raise TypeError(f"no digest of a {type(value).__name__}")
