"""Files with a checksum of their content, checked on reading.

In HDF5 files the SHA-256 of all that follows stands in the first bytes: the 512 bytes before the content are its user
block, which HDF5 libraries skip. In JSON files it is the key `sha256`. The checksum finds what changed by accident;
what an HDF5 file made on purpose could reach outside itself (links, external storage) is refused."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

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


KEY = "sha256"


def sealed_text(data: Mapping[str, Any], *, allow_nan: bool = False) -> str:
    """The text of a JSON file, with the SHA-256 of its content as last key."""
    plain = json.loads(json.dumps(dict(data), allow_nan=allow_nan))
    return json.dumps({**plain, KEY: _digest(plain)}, indent=2) + "\n"


def read_sealed(path: Path) -> dict[str, Any]:
    """What `sealed_text` wrote, without the checksum.

    Raises
    ------
    Damaged : not such a file, or changed since. OSError : it cannot be read.
    """
    try:
        data = json.loads(plain_file(path, is_input=False).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise Damaged("it is no JSON") from error
    found = data.pop(KEY, None) if isinstance(data, dict) else None
    if found is None:
        raise Damaged("it has no checksum: it is of another program or an earlier creak")
    if found != _digest(data):
        raise Damaged("its checksum does not fit: it was changed after it was written")
    return dict(data)


def _digest(data: dict[str, Any]) -> str:
    """Of the content, however it is laid out."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return sha256([text.encode()])
