"""Files with a checksum of their content, checked on reading.

In HDF5 files the SHA-256 of all that follows stands in the first bytes: the 512 bytes before the content are its user
block, which HDF5 libraries skip. In JSON files it is the key `sha256`. The checksum finds what changed by accident;
what an HDF5 file made on purpose could reach outside itself (links, external storage) is refused."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py

from creak.digest import sha256
from creak.formats.complete_file import Interrupts, Unfinished, complete_file, interrupts_later
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


PAGE = 1 << 16
"""Bytes kept at a time after an error."""
KEPT = 1 << 26
"""Bytes kept before `check` gives up."""


@dataclass(frozen=True)
class Hdf5:
    """An HDF5 file on its way to disk, written so that a full disk ends in one error.

    The HDF5 library cannot close a file whose last writes fail: it tries again when the process ends, and crashes. So
    it is given a Python object to write to, whose writes always succeed: the first error is remembered, and what comes
    after it is kept in memory, where the library can read it back. Once it has closed the file, the error is raised.

    This holds for files of any size and on any file system, which neither an image of the file in memory nor space
    taken beforehand does. Going on after the error tells how large the file would have become. Arrays that are made
    while they are written call `check` between blocks, so that not much more than `KEPT` is kept of them.
    """

    file: h5py.File
    check: Callable[[int], None]
    """Called between blocks with the bytes still to come; raises Ctrl-C, and an error after which much is kept."""


@contextmanager
def hdf5_file(partial: Path) -> Iterator[Hdf5]:
    """Write a new HDF5 file with a checksum (`seal`); to be used inside `complete_file`.

    Raises
    ------
    Unfinished : the file could not be written; KeyboardInterrupt : Ctrl-C meanwhile. Both when the file is closed.
    """
    with interrupts_later() as interrupts:  # inside a call of the library one would be one more failure to write
        sink = _Sink(partial, interrupts)
        try:
            with h5py.File(sink, "w", userblock_size=BLOCK) as file:
                yield Hdf5(file, sink.check)
            sink.finish()
        finally:
            sink.close()


@contextmanager
def bound_file(path: Path, kind: str, version: int, made_from: str) -> Iterator[h5py.File]:
    """Write a file of creak's, complete or absent, with what it was made from (`is_bound`).

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with complete_file(path, stream=False, kept=True) as partial, hdf5_file(partial) as out:
        out.file.attrs[f"creak_{kind}"] = version
        out.file.attrs["made_from"] = made_from
        yield out.file


def is_bound(file: h5py.File, kind: str, version: int, made_from: str) -> bool:
    """Whether a file is of that kind and was made from just that."""
    return (file.attrs[f"creak_{kind}"], file.attrs["made_from"]) == (version, made_from)


class _Sink:
    """What the library takes for a file (h5py: file-like objects); no method raises because of the disk."""

    def __init__(self, path: Path, interrupts: Interrupts) -> None:
        self._interrupts = interrupts
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        self._at = self._end = 0
        self._error: OSError | None = None
        self._kept: dict[int, bytearray] = {}
        """Number of the page -> content, of those written since the error."""

    def check(self, more: int) -> None:
        if self._error is not None and len(self._kept) * PAGE > KEPT:
            raise Unfinished(self._error, self._end + more) from self._error
        self._interrupts.check()

    def finish(self) -> None:
        """Write the checksum; raises what has gone wrong."""
        self._interrupts.check()
        if self._error is None:
            block = seal(self._on_disk, self._end)
            self._at = 0
            self.write(memoryview(block))
        if self._error is not None:
            raise Unfinished(self._error, self._end) from self._error

    def close(self) -> None:
        os.close(self._descriptor)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        self._at = start + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def write(self, data: memoryview) -> int:
        view = memoryview(data).cast("B")
        if self._error is None:
            try:
                self._put(view)
            except OSError as error:
                self._error = error
        if self._error is not None:
            self._keep(view)
        self._at += len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def readinto(self, buffer: memoryview) -> int:
        view = memoryview(buffer).cast("B")
        view[:] = self._content(self._at, len(view))
        self._at += len(view)
        return len(view)

    def read(self, n: int = -1) -> bytes:
        n = self._end - self._at if n < 0 else n
        self._at += n
        return self._content(self._at - n, n)

    def truncate(self, size: int) -> int:
        self._end = size
        if self._error is None:
            try:
                os.ftruncate(self._descriptor, size)
            except OSError as error:
                self._error = error
        return size

    def flush(self) -> None:
        """Nothing waits here."""

    def _put(self, view: memoryview) -> None:
        done = 0
        while done < len(view):
            os.lseek(self._descriptor, self._at + done, os.SEEK_SET)
            done += os.write(self._descriptor, view[done:])

    def _on_disk(self, at: int, n: int) -> bytes:
        """What the file holds there, zeros beyond its end."""
        found = b""
        try:
            os.lseek(self._descriptor, at, os.SEEK_SET)
            while len(found) < n and (piece := os.read(self._descriptor, n - len(found))):
                found += piece
        except OSError as error:
            self._error = self._error or error
        return found.ljust(n, b"\0")

    def _pages(self, at: int, n: int) -> Iterator[tuple[int, int, int]]:
        """Page, and the first and last byte of it, of each page that a range touches."""
        for page in range(at // PAGE, (at + n + PAGE - 1) // PAGE):
            yield page, max(at, page * PAGE) - page * PAGE, min(at + n, (page + 1) * PAGE) - page * PAGE

    def _keep(self, view: memoryview) -> None:
        for page, first, last in self._pages(self._at, len(view)):
            if page not in self._kept:
                self._kept[page] = bytearray(self._on_disk(page * PAGE, PAGE))
            start = page * PAGE - self._at
            self._kept[page][first:last] = view[start + first : start + last]

    def _content(self, at: int, n: int) -> bytes:
        if not self._kept:
            return self._on_disk(at, n)
        found = bytearray(self._on_disk(at, n))
        for page, first, last in self._pages(at, n):
            if page in self._kept:
                start = page * PAGE - at
                found[start + first : start + last] = self._kept[page][first:last]
        return bytes(found)
