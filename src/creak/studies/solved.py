"""Modes and checks that an earlier run of the same matrices has left beside its superelements."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.pair import Arrays, Keep
from creak.digest import digest
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
    """The folder is there for what is kept; it and those above it that were made for it are gone again where nothing
    was, or where bad input made them in vain.

    One that cannot be made keeps nothing.
    """
    made = [] if store is None else [folder for folder in (store, *store.parents) if not folder.exists()]
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
        for folder in made:
            with suppress(OSError):  # not empty, or not there
                folder.rmdir()


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
    key = digest([edition(), kind, *made_from])
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


def keep_in(store: Path | None, kind: str) -> Keep:
    """`solved` for what depends on arrays alone."""
    return lambda arrays, make: solved(store, kind, [digest(list(arrays))] if store else [], make)


def keep_here() -> Keep:
    """`keep_in` memory, for searches of one command."""
    found: dict[str, Arrays] = {}

    def keep(arrays: Sequence[FloatArray | IntArray], make: Callable[[], Arrays]) -> Arrays:
        key = digest(list(arrays))
        if key not in found:
            found[key] = make()
        return found[key]

    return keep


def forget(folder: Path, pattern: str, most: int) -> list[Path]:
    """Remove the files of a pattern but the last ones written; returns those."""
    files = sorted(folder.glob(pattern), key=lambda p: p.stat().st_mtime)
    gone = files[: max(len(files) - most, 0)]
    for old in gone:
        old.unlink(missing_ok=True)
    return gone
