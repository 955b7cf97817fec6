"""HDF5 files with a checksum: the SHA-256 of all that follows stands in the first bytes, checked before reading.

The 512 bytes before the HDF5 content are its user block, which HDF5 libraries skip. The checksum finds what changed
by accident; what a file made on purpose could reach outside itself (links, external storage) is refused besides.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from creak.digest import sha256
from creak.formats.deck.command_files import plain_file

BLOCK = 512
"""Bytes of the user block."""
MARK = b"creak sha256 "
PIECE = 1 << 20
MOST_PACKED = 1100
"""Bytes of numbers that one stored byte can stand for: gzip reaches 1032."""
FREE = 1 << 20
"""Bytes that a dataset may have whatever is stored of it."""
PLAIN = "iufbc"
"""Kinds of numbers that creak stores; text besides."""


class Damaged(ValueError):
    """A stored file that is not as creak wrote it; says why in a few words."""


def seal(read: Callable[[int, int], bytes], size: int) -> bytes:
    """The user block of a file.

    Parameters
    ----------
    read : offset, number of bytes -> content. size : bytes of the whole file.
    """
    found = sha256(read(at, min(PIECE, size - at)) for at in range(BLOCK, size, PIECE))
    return (MARK + found.encode()).ljust(BLOCK, b"\0")


@contextmanager
def opened_hdf5(path: Path) -> Iterator[h5py.File]:
    """Open a file that creak stored, after its checksum and all its links have been checked.

    Raises
    ------
    Damaged : it has no checksum, another one, or reaches outside itself. OSError : it cannot be read.
    """
    with plain_file(path, is_input=False).open("rb") as raw:
        found = raw.read(BLOCK)
        if not found.startswith(MARK):
            raise Damaged("it has no checksum: it is cut short, or of another program or an earlier creak")

        def read(at: int, n: int) -> bytes:
            raw.seek(at)
            return raw.read(n)

        if seal(read, os.fstat(raw.fileno()).st_size) != found:
            raise Damaged("its checksum does not fit: it is cut short or was changed after it was written")
    with unsealed_hdf5(path, is_input=False) as file:
        yield file


@contextmanager
def unsealed_hdf5(path: Path, *, is_input: bool = True) -> Iterator[h5py.File]:
    """Open a file without a checksum, as of another program, after all its links have been checked.

    Parameters
    ----------
    is_input : whether it is one of the user's, which nothing may replace.

    Raises
    ------
    Damaged : it reaches outside itself, or announces more than it holds. OSError : it cannot be read.
    """
    with h5py.File(plain_file(path, is_input=is_input), "r") as file:
        _check_group(file, set())
        yield file


def _check_group(group: h5py.Group, seen: set[int]) -> None:
    """Raise Damaged where a group reaches outside the file, or holds what creak does not write."""
    for name in group:
        place = f"{group.name.rstrip('/')}/{name}"[:100]
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise Damaged(f"{place} is a link to another place")
        item = group[name]
        address = h5py.h5o.get_info(item.id).addr
        if address in seen:
            continue
        seen.add(address)
        if isinstance(item, h5py.Group):
            _check_group(item, seen)
        elif isinstance(item, h5py.Dataset):
            _check_dataset(item, place)
        else:
            raise Damaged(f"{place} is no array")


def _check_dataset(item: h5py.Dataset, place: str) -> None:
    if item.is_virtual or item.external:
        raise Damaged(f"{place} lies in another file")
    if h5py.check_string_dtype(item.dtype) is not None:
        return
    if item.dtype.kind not in PLAIN:
        raise Damaged(f"{place} holds neither numbers nor text")
    if item.nbytes > MOST_PACKED * item.id.get_storage_size() + FREE:
        raise Damaged(f"{place} announces more numbers than it holds")
